//! The photometric estimator against the simulator (which shares no code with it), against invariants and finite differences.

mod boards;
mod rings;
mod sheet;
mod uneven;

use super::blur::{Blur, Psf};
use super::coverage::COVERAGE_PARAMETERS;
use super::problem::Workspace;
use super::shape::{SHAPE_PARAMETERS, Shape};
use super::window::Grid;
use crate::board::{Board, Polarity};
use crate::camera::{Camera, Intrinsics, PlumbBob, Pose};
use crate::simulate::{self, Defocus, Scene};
use nalgebra::{Matrix3, Point2, Rotation3, Vector2, Vector3};

const SHAPE: [f64; SHAPE_PARAMETERS] = [31.2, 28.9, 0.0031, 0.0004, 0.0042, 0.002, -0.0015];

fn grid(pixel_px: f64, size_px: f64) -> Grid {
    let count = (size_px / pixel_px) as usize;
    Grid {
        left_px: 0.5 * (pixel_px - 1.0),
        top_px: 0.5 * (pixel_px - 1.0),
        pixel_px,
        width: count,
        height: count,
    }
}

/// Coverage by the outer and the inner circle, rows without padding.
fn circles(grid: &Grid, shape: &Shape, blur: &Blur, ratio: f64) -> [Vec<f64>; 2] {
    let mut room = Workspace::default();
    let planes = room.circles(grid, shape, blur, ratio).unwrap();
    [0, 1].map(|circle: usize| unpadded(grid, &planes[circle]))
}

fn unpadded(grid: &Grid, plane: &[f32]) -> Vec<f64> {
    let rows = plane.chunks_exact(grid.stride());
    rows.flat_map(|row| row[..grid.width].iter().map(|&v| f64::from(v)))
        .collect()
}

/// One ring of these outer radii, tilted, in a square frame.
pub(super) fn scene(outer_px: f64, size: u32, blur: &Blur) -> Scene {
    let board = Board::new(1, 1, 0.0, 0.05, 0.1, Polarity::DarkOnLight).unwrap();
    let middle = 0.5 * (f64::from(size) - 1.0);
    let intrinsics = Intrinsics {
        fx: 800.0,
        fy: 800.0,
        cx: middle,
        cy: middle,
    };
    let camera = Camera {
        width: size,
        height: size,
        intrinsics,
        distortion: PlumbBob::default().into(),
    };
    let depth_m = 80.0 / outer_px;
    let pose = Pose {
        rotation: Rotation3::from_euler_angles(0.8, 0.35, 0.3),
        translation_m: Vector3::new(0.37 * depth_m / 800.0, -0.21 * depth_m / 800.0, depth_m),
    };
    let mut scene = Scene::new(camera, board, pose);
    scene.light.paper = 0.0;
    scene.light.ring = 1.0;
    scene.light.margin = f64::INFINITY;
    scene.defocus = match blur.psf {
        Psf::Gaussian => Defocus::gaussian(blur.size_px),
        Psf::Disc => Defocus::disc(blur.size_px),
    };
    scene
}

/// The shape of the scene's ring, from camera and pose.
pub(super) fn true_shape(scene: &Scene) -> Shape {
    let k = &scene.camera.intrinsics;
    let camera = Matrix3::new(k.fx, 0.0, k.cx, 0.0, k.fy, k.cy, 0.0, 0.0, 1.0);
    let rotation = scene.pose.rotation.matrix();
    let plane = Matrix3::from_columns(&[
        rotation.column(0) * 0.1,
        rotation.column(1) * 0.1,
        scene.pose.translation_m,
    ]);
    let centre = camera * scene.pose.translation_m;
    let back = (camera * plane).try_inverse().unwrap() * centre.z;
    let square = back
        .fixed_view::<2, 2>(0, 0)
        .tr_mul(&back.fixed_view::<2, 2>(0, 0));
    Shape {
        centre: Point2::new(centre.x / centre.z, centre.y / centre.z),
        affine: [square[(0, 0)], square[(0, 1)], square[(1, 1)]],
        perspective: -Vector2::new(back[(2, 0)], back[(2, 1)]),
    }
}

