//! Whether the rings of a grid are those of one printed board, by what the fits of their grey values say.
//!
//! A fit lays a ring into whatever it is given: dots, squares, letters, gaps between things. Under blur, or noise, its residuals may
//! be small all the same. But the fits of a board's rings agree with the board file and with each other, as a blurred edge cannot deceive
//! them: the radius is the file's part of the pitch, and the same part everywhere; so is the part of the light that the dark
//! print swallows; the inner disc is as light as the ground; there is no less light than none; and the outlines are round, as circles are on a plane on which they stand in squares. Each is asked of the board as a whole (medians and quartiles,
//! so that a covered ring or two do not matter) and of what is left beyond the fits' own uncertainty.

use super::detection::{Measured, Miss, Odd, Ring};
use super::labelling::Label;
use crate::board::Board;
use crate::centre::photometric::RingFitted;
use nalgebra::Vector2;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// The rings' common radius over the board file's (logarithm): who measures a board by a ruler is nearer than that.
const MOST_OFF: f64 = 0.12;
/// The same where blur, sigma over the ring's width, hides shapes, as far as the sizes agree with each other: the size alone then tells rings
/// from spots of another shape.
const MOST_OFF_IF_HEAVY: f64 = 0.07;
const HEAVY: f64 = 0.6;
/// Spread of the rings' sizes about that (logarithm, one standard deviation). Blur of a shape that the model does not have leaves
/// half of it.
const MOST_UNEVEN: f64 = 0.045;
/// Cosine between rows and columns, and logarithm of a column's step over a row's, as the rings' shapes measure them. Of hexagons the first is
/// a half.
const MOST_SKEWED: f64 = 0.25;
/// Spread of the part of the light that print swallows, relative to it.
const MOST_CONTRASTS: f64 = 0.25;
/// The dark level over the light one: a black level that was taken off too much leaves little below zero.
const DARKEST: f64 = -0.1;
/// The contrast of inner disc and print over that of ground and print: the disc is ground, too. A fit to heavy blur misses by 0.3, one to
/// blur of less than this, sigma over the ring's width, by a hundredth.
const INSIDES: RangeInclusive<f64> = 0.6..=1.45;
const INSIDES_IF_LIGHT: RangeInclusive<f64> = 0.75..=1.3;
const LIGHT: f64 = 0.35;
/// How far outlines may be from circles, in radii: those of boards are by 0.004 at most, of blurred squares by 0.025.
const MOST_OUT_OF_ROUND: f64 = 0.02;
/// Blur sigma over the ring's width beyond which a fit lays a ring into whatever has a soft edge: nothing tells them apart. (A board can be measured
/// up to about once the width.)
const MOST_BLURRED: f64 = 1.5;
/// Standard deviations that count as uncertain.
const DEVIATIONS: f64 = 2.0;

/// Quartiles of a normal distribution are so many standard deviations apart.
const QUARTILES: f64 = 1.35;
/// The median of its absolute values, in standard deviations.
const NORMAL_MEDIAN: f64 = 0.674;

/// # Errors
/// [`Miss::TooBlurred`] where nobody can tell, [`Miss::OtherRadius`] or [`Miss::Unlike`] where the rings are none of this board's.
pub(super) fn are_the_boards(
    board: &Board,
    rings: &[Ring],
    measured: &Measured,
) -> Result<(), Miss> {
    let found = rings.len();
    let fits = fits(rings);
    let sizes = sizes(board, &fits);
    let sigma_px = middle(&fits, |fitted| fitted.model.blur.sigma_px()).0;
    let width_px = middle(&fits, |fitted| log_size(fitted).exp()).0 * (1.0 - board.radius_ratio());
    if sigma_px > MOST_BLURRED * width_px {
        return Err(Miss::TooBlurred { sigma_px, width_px });
    }
    let insides = if sigma_px < LIGHT * width_px {
        INSIDES_IF_LIGHT
    } else {
        INSIDES
    };
    let uncertain = DEVIATIONS * sizes.deviation;
    let most_off = if sigma_px > HEAVY * width_px {
        (MOST_OFF_IF_HEAVY + DEVIATIONS * sizes.spread).min(MOST_OFF)
    } else {
        MOST_OFF
    };
    // print that is not quite the model's (its edges sharpened by the camera, say) misleads a fit the more the smaller the ring is
    // against its blur: by a little more from each ring of a tilted board to the next
    let spread = if sigma_px > HEAVY * width_px {
        sizes.spread.min(sizes.uneven)
    } else {
        sizes.spread
    };
    let odd = if sizes.common.abs() > most_off + uncertain {
        let given = board.outer_radius_m() / board.pitch_m();
        return Err(Miss::OtherRadius {
            seen: given * sizes.common.exp(),
            given,
        });
    } else if spread > MOST_UNEVEN.hypot(uncertain) {
        Odd::Sizes
    } else if middle(&fits, |fitted| fitted.darkest).0 < DARKEST {
        Odd::Darkness
    } else if is_spread(&fits) {
        Odd::Contrasts
    } else if !insides.contains(&middle(&fits, |fitted| fitted.model.inner_over_outer()).0) {
        Odd::Insides
    } else if is_skewed(&fits) {
        Odd::Skewed
    } else if measured.out_of_round > MOST_OUT_OF_ROUND {
        Odd::Outlines
    } else {
        return Ok(());
    };
    Err(Miss::Unlike { found, odd })
}

