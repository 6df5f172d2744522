//! Coverages against the simulator (which shares no code with them), against invariants and against finite differences.

use super::blur::{Blur, Psf};
use super::coverage::{COVERAGE_PARAMETERS, Values, WithDerivatives};
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

fn values(grid: &Grid, shape: &Shape, radius: f64, blur: &Blur) -> Vec<f64> {
    let mut coverage = Values::default();
    coverage.fill(grid, shape, radius, blur).unwrap();
    (0..grid.width * grid.height)
        .map(|i| coverage.value(i))
        .collect()
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
    let square = back.fixed_view::<2, 2>(0, 0).tr_mul(&back.fixed_view::<2, 2>(0, 0));
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
fn scan() {
    for (outer, size, c, bin) in [
        (22.0, 80, 0.5, 1), (22.0, 80, 0.7, 1), (22.0, 80, 1.0, 1), (22.0, 80, 1.5, 1), (22.0, 80, 2.0, 1), (22.0, 80, 3.0, 1), (22.0, 80, 4.0, 1), (22.0, 80, 8.0, 2), (22.0, 80, 8.0, 1), (22.0, 90, 11.0, 2),(22.0, 90, 13.0, 3),
        (22.0, 110, 20.0, 5), (22.0, 110, 20.0, 1),
        (100.0, 300, 0.5, 1),
        (100.0, 300, 5.0, 1), (100.0, 300, 10.0, 2), (100.0, 300, 20.0, 5), (100.0, 320, 40.0, 10), (100.0, 320, 40.0, 5),(100.0, 320, 40.0, 1), (200.0, 500, 10.0, 2),
    ] {
        let t = std::time::Instant::now();
        let e = worst_error(outer, size, &Blur::disc(c), bin);
        println!("{outer} {c} {bin}: {e:.2e} {:?}", t.elapsed());
    }
    for (outer, size, c, bin) in [(22.0, 80, 0.5, 1), (22.0, 80, 4.0, 2)] {
        println!("gauss {c} {:.2e}", worst_error(outer, size, &Blur::gaussian(c), bin));
    }
}
