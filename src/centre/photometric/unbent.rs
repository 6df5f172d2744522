//! Fits of a board's rings without what the lens's bends do to them.
//!
//! A fit that is free takes the bends of a lens for a perspective, and its centre goes along: before a wide lens by many times its noise,
//! and the perspective it finds contradicts the board's. The map through the centres knows the bends well enough to say what a fit makes
//! of them.

use super::bent::{bends, bent};
use super::fitted::RingFitted;
use super::lens_map::LensMap;
use super::problem::Workspace;
use super::straight::found_of_bent;
use nalgebra::Point2;
use rayon::prelude::*;

/// Of bends below this part of a centre's standard deviation the curves alone say well enough what they do.
const WORTH: f64 = 0.2;

/// The fits of rings at these places (m) as they would be before a lens that bends no ring of this size (outer radius, m; inner over outer
/// radius); `None` where all bends are small: then what they move the curves by is what they move the centres by.
pub(super) fn unbent(
    rings: &[RingFitted],
    plane_m: &[Point2<f64>],
    map: &LensMap,
    (outer_radius_m, ratio): (f64, f64),
) -> Option<Vec<RingFitted>> {
    let pairs = rings.par_iter().zip(plane_m);
    let straight: Vec<Option<(RingFitted, bool)>> = pairs
        .map_init(Workspace::default, |room, (fitted, place)| {
            let image = |d| map.place(place + d * outer_radius_m);
            let std = (0.5 * fitted.centre_covariance().trace()).sqrt();
            let mut straight = *fitted;
            if bends(image)? < WORTH * std {
                straight.model.shape.centre -= bent(image, ratio)?;
                return Some((straight, false));
            }
            let shape = map.ring(*place, outer_radius_m)?;
            let found = found_of_bent(&fitted.model, &shape, image, ratio, room)?;
            straight.model.shape.centre -= found.centre - shape.centre;
            straight.model.shape.perspective -= found.perspective - shape.perspective;
            Some((straight, true))
        })
        .collect();
    let worth = straight.iter().flatten().any(|(_, worth)| *worth);
    let pairs = straight.into_iter().zip(rings);
    worth.then(|| {
        pairs
            .map(|(straight, bent)| straight.map_or(*bent, |(ring, _)| ring))
            .collect()
    })
}
