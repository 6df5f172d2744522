//! The grey profiles along the rays of a ring.
//!
//! All rays of a ring share two buffers: a ring is some two thousand grey values, and a frame has rings by the hundred.

use crate::centre::{Ellipse, RingEllipses};
use crate::frame::{Pixel, Plane};
use nalgebra::{Point2, Vector2};
use std::ops::Range;

/// Samples across the ring's width, and the bounds of the step, px.
const SAMPLES_ACROSS: f64 = 16.0;
const STEP_PX: (f64, f64) = (0.25, 2.0);
/// Half the length of the box that smooths a profile, as a fraction of the ring's width.
const SMOOTHING: f64 = 0.1;
/// How far beyond the outer edge a ray goes: this many ring widths, and at most this fraction of the outer radius.
const BEYOND: (f64, f64) = (1.0, 0.45);
/// Room for so many rays is made at first.
const RESERVED: usize = 64;
/// Variance that pixel integration (1/12) and bilinear interpolation (1/6) add to an edge, px^2.
const SAMPLING_VARIANCE_PX2: f64 = 1.0 / 12.0 + 1.0 / 6.0;

/// Grey values from a ring's middle outwards, and what they say of its three levels. Values are negated for light
/// rings, so that the ring is always the lowest level.
pub(super) struct Profile<'a> {
    origin: Point2<f64>,
    /// Unit vector along the ray.
    pub(super) direction: Vector2<f64>,
    /// Distance between samples, px; sample 0 is at the origin.
    pub(super) step_px: f64,
    /// Grey values, smoothed along the ray.
    pub(super) values: &'a [f32],
    /// Sample of the lowest value between the edges.
    pub(super) darkest: usize,
    /// Highest value inside the inner edge.
    pub(super) inside: f64,
    /// Lowest value between the edges.
    pub(super) ring: f64,
    /// Highest value beyond the outer edge.
    pub(super) outside: f64,
    /// Grey values as sampled.
    raw: &'a [f32],
}

/// Distance between the quartiles of an edge blurred by a Gaussian, in its standard deviations.
const QUARTILES: f64 = 1.348_979_5;

impl Profile<'_> {
    /// The point of the picture at a distance along the ray, px.
    pub(super) fn point(&self, radius_px: f64) -> Point2<f64> {
        self.origin + self.direction * radius_px
    }

    /// Where the smoothed profile passes a level between sample `at` and the one before it, px from the origin.
    pub(super) fn radius_px(&self, at: usize, level: f64) -> f64 {
        let (before, after) = (f64::from(self.values[at - 1]), f64::from(self.values[at]));
        (at as f64 - 1.0 + (level - before) / (after - before)) * self.step_px
    }

    /// The Gaussian whose edge rises from a quarter to three quarters of the height over the same distance, less what
    /// sampling added; `None` where the profile ends before it has risen. `low` and `high` are the levels of the edge,
    /// `radius_px` is where it passes between them. Taken from the profile as sampled: smoothing would widen a sharp edge.
    pub(super) fn blur_sigma_px(&self, low: f64, high: f64, radius_px: f64) -> Option<f64> {
        let level = |fraction: f64| low + fraction * (high - low);
        let raw = |i: usize| f64::from(self.raw[i]);
        let middle = (radius_px / self.step_px) as usize;
        let begin = (1..=(middle + 1).min(self.raw.len()))
            .rev()
            .find(|&i| raw(i - 1) <= level(0.25))?;
        let end = (middle..self.raw.len()).find(|&i| raw(i) >= level(0.75))?;
        let at = |i: usize, wanted: f64| {
            let (before, after) = (raw(i - 1), raw(i));
            let part = if after > before {
                ((wanted - before) / (after - before)).clamp(0.0, 1.0)
            } else {
                0.5
            };
            (i as f64 - 1.0 + part) * self.step_px
        };
        if begin >= self.raw.len() {
            return None;
        }
        let rise_px = at(end.max(1), level(0.75)) - at(begin, level(0.25));
        let sigma = rise_px / QUARTILES;
        Some((sigma * sigma - SAMPLING_VARIANCE_PX2).max(0.0).sqrt())
    }
}

/// Rays of one ring that have been sampled.
#[derive(Default)]
pub(super) struct Rays {
    rays: Vec<Ray>,
    raw: Vec<f32>,
    values: Vec<f32>,
}

/// One ray: where it begins and leads, and where its samples are.
struct Ray {
    origin: Point2<f64>,
    direction: Vector2<f64>,
    step_px: f64,
    samples: Range<usize>,
    /// Samples at the inner and at the outer ellipse.
    edges: (usize, usize),
}

