//! Coverages against the simulator (which shares no code with them), against invariants and against finite differences.

use super::blur::{Blur, Psf};
use super::choice::PsfChoice;
use super::coverage::{COVERAGE_PARAMETERS, Values, WithDerivatives};
use super::model::RingModel;
use super::psf::{fit_psf, fit_view};
use super::shape::{SHAPE_PARAMETERS, Shape};
use super::window::{Grid, Rectangle, Window};
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

fn values(grid: &Grid, shape: &Shape, radius: f64, blur: &Blur) -> Vec<f64> {
    let mut coverage = Values::default();
    coverage.fill(grid, shape, radius, blur).unwrap();
    (0..grid.width * grid.height)
        .map(|i| coverage.value(i))
        .collect()
}

fn derivatives(coverage: &WithDerivatives, pixel: usize) -> [f64; COVERAGE_PARAMETERS] {
    let mut sums = [0.0; COVERAGE_PARAMETERS];
    coverage.add_derivatives(pixel, 1.0, &mut sums);
    sums
}

/// One ring of these outer radii, tilted, in a square frame.
fn scene(outer_px: f64, size: u32, blur: &Blur) -> Scene {
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
        distortion: PlumbBob::default(),
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
fn true_shape(scene: &Scene) -> Shape {
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
    let shape = true_shape(&scene);
    let grid = grid(bin as f64, f64::from(size));
    let outer = values(&grid, &shape, 1.0, blur);
    let inner = values(&grid, &shape, 0.5, blur);
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
    for (outer_px, size, blur, bin) in [
        (22.0, 80, Blur::gaussian(0.5), 1),
        (22.0, 80, Blur::gaussian(4.0), 2),
        (22.0, 80, Blur::disc(0.5), 1),
        (22.0, 80, Blur::disc(1.0), 1),
        (22.0, 80, Blur::disc(2.0), 1),
        (22.0, 80, Blur::disc(4.0), 1),
        (22.0, 90, Blur::disc(8.0), 2),
        // contrast inverted, and a disc larger than the inner ellipse
        (22.0, 90, Blur::disc(13.0), 3),
        (22.0, 110, Blur::disc(20.0), 5),
        (100.0, 300, Blur::disc(20.0), 5),
        (100.0, 320, Blur::disc(40.0), 10),
    ] {
        let error = worst_error(outer_px, size, &blur, bin);
        assert!(error < 1.3e-4, "{outer_px} {blur:?}: {error:.2e}");
    }
}

#[test]
fn the_sum_is_the_ellipse_s_area_and_the_first_moment_its_centre() {
    let shape = Shape::from_parameters(&SHAPE);
    let ellipse = shape.ellipse(1.0).unwrap();
    let area = std::f64::consts::PI * ellipse.major * ellipse.minor;
    let grid = grid(1.0, 64.0);
    for (psf, sigma, tolerance) in [
        (Psf::Gaussian, 0.0, 3e-3),
        (Psf::Gaussian, 0.5, 1e-6),
        (Psf::Gaussian, 3.0, 1e-6),
        (Psf::Disc, 0.0, 1e-4),
        (Psf::Disc, 0.1, 1e-4),
        (Psf::Disc, 0.5, 1e-5),
        (Psf::Disc, 3.0, 1e-5),
    ] {
        let covered = values(&grid, &shape, 1.0, &Blur::of_sigma(psf, sigma));
        let sum: f64 = covered.iter().sum();
        let across = covered.iter().enumerate().map(|(i, v)| (i % 64) as f64 * v);
        let down = covered.iter().enumerate().map(|(i, v)| (i / 64) as f64 * v);
        let mean = Point2::new(across.sum::<f64>() / sum, down.sum::<f64>() / sum);
        let error = (sum / area - 1.0).abs();
        assert!(error < tolerance, "{psf:?} {sigma}: {error:.2e}");
        let error = (mean - ellipse.centre).norm();
        assert!(error < 10.0 * tolerance, "{psf:?} {sigma}: {error:.2e}");
    }
}

/// The coverage with one of shape and blur moved.
fn moved(grid: &Grid, blur: &Blur, k: usize, by: f64) -> Vec<f64> {
    let (mut p, mut blur) = (SHAPE, *blur);
    match p.get_mut(k) {
        Some(parameter) => *parameter += by,
        None => blur.size_px += by,
    }
    values(grid, &Shape::from_parameters(&p), 1.0, &blur)
}

#[test]
fn derivatives_agree_with_finite_differences() {
    // a disc's values are right within 1e-4, so that their differences over 0.05 px are within 2e-3, some percent of the largest
    for (blur, step, tolerance) in [
        (Blur::gaussian(0.8), 1e-5, 1e-4),
        (Blur::gaussian(2.5), 1e-5, 1e-4),
        (Blur::disc(0.3), 3e-3, 2e-2),
        (Blur::disc(1.0), 3e-3, 2e-2),
        (Blur::disc(3.0), 3e-3, 1e-2),
        (Blur::disc(9.0), 3e-3, 2e-2),
    ] {
        let grid = grid(1.0, 64.0);
        let mut coverage = WithDerivatives::default();
        let shape = Shape::from_parameters(&SHAPE);
        coverage.fill(&grid, &shape, 1.0, &blur).unwrap();
        for k in 0..COVERAGE_PARAMETERS {
            let h = step * SHAPE.get(k).map_or(blur.size_px, |p| p.abs());
            let (up, down) = (moved(&grid, &blur, k, h), moved(&grid, &blur, k, -h));
            let told: Vec<f64> = (0..up.len())
                .map(|i| derivatives(&coverage, i)[k])
                .collect();
            let largest = told.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            for (i, told) in told.iter().enumerate() {
                let slope = (up[i] - down[i]) / (2.0 * h);
                let error = (slope - told).abs() / largest;
                assert!(
                    error < tolerance,
                    "{blur:?} {k} {i}: {slope} {told} {error:.1e}"
                );
            }
        }
    }
}

#[test]
fn any_disc_is_finite_and_small_ones_change_smoothly() {
    let grid = grid(2.0, 64.0);
    let mut before: Option<Vec<f64>> = None;
    for step in 0..60 {
        let mut coverage = WithDerivatives::default();
        let blur = Blur::disc(0.03 * f64::from(step));
        let shape = Shape::from_parameters(&SHAPE);
        coverage.fill(&grid, &shape, 1.0, &blur).unwrap();
        let now: Vec<f64> = (0..grid.width * grid.height)
            .map(|i| coverage.value(i))
            .collect();
        let derivatives = (0..now.len()).flat_map(|i| derivatives(&coverage, i));
        assert!(derivatives.into_iter().all(f64::is_finite));
        assert!(now.iter().all(|v| (-1e-3..1.001).contains(v)));
        if let Some(before) = before {
            let leap = before
                .iter()
                .zip(&now)
                .fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
            assert!(leap < 0.02, "{blur:?}: {leap}");
        }
        before = Some(now);
    }
}

#[test]
fn likelihood_tells_a_disc_from_a_gaussian() {
    for (blur, bin) in [(Blur::disc(6.0), 1), (Blur::gaussian(3.0), 1)] {
        let rings: Vec<_> = (0..3).map(|seed| noisy_ring(&blur, bin, seed)).collect();
        let truth = true_shape(&scene(22.0, 80, &blur)).centre;
        let view = fit_view(&rings, 0.5, PsfChoice::Auto);
        assert_eq!(view.psf, blur.psf);
        let evidence = view.disc_over_gaussian.unwrap();
        assert!(evidence.abs() > 10.0, "{evidence}");
        for ((window, start), of_view) in rings.iter().zip(view.rings) {
            let alone = fit_psf(window, start, 0.5, PsfChoice::Auto).unwrap();
            assert_eq!(alone.model.blur.psf, blur.psf);
            assert_eq!(of_view.unwrap(), alone);
            assert!((alone.model.blur.size_px / blur.size_px - 1.0).abs() < 0.05);
            let off = (alone.model.shape.centre - truth).norm();
            assert!(
                off < 4.0 * alone.centre_covariance().trace().sqrt(),
                "{off}"
            );
        }
    }
}

/// A window with 1 % of noise, and a start with its frontal ellipse and a blur that is 20 % off.
fn noisy_ring(blur: &Blur, bin: usize, seed: u64) -> (Window, RingModel) {
    let mut scene = scene(22.0, 80, blur);
    (scene.light.paper, scene.light.ring) = (0.85, 0.1);
    scene.sensor.read_noise = 0.01;
    let frame = simulate::render(&scene, seed).unwrap().frame;
    let all = Rectangle {
        x: 0,
        y: 0,
        width: 80,
        height: 80,
    };
    let window = Window::cut(&frame, all, bin, |_, _| true).unwrap();
    let outer = true_shape(&scene).ellipse(1.0).unwrap();
    let start = RingModel {
        shape: Shape::frontal(&outer),
        blur: Blur::gaussian(1.2 * blur.sigma_px()),
        paper: 0.8,
        ring: 0.15,
        inside: 0.7,
        shading: [0.0, 0.0],
    };
    (window, start)
}
