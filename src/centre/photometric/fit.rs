//! Maximum likelihood of the ring model on a window: what is known of a ring, and fits for what they are needed for.

use super::descent::Descent;
use super::fitted::{FitError, RingFitted};
use super::model::RingModel;
use super::problem::{Problem, Workspace};
use super::shape::{AFFINE, PERSPECTIVE, SHAPE_PARAMETERS};
use super::window::Window;
use std::ops::Range;

/// Steps at most, accepted or not (where blur and size can hardly be told apart a fit creeps along a valley), and the last one: it is of less
/// than this many standard deviations squared, and its own error is far less.
const ALL_THE_WAY: (usize, f64) = (250, 0.05);
/// Steps at most of a fit that only has to show what stands around a ring, and its last one.
const ROUGH: (usize, f64) = (8, 1.0);

/// What a fit knows and what it has to find.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Given {
    /// Nothing is known.
    #[default]
    Nothing,
    /// The start is near the end: the first step goes all the way.
    NearStart,
    /// The start is near, and its shape (but not its place) is right: a board and its lens say so.
    Shape,
    /// The start is near, and its perspective is right. How large the ring looks is left to its pixels: that depends on how it was printed,
    /// and a size that is wrong moves the centre of a ring in perspective.
    Perspective,
}

impl Given {
    /// The parameters that are not to be found.
    pub(super) fn held(self) -> Range<usize> {
        match self {
            Self::Nothing | Self::NearStart => 0..0,
            Self::Shape => AFFINE..SHAPE_PARAMETERS,
            Self::Perspective => PERSPECTIVE..SHAPE_PARAMETERS,
        }
    }
}

/// A window's ring as it is known before the fit.
#[derive(Debug, Clone, Copy)]
pub struct Known<'a> {
    /// The pixels.
    pub window: &'a Window,
    /// Inner over outer radius on the board.
    pub ratio: f64,
    /// Coverages by the outer and inner circles of the rings around, in the window's padded rows.
    pub around: Option<&'a [Vec<f32>; 2]>,
    /// What is known of the ring before.
    pub given: Given,
}

/// Fits a ring from a start.
///
/// # Errors
/// [`FitError`] where the pixels are too few, determine no ring or the fit does not settle.
pub fn fit(known: &Known, start: &RingModel, room: &mut Workspace) -> Result<RingFitted, FitError> {
    let Known { window, given, .. } = *known;
    let mut problem = Problem::of(known, 0.0);
    let first = Descent::begin(&problem, start, given, room)?.descend(ALL_THE_WAY)?;
    if window.censored.is_empty() {
        return Ok(first);
    }
    // only now is the noise known that says how far beyond its end a clipped pixel may be
    problem.noise = first.noise;
    let given = match given {
        Given::Nothing => Given::NearStart,
        near => near,
    };
    Descent::begin(&problem, &first.model, given, room)?.descend(ALL_THE_WAY)
}

/// A fit for its residuals: it need not arrive, only come near enough to tell a ring from what stands around it.
///
/// # Errors
/// [`FitError`] where the pixels are too few or determine no ring.
pub(super) fn fit_roughly(
    known: &Known,
    start: &RingModel,
    noise: f64,
    room: &mut Workspace,
) -> Result<RingFitted, FitError> {
    let problem = Problem::of(known, noise);
    let mut fit = Descent::begin(&problem, start, known.given, room)?;
    match fit.descend(ROUGH) {
        Err(FitError::NotConverged { .. }) => fit.finish(),
        done => done,
    }
}

/// A fit that ends where a step would lower the sum of squares by less than `close`, whatever the noise: of a picture that has none.
///
/// # Errors
/// [`FitError`] where the pixels determine no ring or the fit does not settle.
pub(super) fn fit_closely(
    known: &Known,
    start: &RingModel,
    close: f64,
    room: &mut Workspace,
) -> Result<RingFitted, FitError> {
    let problem = Problem::of(known, 0.0);
    let mut fit = Descent::begin(&problem, start, known.given, room)?;
    fit.least_gain = close;
    fit.descend(ALL_THE_WAY)
}
