//! How many rings speak for a detection, and whether they are rings.

use super::detection::{Detection, Miss, Ring};
use std::ops::Range;

/// Fraction of a board's rings that must have a ring's grey values.
const LEAST_MEASURED: f64 = 0.5;
/// Contrast across the inner circle over that across the outer: 1 in print, less than a quarter where a dot is taken for a ring, more
/// than twice where a fit under heavy blur makes up levels that no print has, to resemble a spot of another shape.
const INSIDE: Range<f64> = 0.5..2.0;
/// Blur sigma over the ring's width from which edges say so little that blur is to blame.
const HEAVY: f64 = 0.5;

/// The answer for which more rings speak; the first where as many do.
pub(super) fn clearer(
    first: Result<Detection, Miss>,
    second: Result<Detection, Miss>,
) -> Result<Detection, Miss> {
    if evidence(&second) > evidence(&first) {
        second
    } else {
        first
    }
}

/// How many rings speak for a detection.
pub(super) fn evidence(detection: &Result<Detection, Miss>) -> usize {
    detection
        .as_ref()
        .map_or(0, |found| match found.photometric {
            Some(_) => measured(&found.rings).count(),
            None => found.rings.len(),
        })
}

/// The rings whose grey values are a ring's: paper shows again inside, which a plain dot does not have.
fn measured(rings: &[Ring]) -> impl Iterator<Item = &Ring> {
    rings.iter().filter(|ring| {
        ring.kept
            .as_ref()
            .is_some_and(|kept| INSIDE.contains(&kept.fitted.model.inner_over_outer()))
    })
}

/// Whether enough of the rings have the grey values of rings.
pub(super) fn are_rings(rings: &[Ring]) -> Result<(), Miss> {
    let fitted = measured(rings).count();
    if fitted as f64 >= LEAST_MEASURED * rings.len() as f64 {
        return Ok(());
    }
    let median = |of: fn(&Ring) -> f64| {
        let mut values: Vec<f64> = rings.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    };
    let (sigma_px, width_px) = (
        median(|ring| ring.blur_sigma_px),
        median(|ring| ring.ellipses.width()),
    );
    if sigma_px > HEAVY * width_px {
        return Err(Miss::TooBlurred { sigma_px, width_px });
    }
    Err(Miss::NotRings {
        found: rings.len(),
        rings: fitted,
    })
}
