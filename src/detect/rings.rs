//! All rings of a frame, whatever their size: candidates of every pyramid level, measured on the frame itself.

use super::band_pass::BandPass;
use super::candidates::{candidates, disc_candidates};
use super::ring_fit::{RingFit, measure, measure_disc};
use crate::centre::Ellipse;
use crate::frame::{Frame, Level, Pixels, half, half_of_frame};
use rayon::prelude::*;

/// Levels whose shorter side is below this hold no ring that a lower level has not shown, px.
const LEAST_SIDE_PX: usize = 24;

/// Every ring that shows in the frame, each once, in no particular order but always the same. `sign` is 1 for dark
/// rings, -1 for light ones; `ratio` the board's inner over outer radius.
pub(super) fn find_rings(frame: &Frame, sign: f64, ratio: f64) -> Vec<RingFit> {
    let mut measured: Vec<RingFit> = Vec::new();
    for rough in over_levels(frame, sign, |band, level| candidates(band, level, ratio)) {
        // most rings show at two or three levels: once is enough
        let new: Vec<RingFit> = rough
            .par_iter()
            .filter(|ring| {
                !measured
                    .iter()
                    .any(|known| is_same(&known.outer, &ring.outer))
            })
            .filter_map(|ring| measure(frame, ring, sign, ratio))
            .collect();
        measured.extend(new);
    }
    distinct(measured)
}

/// The rings given and, where none of them is, discs so blurred that they may be rings whose inner disc has drowned.
pub(super) fn add_drowned(
    frame: &Frame,
    rings: Vec<RingFit>,
    sign: f64,
    ratio: f64,
) -> Vec<RingFit> {
    let rough = over_levels(frame, sign, disc_candidates);
    let discs: Vec<RingFit> = rough
        .concat()
        .par_iter()
        .filter_map(|outline| measure_disc(frame, outline, sign, ratio))
        .collect();
    let mut all = rings;
    for disc in distinct(discs) {
        if !all.iter().any(|ring| overlap(ring, &disc)) {
            all.push(disc);
        }
    }
    all
}

/// What `find` sees at every level of the frame's pyramid, level by level.
fn over_levels<C>(
    frame: &Frame,
    sign: f64,
    find: impl Fn(&BandPass, Level) -> Vec<C>,
) -> Vec<Vec<C>> {
    let band = match &frame.pixels {
        Pixels::U8(plane) => BandPass::of(plane, sign as f32),
        Pixels::U16(plane) => BandPass::of(plane, sign as f32),
    };
    let mut found = vec![find(&band, Level(0))];
    let mut picture = half_of_frame(frame);
    let mut level = 1;
    while let Some(plane) = picture {
        if plane.width().min(plane.height()) < LEAST_SIDE_PX {
            break;
        }
        found.push(find(&BandPass::of(&plane, sign as f32), Level(level)));
        picture = half(&plane);
        level += 1;
    }
    found
}

/// Keeps the best of the rings that lie on one another (a ring shows at two or three levels).
fn distinct(mut rings: Vec<RingFit>) -> Vec<RingFit> {
    let quality = |r: &RingFit| r.stray_px / (r.outer.major * r.outer.minor).sqrt();
    rings.sort_by(|a, b| quality(a).total_cmp(&quality(b)));
    let mut kept: Vec<RingFit> = Vec::new();
    for ring in rings {
        if !kept.iter().any(|other| overlap(other, &ring)) {
            kept.push(ring);
        }
    }
    kept
}

/// Outlines so near and alike belong to one ring.
const SAME_PLACE: f64 = 0.2;
const SAME_SIZE: f64 = 0.25;

fn is_same(a: &Ellipse, b: &Ellipse) -> bool {
    let size = |e: &Ellipse| (e.major * e.minor).sqrt();
    (a.centre - b.centre).norm() < SAME_PLACE * a.minor
        && (size(a) / size(b)).ln().abs() < SAME_SIZE
}

fn overlap(a: &RingFit, b: &RingFit) -> bool {
    (a.outer.centre - b.outer.centre).norm() < 0.7 * (a.outer.minor + b.outer.minor)
}
