//! The verdict on views that gave no calibration.

use super::{Assessment, Grade};
use crate::calibrate::{CalibrateError, NEEDED_VIEWS};

/// What to say of views that gave no calibration; `inputs` is how many frames were read.
pub fn refused(error: &CalibrateError, inputs: u64) -> Assessment {
    Assessment {
        grade: Grade::NotEnough,
        reason: format!(
            "no calibration was made. {}",
            capitalised(&error.to_string())
        ),
        advice: advice(error, inputs),
        criteria: Vec::new(),
    }
}

/// What would help, in sentences.
fn advice(error: &CalibrateError, inputs: u64) -> Vec<String> {
    use CalibrateError as E;
    let show = "Take 15 views or more: the board large in the frame, in all its parts, tilted by 20 to 45 degrees to \
                all sides.";
    let one_camera =
        "Give frames of one camera, at one resolution and one focus setting, and of one board.";
    match error {
        E::TooFewViews { found: 0 } => vec![
            format!(
                "The board was found in none of the {inputs} inputs; the reasons are below. Does the board file describe \
                 this print?"
            ),
            show.to_owned(),
        ],
        E::TooFewViews { found } if (*found as u64) < inputs => vec![
            show.to_owned(),
            "Inputs in which the board was not found are listed below, with the reason.".to_owned(),
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
        E::TooFewViews { .. } | E::TooFewMeasurements { .. } | E::Undetermined { .. } => {
            vec![show.to_owned()]
        }
        E::NotConverged { .. } | E::Absurd { .. } => vec![
            one_camera.to_owned(),
            "Does the board file describe this print? Then add views at other tilts.".to_owned(),
        ],
        E::Size { .. } => vec![one_camera.to_owned()],
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

fn capitalised(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(characters).collect()
    })
}
