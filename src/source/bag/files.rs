//! The files of a bag: what they are, by their first bytes, and in which order.

use super::metadata::{self, Metadata};
use super::zstd;
use crate::source::natural_order::natural_order;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

const MCAP_MAGIC: &[u8] = ::mcap::MAGIC;
const SQLITE_MAGIC: &[u8] = b"SQLite format 3\0";

/// How rosbag2 names its files.
const ENDINGS: [(&str, Storage); 2] = [("mcap", Storage::Mcap), ("db3", Storage::Sqlite)];

/// A kind of file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Storage {
    Mcap,
    Sqlite,
}

/// One file of a bag.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct BagFile {
    pub(super) path: PathBuf,
    pub(super) storage: Storage,
    /// Whether the whole file is compressed (`.db3.zstd`).
    pub(super) packed: bool,
}

impl BagFile {
    /// The file at a path: by its first bytes, and by its name where they are missing or say nothing. `None` for any other file.
    pub(super) fn at(path: &Path) -> io::Result<Option<Self>> {
        let start = first_bytes(File::open(path)?)?;
        let packed = start.starts_with(&zstd::MAGIC);
        let inside = if packed {
            // what cannot be unpacked has no first bytes
            zstd::unpacking(path)
                .and_then(first_bytes)
                .unwrap_or_default()
        } else {
            start
        };
        let storage = if inside.starts_with(MCAP_MAGIC) {
            Some(Storage::Mcap)
        } else if inside.starts_with(SQLITE_MAGIC) {
            Some(Storage::Sqlite)
        } else {
            named(path)
        };
        Ok(storage.map(|storage| Self {
            path: path.to_owned(),
            storage,
            packed,
        }))
    }
}

fn first_bytes(source: impl Read) -> io::Result<Vec<u8>> {
    let mut start = Vec::new();
    source.take(16).read_to_end(&mut start)?;
    Ok(start)
}

/// What a file's name says it is.
fn named(path: &Path) -> Option<Storage> {
    let name = path.file_name()?.to_str()?.to_ascii_lowercase();
    let name = name.strip_suffix(".zstd").unwrap_or(&name);
    let known = ENDINGS.iter().find(|(ending, _)| {
        name.strip_suffix(ending)
            .is_some_and(|stem| stem.len() > 1 && stem.ends_with('.'))
    });
    known.map(|(_, storage)| *storage)
}

/// Whether a path is a bag: a folder with metadata.yaml, or with files of a bag and no pictures; or a file of a bag.
pub fn is_bag(path: &Path) -> bool {
    if !path.is_dir() {
        return matches!(BagFile::at(path), Ok(Some(_)));
    }
    path.join(metadata::NAME).is_file()
        || in_folder(path).is_ok_and(|files| !files.is_empty())
            && crate::source::folder::image_files(path).is_err()
}

/// The first file of a bag in a folder, and how many there are.
pub fn first_in_folder(folder: &Path) -> Option<(PathBuf, usize)> {
    let files = in_folder(folder).ok()?;
    let count = files.len();
    files.into_iter().next().map(|file| (file, count))
}

/// The files of a folder's bag in the order in which they were recorded, and those that metadata.yaml names and that are missing.
///
/// A file that metadata.yaml does not name is part of the bag too, after the others: metadata.yaml may be older than the crash.
pub(super) fn of_folder(
    folder: &Path,
    metadata: Option<&Metadata>,
) -> io::Result<(Vec<PathBuf>, Vec<PathBuf>)> {
    let mut found = in_folder(folder)?;
    let (mut files, mut missing) = (Vec::new(), Vec::new());
    for named in metadata.map_or(&[][..], |m| &m.files) {
        let same = |path: &PathBuf| {
            path.file_name()
                .is_some_and(|name| unpacked(name) == unpacked(named.as_os_str()))
        };
        match found.iter().position(same) {
            Some(at) => files.push(found.remove(at)),
            // by another name than rosbag2 gives
            None if folder.join(named).is_file() => files.push(folder.join(named)),
            None => missing.push(folder.join(named)),
        }
    }
    files.extend(found);
    Ok((files, missing))
}

