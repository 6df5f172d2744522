//! Patches that a ring of the other grey surrounds: rough inner and outer ellipses.

use super::band_pass::BandPass;
use super::blobs::{Blob, blobs};
use super::outward::{ALL_RAYS, BEGIN, FEW_RAYS, Ray, Rays, crossing, middle};
use super::runs::Side;
use crate::centre::{Ellipse, RingEllipses};
use crate::frame::Level;
use nalgebra::Point2;
use rayon::prelude::*;

/// Patches smaller than this are no inner disc, px of the level.
const LEAST_AREA: f64 = 5.0;
/// Patches larger than this are seen better one level up, px of the level.
const MOST_AREA: f64 = 2400.0;
/// At most so many patches of a level are looked at, so that texture costs no more than a full board.
const MOST_PATCHES: usize = 2048;
/// How far a ray is followed for the end of an inner disc, in units of the patch's own radius.
const INNER_REACH: f32 = 2.0;
/// The same for the end of a disc.
const DISC_REACH: f32 = 2.0;
/// How far a ray of a dark patch may run through a light middle, in the same units.
const MIDDLE_REACH: f32 = 0.7;
/// A light middle of a dark patch is no patch of its own up to this area, px, and takes from the patch's own area what makes its
/// ellipse a misfit by this at most: a ring of 8 px.
const MIDDLES: f64 = 16.0;
const MOST_MISSING: f64 = 0.25;
/// How far above the board's radius ratio a candidate's may be.
const SLACK: f64 = 2.0;
/// What distances along the rays say of the ratio before ellipses are laid through them is right within this factor.
const CERTAINLY: f64 = 1.3;

/// A band looked at for dark rings (1) or for light ones (-1), which are dark in it with all signs turned.
#[derive(Clone, Copy)]
pub(super) struct Seen<'a> {
    pub(super) band: &'a BandPass,
    pub(super) sign: f32,
}

impl Seen<'_> {
    /// Where inner discs are.
    fn light(&self) -> Side {
        if self.sign > 0.0 {
            Side::Light
        } else {
            Side::Dark
        }
    }

    /// Where rings are.
    fn dark(&self) -> Side {
        if self.sign > 0.0 {
            Side::Dark
        } else {
            Side::Light
        }
    }
}

/// All rings that show at one level, in frame pixels. `ratio` is the board's inner over outer radius.
pub(super) fn candidates(seen: Seen, level: Level, ratio: f64) -> Vec<RingEllipses> {
    compact(seen.band, seen.light(), 0.0)
        .par_iter()
        .filter_map(|blob| surrounded(seen, blob, ratio))
        .map(|ring| RingEllipses {
            inner: to_frame(&ring.inner, level),
            outer: to_frame(&ring.outer, level),
        })
        .collect()
}

/// All dark patches that may be rings whose inner disc the blur has drowned: their outlines in frame pixels.
pub(super) fn disc_candidates(seen: Seen, level: Level) -> Vec<Ellipse> {
    compact(seen.band, seen.dark(), MIDDLES)
        .par_iter()
        .filter_map(|blob| outline(seen, blob))
        .map(|outline| to_frame(&outline, level))
        .collect()
}

/// Where the band passes zero around a dark patch.
fn outline(seen: Seen, blob: &Blob) -> Option<Ellipse> {
    let rays = Rays::of(seen, blob)?;
    let [ends] = rays.each(FEW_RAYS, |ray| leave_disc(ray).map(|end| [end]))?;
    rays.outline(&ends)
}

/// Follows one ray to where it leaves a dark patch.
fn leave_disc(ray: &mut Ray) -> Option<f32> {
    let mut previous = ray.here()?;
    // the middle of a small ring may be light, though too small a patch to be seen by itself
    while previous.1 >= 0.0 {
        if previous.0 > MIDDLE_REACH {
            return Some(BEGIN);
        }
        previous = ray.next()?;
    }
    while previous.0 < DISC_REACH {
        let next = ray.next()?;
        if next.1 >= 0.0 {
            return Some(crossing(previous, next));
        }
        previous = next;
    }
    None
}

/// The compact patches of a level; where there are too many, those that stand out most from the noise about
/// them, in the order in which they were found.
fn compact(band: &BandPass, side: Side, middles: f64) -> Vec<Blob> {
    let mut compact = blobs(band, side);
    compact.retain(|blob| is_compact(blob, middles));
    if compact.len() > MOST_PATCHES {
        let height = |blob: &Blob| {
            let (x, y) = (blob.centre.x, blob.centre.y);
            let middle = band.plane.bilinear(x, y).unwrap_or(0.0).abs();
            middle / band.margins.at(x, y).max(f32::MIN_POSITIVE)
        };
        let mut heights: Vec<f32> = compact.iter().map(height).collect();
        let at = compact.len() - MOST_PATCHES;
        let least = *heights.select_nth_unstable_by(at, f32::total_cmp).1;
        compact.retain(|blob| height(blob) >= least);
        compact.truncate(MOST_PATCHES);
    }
    compact
}

