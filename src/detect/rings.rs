//! All rings of a frame, whatever their size: candidates of every pyramid level, measured on the frame itself.

use super::band_pass::BandPass;
use super::candidates::candidates;
use super::ring_fit::{RingFit, measure};
use crate::centre::{Ellipse, RingEllipses};
use crate::frame::{Frame, Level, Pixels, half, half_of_frame};
use rayon::prelude::*;

/// Levels whose shorter side is below this hold no ring that a lower level has not shown, px.
const LEAST_SIDE_PX: usize = 24;

/// Every ring that shows in the frame, each once, in no particular order but always the same. `sign` is 1 for dark
/// rings, -1 for light ones; `ratio` the board's inner over outer radius.
pub(super) fn find_rings(frame: &Frame, sign: f64, ratio: f64) -> Vec<RingFit> {
    let rough = rough_rings(frame, sign, ratio);
    let measured: Vec<RingFit> = rough
        .par_iter()
        .filter_map(|ring| measure(frame, ring, sign, ratio))
        .collect();
    distinct(measured)
}

fn rough_rings(frame: &Frame, sign: f64, ratio: f64) -> Vec<RingEllipses> {
    let band = match &frame.pixels {
        Pixels::U8(plane) => BandPass::of(plane, sign as f32),
        Pixels::U16(plane) => BandPass::of(plane, sign as f32),
    };
    let mut rough = candidates(&band, Level(0), ratio);
    let mut picture = half_of_frame(frame);
    let mut level = 1;
    while let Some(plane) = picture {
        if plane.width().min(plane.height()) < LEAST_SIDE_PX {
            break;
        }
        let band = BandPass::of(&plane, sign as f32);
        rough.extend(candidates(&band, Level(level), ratio));
        picture = half(&plane);
        level += 1;
    }
    rough
}

/// Keeps the best of the rings that lie on one another (a ring shows at two or three levels).
fn distinct(mut rings: Vec<RingFit>) -> Vec<RingFit> {
    let size = |e: &Ellipse| (e.major * e.minor).sqrt();
    let quality = |r: &RingFit| r.stray_px / size(&r.ellipses.outer);
    rings.sort_by(|a, b| quality(a).total_cmp(&quality(b)));
    let mut kept: Vec<RingFit> = Vec::new();
    for ring in rings {
        let outer = &ring.ellipses.outer;
        let overlaps = kept.iter().any(|k| {
            let other = &k.ellipses.outer;
            (other.centre - outer.centre).norm() < 0.7 * (other.minor + outer.minor)
        });
        if !overlaps {
            kept.push(ring);
        }
    }
    kept
}