/// Everything in a folder that is named like a file of a bag, in natural order. Of a file and its compressed copy, the file: the
/// recorder deletes it once the copy is complete.
fn in_folder(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut files: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if named(&path).is_some() && path.is_file() {
            files.push(path);
        }
    }
    let name = |path: &Path| {
        let name = path.file_name().unwrap_or_default();
        name.to_string_lossy().into_owned()
    };
    files.sort_by(|a, b| natural_order(&name(a), &name(b)).then_with(|| a.cmp(b)));
    let plain = files.clone();
    files.retain(|path| {
        let stem = unpacked(path.as_os_str());
        stem == path.as_os_str().to_string_lossy() || !plain.contains(&PathBuf::from(stem))
    });
    Ok(files)
}

/// A name without the ending that says it is compressed.
fn unpacked(name: &std::ffi::OsStr) -> String {
    let name = name.to_string_lossy();
    name.strip_suffix(".zstd").unwrap_or(&name).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder_with(names: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        folder
    }

    fn names(paths: &[PathBuf]) -> Vec<&str> {
        let name = |path: &'_ PathBuf| path.file_name().unwrap().to_str().unwrap().to_owned();
        paths.iter().map(|p| &*name(p).leak()).collect()
    }

    #[test]
    fn the_order_is_that_of_the_metadata_or_of_the_numbers() {
        let folder = folder_with(&[
            "d_10.db3",
            "d_2.db3.zstd",
            "d_2.db3",
            "d_3.db3.zstd",
            "notes",
        ]);
        let (files, missing) = of_folder(folder.path(), None).unwrap();
        assert_eq!(names(&files), ["d_2.db3", "d_3.db3.zstd", "d_10.db3"]);
        assert!(missing.is_empty());
        let metadata = Metadata {
            files: ["d_10.db3", "d_1.db3", "d_3.db3", "notes"]
                .map(PathBuf::from)
                .into(),
            topics: Vec::new(),
        };
        let (files, missing) = of_folder(folder.path(), Some(&metadata)).unwrap();
        assert_eq!(
            names(&files),
            ["d_10.db3", "d_3.db3.zstd", "notes", "d_2.db3"]
        );
        assert_eq!(names(&missing), ["d_1.db3"]);
    }

    #[test]
    fn content_counts_and_then_the_name() {
        let folder = folder_with(&["a.mcap", "b", "c.png", ".db3", "d.mcap"]);
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("b"), SQLITE_MAGIC).unwrap();
        let packed = ::zstd::encode_all(SQLITE_MAGIC, 1).unwrap();
        std::fs::write(path("d.mcap"), packed).unwrap();
        let at = |name: &str| {
            BagFile::at(&path(name))
                .unwrap()
                .map(|f| (f.storage, f.packed))
        };
        assert_eq!(at("a.mcap"), Some((Storage::Mcap, false)));
        assert_eq!(at("b"), Some((Storage::Sqlite, false)));
        assert_eq!(at("d.mcap"), Some((Storage::Sqlite, true)));
        assert_eq!((at("c.png"), at(".db3")), (None, None));
        assert!(BagFile::at(&path("e.mcap")).is_err());
    }

    #[test]
    fn a_folder_of_pictures_is_no_bag_unless_it_says_so() {
        let folder = folder_with(&["a.mcap"]);
        assert!(is_bag(folder.path()) && is_bag(&folder.path().join("a.mcap")));
        std::fs::write(folder.path().join("a.png"), "").unwrap();
        assert!(!is_bag(folder.path()));
        std::fs::write(folder.path().join("metadata.yaml"), "").unwrap();
        assert!(is_bag(folder.path()));
        assert!(!is_bag(&folder.path().join("a.png")) && !is_bag(&folder.path().join("none")));
    }
}
