//! Whether the rings of a lattice can be one board: texture, too, has blobs that stand in rows by chance.

use super::edges::median;
use super::labelling::Label;
use super::places::Places;
use super::ring_fit::RingFit;
use crate::board::Board;
use std::collections::BTreeMap;

/// Root mean square distance of the rings from where the others expect them, as a fraction of the step between neighbours.
/// A strong lens leaves 3 or 4 % on a board that fills the frame.
const MOST_BENT: f64 = 0.08;
/// Standard deviation of the rings' sizes about the board's (logarithm): blur changes them all alike.
const MOST_UNEVEN: f64 = 0.15;
/// The same where (nearly) every place of the board has a ring and all lie as exactly as this: a blur that inverts the contrast of some
/// rings lets those look half as large as the others. Where most inner discs have drowned, nothing lies as exactly.
const MOST_UNEVEN_WHERE_WHOLE: f64 = 0.45;
/// The same where grey values decide.
const MOST_UNEVEN_WHERE_ASKED: f64 = 0.6;
const WHOLE: f64 = 0.9;
const LEAST_BENT: f64 = 0.03;
const LEAST_BENT_IF_DROWNED: f64 = 0.06;
/// The rings' common size over the board's: blur makes them larger, a roughly measured board either.
const SIZE: (f64, f64) = (0.6, 1.7);
/// Where most inner discs have drowned they look smaller, the more the closer the blur is to the ring's own size.
const LEAST_SIZE_IF_DROWNED: f64 = 0.25;
/// The faintest ring's contrast over the strongest's: a shadow over a part of the board leaves more.
const LEAST_CONTRAST: f64 = 0.06;

/// How far the measured inner over outer radius may be from the board file's (logarithm), where blur leaves the edges where they are: sigma
/// (with what a pixel adds) below this fraction of the ring's width and of three inner radii.
const MOST_OFF_RATIO: f64 = 0.22;
const LIGHT: f64 = 0.2;
const PIXEL_SIGMA_PX: f64 = 0.5;

/// Whether the inner circles are as large as the board file says, as far as edges tell: a fit of grey values knows no other ratio and
/// makes up for it with blur. Of rings as small or as blurred that edges are displaced nothing is asked.
pub(super) fn has_the_ratio(board: &Board, rings: &BTreeMap<Label, RingFit>) -> bool {
    let ratio = |ring: &RingFit| {
        let (inner, outer) = (ring.inner?.mean_radius(), ring.outer.mean_radius());
        let narrow = (outer - inner).min(3.0 * inner);
        let sharp = ring.blur_sigma_px.hypot(PIXEL_SIGMA_PX) < LIGHT * narrow;
        sharp.then(|| (inner / outer / board.radius_ratio()).ln().abs())
    };
    let mut off: Vec<f64> = rings.values().filter_map(ratio).collect();
    2 * off.len() < rings.len() || median(&mut off) < MOST_OFF_RATIO
}

/// How much has to agree.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Asked {
    /// What makes a board.
    All,
    /// What is worth asking its grey values: where contrasts invert, outlines are those of rings, of their middles and of what lies
    /// between.
    Places,
}

/// Whether places, sizes and contrasts of the rings agree with one board on one plane.
pub(super) fn is_plausible(
    board: &Board,
    rings: &BTreeMap<Label, RingFit>,
    places: &Places,
    asked: Asked,
) -> bool {
    let expected = board.outer_radius_m() / board.pitch_m();
    let (mut bent, mut sizes) = (0.0, Vec::with_capacity(rings.len()));
    for (&label, ring) in rings {
        let Some(place) = places.expect(label) else {
            return false;
        };
        bent += ((ring.outer.centre - place.at).norm() / place.step_px()).powi(2);
        let size_px = ring.outer.mean_radius();
        sizes.push((size_px / (expected * (place.column_px * place.row_px).sqrt())).ln());
    }
    let count = rings.len() as f64;
    let common = sizes.iter().sum::<f64>() / count;
    let uneven = (sizes.iter().map(|s| (s - common).powi(2)).sum::<f64>() / count).sqrt();
    let contrast =
        |pick: fn(f64, f64) -> f64, start| rings.values().map(|r| r.contrast).fold(start, pick);
    let (faintest, strongest) = (contrast(f64::min, f64::MAX), contrast(f64::max, 0.0));
    let bent = (bent / count).sqrt();
    let drowned = 2 * rings.values().filter(|r| r.inner.is_none()).count() > rings.len();
    let (least_bent, least_size) = if drowned {
        (LEAST_BENT_IF_DROWNED, LEAST_SIZE_IF_DROWNED)
    } else {
        (LEAST_BENT, SIZE.0)
    };
    let whole = count >= WHOLE * board.ring_count() as f64 && bent < least_bent;
    let most_uneven = match asked {
        Asked::All if whole => MOST_UNEVEN_WHERE_WHOLE,
        Asked::Places if bent < least_bent => MOST_UNEVEN_WHERE_ASKED,
        Asked::All | Asked::Places => MOST_UNEVEN,
    };
    bent < MOST_BENT
        && uneven < most_uneven
        && (least_size..SIZE.1).contains(&common.exp())
        && faintest > LEAST_CONTRAST * strongest
}
