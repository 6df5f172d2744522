//! The grey profile along one ray of a ring.

use crate::centre::{Ellipse, RingEllipses};
use crate::frame::{Pixel, Plane};
use nalgebra::{Point2, Vector2};

/// Samples across the ring's width, and the bounds of the step, px.
const SAMPLES_ACROSS: f64 = 16.0;
const STEP_PX: (f64, f64) = (0.25, 2.0);
/// Half the length of the box that smooths a profile, as a fraction of the ring's width.
const SMOOTHING: f64 = 0.1;
/// How far beyond the outer edge a ray goes: this many ring widths, and at most this fraction of the outer radius.
const BEYOND: (f64, f64) = (1.0, 0.45);
/// Variance that pixel integration (1/12) and bilinear interpolation (1/6) add to an edge, px^2.
const SAMPLING_VARIANCE_PX2: f64 = 1.0 / 12.0 + 1.0 / 6.0;

/// Grey values from a ring's middle outwards, and what they say of its three levels. Values are negated for light
/// rings, so that the ring is always the lowest level.
pub(super) struct Profile {
    origin: Point2<f64>,
    /// Unit vector along the ray.
    pub(super) direction: Vector2<f64>,
    /// Distance between samples, px; sample 0 is at the origin.
    pub(super) step_px: f64,
    /// Grey values, smoothed along the ray.
    pub(super) values: Vec<f64>,
    /// Sample of the lowest value between the edges.
    pub(super) darkest: usize,
    /// Highest value inside the inner edge.
    pub(super) inside: f64,
    /// Lowest value between the edges.
    pub(super) ring: f64,
    /// Highest value beyond the outer edge.
    pub(super) outside: f64,
    /// Grey values as sampled.
    raw: Vec<f64>,
}

/// Distance between the quartiles of an edge blurred by a Gaussian, in its standard deviations.
const QUARTILES: f64 = 1.348_979_5;

impl Profile {
    /// The point of the picture at a distance along the ray, px.
    pub(super) fn point(&self, radius_px: f64) -> Point2<f64> {
        self.origin + self.direction * radius_px
    }

    /// Where the smoothed profile passes a level between sample `at` and the one before it, px from the origin.
    pub(super) fn radius_px(&self, at: usize, level: f64) -> f64 {
        let (before, after) = (self.values[at - 1], self.values[at]);
        (at as f64 - 1.0 + (level - before) / (after - before)) * self.step_px
    }

    /// The Gaussian whose edge rises from a quarter to three quarters of the height over the same distance, less what
    /// sampling added; `None` where the profile ends before it has risen. `low` and `high` are the levels of the edge,
    /// `radius_px` is where it passes between them. Taken from the profile as sampled: smoothing would widen a sharp edge.
    pub(super) fn blur_sigma_px(&self, low: f64, high: f64, radius_px: f64) -> Option<f64> {
        let level = |fraction: f64| low + fraction * (high - low);
        let middle = (radius_px / self.step_px) as usize;
        let begin = (1..=middle + 1)
            .rev()
            .find(|&i| self.raw.get(i - 1).is_some_and(|&v| v <= level(0.25)))?;
        let end = (middle..self.raw.len()).find(|&i| self.raw[i] >= level(0.75))?;
        let at = |i: usize, wanted: f64| {
            let (before, after) = (self.raw[i - 1], self.raw[i]);
            let part = if after > before {
                ((wanted - before) / (after - before)).clamp(0.0, 1.0)
            } else {
                0.5
            };
            (i as f64 - 1.0 + part) * self.step_px
        };
        let rise_px = at(end.max(1), level(0.75)) - at(begin, level(0.25));
        let sigma = rise_px / QUARTILES;
        Some((sigma * sigma - SAMPLING_VARIANCE_PX2).max(0.0).sqrt())
    }
}

/// The profile towards the outer ellipse's point at parameter `t`; `None` where it leaves the picture before it has
/// passed the outer edge.
pub(super) fn sample<T: Pixel>(
    picture: &Plane<T>,
    rough: &RingEllipses,
    t: f64,
    sign: f64,
) -> Option<Profile> {
    let origin = rough.inner.centre;
    let towards = rough.outer.point(t) - origin;
    let outer_px = towards.norm();
    let direction = towards / outer_px;
    let inner_px = reach(&rough.inner, &direction);
    let width = outer_px - inner_px;
    if !(width > 0.0 && width.is_finite()) {
        return None;
    }
    let step_px = (width / SAMPLES_ACROSS).clamp(STEP_PX.0, STEP_PX.1);
    let beyond = (BEYOND.0 * width).min(BEYOND.1 * outer_px).max(2.0);
    let count = ((outer_px + beyond) / step_px) as usize + 1;
    let mut raw = Vec::new();
    for i in 0..count {
        let p = origin + direction * (i as f64 * step_px);
        match picture.bilinear(p.x, p.y) {
            Some(value) => raw.push(sign * f64::from(value)),
            None => break,
        }
    }
    let index = |radius: f64| (radius / step_px) as usize;
    if raw.len() < index(outer_px + 0.5 * beyond) + 2 {
        return None;
    }
    let half = ((SMOOTHING * width / step_px).round() as usize).max(1);
    let values = smooth(&raw, half);
    let between = index(inner_px)..index(outer_px) + 1;
    let darkest = between.min_by(|&i, &j| values[i].total_cmp(&values[j]))?;
    let highest =
        |from: usize, to: usize| values[from..to].iter().copied().fold(f64::MIN, f64::max);
    Some(Profile {
        origin,
        direction,
        step_px,
        darkest,
        inside: highest(0, index(inner_px) + 1),
        ring: values[darkest],
        outside: highest(index(outer_px), values.len()),
        values,
        raw,
    })
}

/// Distance from an ellipse's centre to its curve along a direction.
fn reach(ellipse: &Ellipse, direction: &Vector2<f64>) -> f64 {
    let (sin, cos) = ellipse.angle.sin_cos();
    let u = (cos * direction.x + sin * direction.y) / ellipse.major;
    let v = (cos * direction.y - sin * direction.x) / ellipse.minor;
    u.hypot(v).recip()
}

/// Mean over `half` samples on either side; mirrored at the ring's middle, shortened at the far end.
fn smooth(raw: &[f64], half: usize) -> Vec<f64> {
    (0..raw.len())
        .map(|i| {
            let reach = half.min(raw.len() - 1 - i) as isize;
            let sum: f64 = (-reach..=reach)
                .map(|k| raw[(i as isize + k).unsigned_abs()])
                .sum();
            sum / (2 * reach + 1) as f64
        })
        .collect()
}
