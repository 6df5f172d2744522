//! `ringcal detect`: finds the board in image files.

use super::measuring::Measuring;
use super::output::{Reader, print};
use crate::board::Board;
use crate::camera::Camera;
use crate::detect::{DetectOptions, Detection, Detector, Miss};
use crate::formats::{DetectionLine, write_by_rename};
use crate::frame::Frame;
use crate::report::{Scale, overlay, png};
use crate::source::{read_board, read_camera_info, read_image};
use anyhow::Context;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `ringcal detect`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Image files, looked at in this order.
    #[arg(required = true, value_name = "IMAGE")]
    images: Vec<PathBuf>,
    /// The board's YAML file.
    #[arg(long, value_name = "FILE")]
    board: PathBuf,
    #[command(flatten)]
    measuring: Measuring,
    /// The camera's calibration, a camera_info.yaml, for photometric: it knows the perspective of every ring.
    #[arg(long, value_name = "FILE")]
    camera_info: Option<PathBuf>,
    /// What to print for each image.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Also write a picture of what was found for each image into this folder.
    #[arg(long, value_name = "DIR")]
    overlay: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// Lines for people.
    Text,
    /// One line of JSON for each image.
    Jsonl,
}

/// Prints one result per image, in the order given. A file that cannot be read is a result too; the rest go on, and the
/// command fails at the end.
pub fn run(arguments: Arguments) -> anyhow::Result<()> {
    let board = read_board(&arguments.board)?;
    let info = arguments.camera_info.as_deref().map(read_camera_info);
    let camera = info.transpose()?.map(|info| info.camera);
    let detectors = Detectors::new(board, arguments.measuring.options(), camera);
    let mut overlays = arguments.overlay.map(Overlays::new).transpose()?;
    let mut unreadable = 0;
    for path in &arguments.images {
        let name = path.display().to_string();
        let line = match read_image(path) {
            Ok(frame) => {
                let detector = detectors.of(&name, &frame);
                let begin = Instant::now();
                let outcome = detector.detect(&frame);
                let elapsed_ms = begin.elapsed().as_secs_f64() * 1e3;
                if let Some(overlays) = &mut overlays {
                    overlays.write(path, &frame, detector.board(), &outcome)?;
                }
                match &outcome {
                    Ok(detection) => DetectionLine::found(name, detection, elapsed_ms),
                    Err(miss) => {
                        let size = (frame.width(), frame.height());
                        DetectionLine::missed(name, size, miss.to_string(), elapsed_ms)
                    }
                }
            }
            Err(error) => {
                unreadable += 1;
                let reason = error.to_string();
                // the line begins with the path already
                let reason = reason
                    .strip_prefix(&format!("{name}: "))
                    .unwrap_or(&reason)
                    .to_owned();
                DetectionLine::unreadable(name, reason)
            }
        };
        let text = match arguments.format {
            Format::Text => line.text(),
            Format::Jsonl => line.json()?,
        };
        if print(&format!("{text}\n"))? == Reader::Gone {
            return Ok(());
        }
    }
    let all = arguments.images.len();
    anyhow::ensure!(
        unreadable == 0,
        "{unreadable} of {all} files could not be read"
    );
    Ok(())
}

/// Detectors of one board.
struct Detectors {
    /// Knows no camera.
    plain: Detector,
    /// Knows the camera, where there is one.
    calibrated: Option<(Camera, Detector)>,
}

impl Detectors {
    fn new(board: Board, options: DetectOptions, camera: Option<Camera>) -> Self {
        Self {
            calibrated: camera.map(|known| {
                let options = DetectOptions { camera, ..options };
                (known, Detector::new(board.clone(), options))
            }),
            plain: Detector::new(board, options),
        }
    }

    /// The one for a frame. A camera whose frames are of another size is not this frame's: it is left aside, with a warning.
    fn of(&self, image: &str, frame: &Frame) -> &Detector {
        let Some((camera, calibrated)) = &self.calibrated else {
            return &self.plain;
        };
        let (width, height) = (frame.width(), frame.height());
        if (width, height) == (camera.width as usize, camera.height as usize) {
            return calibrated;
        }
        eprintln!(
            "warning: {image}: {width} x {height} px, but the camera of --camera-info has {} x {} px: it is ignored here",
            camera.width, camera.height
        );
        &self.plain
    }
}

/// A folder of pictures of what was found, named after the images.
struct Overlays {
    folder: PathBuf,
    /// Names that are taken: images of two folders may be called the same.
    taken: HashSet<PathBuf>,
}

impl Overlays {
    fn new(folder: PathBuf) -> anyhow::Result<Self> {
        std::fs::create_dir_all(&folder).with_context(|| format!("folder {}", folder.display()))?;
        let taken = HashSet::new();
        Ok(Self { folder, taken })
    }

    fn write(
        &mut self,
        image: &Path,
        frame: &Frame,
        board: &Board,
        outcome: &Result<Detection, Miss>,
    ) -> anyhow::Result<()> {
        let stem = image.file_stem().unwrap_or_default().to_string_lossy();
        let path = std::iter::once(format!("{stem}.png"))
            .chain((2..).map(|n| format!("{stem}_{n}.png")))
            .map(|name| self.folder.join(name))
            .find(|path| !self.taken.contains(path))
            .context("no free name for the overlay")?;
        let picture = overlay(frame, board, outcome.as_ref(), &[], Scale::default());
        write_by_rename(&path, &png(&picture)?).with_context(|| format!("{}", path.display()))?;
        self.taken.insert(path);
        Ok(())
    }
}
