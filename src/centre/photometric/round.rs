//! How far the outlines of a board's rings are from circles.
//!
//! Squares, letters and broken rings in a grid are fitted by rings, too, and under noise or compression their residuals alone are no larger
//! than those of a poor picture. But what is left of them has a shape that nothing that happens to a picture of circles gives it: their outline
//! goes in and out three, four or six times on its way around (a hexagon's). Blur, sharpening, shading and tilt do not do that, and compression does
//! it to each ring otherwise. So the residuals are projected on what such a wave of the outline would change. On a
//! print that repeats one shape the waves of all spots agree, so that their mean is above a noise that each alone is below.

use super::around::around;
use super::fit::{Given, Known};
use super::fitted::RingFitted;
use super::jury::median;
use super::model::RingModel;
use super::problem::Workspace;
use super::shape::{AFFINE, Shape};
use super::under::Under;
use super::window::Window;
use nalgebra::{Matrix2, Vector2};
use rayon::prelude::*;

/// What is that small a part of a wave's own standard deviations is noise: the median of waves of pure noise is 1.2.
const NOISE: f64 = 2.0;
/// Standard deviation of a median over that of a mean.
const MEDIAN: f64 = 1.25;
/// Blur wears waves of an outline off. What is left of them is made up for as far as to this part.
const LEAST_LEFT: f64 = 0.25;

/// Waves of an outline that are looked for: three, four and six periods.
const WAVES: usize = 3;

/// What each counts: a hexagon's wave is a third of a square's.
const WEIGHTS: [f64; WAVES] = [1.0, 1.0, 3.0];

/// Rings that are asked at most, spread over the board: the median of so many says it.
const ASKED: usize = 16;

/// A wave of an outline: its two parts and the standard deviation of each, in radii.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Wave {
    cos: f64,
    sin: f64,
    deviation: f64,
    /// What blur leaves of such a wave of the outline.
    left: f64,
}

/// How far the outlines of rings are from circles, in radii: the largest of three waves, as the median of some rings has it or as they
/// have it together, less what may be noise.
pub(super) fn out_of_round(ratio: f64, rings: &[Under]) -> f64 {
    let models: Vec<RingModel> = rings.iter().map(|ring| ring.model).collect();
    let every = rings.len().div_ceil(ASKED).max(1);
    let asked = rings.par_iter().enumerate().step_by(every);
    let waves: Vec<[Wave; WAVES]> = asked
        .map_init(Workspace::default, |room, (i, ring)| {
            let (fitted, window) = (ring.fitted.as_ref().ok()?, ring.window.as_ref()?);
            let around = around(&window.grid, ratio, (i, &models), room);
            let known = Known {
                window,
                ratio,
                around: around.as_ref(),
                given: Given::NearStart,
            };
            waves(&known, fitted, room)
        })
        .flatten()
        .collect();
    let beyond_noise = |amplitude: f64, noise: f64| {
        let noise = NOISE * noise;
        (amplitude * amplitude - noise * noise).max(0.0).sqrt()
    };
    let of_each = |k: usize| {
        let middle = |of: fn(&Wave) -> f64| median(waves.iter().map(|all| of(&all[k])));
        let amplitude = middle(|wave| wave.cos.hypot(wave.sin)).unwrap_or(0.0);
        let deviation = middle(|wave| wave.deviation).unwrap_or(0.0);
        let together = middle(|wave| wave.cos)
            .unwrap_or(0.0)
            .hypot(middle(|wave| wave.sin).unwrap_or(0.0));
        let noise = MEDIAN * deviation / (waves.len().max(1) as f64).sqrt();
        let left = middle(|wave| wave.left).unwrap_or(1.0).max(LEAST_LEFT);
        beyond_noise(amplitude, deviation).max(beyond_noise(together, noise) / left)
    };
    (0..WAVES)
        .map(|k| WEIGHTS[k] * of_each(k))
        .fold(0.0, f64::max)
}

