//! Fits of a board's rings without what the lens's bends do to them.
//!
//! A fit that is free takes the bends of a lens for a perspective, and its centre goes along: before a wide lens by many times its noise,
//! and the perspective it finds contradicts the board's. The map through the centres knows the bends well enough to say what a fit makes
//! of them.

use super::bent::{Bent, Image};
use super::fitted::RingFitted;
use super::lens_map::LensMap;
use super::problem::Workspace;
use super::straight::found_of_bent;
use nalgebra::Point2;
use rayon::prelude::*;

/// What bends do below this part of a centre's standard deviation is not asked for.
const WORTH: f64 = 0.2;

/// The fits of rings that a map bends so at these places (m) as they would be before a lens that bends no ring of this size (outer radius, m;
/// inner over outer radius); `None` where all bends are small: then what they move the curves by is what they move the centres by.
pub(super) fn unbent(
    rings: &[RingFitted],
    (plane_m, bent): (&[Point2<f64>], &[Option<Bent>]),
    map: &LensMap,
    (outer_radius_m, ratio): (f64, f64),
) -> Option<Vec<RingFitted>> {
    let pairs = rings.iter().zip(bent);
    if !pairs.flat_map(|(r, b)| Some((r, (*b)?))).any(is_worth) {
        return None;
    }
    let rings = rings.par_iter().zip(plane_m).zip(bent);
    let straight = rings.map_init(Workspace::default, |room, ((ring, place), bent)| {
        let image = |d| map.place(place + d * outer_radius_m);
        bent.and_then(|bent| straightened(ring, &bent, (&image, ratio), room))
            .unwrap_or(*ring)
    });
    Some(straight.collect())
}

/// Whether the bends of a ring are more than nothing against what is known of its centre.
fn is_worth((ring, bent): (&RingFitted, Bent)) -> bool {
    bent.beside_px >= WORTH * deviation_px(ring)
}

fn deviation_px(ring: &RingFitted) -> f64 {
    (0.5 * ring.centre_covariance().trace()).sqrt()
}

fn straightened(
    ring: &RingFitted,
    bent: &Bent,
    (image, ratio): (&impl Image, f64),
    room: &mut Workspace,
) -> Option<RingFitted> {
    let unlike_px = bent.unlike_px(ring.model.blur.sigma_px());
    let found = if unlike_px < WORTH * deviation_px(ring) {
        bent.free()?
    } else {
        found_of_bent(ring, bent, image, ratio, room)?
    };
    let mut straight = *ring;
    let shape = &mut straight.model.shape;
    shape.centre -= found.centre - bent.straight.centre;
    shape.perspective -= found.perspective - bent.straight.perspective;
    Some(straight)
}