/// The fits of the rings by their labels (column, row).
fn fits(rings: &[Ring]) -> BTreeMap<Label, &RingFitted> {
    let fits = rings.iter().filter_map(|ring| {
        let label = (i32::from(ring.column), i32::from(ring.row));
        Some((label, &ring.kept.as_ref()?.fitted))
    });
    fits.collect()
}

/// Sizes of the rings over those that the board file says they have where they are (logarithms). Where that is say the steps to the rings
/// beside each: whatever plane and lens do to a ring they do to these.
struct Sizes {
    common: f64,
    /// Standard deviation of a ring's about that.
    spread: f64,
    /// The same by how much neighbours differ: not by what changes slowly over the board.
    uneven: f64,
    /// Standard deviation of one of them by its own fit.
    deviation: f64,
}

fn sizes(board: &Board, fits: &BTreeMap<Label, &RingFitted>) -> Sizes {
    let part = board.outer_radius_m() / board.pitch_m();
    let over_file = fits.iter().filter_map(|(&label, fitted)| {
        let across = step(fits, label, (1, 0))?;
        let down = step(fits, label, (0, 1))?;
        let square_px = across.perp(&down).abs();
        Some((label, log_size(fitted) - (part * square_px.sqrt()).ln()))
    });
    let over_file: BTreeMap<Label, f64> = over_file.collect();
    let (common, spread) = quartiles(over_file.values().copied().collect());
    let next = over_file.iter().flat_map(|(&(column, row), size)| {
        let beside = [(column + 1, row), (column, row + 1)];
        beside.map(|label| Some((over_file.get(&label)? - size).abs()))
    });
    let uneven = quartiles(next.flatten().collect()).0 / (NORMAL_MEDIAN * 2.0_f64.sqrt());
    let deviations = fits.values().map(|fitted| fitted.size_deviation());
    Sizes {
        common,
        spread,
        uneven,
        deviation: quartiles(deviations.collect()).0,
    }
}

/// Logarithm of the outer radius (px) of a ring seen without perspective.
fn log_size(fitted: &RingFitted) -> f64 {
    let [xx, xy, yy] = fitted.model.shape.affine;
    -0.25 * (xx * yy - xy * xy).max(f64::MIN_POSITIVE).ln()
}

/// Whether circles on the plane that the rings show by their shapes stand in no square grid there: a hexagonal one, seen at an angle, may
/// be square in the frame.
fn is_skewed(fits: &BTreeMap<Label, &RingFitted>) -> bool {
    let seen = fits.iter().filter_map(|(&label, fitted)| {
        let across = step(fits, label, (1, 0))?;
        let down = step(fits, label, (0, 1))?;
        let [xx, xy, yy] = fitted.model.shape.affine;
        // lengths and angles in units of the ring's own radius
        let product = |a: &Vector2<f64>, b: &Vector2<f64>| {
            xx * a.x * b.x + xy * (a.x * b.y + a.y * b.x) + yy * a.y * b.y
        };
        let (columns, rows) = (product(&across, &across), product(&down, &down));
        let cosine = product(&across, &down) / (columns * rows).sqrt();
        Some((cosine, 0.5 * (columns / rows).ln()))
    });
    let (cosines, stretches): (Vec<f64>, Vec<f64>) = seen.unzip();
    [cosines, stretches].into_iter().any(|values| {
        let (common, spread) = quartiles(values);
        common.abs() > MOST_SKEWED + DEVIATIONS * spread
    })
}

/// From one ring to the next at a label, px, right up to second differences; `None` where it has too few neighbours.
fn step(
    fits: &BTreeMap<Label, &RingFitted>,
    (column, row): Label,
    (dx, dy): Label,
) -> Option<Vector2<f64>> {
    let at = |k: i32| {
        let fitted = fits.get(&(column + k * dx, row + k * dy))?;
        Some(fitted.model.shape.centre.coords)
    };
    let one_sided = |sign: i32| {
        let (own, next, second) = (at(0)?, at(sign)?, at(2 * sign)?);
        Some((next * 4.0 - own * 3.0 - second) * (0.5 * f64::from(sign)))
    };
    let both_sided = || Some((at(1)? - at(-1)?) * 0.5);
    both_sided()
        .or_else(|| one_sided(1))
        .or_else(|| one_sided(-1))
}

/// Whether the parts of the light that the rings' print swallows are as different as no board's.
fn is_spread(fits: &BTreeMap<Label, &RingFitted>) -> bool {
    let (part, spread) = middle(fits, |fitted| 1.0 - fitted.darkest);
    spread > MOST_CONTRASTS * part
}

fn middle(fits: &BTreeMap<Label, &RingFitted>, of: fn(&RingFitted) -> f64) -> (f64, f64) {
    quartiles(fits.values().map(|fitted| of(fitted)).collect())
}

/// The median, and the standard deviation by the quartiles.
fn quartiles(mut values: Vec<f64>) -> (f64, f64) {
    values.sort_by(f64::total_cmp);
    let at = |part: usize| values.get(part * values.len() / 4).copied().unwrap_or(0.0);
    (at(2), (at(3) - at(1)) / QUARTILES)
}
