//! One ring measured by its grey values: window, start, fit, and the gate that decides whether to believe it.

use super::fit::{FitError, RingFitted, fit};
use super::start::{start, window};
use crate::centre::{Ellipse, RingEllipses};
use crate::frame::Frame;
use nalgebra::Point2;

/// How far the fitted centre may be from the outer ellipse's, in its minor semi-axes.
const FARTHEST: f64 = 0.5;
/// The residuals of a ring are noise: larger than this fraction of its contrast, something else is in the window.
const MOST_NOISE: f64 = 0.25;
/// A centre less certain than this fraction of the outer minor semi-axis is no measurement.
const LEAST_CERTAIN: f64 = 0.1;
/// The window is cut anew where the fitted blur is this much larger than the one it was cut for.
const BLUR_GROWTH: f64 = 1.3;
/// Neighbouring rings are masked as far as this many blur sigmas beyond their outer ellipses.
const SKIRT_SIGMAS: f64 = 2.5;

/// Why a ring has no photometric centre.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum RingError {
    /// The ring lies outside the frame.
    #[error("the ring is outside the frame")]
    Outside,
    /// The fit failed.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The fit ended on something that is not this ring.
    #[error("the fit ended on something else: {what}")]
    NotThisRing {
        /// What gave it away.
        what: &'static str,
    },
}

/// A ring to be measured: what edges say of it and what stands around it.
#[derive(Debug, Clone, Copy)]
pub struct RingStart<'a> {
    /// The ellipses its edges gave, px.
    pub ellipses: RingEllipses,
    /// The blur its edges gave, px.
    pub sigma_px: f64,
    /// Inner over outer radius on the board.
    pub ratio: f64,
    /// 1 for a dark ring, -1 for a light one.
    pub sign: f64,
    /// Outer ellipses of the other rings of the frame, px.
    pub neighbours: &'a [Ellipse],
}

/// Measures a ring on the frame.
///
/// # Errors
/// [`RingError`] where its pixels determine no ring, or another one than was asked for.
pub fn measure_ring(frame: &Frame, ring: &RingStart) -> Result<RingFitted, RingError> {
    let outer = ring.ellipses.outer;
    let mut sigma_px = ring.sigma_px;
    let mut first = None;
    loop {
        let skirts = skirts(ring, sigma_px);
        let alone = |x: f64, y: f64| {
            !skirts
                .iter()
                .any(|skirt| skirt.contains(&Point2::new(x, y)))
        };
        let pixels = window(frame, &outer, sigma_px, alone).ok_or(RingError::Outside)?;
        let begin = match first {
            Some(model) => model,
            None => start(&pixels, &ring.ellipses, sigma_px, ring.ratio)
                .ok_or(FitError::Undetermined)?,
        };
        let fitted = fit(&pixels, &begin, ring.ratio)?;
        gate(ring, &fitted)?;
        if first.is_some() || fitted.model.blur.sigma_px() < BLUR_GROWTH * sigma_px.max(1.0) {
            return Ok(fitted);
        }
        sigma_px = fitted.model.blur.sigma_px();
        first = Some(fitted.model);
    }
}

/// The neighbours' ellipses grown by their blurred skirts.
fn skirts(ring: &RingStart, sigma_px: f64) -> Vec<Ellipse> {
    let outer = &ring.ellipses.outer;
    let grow = SKIRT_SIGMAS * sigma_px;
    let near = |e: &&Ellipse| {
        let apart = (e.centre - outer.centre).norm();
        apart > 0.5 * outer.minor && apart < outer.major + e.major + 2.0 * grow + 4.0
    };
    let grown = |e: &Ellipse| Ellipse {
        major: e.major + grow,
        minor: e.minor + grow,
        ..*e
    };
    ring.neighbours.iter().filter(near).map(grown).collect()
}

fn gate(ring: &RingStart, fitted: &RingFitted) -> Result<(), RingError> {
    let outer = &ring.ellipses.outer;
    let model = &fitted.model;
    let contrast = ring.sign * (model.paper - model.ring);
    let size = model.shape.ellipse(1.0).map(|e| (e.major * e.minor).sqrt());
    let expected = (outer.major * outer.minor).sqrt();
    let what = if (model.shape.centre - outer.centre).norm() > FARTHEST * outer.minor {
        "its centre is elsewhere"
    } else if !size.is_some_and(|s| s > 0.5 * expected && s < 1.6 * expected) {
        "its size is another"
    } else if contrast <= 0.0 || ring.sign * (model.inside - model.ring) <= 0.0 {
        "its contrast is reversed"
    } else if fitted.noise > MOST_NOISE * contrast {
        "its residuals are no noise"
    } else if fitted.centre_covariance().trace().sqrt() > LEAST_CERTAIN * outer.minor {
        "its centre is uncertain"
    } else {
        return Ok(());
    };
    Err(RingError::NotThisRing { what })
}