/// `middles` is the area in px that may be missing in the middle.
fn is_compact(blob: &Blob, middles: f64) -> bool {
    // few pixels make a rough outline
    let tolerance = 0.2 + 2.0 / blob.area + (middles / blob.area).min(MOST_MISSING);
    (LEAST_AREA..=MOST_AREA).contains(&blob.area)
        && blob.aspect() > 0.25
        && blob.ellipse_misfit() < tolerance
}

/// The two outlines of the ring around a patch: where the band turns dark and where it turns light again.
fn surrounded(seen: Seen, blob: &Blob, ratio: f64) -> Option<RingEllipses> {
    let margin = seen.band.margins.at(blob.centre.x, blob.centre.y);
    let reach = (2.5 / ratio) as f32;
    let rays = Rays::of(seen, blob)?;
    let [inner, outer] = rays.each(ALL_RAYS, |ray| cross_ring(ray, reach, margin))?;
    let sizes = f64::from(middle(&inner) / middle(&outer));
    // ellipses cost more than a look at the distances
    let (least, most) = sizes_over(ratio, SLACK);
    if !(least / CERTAINLY..most * CERTAINLY).contains(&sizes) {
        return None;
    }
    let ring = RingEllipses {
        inner: rays.outline(&inner)?,
        outer: rays.through(&outer)?,
    };
    looks_concentric(&ring, ratio, SLACK).then_some(ring)
}

/// Blur lets the inner edge shrink and the outer one grow, down to this fraction of the board's radius ratio before the
/// inner disc drowns.
const MOST_SHRINKAGE: f64 = 0.33;

/// Least and most of inner over outer size of what can be a ring.
fn sizes_over(ratio: f64, slack: f64) -> (f64, f64) {
    (
        ratio * MOST_SHRINKAGE,
        (ratio * slack).min(0.5 * (1.0 + ratio)),
    )
}

/// Whether two ellipses can be the circles of one ring: nested, alike in shape, and their sizes in the board's `ratio`,
/// less what blur takes from it and within the factor `slack` above it.
pub(super) fn looks_concentric(ring: &RingEllipses, ratio: f64, slack: f64) -> bool {
    let (inner, outer) = (ring.inner.mean_radius(), ring.outer.mean_radius());
    let found = inner / outer;
    let aspects = (ring.inner.minor / ring.inner.major) / (ring.outer.minor / ring.outer.major);
    let apart = (ring.inner.centre - ring.outer.centre).norm();
    let (least, most) = sizes_over(ratio, slack);
    found > least
        && found < most
        && apart < 0.3 * (outer - inner)
        && ring.outer.minor > 0.2 * ring.outer.major
        && (0.5..2.0).contains(&aspects)
}

/// Follows one ray out of the patch: the zero crossings into the dark ring and out of it.
fn cross_ring(ray: &mut Ray, reach: f32, margin: f32) -> Option<[f32; 2]> {
    let mut previous = ray.here()?;
    let (mut inner, mut darkest) = (None, 0.0_f32);
    while previous.0 < reach {
        let next = ray.next()?;
        match inner {
            None if next.1 <= 0.0 && previous.1 > 0.0 => inner = Some(crossing(previous, next)),
            None if next.0 > INNER_REACH => return None,
            Some(begin) if next.1 >= 0.0 && previous.1 < 0.0 => {
                if darkest < -margin {
                    return Some([begin, crossing(previous, next)]);
                }
                // noise made it cross before the ring began
                inner = None;
            }
            _ => {}
        }
        darkest = darkest.min(next.1);
        previous = next;
    }
    None
}

fn to_frame(ellipse: &Ellipse, level: Level) -> Ellipse {
    Ellipse {
        centre: Point2::new(
            level.to_frame(ellipse.centre.x),
            level.to_frame(ellipse.centre.y),
        ),
        major: ellipse.major * level.scale(),
        minor: ellipse.minor * level.scale(),
        angle: ellipse.angle,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Plane;
    use proptest::prelude::*;
    use rand::{RngExt, SeedableRng};

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(6))]
        #[test]
        fn no_texture_has_more_patches_than_are_looked_at(seed: u64, coarse in 1..5_usize) {
            let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
            let (width, height) = (800, 600);
            let greys: Vec<u8> = (0..width * height).map(|_| random.random()).collect();
            let at = |x: usize, y: usize| greys[y / coarse * width + x / coarse];
            let data = (0..width * height).map(|i| at(i % width, i / width)).collect();
            let picture = Plane::from_vec(width, height, data).unwrap();
            let band = BandPass::of(&picture);
            prop_assert!(compact(&band, Side::Light, 0.0).len() <= MOST_PATCHES);
            prop_assert!(compact(&band, Side::Dark, MIDDLES).len() <= MOST_PATCHES);
            let seen = Seen { band: &band, sign: 1.0 };
            prop_assert!(candidates(seen, Level(0), 0.5).len() <= MOST_PATCHES);
        }
    }
}