/// The waves of three, four and six periods; `None` where the pixels do not show them.
fn waves(known: &Known, fitted: &RingFitted, room: &mut Workspace) -> Option<[Wave; WAVES]> {
    let model = &fitted.model;
    room.residuals_and(known, model, Some(model.contrasts()));
    let sums = sums(known.window, model, room);
    let blur = model.blur.sigma_px() / model.shape.size_px();
    let wave = |[cos, sin]: [Sum; 2], periods: f64| {
        let own = 0.5 * (cos.own + sin.own);
        (own > 0.0).then(|| Wave {
            cos: cos.shown / cos.own,
            sin: sin.shown / sin.own,
            deviation: fitted.noise / own.sqrt(),
            left: (-0.5 * (periods * blur).powi(2)).exp(),
        })
    };
    let [three, four, six] = sums;
    Some([wave(three, 3.0)?, wave(four, 4.0)?, wave(six, 6.0)?])
}

/// What the residuals show of a change, and what the change is itself.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    shown: f64,
    own: f64,
}

/// For each wave, its cosine and its sine.
fn sums(window: &Window, model: &RingModel, room: &Workspace) -> [[Sum; 2]; WAVES] {
    let (grid, stride) = (&window.grid, window.grid.stride());
    let mut sums = [[Sum::default(); 2]; WAVES];
    let [by_xx, by_xy, by_yy] = [0, 1, 2].map(|k| &room.coverage.changes[AFFINE + k]);
    let [xx, xy, yy] = model.shape.affine.map(|v| v as f32);
    let circle = to_circle(&model.shape);
    for row in 0..grid.height {
        let y = grid.y(row) - model.shape.centre.y;
        for column in 0..grid.width {
            let i = row * stride + column;
            // a radius grows where the affine form, its inverse square, shrinks
            let grown = -2.0 * (xx * by_xx[i] + xy * by_xy[i] + yy * by_yy[i]);
            if window.weights[i] <= 0.0 || grown == 0.0 {
                continue;
            }
            let at = circle * Vector2::new(grid.x(column) - model.shape.centre.x, y);
            let residual = f64::from(room.residuals[i]);
            for (sums, waves) in sums.iter_mut().zip(of_angle(at)) {
                for (sum, wave) in sums.iter_mut().zip(waves) {
                    let change = f64::from(grown) * wave;
                    sum.shown += change * residual;
                    sum.own += change * change;
                }
            }
        }
    }
    sums
}

/// Cosine and sine of three, four and six times the angle of a place.
fn of_angle(at: Vector2<f64>) -> [[f64; 2]; WAVES] {
    let norm = at.norm().max(f64::MIN_POSITIVE);
    let (c, s) = (at.x / norm, at.y / norm);
    let (c2, s2) = (c * c - s * s, 2.0 * c * s);
    let (c3, s3) = (c2 * c - s2 * s, s2 * c + c2 * s);
    [
        [c3, s3],
        [c2 * c2 - s2 * s2, 2.0 * c2 * s2],
        [c3 * c3 - s3 * s3, 2.0 * c3 * s3],
    ]
}

/// The symmetric matrix that carries the outline, seen without perspective, to the unit circle.
fn to_circle(shape: &Shape) -> Matrix2<f64> {
    let [xx, xy, yy] = shape.affine;
    let root = (xx * yy - xy * xy).max(0.0).sqrt();
    let sum = (xx + yy + 2.0 * root).max(f64::MIN_POSITIVE).sqrt();
    Matrix2::new(xx + root, xy, xy, yy + root) / sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point2;

    #[test]
    fn an_outline_becomes_the_unit_circle() {
        let shape = Shape {
            centre: Point2::origin(),
            affine: [0.04, 0.01, 0.02],
            perspective: Vector2::zeros(),
        };
        let root = to_circle(&shape);
        let again = root * root;
        let apart = again - Matrix2::new(0.04, 0.01, 0.01, 0.02);
        assert!(apart.norm() < 1e-12, "{again}");
    }

    #[test]
    fn three_four_and_six_times_an_angle() {
        for angle in [0.0, 0.3, 1.7, 4.0_f64] {
            let at = Vector2::new(angle.cos(), angle.sin()) * 7.0;
            for (k, [cos, sin]) in [3.0, 4.0, 6.0].into_iter().zip(of_angle(at)) {
                let (expected_sin, expected_cos) = (k * angle).sin_cos();
                assert!((cos - expected_cos).abs() < 1e-12 && (sin - expected_sin).abs() < 1e-12);
            }
        }
    }
}
