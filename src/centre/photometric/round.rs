//! How far the outlines of a board's rings are from circles.
//!
//! Squares, letters and broken rings in a grid are fitted by rings, too, and under noise or compression their residuals alone are no larger
//! than those of a poor picture. But what is left of them has a shape that nothing that happens to a picture of circles gives it: their outline
//! goes in and out three or four times on its way around. Blur, sharpening, shading and tilt do not do that, and compression does
//! it to each ring otherwise. So the residuals are projected on what such a wave of the outline would change.

use super::around::around;
use super::fit::{Given, Known};
use super::fitted::RingFitted;
use super::jury::median;
use super::model::RingModel;
use super::problem::Workspace;
use super::shape::AFFINE;
use super::shape::Shape;
use super::under::Under;
use super::window::Window;
use nalgebra::{Matrix2, Vector2};
use rayon::prelude::*;

/// What is that small a part of a wave's own standard deviations is noise: the median of waves of pure noise is 1.2.
const NOISE: f64 = 2.0;

/// Rings that are asked at most, spread over the board: the median of so many says it.
const ASKED: usize = 16;

/// A wave of an outline: its amplitude and the standard deviation of each of its two parts, in radii.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Wave {
    amplitude: f64,
    deviation: f64,
}

/// How far the outlines of rings are from circles, in radii: the median over some of the rings of the larger of two waves, less what may
/// be noise.
pub(super) fn out_of_round(ratio: f64, rings: &[Under]) -> f64 {
    let models: Vec<RingModel> = rings.iter().map(|ring| ring.model).collect();
    let every = rings.len().div_ceil(ASKED).max(1);
    let asked = rings.par_iter().enumerate().step_by(every);
    let waves: Vec<[Wave; 2]> = asked
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
    let beyond_noise = |k: usize| {
        let amplitude = median(waves.iter().map(|both| both[k].amplitude));
        let deviation = median(waves.iter().map(|both| both[k].deviation));
        let (amplitude, noise) = (amplitude.unwrap_or(0.0), NOISE * deviation.unwrap_or(0.0));
        (amplitude * amplitude - noise * noise).max(0.0).sqrt()
    };
    beyond_noise(0).max(beyond_noise(1))
}

/// The waves of three and of four periods; `None` where the pixels do not show them.
fn waves(known: &Known, fitted: &RingFitted, room: &mut Workspace) -> Option<[Wave; 2]> {
    let model = &fitted.model;
    room.residuals_and(known, model, Some(model.contrasts()));
    let sums = sums(known.window, model, room);
    let wave = |[cos, sin]: [Sum; 2]| {
        let own = 0.5 * (cos.own + sin.own);
        (own > 0.0).then(|| Wave {
            amplitude: (cos.shown / cos.own).hypot(sin.shown / sin.own),
            deviation: fitted.noise / own.sqrt(),
        })
    };
    let [three, four] = sums;
    Some([wave(three)?, wave(four)?])
}

/// What the residuals show of a change, and what the change is itself.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    shown: f64,
    own: f64,
}

/// For both waves, their cosine and their sine.
fn sums(window: &Window, model: &RingModel, room: &Workspace) -> [[Sum; 2]; 2] {
    let (grid, stride) = (&window.grid, window.grid.stride());
    let mut sums = [[Sum::default(); 2]; 2];
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
            for (sums, waves) in sums.iter_mut().zip(three_and_four(at)) {
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

/// Cosine and sine of three and four times the angle of a place.
fn three_and_four(at: Vector2<f64>) -> [[f64; 2]; 2] {
    let norm = at.norm().max(f64::MIN_POSITIVE);
    let (c, s) = (at.x / norm, at.y / norm);
    let (c2, s2) = (c * c - s * s, 2.0 * c * s);
    [
        [c2 * c - s2 * s, s2 * c + c2 * s],
        [c2 * c2 - s2 * s2, 2.0 * c2 * s2],
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
    fn three_and_four_times_an_angle() {
        for angle in [0.0, 0.3, 1.7, 4.0_f64] {
            let at = Vector2::new(angle.cos(), angle.sin()) * 7.0;
            for (k, [cos, sin]) in [3.0, 4.0].into_iter().zip(three_and_four(at)) {
                let (expected_sin, expected_cos) = (k * angle).sin_cos();
                assert!((cos - expected_cos).abs() < 1e-12 && (sin - expected_sin).abs() < 1e-12);
            }
        }
    }
}
