//! Rays from the middle of a patch outwards, and what is found along them.
//!
//! Texture has patches by the thousand, each with its rays: they walk in fixed-point numbers from pixel to pixel of the band, and a patch
//! is given up as soon as it can be.

use super::blobs::Blob;
use super::candidates::Seen;
use super::ellipse_fit::{ROUGH, fit_ellipse};
use crate::centre::Ellipse;
use nalgebra::{Matrix2, Point2, Vector2};
use std::sync::LazyLock;

/// Rays from the patch's centre.
const RAYS: usize = 32;
/// Fraction of them that must find what they look for.
const LEAST_RAYS: f64 = 0.7;
/// How many tell how large a disc is.
pub(super) const FEW_RAYS: usize = 16;
/// How many tell what shape a ring has.
pub(super) const ALL_RAYS: usize = RAYS;
/// So many rays, evenly spread, are looked at first: fewer than this must not come to nothing, which most of texture's do.
const FIRST_RAYS: (usize, usize) = (8, 5);
/// Where a ray begins: a compact patch is not left nearer to its middle, in units of its own radius.
pub(super) const BEGIN: f32 = 0.4;
/// Steps along a ray, in units of the patch's own radius: between this and that many pixels, up to the second. The band is smooth over a
/// pixel, and a crossing is interpolated.
const STEP: (f64, f64) = (0.125, 0.25);
const STEP_PX: f64 = 0.7;
/// Of the distances along the rays, in units of the patch's own radius, the third quartile over the first is at most this: what is found
/// around a ring's inner disc is shaped as that is.
const MOST_UNEVEN: f32 = 1.6;
/// The same of the first few rays.
const FIRST_UNEVEN: f32 = 2.0;
/// Fractional bits of a place on a ray.
const BITS: u32 = 32;

/// Unit vectors along the rays, the first few of them evenly spread.
static DIRECTIONS: LazyLock<[Vector2<f64>; RAYS]> = LazyLock::new(|| {
    let each = RAYS / FIRST_RAYS.0;
    std::array::from_fn(|i| {
        let turn = i % FIRST_RAYS.0 * each + i / FIRST_RAYS.0;
        let (sin, cos) = (std::f64::consts::TAU * turn as f64 / RAYS as f64).sin_cos();
        Vector2::new(cos, sin)
    })
});

/// What a ray has found: which ray, and how far from the middle in units of the patch's own radius.
#[derive(Clone, Copy)]
pub(super) struct Found {
    ray: usize,
    distance: f32,
}

/// All rays of one patch.
pub(super) struct Rays<'a> {
    seen: Seen<'a>,
    centre: Point2<f64>,
    /// Carries the unit circle to the ellipse with the patch's moments.
    axes: Matrix2<f64>,
}

impl<'a> Rays<'a> {
    /// `None` where the patch has no area.
    pub(super) fn of(seen: Seen<'a>, blob: &Blob) -> Option<Self> {
        let eigen = blob.spread.symmetric_eigen();
        let root = eigen.eigenvalues.map(|v| 2.0 * v.max(0.0).sqrt());
        (root.min() > 0.0).then(|| Self {
            seen,
            centre: blob.centre,
            axes: eigen.eigenvectors
                * Matrix2::from_diagonal(&root)
                * eigen.eigenvectors.transpose(),
        })
    }

    /// What is found along each of so many rays, which is one distance or several; `None` as soon as too many rays have found nothing, or the first
    /// few what is as uneven as around no disc.
    pub(super) fn each<const EACH: usize>(
        &self,
        rays: usize,
        find: impl Fn(&mut Ray) -> Option<[f32; EACH]>,
    ) -> Option<[Vec<Found>; EACH]> {
        let mut found: [Vec<Found>; EACH] = std::array::from_fn(|_| Vec::with_capacity(RAYS));
        let (mut count, mut most_missing) = (0, ((1.0 - LEAST_RAYS) * rays as f64) as usize);
        for ray in 0..rays.min(RAYS) {
            if ray == FIRST_RAYS.0
                && (count < FIRST_RAYS.1 || found.iter().any(|f| unevenness(f) > FIRST_UNEVEN))
            {
                return None;
            }
            let Some(distances) = find(&mut Ray::of(self, ray)) else {
                most_missing = most_missing.checked_sub(1)?;
                continue;
            };
            count += 1;
            for (found, distance) in found.iter_mut().zip(distances) {
                found.push(Found { ray, distance });
            }
        }
        Some(found)
    }

