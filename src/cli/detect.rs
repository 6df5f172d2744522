//! `ringcal detect`: finds the board in image files.

use super::board_file;
use crate::centre::Estimator;
use crate::detect::{DetectOptions, Detector};
use crate::formats::DetectionLine;
use crate::frame::{Frame, Stamp};
use std::io::Write;
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
    /// Which construction gives the projected centre: big_ellipse, small_ellipse, one_sided, cross or pole_polar.
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
    let board = board_file(&arguments.board)?;
    let detector = Detector::new(
        board,
        DetectOptions {
            estimator: arguments.estimator,
        },
    );
    let mut unreadable = 0;
    for path in &arguments.images {
        let line = match read(path) {
            Ok(frame) => look(&detector, &frame, path),
            Err(reason) => {
                unreadable += 1;
                DetectionLine::unreadable(path.display().to_string(), reason)
            }
        };
        let text = match arguments.format {
            Format::Text => line.text(),
            Format::Jsonl => line.json()?,
        };
        writeln!(std::io::stdout().lock(), "{text}")?;
    }
    anyhow::ensure!(
        unreadable == 0,
        "{unreadable} of {} files could not be read",
        arguments.images.len()
    );
    Ok(())
}

fn look(detector: &Detector, frame: &Frame, path: &Path) -> DetectionLine {
    let name = path.display().to_string();
    let begin = Instant::now();
    let outcome = detector.detect(frame);
    let elapsed_ms = begin.elapsed().as_secs_f64() * 1e3;
    match outcome {
        Ok(detection) => DetectionLine::found(name, &detection, elapsed_ms),
        Err(miss) => DetectionLine::missed(
            name,
            (frame.width(), frame.height()),
            miss.to_string(),
            elapsed_ms,
        ),
    }
}

fn read(path: &Path) -> Result<Frame, String> {
    let bytes = std::fs::read(path).map_err(|e| e.to_string())?;
    Frame::decode(&bytes, Stamp::default(), path.display().to_string()).map_err(|e| e.to_string())
}
