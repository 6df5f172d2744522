//! `ringcal detect`: finds the board in image files.

use super::output::{Reader, print};
use crate::board::Board;
use crate::centre::Estimator;
use crate::detect::{DetectOptions, Detection, Detector, Miss};
use crate::formats::{DetectionLine, write_by_rename};
use crate::frame::Frame;
use crate::report::{Scale, overlay, png};
use crate::source::{read_board, read_image};
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
    /// What gives the projected centre: big_ellipse, small_ellipse, one_sided, cross, pole_polar or photometric.
    #[arg(long, value_name = "NAME", default_value = Estimator::default().name())]
    estimator: Estimator,
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
    let estimator = arguments.estimator;
    let detector = Detector::new(board, DetectOptions { estimator });
    let mut overlays = arguments.overlay.map(Overlays::new).transpose()?;
    let mut unreadable = 0;
    for path in &arguments.images {
        let name = path.display().to_string();
        let line = match read_image(path) {
            Ok(frame) => {
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