    /// The outline of the patch as its moments give it, in its middle size as the rays have found it; `None` where what they found is
    /// uneven. For a patch that is compact this is as good as an ellipse through what was found, and costs nothing.
    pub(super) fn outline(&self, found: &[Found]) -> Option<Ellipse> {
        if unevenness(found) > MOST_UNEVEN {
            return None;
        }
        let eigen = self.axes.symmetric_eigen();
        let long = eigen.eigenvalues.imax();
        let axis = eigen.eigenvectors.column(long);
        let size = f64::from(middle(found));
        Some(Ellipse {
            centre: self.centre,
            major: size * eigen.eigenvalues[long],
            minor: size * eigen.eigenvalues[1 - long],
            angle: axis[1].atan2(axis[0]),
        })
    }

    /// The ellipse through what was found; `None` where the distances are as uneven as around no disc, which costs much less to see than
    /// to fit.
    pub(super) fn through(&self, found: &[Found]) -> Option<Ellipse> {
        if unevenness(found) > MOST_UNEVEN {
            return None;
        }
        let point = |f: &Found| self.centre + self.axes * DIRECTIONS[f.ray] * f64::from(f.distance);
        let points: Vec<Point2<f64>> = found.iter().map(point).collect();
        fit_ellipse(&points, ROUGH).map(|fit| fit.ellipse)
    }
}

/// The middle one of the distances.
pub(super) fn middle(found: &[Found]) -> f32 {
    let distances = sorted(found);
    distances[found.len().min(RAYS) / 2]
}

/// The third quartile of the distances over the first.
fn unevenness(found: &[Found]) -> f32 {
    let distances = sorted(found);
    let quartile = |part: usize| distances[part * found.len().min(RAYS) / 4];
    quartile(3) / quartile(1)
}

/// The distances in their order, and infinity after them.
fn sorted(found: &[Found]) -> [f32; RAYS + 1] {
    let mut distances = [f32::INFINITY; RAYS + 1];
    for (to, from) in distances.iter_mut().zip(found) {
        *to = from.distance;
    }
    distances[..found.len().min(RAYS)].sort_unstable_by(f32::total_cmp);
    distances
}

/// One ray while it is followed: where it is, px of the level in fixed-point numbers.
pub(super) struct Ray<'a> {
    data: &'a [f32],
    size: (usize, usize),
    sign: f32,
    at: (i64, i64),
    step: (i64, i64),
    distance: f32,
    step_distance: f32,
}

impl<'a> Ray<'a> {
    fn of(rays: &Rays<'a>, ray: usize) -> Self {
        let plane = &rays.seen.band.plane;
        let axis = rays.axes * DIRECTIONS[ray];
        let step = (STEP_PX / axis.norm()).clamp(STEP.0, STEP.1);
        let fixed = |v: Vector2<f64>| {
            let one = (1_i64 << BITS) as f64;
            ((v.x * one) as i64, (v.y * one) as i64)
        };
        Self {
            data: plane.data(),
            size: (plane.width(), plane.height()),
            sign: rays.seen.sign,
            at: fixed(rays.centre.coords + axis * f64::from(BEGIN)),
            step: fixed(axis * step),
            distance: BEGIN,
            step_distance: step as f32,
        }
    }

    /// Distance from the middle in units of the patch's own radius, and the band there; `None` outside of the picture.
    pub(super) fn here(&self) -> Option<(f32, f32)> {
        let (x, y) = ((self.at.0 >> BITS) as usize, (self.at.1 >> BITS) as usize);
        // what is negative has become large
        if x >= self.size.0 - 1 || y >= self.size.1 - 1 {
            return None;
        }
        let part = |v: i64| (v as u32 >> 8) as i32 as f32 * (1.0 / (1 << 24) as f32);
        let (fx, fy) = (part(self.at.0), part(self.at.1));
        let rows = &self.data[y * self.size.0 + x..][..self.size.0 + 2];
        let (a, b) = (rows[0], rows[1]);
        let (c, d) = (rows[self.size.0], rows[self.size.0 + 1]);
        let (top, bottom) = (a + (b - a) * fx, c + (d - c) * fx);
        Some((self.distance, self.sign * (top + (bottom - top) * fy)))
    }

    /// The same one step on.
    pub(super) fn next(&mut self) -> Option<(f32, f32)> {
        self.at = (self.at.0 + self.step.0, self.at.1 + self.step.1);
        self.distance += self.step_distance;
        self.here()
    }
}

/// Where a value passes zero between two places.
pub(super) fn crossing((t0, v0): (f32, f32), (t1, v1): (f32, f32)) -> f32 {
    t0 + (t1 - t0) * v0 / (v0 - v1)
}