/// Largest difference between the ring's coverage and the simulator's picture, binned.
fn worst_error(outer_px: f64, size: u32, blur: &Blur, bin: usize) -> f64 {
    let scene = scene(outer_px, size, blur);
    let picture = simulate::irradiance(&scene).unwrap();
    let grid = grid(bin as f64, f64::from(size));
    let [outer, inner] = circles(&grid, &true_shape(&scene), blur, 0.5);
    let mut worst = 0.0_f64;
    for row in 0..grid.height {
        for column in 0..grid.width {
            let i = row * grid.width + column;
            let lines = row * bin..(row + 1) * bin;
            let sum: f64 = lines
                .flat_map(|y| &picture.row(y)[column * bin..(column + 1) * bin])
                .map(|&v| f64::from(v))
                .sum();
            let error = outer[i] - inner[i] - sum / (bin * bin) as f64;
            worst = worst.max(error.abs());
        }
    }
    worst
}

#[test]
fn coverages_agree_with_the_simulator() {
    for (outer_px, size, blur, bin, most) in [
        (22.0, 80, Blur::gaussian(0.0), 1, 1.2e-2),
        // pixel by pixel: what is of second order in the circles' bends is left out
        (22.0, 80, Blur::gaussian(0.2), 1, 1e-3),
        (22.0, 80, Blur::gaussian(0.4), 1, 1e-3),
        // pixel by pixel, with the box's fourth and sixth moment
        (22.0, 80, Blur::gaussian(0.5), 1, 5e-4),
        (22.0, 80, Blur::gaussian(0.8), 1, 3e-4),
        (22.0, 80, Blur::gaussian(1.5), 1, 3e-4),
        (22.0, 80, Blur::gaussian(2.5), 1, 3e-4),
        (22.0, 80, Blur::gaussian(4.0), 2, 1e-4),
        (22.0, 80, Blur::gaussian(4.0), 4, 1e-4),
        (22.0, 80, Blur::disc(0.5), 1, 7e-3),
        (22.0, 80, Blur::disc(1.0), 1, 2e-3),
        (22.0, 80, Blur::disc(2.0), 1, 2e-3),
        (22.0, 80, Blur::disc(4.0), 1, 2e-3),
        (22.0, 90, Blur::disc(8.0), 2, 1e-3),
        // contrast inverted, and a disc larger than the inner ellipse
        (22.0, 90, Blur::disc(13.0), 3, 1e-3),
        (22.0, 110, Blur::disc(20.0), 5, 1e-3),
        (100.0, 320, Blur::disc(40.0), 8, 1e-3),
    ] {
        let error = worst_error(outer_px, size, &blur, bin);
        assert!(error < most, "{outer_px} {blur:?}: {error:.2e}");
    }
}

#[test]
fn the_sum_is_the_ellipse_s_area_and_the_first_moment_its_centre() {
    let shape = Shape::from_parameters(&SHAPE);
    let ellipse = shape.ellipse(1.0).unwrap();
    let area = std::f64::consts::PI * ellipse.major * ellipse.minor;
    let grid = grid(1.0, 64.0);
    for (psf, sigma) in [
        (Psf::Gaussian, 0.0),
        (Psf::Gaussian, 0.5),
        (Psf::Gaussian, 3.0),
        (Psf::Disc, 0.0),
        (Psf::Disc, 0.5),
        (Psf::Disc, 3.0),
    ] {
        let [covered, _] = circles(&grid, &shape, &Blur::of_sigma(psf, sigma), 0.5);
        let sum: f64 = covered.iter().sum();
        let across = covered.iter().enumerate().map(|(i, v)| (i % 64) as f64 * v);
        let down = covered.iter().enumerate().map(|(i, v)| (i / 64) as f64 * v);
        let mean = Point2::new(across.sum::<f64>() / sum, down.sum::<f64>() / sum);
        let error = (sum / area - 1.0).abs();
        assert!(error < 4e-4, "{psf:?} {sigma}: {error:.2e}");
        let error = (mean - ellipse.centre).norm();
        assert!(error < 1e-3, "{psf:?} {sigma}: {error:.2e}");
    }
}

