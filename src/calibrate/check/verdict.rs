//! What a check says.

use super::{Alone, Cell};
use nalgebra::Point2;
use std::fmt;

/// Bias of a cell over its standard deviation beyond which it is no accident; one cell in 400 exceeds it by chance.
const SURE: f64 = 3.5;
/// A bias that does not matter to anybody, px.
const NO_MATTER_PX: f64 = 0.02;
/// A bias that spoils a measurement, px.
const SPOILS_PX: f64 = 0.5;
/// Part of the cells that must have been seen for a verdict.
const SEEN: f64 = 0.5;

/// What a check says; displays as one plain sentence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// No bias beyond what the scatter explains, or none that matters.
    Holds {
        /// The largest bias that a cell shows, px.
        worst_px: f64,
        /// Whether the views tell the camera by themselves, and much the same one.
        by_itself: bool,
    },
    /// There is a bias, and it is small.
    Drifted {
        /// The largest bias that is no accident, px.
        worst_px: f64,
        /// As of [`Verdict::Holds`].
        by_itself: bool,
    },
    /// The camera is another one.
    Fails {
        /// The largest bias that is no accident, px.
        worst_px: f64,
    },
    /// The views by themselves tell another camera.
    Another {
        /// The largest difference that is no accident, px.
        worst_px: f64,
        /// Where it is, px.
        at: Point2<f64>,
    },
    /// The camera sees no view as it is, wherever the board is placed.
    ExplainsNone,
    /// Too little of the frame was seen.
    NotEnough {
        /// Part of the cells with enough rings, %.
        percent: f64,
    },
}

impl Verdict {
    /// Of the bias over the frame, and of what the views tell by themselves.
    pub(super) fn of(field: &[Cell], alone: Option<&Alone>) -> Self {
        let told: Vec<&Cell> = field.iter().filter(|c| c.tells()).collect();
        let part = told.len() as f64 / field.len() as f64;
        let sure = told
            .iter()
            .filter(|c| c.bias_px.norm() > SURE * c.std_px)
            .map(|c| c.bias_px.norm())
            .fold(0.0, f64::max);
        let apart = |limit: f64| alone.filter(|alone| alone.worst_px > limit.max(sure));
        let by_itself = alone.is_some();
        if let Some(alone) = apart(SPOILS_PX) {
            return Self::another(alone);
        }
        if sure > SPOILS_PX {
            return Self::Fails { worst_px: sure };
        }
        if part < SEEN {
            return Self::NotEnough {
                percent: 100.0 * part,
            };
        }
        if let Some(alone) = apart(NO_MATTER_PX) {
            return Self::another(alone);
        }
        if sure > NO_MATTER_PX {
            return Self::Drifted {
                worst_px: sure,
                by_itself,
            };
        }
        Self::Holds {
            worst_px: told.iter().map(|c| c.bias_px.norm()).fold(0.0, f64::max),
            by_itself,
        }
    }

    fn another(alone: &Alone) -> Self {
        Self::Another {
            worst_px: alone.worst_px,
            at: alone.at,
        }
    }

    /// The verdict as one word: holds, drifted, fails or not_enough.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Holds { .. } => "holds",
            Self::Another { worst_px, .. } if *worst_px <= SPOILS_PX => "drifted",
            Self::Drifted { .. } => "drifted",
            Self::Fails { .. } | Self::Another { .. } | Self::ExplainsNone => "fails",
            Self::NotEnough { .. } => "not_enough",
        }
    }
}

/// What a check cannot see where the views do not tell the camera by themselves.
fn hidden(by_itself: bool) -> &'static str {
    if by_itself {
        ""
    } else {
        "; these views alone cannot calibrate a camera, and a wrong focal length may hide in the distance of the board: add \
         views tilted by 20 to 45 degrees to all sides"
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Holds {
                worst_px,
                by_itself,
            } => write!(
                f,
                "the calibration holds: with the board of each view placed anew, no part of the frame is off by more than its \
                 scatter explains or than matters ({worst_px:.3} px at most){}",
                hidden(*by_itself)
            ),
            Self::Drifted {
                worst_px,
                by_itself,
            } => write!(
                f,
                "the calibration is a little off, by {worst_px:.3} px where it is worst, with the board of each view placed \
                 anew: calibrate anew where that matters{}",
                hidden(*by_itself)
            ),
            Self::Fails { worst_px } => write!(
                f,
                "the calibration does not fit these views: with the board of each view placed anew it is off by {worst_px:.2} px \
                 where it is worst; calibrate anew"
            ),
            Self::Another { worst_px, at } => {
                let (off, px, when) = match self.word() {
                    "drifted" => (
                        "is a little off",
                        format!("{worst_px:.3}"),
                        " where that matters",
                    ),
                    _ => ("does not fit these views", format!("{worst_px:.2}"), ""),
                };
                write!(
                    f,
                    "the calibration {off}: these views alone tell another camera, {px} px away from it at worst, at pixel \
                     ({:.0}, {:.0}); calibrate anew{when}",
                    at.x, at.y
                )
            }
            Self::ExplainsNone => f.write_str(
                "the calibration does not fit these views: no position of the board explains any of them; calibrate anew",
            ),
            Self::NotEnough { percent } => write!(
                f,
                "no verdict: the rings of these views reach only {percent:.0} % of the frame; show the board all over it"
            ),
        }
    }
}
