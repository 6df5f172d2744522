//! `ringcal detect`: finds the board in image files and bags.

mod overlays;

use super::looking::{Looking, Step};
use super::measuring::Measuring;
use super::output::{Reader, print};
use super::reading::Reading;
use crate::board::Board;
use crate::camera::Camera;
use crate::detect::{DetectOptions, Detection, Detector, Miss};
use crate::formats::DetectionLine;
use crate::frame::{Frame, Stamp};
use crate::source::{Origin, read_board, read_camera_file};
use overlays::Overlays;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Arguments of `ringcal detect`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Image files, folders of them, and rosbag2 bags (MCAP, SQLite3), looked at in this order.
    #[arg(required = true, value_name = "INPUT")]
    inputs: Vec<PathBuf>,
    /// The board's YAML file.
    #[arg(long, value_name = "FILE")]
    board: PathBuf,
    #[command(flatten)]
    measuring: Measuring,
    #[command(flatten)]
    reading: Reading,
    /// The camera's calibration, for photometric: it knows the perspective of every ring. camera_info.yaml, or a camera in any other
    /// format that `ringcal convert` reads.
    #[arg(long, value_name = "FILE")]
    camera_info: Option<PathBuf>,
    /// What to print for each frame.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Also write a picture of what was found for each frame into this folder; never over an input.
    #[arg(long, value_name = "DIR")]
    overlay: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// Lines for people.
    Text,
    /// One line of JSON for each frame.
    Jsonl,
}

/// Prints one result per frame, in the order given. A file that cannot be read is a result too; the rest go on, and the
/// command fails at the end.
pub fn run(arguments: Arguments) -> anyhow::Result<()> {
    let board = read_board(&arguments.board)?;
    let info = arguments.camera_info.as_deref().map(read_camera_file);
    let camera = info.transpose()?.map(|info| info.camera);
    let measuring = arguments.measuring.options(&board)?;
    let inputs = arguments.reading.open(&arguments.inputs)?;
    let detectors = Detectors::new(board, measuring, camera);
    let overlays = arguments.overlay;
    let overlays = overlays.map(|folder| Overlays::new(folder, &inputs));
    let overlays = overlays.transpose()?;
    let mut results = Results {
        format: arguments.format,
        overlays,
        board: detectors.plain.board().clone(),
        warned_of: None,
        all: 0,
        unreadable: 0,
    };
    let stop = AtomicBool::new(false);
    let looking = if inputs.have_bags() {
        Looking::on_all_cores(&stop, false)
    } else {
        // one after the other, so that the time of each is its own
        Looking {
            batch: 1,
            ..Looking::on_all_cores(&stop, false)
        }
    };
    let keep = results.overlays.is_some();
    let look = |_: &Origin, frame| Seen::in_frame(frame, &detectors, keep);
    looking.each(inputs.items(), look, |step| results.take(step))?;
    let (all, unreadable) = (results.all, results.unreadable);
    anyhow::ensure!(
        unreadable == 0,
        "{unreadable} of {all} files or frames could not be read"
    );
    Ok(())
}

/// What was found in one frame.
struct Seen {
    size: (usize, usize),
    stamp: Stamp,
    outcome: Result<Detection, Miss>,
    elapsed_ms: f64,
    /// The size of the camera's frames, where they are not this frame's, px.
    camera_ignored: Option<(u32, u32)>,
    /// Kept to draw on.
    frame: Option<Frame>,
}

impl Seen {
    fn in_frame(frame: Frame, detectors: &Detectors, keep: bool) -> Self {
        let (detector, camera_ignored) = detectors.of(&frame);
        let begin = Instant::now();
        let outcome = detector.detect(&frame);
        Self {
            elapsed_ms: begin.elapsed().as_secs_f64() * 1e3,
            size: (frame.width(), frame.height()),
            stamp: frame.stamp,
            outcome,
            camera_ignored,
            frame: keep.then_some(frame),
        }
    }
}

/// The results so far, and where they go.
struct Results {
    format: Format,
    overlays: Option<Overlays>,
    board: Board,
    /// The input whose frames are known not to be the camera's.
    warned_of: Option<PathBuf>,
    all: u64,
    unreadable: u64,
}

impl Results {
    fn take(&mut self, step: Step<Seen>) -> anyhow::Result<ControlFlow<()>> {
        let line = match step {
            Step::Warning(text) => {
                eprintln!("warning: {text}");
                return Ok(ControlFlow::Continue(()));
            }
            // detect looks at every frame
            Step::Repeat(_) => return Ok(ControlFlow::Continue(())),
            Step::Unreadable(origin, error) => {
                self.unreadable += 1;
                // the line begins with the path and the number already
                let reason = error.to_string();
                let bare = reason.strip_prefix(&format!("{origin}: "));
                let reason = bare.unwrap_or(&reason).to_owned();
                let line = DetectionLine::unreadable(origin.path.display().to_string(), reason);
                match origin.number {
                    Some(number) => line.of_message(number, None),
                    None => line,
                }
            }
            Step::Looked(origin, seen) => {
                self.warn(&origin, &seen);
                if let (Some(overlays), Some(frame)) = (&mut self.overlays, &seen.frame) {
                    overlays.write(&origin, frame, &self.board, &seen.outcome)?;
                }
                line(&origin, &seen)
            }
        };
        self.all += 1;
        let text = match self.format {
            Format::Text => line.text(),
            Format::Jsonl => line.json()?,
        };
        Ok(match print(&format!("{text}\n"))? {
            Reader::There => ControlFlow::Continue(()),
            Reader::Gone => {
                // what was not wanted is no failure
                self.unreadable = 0;
                ControlFlow::Break(())
            }
        })
    }

    /// Says once for each input that its frames are not the camera's.
    fn warn(&mut self, origin: &Origin, seen: &Seen) {
        let Some((camera_width, camera_height)) = seen.camera_ignored else {
            return;
        };
        if self.warned_of.as_ref() != Some(&origin.path) {
            let (width, height) = seen.size;
            eprintln!(
                "warning: {origin}: {width} x {height} px, but the camera of --camera-info has {camera_width} x \
                 {camera_height} px: it is ignored here"
            );
            self.warned_of = Some(origin.path.clone());
        }
    }
}

fn line(origin: &Origin, seen: &Seen) -> DetectionLine {
    let name = origin.path.display().to_string();
    let line = match &seen.outcome {
        Ok(detection) => DetectionLine::found(name, detection, seen.elapsed_ms),
        Err(miss) => DetectionLine::missed(name, seen.size, miss.to_string(), seen.elapsed_ms),
    };
    match origin.number {
        Some(number) => line.of_message(number, Some(seen.stamp)),
        None => line,
    }
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

    /// The one for a frame. A camera whose frames are of another size is not this frame's: it is left aside, and its size is told.
    fn of(&self, frame: &Frame) -> (&Detector, Option<(u32, u32)>) {
        match &self.calibrated {
            None => (&self.plain, None),
            Some((camera, calibrated)) => {
                let size = (camera.width as usize, camera.height as usize);
                if (frame.width(), frame.height()) == size {
                    (calibrated, None)
                } else {
                    (&self.plain, Some((camera.width, camera.height)))
                }
            }
        }
    }
}