/// Grey (contrasts -0.7 and 0.6) with one parameter of shape and blur moved.
fn moved(grid: &Grid, blur: &Blur, k: usize, by: f64) -> Vec<f64> {
    let (mut p, mut blur) = (SHAPE, *blur);
    match p.get_mut(k) {
        Some(parameter) => *parameter += by,
        None => blur.size_px += by,
    }
    let [outer, inner] = circles(grid, &Shape::from_parameters(&p), &blur, 0.5);
    outer
        .iter()
        .zip(&inner)
        .map(|(o, i)| -0.7 * o + 0.6 * i)
        .collect()
}

#[test]
fn derivatives_agree_with_finite_differences() {
    for (blur, pixel_px) in [
        (Blur::gaussian(0.3), 1.0),
        (Blur::gaussian(0.8), 1.0),
        (Blur::gaussian(1.6), 2.0),
        (Blur::gaussian(2.5), 1.0),
        (Blur::gaussian(3.0), 3.0),
        (Blur::gaussian(6.0), 3.0),
        (Blur::disc(0.5), 1.0),
        (Blur::disc(3.0), 1.0),
        (Blur::disc(9.0), 2.0),
    ] {
        let grid = grid(pixel_px, 66.0);
        let shape = Shape::from_parameters(&SHAPE);
        let mut room = Workspace::default();
        let contrasts = Some([-0.7, 0.6]);
        room.coverage
            .fill(&grid, (&shape, &blur), 0.5, contrasts, None)
            .unwrap();
        for k in 0..COVERAGE_PARAMETERS {
            // f32 values: steps that change them by a percent or so
            let h = match k {
                0 | 1 => 0.05,
                2..=4 => 5e-5,
                5 | 6 => 2e-4,
                _ => 0.05 * blur.size_px,
            };
            let (up, down) = (moved(&grid, &blur, k, h), moved(&grid, &blur, k, -h));
            let mut told = unpadded(&grid, &room.coverage.changes[k]);
            if k == SHAPE_PARAMETERS {
                told.iter_mut().for_each(|v| *v /= pixel_px);
            }
            let slopes = up.iter().zip(&down).map(|(u, d)| (u - d) / (2.0 * h));
            let errors = slopes
                .zip(&told)
                .map(|(slope, told)| (slope - told).powi(2));
            let squares = told.iter().map(|v| v * v).sum::<f64>();
            let error = (errors.sum::<f64>() / squares).sqrt();
            // a disc's rim is a step, which nodes half a pixel apart follow roughly
            // a sharp edge is moved as if its bend stayed the same
            let most = match blur.psf {
                Psf::Gaussian if blur.size_px < 0.5 => 0.015,
                // a ring of five pixels: two points stand for the arc that a pixel sees
                Psf::Gaussian if blur.size_px == pixel_px => 0.015,
                Psf::Gaussian => 0.005,
                Psf::Disc => 0.12,
            };
            assert!(error < most, "{blur:?} {k}: {error:.1e}");
        }
    }
}

#[test]
fn any_blur_is_finite_and_changes_smoothly() {
    let grid = grid(2.0, 64.0);
    for psf in [Psf::Gaussian, Psf::Disc] {
        let mut before: Option<Vec<f64>> = None;
        for step in 0..60 {
            let blur = Blur::of_sigma(psf, 0.02 * f64::from(step));
            let [now, _] = circles(&grid, &Shape::from_parameters(&SHAPE), &blur, 0.5);
            let outside = now.iter().map(|v| (-v).max(v - 1.0));
            let outside = outside.fold(0.0_f64, f64::max);
            assert!(outside < 1e-3, "{blur:?}: {outside:.1e}");
            if let Some(before) = before {
                let leaps = before.iter().zip(&now).map(|(a, b)| (a - b).abs());
                let leap = leaps.fold(0.0_f64, f64::max);
                assert!(leap < 0.02, "{blur:?}: {leap}");
            }
            before = Some(now);
        }
    }
}
