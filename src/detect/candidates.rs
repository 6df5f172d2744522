//! Patches that a ring of the other grey surrounds: rough inner and outer ellipses.

use super::band_pass::BandPass;
use super::blobs::{Blob, blobs};
use super::ellipse_fit::{ROUGH, fit_ellipse};
use super::runs::Side;
use crate::centre::{Ellipse, RingEllipses};
use crate::frame::Level;
use nalgebra::{Matrix2, Point2, Vector2};
use rayon::prelude::*;
use std::sync::LazyLock;

/// Rays from the patch's centre.
const RAYS: usize = 32;
/// Fraction of the rays that must cross into the ring and out of it again.
const LEAST_RAYS: f64 = 0.7;
/// Patches smaller than this are no inner disc, px of the level.
const LEAST_AREA: f64 = 5.0;
/// Patches larger than this are seen better one level up, px of the level.
const MOST_AREA: f64 = 2400.0;
/// At most so many patches of a level are looked at, so that texture costs no more than a full board.
const MOST_PATCHES: usize = 2048;
/// So many rays, evenly spread, are looked at first: fewer than this must not come to nothing, which most of texture's do.
const FIRST_RAYS: (usize, usize) = (8, 5);
/// Where a ray begins: a compact patch is not left nearer to its middle, in units of its own radius.
const BEGIN: f64 = 0.4;
/// Steps along a ray, in units of the patch's own radius, and the least, px of the level.
const STEP: f64 = 0.1;
const LEAST_STEP_PX: f64 = 0.4;
/// Of the distances along the rays, in units of the patch's own radius, the third quartile over the first is at most this: what is found
/// around a ring's inner disc is shaped as that is.
const MOST_UNEVEN: f64 = 1.6;

/// A band looked at for dark rings (1) or for light ones (-1), which are dark in it with all signs turned.
#[derive(Clone, Copy)]
pub(super) struct Seen<'a> {
    pub(super) band: &'a BandPass,
    pub(super) sign: f32,
}

impl Seen<'_> {
    fn at(&self, place: Point2<f64>) -> Option<f32> {
        let value = self.band.plane.bilinear(place.x, place.y)?;
        Some(self.sign * value)
    }

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
    compact(seen.band, seen.light())
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
    compact(seen.band, seen.dark())
        .par_iter()
        .filter_map(|blob| outline(seen, blob))
        .map(|outline| to_frame(&outline, level))
        .collect()
}

/// Where the band passes zero around a dark patch.
fn outline(seen: Seen, blob: &Blob) -> Option<Ellipse> {
    let axes = half_axes(&blob.spread)?;
    let ends = along_rays(&axes, |axis| {
        let at = |t: f64| seen.at(blob.centre + axis * t);
        let step = step(&axis);
        let end = (0..=((2.0 - BEGIN) / step) as u32)
            .map(|k| BEGIN + f64::from(k) * step)
            .find(|&t| at(t).is_some_and(|v| v >= 0.0))?;
        let end = end - 0.5 * step;
        Some((end, blob.centre + axis * end))
    })?;
    through(&ends)
}

/// Steps along a ray.
fn step(axis: &Vector2<f64>) -> f64 {
    STEP.max(LEAST_STEP_PX / axis.norm())
}

/// The ellipse through what was found along rays: distances, and points there; `None` where the distances are as uneven as around no
/// disc, which costs much less to see than to fit.
fn through(found: &[(f64, Point2<f64>)]) -> Option<Ellipse> {
    let mut distances: Vec<f64> = found.iter().map(|&(t, _)| t).collect();
    distances.sort_unstable_by(f64::total_cmp);
    let quartile = |part: usize| distances[part * distances.len() / 4];
    if found.is_empty() || quartile(3) > MOST_UNEVEN * quartile(1) {
        return None;
    }
    let points: Vec<Point2<f64>> = found.iter().map(|&(_, point)| point).collect();
    fit_ellipse(&points, ROUGH).map(|fit| fit.ellipse)
}

/// Unit vectors along the rays.
static DIRECTIONS: LazyLock<[Vector2<f64>; RAYS]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / RAYS as f64).sin_cos();
        Vector2::new(cos, sin)
    })
});

/// What is found along each ray, its direction given in units of the patch's own radii; `None` as soon as too many rays have found
/// nothing.
fn along_rays<T>(axes: &Matrix2<f64>, find: impl Fn(Vector2<f64>) -> Option<T>) -> Option<Vec<T>> {
    let mut found = Vec::with_capacity(RAYS);
    for i in 0..RAYS {
        let each = RAYS / FIRST_RAYS.0;
        found.extend(find(
            axes * DIRECTIONS[i % FIRST_RAYS.0 * each + i / FIRST_RAYS.0],
        ));
        let possible = found.len() + RAYS - 1 - i;
        let hopeless = i + 1 == FIRST_RAYS.0 && found.len() < FIRST_RAYS.1;
        if hopeless || (possible as f64) < LEAST_RAYS * RAYS as f64 {
            return None;
        }
    }
    Some(found)
}

