//! The paper's adaptive image enhancement (section III-A): sharpens the edges of blurred rings.
//!
//! ```text
//! frame -> joint_histogram -> otsu_2d        Step 1: thresholds (s, t) of grey value and neighbourhood mean
//!       -> regions                           Step 2: target A, background C, and B, D off the diagonal
//!       -> otsu_1d                           Step 3: B and D split at th into A' (edge) and C' (noise)
//!       -> sigmoid, restore                  Step 4: C' -> its median, A' from (v3, v4) to (v1, v2)
//! ```
//!
//! Steps 3 and 4 may be repeated; a repeat rebuilds B and D from the new picture with the first `s`, `t`, `v1`, `v2`.
//!
//! What it does to a blurred edge, and what to expect of it: the largest scatter is reached when the grey values in the
//! middle of the edge belong to neither class (a pixel closer to the picture's mean than half its class's mean
//! lowers the scatter), so `s` and `t` lie on the two flanks of the edge, and B and D hold the flanks between
//! them. The flank on the background's side becomes one grey value, the flank on the target's side is spread over the
//! target's own range: the edge turns into a step at `th`. Sub-pixel positions within the flank are lost, and the spread
//! values start again at the target's far end, so the picture is for finding rings and for people, not for
//! photometry. One run is the one to use: in a repeat the flattened flank is a single grey value that may fall on
//! either side of the new th, and then moves the edge.
//!
//! Grey values stay in the depth of the frame. For the joint histogram a 16-bit frame is cut into 256 equal levels
//! between its smallest and largest value (an 8-bit frame keeps its own 256); the thresholds come back as the
//! largest grey value of their level, and everything after Step 1 works on whole grey values.

mod joint_histogram;
mod levels;
mod neighbourhood;
mod otsu_1d;
mod otsu_2d;
mod regions;
mod restore;
mod sigmoid;

pub use joint_histogram::JointHistogram;
pub use otsu_1d::otsu_1d;
pub use otsu_2d::{LevelThresholds, otsu_2d};
pub use sigmoid::Sigmoid;

use crate::board::Polarity;
use crate::frame::{Frame, Pixels, Plane};
use levels::{Grey, Levels};
use regions::Thresholds;
use restore::Table;
use std::borrow::Cow;
use std::num::NonZeroU32;

/// The class of the rings: it is the paper's target.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Target {
    /// Rings darker than the board.
    Dark,
    /// Rings lighter than the board.
    Light,
}

impl Target {
    /// The rings' class on a board of this polarity; `None` where it is not known and both have to be tried.
    pub fn of(polarity: Polarity) -> Option<Self> {
        match polarity {
            Polarity::DarkOnLight => Some(Self::Dark),
            Polarity::LightOnDark => Some(Self::Light),
            Polarity::Auto => None,
        }
    }
}

/// What the enhancement made of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Enhanced {
    /// The enhanced frame: same size, depth, stamp and source.
    pub frame: Frame,
    /// What was chosen on the way, or why nothing was changed.
    pub outcome: Outcome,
}

/// Whether a frame could be enhanced.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// Edges were restored with these values.
    Restored(Choices),
    /// The frame is returned as it came.
    Unchanged(Reason),
}

/// Why a frame has nothing to enhance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Reason {
    /// No threshold pair leaves pixels on both sides: one grey level, or no pixels.
    #[error("the frame has only one grey level")]
    OneLevel,
    /// The pixels off the diagonal are none, or all of one grey value, or already what Step 4 would make them (a picture
    /// of two levels).
    #[error("the frame has no blurred edges")]
    NoEdges,
}

/// The values chosen by Steps 1 to 4, in grey values of the frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Choices {
    /// Largest grey value of the dark class (the paper's s').
    pub s: u16,
    /// Largest neighbourhood mean of the dark class (the paper's t').
    pub t: u16,
    /// Smallest grey value of the target region A.
    pub v1: u16,
    /// Largest grey value of the target region A.
    pub v2: u16,
    /// One entry for each run of Steps 3 and 4 that changed something: at least one, at most as many as asked for.
    pub rounds: Vec<Round>,
}

/// The values chosen by one run of Steps 3 and 4, in grey values of the frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Round {
    /// Largest grey value of the dark part of B and D.
    pub th: u16,
    /// Smallest grey value of the edge region A'.
    pub v3: u16,
    /// Largest grey value of the edge region A'.
    pub v4: u16,
    /// Median grey value of the noise region C', which replaces all of it.
    pub median: u16,
}

/// Enhances a frame (Steps 1 to 4) whose rings are of class `target`, running Steps 3 and 4 at most `rounds` times.
///
/// A picture that offers nothing to restore, of whatever size, comes back as it is with the reason.
pub fn enhance(frame: &Frame, target: Target, rounds: NonZeroU32) -> Enhanced {
    let (pixels, outcome) = match &frame.pixels {
        Pixels::U8(plane) => {
            let (plane, outcome) = enhance_plane(plane, target, rounds);
            (Pixels::U8(plane), outcome)
        }
        Pixels::U16(plane) => {
            let (plane, outcome) = enhance_plane(plane, target, rounds);
            (Pixels::U16(plane), outcome)
        }
    };
    let frame = Frame {
        pixels,
        stamp: frame.stamp,
        source: frame.source.clone(),
    };
    Enhanced { frame, outcome }
}

fn enhance_plane<T: Grey>(
    plane: &Plane<T>,
    target: Target,
    rounds: NonZeroU32,
) -> (Plane<T>, Outcome) {
    let unchanged = |reason| (plane.clone(), Outcome::Unchanged(reason));
    let levels = Levels::of(plane);
    let Some(found) = otsu_2d(&JointHistogram::of(plane, &levels)) else {
        return unchanged(Reason::OneLevel);
    };
    let thresholds = Thresholds {
        s: levels.largest_in(found.s),
        t: levels.largest_in(found.t),
    };
    let Some((v1, v2)) = regions::target_range(plane, thresholds, target) else {
        return unchanged(Reason::OneLevel);
    };
    let mut current = Cow::Borrowed(plane);
    let mut done = Vec::new();
    for _ in 0..rounds.get() {
        let histogram = regions::edge_histogram(&current, thresholds);
        let Some(table) = Table::new(&histogram, target, (v1, v2)) else {
            break;
        };
        let restored = restore::apply(&current, thresholds, &table);
        if restored == *current {
            break;
        }
        done.push(table.round());
        current = Cow::Owned(restored);
    }
    if done.is_empty() {
        return unchanged(Reason::NoEdges);
    }
    let choices = Choices {
        s: thresholds.s.into(),
        t: thresholds.t.into(),
        v1: v1.into(),
        v2: v2.into(),
        rounds: done,
    };
    (current.into_owned(), Outcome::Restored(choices))
}

#[cfg(test)]
mod tests;
