//! Offline input: image files and folders of them, one frame at a time.
//!
//! [`frames`] gives the frames of several inputs in the order of the command line. A file that cannot be read is an item of its
//! own with the reason, and the rest go on. Only the names of a folder and one decoded picture are in memory at a time.

pub mod bag;
mod board_file;
mod camera_info_file;
mod folder;
mod natural_order;
mod text_file;

pub use board_file::{BoardFileError, read_board};
pub use camera_info_file::{CameraInfoFileError, read_camera_info};

use crate::frame::{DecodeError, Frame, Stamp};
use std::io;
use std::path::{Path, PathBuf};

/// One frame of an input, or why there is none.
#[derive(Debug)]
pub struct Recorded {
    /// The file, as the path was given (for a file of a folder: the folder's path as given, and the name).
    pub path: PathBuf,
    /// The decoded picture; its `source` is the path.
    pub frame: Result<Frame, SourceError>,
}

/// Why an input gives no frame. Every message names the path.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// There is nothing at this path.
    #[error("{}: no such file or folder", path.display())]
    NotFound {
        /// The path as given.
        path: PathBuf,
    },
    /// The file or folder is there but cannot be read.
    #[error("{}: cannot be read: {reason}", path.display())]
    Unreadable {
        /// The path as given.
        path: PathBuf,
        /// What the operating system says.
        reason: io::Error,
    },
    /// The file was read but is no picture, or a damaged one.
    #[error("{}: {reason}", path.display())]
    NotDecoded {
        /// The path as given.
        path: PathBuf,
        /// What is wrong with it.
        reason: DecodeError,
    },
    /// A folder without image files.
    #[error("{}: the folder has no image files ({})", path.display(), folder::EXTENSIONS.join(", "))]
    EmptyFolder {
        /// The path as given.
        path: PathBuf,
    },
}

impl SourceError {
    fn from_io(path: &Path, reason: io::Error) -> Self {
        let path = path.to_owned();
        if reason.kind() == io::ErrorKind::NotFound {
            Self::NotFound { path }
        } else {
            Self::Unreadable { path, reason }
        }
    }
}

/// Reads one image file; its content decides the format, not its name.
///
/// # Errors
/// [`SourceError`] where the file cannot be read or is not a picture.
pub fn read_image(path: &Path) -> Result<Frame, SourceError> {
    let bytes = std::fs::read(path).map_err(|reason| SourceError::from_io(path, reason))?;
    Frame::decode(&bytes, Stamp::default(), path.to_string_lossy()).map_err(|reason| {
        SourceError::NotDecoded {
            path: path.to_owned(),
            reason,
        }
    })
}

/// The frames of all inputs in the order given: a file is itself, a folder its image files in natural order (view_2
/// before view_10). Files are opened when the iterator comes to them.
pub fn frames(inputs: impl IntoIterator<Item = PathBuf>) -> impl Iterator<Item = Recorded> {
    inputs
        .into_iter()
        .flat_map(|path| Input::open(path).frames())
}

/// An input of one kind; a new kind of input is a new variant here.
enum Input {
    Image(PathBuf),
    Folder(Vec<PathBuf>),
    Broken(PathBuf, SourceError),
}

impl Input {
    fn open(path: PathBuf) -> Self {
        if !path.is_dir() {
            return Self::Image(path);
        }
        match folder::image_files(&path) {
            Ok(files) => Self::Folder(files),
            Err(error) => Self::Broken(path, error),
        }
    }

    fn frames(self) -> Box<dyn Iterator<Item = Recorded>> {
        match self {
            Self::Image(path) => Box::new(std::iter::once(path).map(recorded)),
            Self::Folder(files) => Box::new(files.into_iter().map(recorded)),
            Self::Broken(path, error) => Box::new(std::iter::once(Recorded {
                path,
                frame: Err(error),
            })),
        }
    }
}

fn recorded(path: PathBuf) -> Recorded {
    let frame = read_image(&path);
    Recorded { path, frame }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Pixels, Plane};
    use image::{GrayImage, ImageFormat, Luma};
    use std::fs;

    fn write_grey(path: &Path, value: u8) {
        let picture = GrayImage::from_pixel(4, 3, Luma([value]));
        picture.save_with_format(path, ImageFormat::Png).unwrap();
    }

    fn values(inputs: Vec<PathBuf>) -> Vec<Option<u8>> {
        frames(inputs)
            .map(|recorded| match recorded.frame.ok()?.pixels {
                Pixels::U8(plane) => Some(plane.at(0, 0)),
                Pixels::U16(_) => None,
            })
            .collect()
    }

    #[test]
    fn files_and_folders_come_in_the_order_given() {
        let folder = tempfile::tempdir().unwrap();
        let views = folder.path().join("views");
        fs::create_dir(&views).unwrap();
        for (name, value) in [("view_10.png", 10), ("view_2.png", 2), ("View_3.PNG", 3)] {
            write_grey(&views.join(name), value);
        }
        fs::write(views.join("notes.txt"), "not an image").unwrap();
        fs::write(views.join(".hidden.png"), "nor this").unwrap();
        fs::create_dir(views.join("deeper.png")).unwrap();
        let last = folder.path().join("a.dat");
        write_grey(&last, 99);
        let found = values(vec![last.clone(), views, last]);
        assert_eq!(found, [99, 3, 2, 10, 99].map(Some));
    }

    #[test]
    fn a_broken_file_does_not_stop_the_others() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        write_grey(&path("a.png"), 1);
        let whole = fs::read(path("a.png")).unwrap();
        fs::write(path("b.png"), &whole[..whole.len() / 2]).unwrap();
        fs::write(path("c.png"), "").unwrap();
        fs::write(path("d.png"), "hello").unwrap();
        write_grey(&path("f.png"), 6);
        let inputs: Vec<_> = ["a.png", "b.png", "c.png", "d.png", "e.png", "f.png"]
            .map(path)
            .into();
        let all: Vec<_> = frames(inputs.clone()).collect();
        let paths: Vec<_> = all.iter().map(|r| r.path.clone()).collect();
        assert_eq!(paths, inputs);
        assert!(all[0].frame.is_ok() && all[5].frame.is_ok());
        for (at, words) in [
            (1, "truncated PNG"),
            (2, "empty"),
            (3, "not a PNG"),
            (4, "no such file"),
        ] {
            let message = all[at].frame.as_ref().unwrap_err().to_string();
            assert!(message.contains(words), "{message}");
            assert!(
                message.contains(&*inputs[at].to_string_lossy()),
                "{message}"
            );
        }
    }

    #[test]
    fn an_empty_folder_is_an_error_that_says_so() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("README"), "nothing here").unwrap();
        let all: Vec<_> = frames([folder.path().to_owned()]).collect();
        assert_eq!(all.len(), 1);
        let message = all[0].frame.as_ref().unwrap_err().to_string();
        assert!(message.contains("no image files"), "{message}");
    }

    #[test]
    fn sixteen_bits_and_the_path_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep.tif");
        let picture =
            image::ImageBuffer::from_fn(3, 2, |x, y| Luma([(40_000 + x + 10 * y) as u16]));
        picture.save(&path).unwrap();
        let frame = read_image(&path).unwrap();
        let expected = vec![40_000, 40_001, 40_002, 40_010, 40_011, 40_012];
        assert_eq!(
            frame.pixels,
            Pixels::U16(Plane::from_vec(3, 2, expected).unwrap())
        );
        assert_eq!(frame.source, path.to_string_lossy());
        assert_eq!(frame.stamp, Stamp::default());
    }
}