/// The compact patches of a level; where there are too many, those that stand out most from the noise about
/// them, in the order in which they were found.
fn compact(band: &BandPass, side: Side) -> Vec<Blob> {
    let mut compact = blobs(band, side);
    compact.retain(is_compact);
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

fn is_compact(blob: &Blob) -> bool {
    // few pixels make a rough outline
    let tolerance = 0.2 + 2.0 / blob.area;
    (LEAST_AREA..=MOST_AREA).contains(&blob.area)
        && blob.aspect() > 0.25
        && blob.ellipse_misfit() < tolerance
}

/// The two outlines of the ring around a patch: where the band turns dark and where it turns light again.
fn surrounded(seen: Seen, blob: &Blob, ratio: f64) -> Option<RingEllipses> {
    let axes = half_axes(&blob.spread)?;
    let margin = f64::from(seen.band.margins.at(blob.centre.x, blob.centre.y));
    let reach = (2.5 / ratio, margin);
    let crossings = along_rays(&axes, |axis| cross_ring(seen, blob.centre, axis, reach))?;
    let (inner, outer): (Vec<_>, Vec<_>) = crossings.into_iter().unzip();
    let ring = RingEllipses {
        inner: through(&inner)?,
        outer: through(&outer)?,
    };
    looks_concentric(&ring, ratio, 2.0).then_some(ring)
}

/// Blur lets the inner edge shrink and the outer one grow, down to this fraction of the board's radius ratio before the
/// inner disc drowns.
const MOST_SHRINKAGE: f64 = 0.33;

/// Whether two ellipses can be the circles of one ring: nested, alike in shape, and their sizes in the board's `ratio`,
/// less what blur takes from it and within the factor `slack` above it.
pub(super) fn looks_concentric(ring: &RingEllipses, ratio: f64, slack: f64) -> bool {
    let (inner, outer) = (ring.inner.mean_radius(), ring.outer.mean_radius());
    let found = inner / outer;
    let aspects = (ring.inner.minor / ring.inner.major) / (ring.outer.minor / ring.outer.major);
    let apart = (ring.inner.centre - ring.outer.centre).norm();
    found > ratio * MOST_SHRINKAGE
        && found < (ratio * slack).min(0.5 * (1.0 + ratio))
        && apart < 0.3 * (outer - inner)
        && ring.outer.minor > 0.2 * ring.outer.major
        && (0.5..2.0).contains(&aspects)
}

/// The matrix that carries the unit circle to the ellipse with this spread.
fn half_axes(spread: &Matrix2<f64>) -> Option<Matrix2<f64>> {
    let eigen = spread.symmetric_eigen();
    let root = eigen.eigenvalues.map(|v| 2.0 * v.max(0.0).sqrt());
    (root.min() > 0.0).then(|| {
        eigen.eigenvectors * Matrix2::from_diagonal(&root) * eigen.eigenvectors.transpose()
    })
}

/// A distance along a ray and the point there.
type Crossing = (f64, Point2<f64>);

/// Follows one ray out of the patch: the zero crossings into the dark ring and out of it.
fn cross_ring(
    seen: Seen,
    centre: Point2<f64>,
    axis: Vector2<f64>,
    (reach, margin): (f64, f64),
) -> Option<(Crossing, Crossing)> {
    let at = |t: f64| seen.at(centre + axis * t).map(f64::from);
    let step = step(&axis);
    let mut previous = (BEGIN, at(BEGIN)?);
    let (mut inner, mut darkest) = (None, 0.0_f64);
    let steps = ((reach - BEGIN) / step) as usize;
    for t in (1..=steps).map(|i| BEGIN + i as f64 * step) {
        let value = at(t)?;
        let crossing = || {
            let (t0, v0) = previous;
            let at = t0 + (t - t0) * v0 / (v0 - value);
            (at, centre + axis * at)
        };
        match inner {
            None if value <= 0.0 && previous.1 > 0.0 => inner = Some(crossing()),
            None if t > 2.0 => return None,
            Some(begin) if value >= 0.0 && previous.1 < 0.0 => {
                if darkest < -margin {
                    return Some((begin, crossing()));
                }
                // noise made it cross before the ring began
                inner = None;
            }
            _ => {}
        }
        darkest = darkest.min(value);
        previous = (t, value);
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
            prop_assert!(compact(&band, Side::Light).len() <= MOST_PATCHES);
            prop_assert!(compact(&band, Side::Dark).len() <= MOST_PATCHES);
            let seen = Seen { band: &band, sign: 1.0 };
            prop_assert!(candidates(seen, Level(0), 0.5).len() <= MOST_PATCHES);
        }
    }
}
