//! The verdict on views that gave no calibration.

use super::{Assessment, Grade};
use crate::calibrate::{CalibrateError, NEEDED_VIEWS};
use crate::plural::counted;

/// The frames that the views were chosen from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FramesRead {
    /// All of them.
    pub all: u64,
    /// Those in which the board was found.
    pub with_board: u64,
    /// Those of them that became no view because the board moved.
    pub moving: u64,
}

/// What to say of views that gave no calibration.
pub fn refused(error: &CalibrateError, frames: FramesRead) -> Assessment {
    Assessment {
        grade: Grade::NotEnough,
        reason: format!(
            "no calibration was made. {}",
            capitalised(&error.to_string())
        ),
        advice: advice(error, frames),
        criteria: Vec::new(),
    }
}

/// What would help, in sentences.
fn advice(error: &CalibrateError, frames: FramesRead) -> Vec<String> {
    use CalibrateError as E;
    let show = "Take 15 views or more: the board large in the frame, in all its parts, tilted by 20 to 45 degrees to \
                all sides.";
    let one_camera =
        "Give frames of one camera, at one resolution and one focus setting, and of one board.";
    match error {
        E::TooFewViews { found: 0 } => vec![no_view(frames), show.to_owned()],
        E::TooFewViews { .. } if frames.moving > 0 => vec![hold_still(frames), show.to_owned()],
        E::TooFewViews { found } if (*found as u64) < frames.all => vec![
            show.to_owned(),
            "Inputs that became no view are listed below, with the reason.".to_owned(),
        ],
        E::TooFewLeft { .. } => vec![
            "The views contradict one another. Does the board file describe this print, and do all frames show it?"
                .to_owned(),
            one_camera.to_owned(),
        ],
        E::Parallel { .. } | E::Undetermined { name: "fx" | "fy", .. } => vec![
            "A board that always stands the same way fits every focal length: a longer lens, farther away, would see it just \
             the same. Only tilt tells them apart."
                .to_owned(),
            show.to_owned(),
        ],
        E::LensOpen { .. } | E::LensFolds { .. } => vec![
            "Show the board in the parts of the frame where no ring was seen, corners and edges first.".to_owned(),
            "Or ask for less: --fix k3, or --fix radial=1.".to_owned(),
        ],
        E::LensModel { .. } => vec![
            "Show the board in the parts of the frame where no ring was seen, corners and edges first: lenses differ there most."
                .to_owned(),
            "Or say which lens it is: --model equidistant for a fisheye, --model plumb_bob for most others.".to_owned(),
        ],
        E::TooFewViews { .. } | E::TooFewMeasurements { .. } | E::Undetermined { .. } => {
            vec![show.to_owned()]
        }
        E::NotConverged { .. } | E::Absurd { .. } => vec![
            one_camera.to_owned(),
            "Does the board file describe this print? Then add views at other tilts.".to_owned(),
        ],
        E::Size { .. } | E::CameraSize { .. } => vec![one_camera.to_owned()],
        E::SingleRing => vec![format!(
            "Use a board of at least 2 x 2 rings, and {NEEDED_VIEWS} views or more."
        )],
        E::Fixed(_) | E::GuessSize { .. } | E::QuarterTurns => {
            vec!["Change the options; the views are not at fault.".to_owned()]
        }
        E::BadRing { .. } | E::Label { .. } => vec![
            "A view holds what no detection gives; leave it out.".to_owned(),
        ],
    }
}

/// Why there is not a single view.
fn no_view(frames: FramesRead) -> String {
    let inputs = counted(frames.all, "input");
    match frames {
        FramesRead { with_board: 0, .. } => format!(
            "The board was found in none of the {inputs}; the reasons are below. Does the board file describe this print?"
        ),
        FramesRead { moving: 0, .. } => format!(
            "The board was found in {} of the {inputs}, but none was kept as a view; the reasons are below.",
            frames.with_board
        ),
        _ => format!(
            "The board was found in {} of the {inputs}, but none was kept as a view. {}",
            frames.with_board,
            hold_still(frames)
        ),
    }
}

/// What to do about a board that moved.
fn hold_still(frames: FramesRead) -> String {
    format!(
        "In {} the board moved: hold it still at each place for a moment, or take moving boards too with --max-motion-px 0.",
        counted(frames.moving, "input")
    )
}

fn capitalised(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(characters).collect()
    })
}
