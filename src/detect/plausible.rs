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
/// From this on the lattice is not completed: further rings would have to be many, and exact.
const SCATTERED: f64 = 0.12;
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
/// Edges of rings that are less than 3.5 px wide have been seen a quarter of the inner radius off, and looked sharp.
const PIXEL_SIGMA_PX: f64 = 0.7;
/// The same where the sensor's white clips what is lighter: whatever is light looks larger then, and its edges sharper than they are, so that
/// nobody can tell how far they have moved.
const MOST_OFF_RATIO_IF_CLIPPED: f64 = 0.45;

/// Whether the inner circles are as large as the board file says, as far as edges tell: a fit of grey values knows no other ratio and
/// makes up for it with blur. Of rings as small or as blurred that edges are displaced nothing is asked. `clipped` is the sign of the rings
/// (1 dark, -1 light) where the frame's white is clipped.
pub(super) fn has_the_ratio(
    board: &Board,
    rings: &BTreeMap<Label, RingFit>,
    clipped: Option<f64>,
) -> bool {
    // light that spreads widens inner discs of dark rings, and closes those of light ones
    let off = |inner_over_outer: f64| {
        let off = (inner_over_outer / board.radius_ratio()).ln();
        match clipped {
            Some(sign) if sign * off > 0.0 => {
                off.abs() * MOST_OFF_RATIO / MOST_OFF_RATIO_IF_CLIPPED
            }
            _ => off.abs(),
        }
    };
    let ratio = |ring: &RingFit| {
        let (inner, outer) = (ring.inner?.mean_radius(), ring.outer.mean_radius());
        let narrow = (outer - inner).min(3.0 * inner);
        let sharp = ring.blur_sigma_px.hypot(PIXEL_SIGMA_PX) < LIGHT * narrow;
        sharp.then(|| off(inner / outer))
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

/// Whether most rings of a lattice stand so much beside their places that no further ones make it a board: not worth looking for these. A few
/// that do may be strays.
pub(super) fn is_scattered(rings: &BTreeMap<Label, RingFit>, places: &Places) -> bool {
    besides(rings, places).is_none_or(|mut besides| median(&mut besides) > SCATTERED)
}

/// Distances of the rings from their places, in steps.
fn besides(rings: &BTreeMap<Label, RingFit>, places: &Places) -> Option<Vec<f64>> {
    let besides = rings.iter().map(|(&label, ring)| {
        let place = places.expect(label)?;
        Some((ring.outer.centre - place.at).norm() / place.step_px())
    });
    besides.collect()
}

/// Whether places, sizes and contrasts of the rings agree with one board on one plane.
pub(super) fn is_plausible(
    board: &Board,
    rings: &BTreeMap<Label, RingFit>,
    places: &Places,
    asked: Asked,
) -> bool {
    let expected = board.outer_radius_m() / board.pitch_m();
    let Some(besides) = besides(rings, places) else {
        return false;
    };
    let squares: f64 = besides.iter().map(|beside| beside * beside).sum();
    let bent = (squares / rings.len() as f64).sqrt();
    let mut sizes = Vec::with_capacity(rings.len());
    for (&label, ring) in rings {
        let Some(place) = places.expect(label) else {
            return false;
        };
        let size_px = ring.outer.mean_radius();
        sizes.push((size_px / (expected * (place.column_px * place.row_px).sqrt())).ln());
    }
    let count = rings.len() as f64;
    let common = sizes.iter().sum::<f64>() / count;
    let uneven = (sizes.iter().map(|s| (s - common).powi(2)).sum::<f64>() / count).sqrt();
    let contrast =
        |pick: fn(f64, f64) -> f64, start| rings.values().map(|r| r.contrast).fold(start, pick);
    let (faintest, strongest) = (contrast(f64::min, f64::MAX), contrast(f64::max, 0.0));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::Polarity;
    use crate::centre::Ellipse;
    use nalgebra::{Point2, Vector2};

    fn circle(centre: Point2<f64>, radius: f64) -> Ellipse {
        Ellipse {
            centre,
            major: radius,
            minor: radius,
            angle: 0.0,
        }
    }

    /// 4 x 5 rings of an outer radius, px, whose inner one is so much of it, each moved.
    fn rings(
        outer_px: f64,
        ratio: f64,
        moved: impl Fn(Label) -> Vector2<f64>,
    ) -> BTreeMap<Label, RingFit> {
        let labels = (0..4).flat_map(|row| (0..5).map(move |column| (column, row)));
        let ring = |(column, row): Label| {
            let pitch_px = 3.0 * outer_px;
            let at = Point2::new(f64::from(column), f64::from(row)) * pitch_px
                + moved((column, row)) * pitch_px;
            RingFit {
                outer: circle(at, outer_px),
                inner: Some(circle(at, ratio * outer_px)),
                blur_sigma_px: 0.2,
                stray_px: 0.1,
                contrast: 0.5,
            }
        };
        labels.map(|label| (label, ring(label))).collect()
    }

    fn still(_: Label) -> Vector2<f64> {
        Vector2::zeros()
    }

    #[test]
    fn clipping_widens_what_is_light_and_nothing_else() {
        let board = Board::new(4, 5, 0.03, 0.005, 0.01, Polarity::Auto).unwrap();
        let has = |ratio: f64, clipped| has_the_ratio(&board, &rings(20.0, ratio, still), clipped);
        assert!(has(0.5, None) && !has(0.37, None) && !has(0.67, None));
        // inner discs of light rings look smaller, those of dark rings larger
        assert!(has(0.37, Some(-1.0)) && !has(0.67, Some(-1.0)));
        assert!(has(0.67, Some(1.0)) && !has(0.37, Some(1.0)));
        assert!(!has(0.3, Some(-1.0)) && !has(0.8, Some(1.0)));
    }

    #[test]
    fn edges_of_tiny_rings_say_nothing_of_the_ratio() {
        let board = Board::new(4, 5, 0.03, 0.005, 0.01, Polarity::Auto).unwrap();
        assert!(has_the_ratio(&board, &rings(5.0, 0.38, still), None));
        assert!(!has_the_ratio(&board, &rings(9.0, 0.38, still), None));
    }

    #[test]
    fn what_stands_anywhere_is_scattered_and_what_a_lens_bends_is_not() {
        let places = |rings: &BTreeMap<Label, RingFit>| {
            Places::fit(rings.iter().map(|(&l, r)| (l, r.outer.centre))).unwrap()
        };
        let anywhere = |(column, row): Label| {
            let angle = f64::from(column * 7 + row * 5);
            Vector2::new(angle.sin(), (2.3 * angle).cos()) * 0.25
        };
        let bends = |(column, row): Label| {
            let at = Vector2::new(f64::from(column) - 2.0, f64::from(row) - 1.5);
            at * (-0.03 * at.norm_squared())
        };
        let [loose, bent] = [rings(10.0, 0.5, anywhere), rings(10.0, 0.5, bends)];
        assert!(is_scattered(&loose, &places(&loose)));
        assert!(!is_scattered(&bent, &places(&bent)));
        let stray = rings(10.0, 0.5, |label| {
            let far = if label == (1, 2) { 0.9 } else { 0.0 };
            Vector2::new(far, 0.0)
        });
        assert!(!is_scattered(&stray, &places(&stray)));
    }
}