impl Rays {
    /// Samples the ray towards the outer ellipse's point at parameter `t`; one that leaves the picture before it has passed the
    /// outer edge is left out.
    pub(super) fn sample<T: Pixel>(
        &mut self,
        picture: &Plane<T>,
        rough: &RingEllipses,
        t: f64,
        sign: f64,
    ) {
        let origin = rough.inner.centre;
        let towards = rough.outer.point(t) - origin;
        let outer_px = towards.norm();
        let direction = towards / outer_px;
        let inner_px = reach(&rough.inner, &direction);
        let width = outer_px - inner_px;
        if !(width > 0.0 && width.is_finite()) {
            return;
        }
        let step_px = (width / SAMPLES_ACROSS).clamp(STEP_PX.0, STEP_PX.1);
        let beyond = (BEYOND.0 * width).min(BEYOND.1 * outer_px).max(2.0);
        let count = ((outer_px + beyond) / step_px) as usize + 1;
        let first = self.raw.len();
        if first == 0 {
            // rays of one ring are about as long
            self.raw.reserve(RESERVED * count);
            self.values.reserve(RESERVED * count);
        }
        picture.along(origin, direction * step_px, count, &mut self.raw);
        let index = |radius: f64| (radius / step_px) as usize;
        if self.raw.len() - first < index(outer_px + 0.5 * beyond) + 2 {
            self.raw.truncate(first);
            return;
        }
        if sign < 0.0 {
            self.raw[first..].iter_mut().for_each(|grey| *grey = -*grey);
        }
        let half = ((SMOOTHING * width / step_px).round() as usize).max(1);
        smooth(&self.raw[first..], half, &mut self.values);
        self.rays.push(Ray {
            origin,
            direction,
            step_px,
            samples: first..self.raw.len(),
            edges: (index(inner_px), index(outer_px)),
        });
    }

    /// The profiles of all rays that were sampled, in their order.
    pub(super) fn profiles(&self) -> Vec<Profile<'_>> {
        self.rays.iter().map(|ray| self.profile(ray)).collect()
    }

    fn profile(&self, ray: &Ray) -> Profile<'_> {
        let values = &self.values[ray.samples.clone()];
        let (inner, outer) = ray.edges;
        let highest = |part: &[f32]| f64::from(part.iter().copied().fold(f32::MIN, f32::max));
        let mut darkest = inner.min(outer);
        for (i, value) in values[..=outer].iter().enumerate().skip(inner) {
            if *value < values[darkest] {
                darkest = i;
            }
        }
        Profile {
            origin: ray.origin,
            direction: ray.direction,
            step_px: ray.step_px,
            darkest,
            inside: highest(&values[..=inner]),
            ring: f64::from(values[darkest]),
            outside: highest(&values[outer..]),
            values,
            raw: &self.raw[ray.samples.clone()],
        }
    }
}

/// Distance from an ellipse's centre to its curve along a direction.
fn reach(ellipse: &Ellipse, direction: &Vector2<f64>) -> f64 {
    let (sin, cos) = ellipse.angle.sin_cos();
    let u = (cos * direction.x + sin * direction.y) / ellipse.major;
    let v = (cos * direction.y - sin * direction.x) / ellipse.minor;
    (u * u + v * v).sqrt().recip()
}

/// Appends the mean over `half` samples on either side; mirrored at the ring's middle, shortened at the far end.
fn smooth(raw: &[f32], half: usize, out: &mut Vec<f32>) {
    let (n, begin) = (raw.len(), out.len());
    out.resize(begin + n, 0.0);
    let out = &mut out[begin..];
    let (low, high) = (half.min(n), n.saturating_sub(half).max(half.min(n)));
    for i in (0..low).chain(high..n) {
        let reach = half.min(n - 1 - i) as isize;
        let around = (-reach..=reach).map(|k| raw[(i as isize + k).unsigned_abs()]);
        out[i] = around.sum::<f32>() / (2 * reach + 1) as f32;
    }
    let middle = &mut out[low..high];
    match half {
        1 => box_mean::<3>(raw, middle),
        2 => box_mean::<5>(raw, middle),
        _ => {
            let scale = 1.0 / (2 * half + 1) as f32;
            for (out, raw) in middle.iter_mut().zip(raw.windows(2 * half + 1)) {
                *out = raw.iter().sum::<f32>() * scale;
            }
        }
    }
}

/// The mean of every window: of nearly all rings, whose width has 16 samples, they are five.
fn box_mean<const LENGTH: usize>(raw: &[f32], out: &mut [f32]) {
    for (out, raw) in out.iter_mut().zip(raw.array_windows::<LENGTH>()) {
        *out = raw.iter().sum::<f32>() * (1.0 / LENGTH as f32);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smoothing_is_a_mean_mirrored_at_the_middle_and_shortened_at_the_end() {
        for (n, half) in [(20, 2), (20, 1), (5, 2), (4, 3), (3, 4)] {
            let raw: Vec<f32> = (0..n).map(|i| ((i * 7) % 5) as f32).collect();
            let mut out = vec![9.0];
            smooth(&raw, half, &mut out);
            assert_eq!(out.len(), n + 1);
            for i in 0..n as isize {
                let reach = (half as isize).min(n as isize - 1 - i);
                let around = (-reach..=reach).map(|k| raw[(i + k).unsigned_abs()]);
                let expected = around.sum::<f32>() / (2 * reach + 1) as f32;
                assert!(
                    (out[1 + i as usize] - expected).abs() < 1e-6,
                    "{n} {half} {i}"
                );
            }
        }
    }
}
