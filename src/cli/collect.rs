//! The board in all inputs: image files, each for itself, and bags, which are streams.

mod files;
mod stream;

use super::interrupt::stop_flag;
use super::looking::{Looking, Step};
use super::progress::{Counts, Progress};
use crate::board::Board;
use crate::calibrate::{CalibrateOptions, FramesRead};
use crate::detect::{Detection, Detector};
use crate::formats::Outcome;
use crate::frame::{Frame, Stamp, Thumbnail};
use crate::report::{Picture, Pictures};
use crate::session::{Coverage, Session, SessionRules, View};
use crate::source::{Inputs, Origin};
use files::Files;
use std::ops::ControlFlow;
use std::sync::atomic::Ordering;
use stream::Stream;

/// The views of a run and what became of its inputs.
#[derive(Debug)]
pub struct Collected {
    /// The views of the image files, then those of the bags.
    pub views: Vec<View>,
    /// Every image file, then every view of the bags.
    pub outcomes: Vec<Outcome>,
    /// Frames read: image files and messages.
    pub frames: u64,
    /// Those of them in which the board was found.
    pub boards: u64,
    /// Those of these that became no view because the board moved.
    pub moving: u64,
    /// Small pictures of the views and of some files that are none, where they were asked for.
    pub pictures: Pictures,
    /// Frames of bags that became no views: how many, and why.
    pub passed_over: Vec<(u64, String)>,
}

impl Collected {
    /// What the views were chosen from.
    pub fn frames_read(&self) -> FramesRead {
        FramesRead {
            all: self.frames,
            with_board: self.boards,
            moving: self.moving,
        }
    }

    /// Fraction of the frame's area that the rings of the views cover, 0 to 1.
    pub fn coverage(&self) -> f64 {
        let mut coverage = Coverage::default();
        for view in &self.views {
            coverage.add(view);
        }
        coverage.fraction()
    }
}

/// Which frames become views.
#[derive(Debug, Clone)]
pub struct Rules {
    /// Of the image files; `None` keeps all of them.
    pub files: Option<SessionRules>,
    /// Of a bag.
    pub stream: SessionRules,
    /// How the camera is estimated while the views of a bag are chosen.
    pub options: CalibrateOptions,
    /// Whether small pictures of the frames are kept.
    pub pictures: bool,
}

/// What was seen in one frame.
struct Seen {
    frame_id: String,
    stamp: Stamp,
    found: Result<Detection, String>,
    /// What a picture of it would be made of.
    small: Option<Thumbnail>,
}

/// Looks for the board in all frames, until there are no more or Ctrl-C says that these are enough.
///
/// # Errors
/// Where Ctrl-C cannot be waited for. What cannot be read is an outcome or a warning.
pub fn collect(
    detector: &Detector,
    inputs: Inputs,
    rules: &Rules,
    quiet: bool,
) -> anyhow::Result<Collected> {
    let stop = stop_flag()?;
    let mut progress = Progress::new(quiet, inputs.frame_count());
    let mut files = Files::default();
    let mut stream = Stream::new(detector.board(), rules);
    let look = |origin: &Origin, frame: Frame| {
        let found = detector.detect(&frame).map_err(|miss| miss.to_string());
        // of a stream only views are shown, and most of its frames become none
        let shown = rules.pictures && (found.is_ok() || !origin.is_stream());
        Seen {
            found,
            small: shown.then(|| Picture::reduce(&frame)),
            frame_id: frame.source,
            stamp: frame.stamp,
        }
    };
    let looking = Looking::on_all_cores(&stop, true);
    looking.each(inputs.items(), look, |step| {
        match step {
            Step::Warning(text) => progress.warn(&text),
            Step::Unreadable(origin, error) if origin.is_stream() => {
                stream.unreadable(&origin, &error.to_string(), &progress);
            }
            Step::Unreadable(origin, error) => {
                files.add(&origin, (Err(error.to_string()), None), &progress);
            }
            Step::Repeat(origin) => stream.repeat(&origin),
            Step::Looked(origin, seen) if origin.is_stream() => {
                stream.add(&origin, seen, &progress);
            }
            Step::Looked(origin, seen) => files.add(&origin, (seen.found, seen.small), &progress),
        }
        progress.tell(Counts {
            frames: files.count() + stream.frames(),
            boards: files.boards() + stream.boards(),
            views: stream.views().len(),
            uncertain_px: stream.uncertain_px(),
        });
        Ok(ControlFlow::Continue(()))
    })?;
    progress.finish();
    if stop.load(Ordering::Relaxed) {
        let frames = files.count() + stream.frames();
        progress.warn(&format!(
            "stopped after {frames} frames; going on with what they show"
        ));
    }
    stream.tell(&progress);
    Ok(joined(detector.board(), files, stream, rules))
}

/// The views of files and bags together; those of another size than most are not of the same camera.
fn joined(board: &Board, mut files: Files, mut stream: Stream, rules: &Rules) -> Collected {
    let frames = files.count() + stream.frames();
    let mut pictures = files.take_pictures();
    pictures.append(&mut stream.take_pictures());
    let of_stream = stream.views();
    let sizes = of_stream.iter().map(|view| (view.width, view.height));
    let size = files::most_common_size(files.sizes().chain(sizes));
    let session = |rules: &SessionRules| Session::new(board.clone(), *rules);
    let mut collected = Collected {
        views: Vec::new(),
        outcomes: Vec::new(),
        frames,
        boards: files.boards() + stream.boards(),
        moving: stream.moving(),
        pictures,
        passed_over: stream.passed_over(),
    };
    files.finish(&mut collected, rules.files.as_ref().map(session), size);
    for view in of_stream {
        match files::of_other_size((view.width, view.height), size) {
            Some(reason) => {
                let source = view.source.clone();
                collected.outcomes.push(Outcome::NotUsed { source, reason });
            }
            None => {
                collected
                    .outcomes
                    .push(Outcome::Used(collected.views.len()));
                collected.views.push(view.clone());
            }
        }
    }
    collected
}
