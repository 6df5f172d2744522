//! The noise that the rings of a board usually have, and which ring has more.

use super::fitted::RingFitted;
use super::ring::RingError;
use super::under::Under;
use super::window::Grid;

/// A ring with its own shape has at most so much of the others' noise.
const MOST: f64 = 1.5;
/// One whose shape is given may have more: its place is sure, and its covariance grows with its noise.
pub(super) const MOST_IF_GIVEN: f64 = 3.0;
/// And one that nothing covers has no more, in the worst light.
const MOST_IF_COVERED: f64 = 3.0;
/// Nor has one that a lens bends, which is all that is wrong with it, of the contrast.
const MOST_IF_BENT: f64 = 1.5e-2;
/// The model itself is right within this fraction of the contrast: without noise residuals are that, and differ.
const MODEL_ERROR: f64 = 1.4e-3;

/// What is usual on a board.
#[derive(Debug, Clone, Copy)]
pub(super) struct Usual {
    /// Median standard deviation of the residuals, as if no pixels had been binned.
    noise: f64,
}

impl Usual {
    /// Of the rings that have a fit.
    pub(super) fn of(rings: &[Under]) -> Self {
        let unbinned =
            |ring: &Under| Some(ring.fitted.ok()?.noise * ring.window.as_ref()?.grid.pixel_px);
        let mut noises: Vec<f64> = rings.iter().filter_map(unbinned).collect();
        noises.sort_by(f64::total_cmp);
        Self {
            noise: noises.get(noises.len() / 2).copied().unwrap_or(0.0),
        }
    }

    /// Whether a fit on a window of this grid has more than `most` times the usual noise.
    pub(super) fn is_noisy(&self, fitted: &RingFitted, grid: &Grid, most: f64) -> bool {
        let contrast = (fitted.model.paper - fitted.model.ring).abs();
        let usual = self.noise / grid.pixel_px;
        fitted.noise > most * usual.max(MODEL_ERROR * contrast)
    }

    /// Leaves out what is no ring like the others, though a fit has settled on it; says whether there was any.
    pub(super) fn leave_out_covered(rings: &mut [Under]) -> bool {
        let usual = Self::of(rings);
        let mut any = false;
        for ring in rings {
            let (Ok(fitted), Some(window)) = (ring.fitted, ring.window.as_ref()) else {
                continue;
            };
            let contrast = (fitted.model.paper - fitted.model.ring).abs();
            let expected = (usual.noise / window.grid.pixel_px).max(MODEL_ERROR * contrast);
            let times = fitted.noise / expected;
            if times > MOST_IF_COVERED && fitted.noise > MOST_IF_BENT * contrast {
                ring.fitted = Err(RingError::Covered { times });
                any = true;
            }
        }
        any
    }

    /// The same of a ring; `None` where it has no fit.
    pub(super) fn is_ring_noisy(&self, ring: &Under) -> Option<bool> {
        Some(self.is_noisy(&ring.fitted.ok()?, &ring.window.as_ref()?.grid, MOST))
    }
}
