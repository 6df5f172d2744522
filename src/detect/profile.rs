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
    smoothing_px: f64,
}

impl Profile {
    /// The point of the picture at a distance along the ray, px.
    pub(super) fn point(&self, radius_px: f64) -> Point2<f64> {
        self.origin + self.direction * radius_px
    }

    /// The Gaussian whose edge of this height has this slope, less what sampling and smoothing added.
    pub(super) fn blur_sigma_px(&self, height: f64, slope: f64) -> f64 {
        let along = height / ((2.0 * std::f64::consts::PI).sqrt() * slope.max(1e-9));
        let smoothing = self.smoothing_px * self.smoothing_px / 12.0;
        (along * along - smoothing - SAMPLING_VARIANCE_PX2)
            .max(0.0)
            .sqrt()
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
        smoothing_px: (2 * half + 1) as f64 * step_px,
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
