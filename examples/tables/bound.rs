//! How well the truth could be known: Cramer-Rao bounds of the centres, from the true model, and what they leave of the camera.

use crate::outcome::PARAMETERS;
use anyhow::{Context, Result};
use nalgebra::{DMatrix, Matrix2, Vector2};
use ringcal::board::Board;
use ringcal::camera::{Camera, Pose};
use ringcal::centre::photometric::{Blur, RingModel, cramer_rao_bound, shape_under, window};
use ringcal::frame::{Frame, Linear};
use ringcal::simulate::{Scene, Truth};

/// Windows reach so many blur sigmas beyond the rings.
const MARGIN_SIGMAS: f64 = 3.0;
/// Grey values of 8 bits are uniform within a step.
const STEP: f64 = 1.0 / 255.0;
/// Numbers of a pose.
const POSE: usize = 6;

/// The bound of each ring of the truth, in its order, px^2: levels, shading, blur and affine shape unknown, perspective known.
pub fn centres(scene: &Scene, frame: &Frame, truth: &Truth) -> Result<Vec<Matrix2<f64>>> {
    let linear = Linear::new(1.0, false);
    let noise = scene.sensor.read_noise.hypot(STEP / 12.0_f64.sqrt());
    let ratio = scene.board.radius_ratio();
    let rings = truth.rings.iter().map(|ring| {
        let [x, y] = scene.board.centre_m(ring.row, ring.column);
        let radius_m = scene.board.outer_radius_m();
        let image = |d: Vector2<f64>| {
            let place = [x + d.x * radius_m, y + d.y * radius_m];
            scene.camera.project(&scene.pose.board_to_camera(place))
        };
        let shape = shape_under(image)?;
        let outer = shape.ellipse(1.0)?;
        let sigma_px = ring.blur_sigma_px;
        let pixels = window(frame, &outer, sigma_px, MARGIN_SIGMAS, &linear)?;
        let model = RingModel {
            shape,
            blur: Blur::disc(2.0 * sigma_px),
            paper: scene.light.paper,
            ring: scene.light.ring,
            inside: scene.light.paper,
            shading: [0.0; 2],
            sheet: None,
        };
        let binned = noise / pixels.grid.pixel_px;
        cramer_rao_bound(&pixels, &model, ratio, binned, true)
    });
    let bounds: Option<Vec<_>> = rings.collect();
    bounds.context("a ring has no bound")
}

/// Standard deviations of the first parameters of the camera, the others known and all poses unknown, for centres as uncertain as this.
pub fn camera(board: &Board, views: &[(&Truth, &[Matrix2<f64>])]) -> Option<[f64; PARAMETERS]> {
    let mut information = DMatrix::<f64>::zeros(PARAMETERS, PARAMETERS);
    for (truth, bounds) in views {
        let (mut shared, mut own) = (
            DMatrix::zeros(PARAMETERS, PARAMETERS),
            DMatrix::zeros(POSE, POSE),
        );
        let mut mixed = DMatrix::zeros(PARAMETERS, POSE);
        for (ring, bound) in truth.rings.iter().zip(*bounds) {
            let place = board.centre_m(ring.row, ring.column);
            let (by_camera, by_pose) = derivatives(&truth.camera, &truth.pose, place)?;
            let weight = bound.try_inverse()?;
            let weight = DMatrix::from_fn(2, 2, |i, j| weight[(i, j)]);
            shared += by_camera.transpose() * &weight * &by_camera;
            mixed += by_camera.transpose() * &weight * &by_pose;
            own += by_pose.transpose() * &weight * &by_pose;
        }
        let eliminated = own.cholesky()?.solve(&mixed.transpose());
        information += shared - mixed * eliminated;
    }
    // a focal length in px and k2 differ by many orders
    let scale = information.diagonal().map(|v| v.sqrt().recip());
    let unit = DMatrix::from_diagonal(&scale);
    let inverse = (&unit * information * &unit).cholesky()?.inverse();
    Some(std::array::from_fn(|i| inverse[(i, i)].sqrt() * scale[i]))
}

/// Differences of a ring's place by the camera's first parameters, and by turn and shift of its board.
fn derivatives(
    camera: &Camera,
    pose: &Pose,
    place: [f64; 2],
) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let values = camera.parameters();
    let with = |k: usize, by: f64| {
        let mut moved = values.clone();
        moved[k] += by;
        camera
            .with_parameters(&moved)
            .project(&pose.board_to_camera(place))
    };
    let posed = |k: usize, by: f64| {
        let mut step = [0.0; POSE];
        step[k] = by;
        let turn = nalgebra::Rotation3::new(nalgebra::Vector3::new(step[0], step[1], step[2]));
        let moved = Pose {
            rotation: turn * pose.rotation,
            translation_m: pose.translation_m + nalgebra::Vector3::new(step[3], step[4], step[5]),
        };
        camera.project(&moved.board_to_camera(place))
    };
    let columns = |count: usize, by: &dyn Fn(usize, f64) -> Option<nalgebra::Point2<f64>>| {
        let mut all = DMatrix::zeros(2, count);
        for k in 0..count {
            // fx, fy, cx, cy move pixels; coefficients and poses move them thousands of times as much
            let step = if count == PARAMETERS && k < 4 {
                1e-1
            } else {
                1e-5
            };
            let slope = (by(k, step)? - by(k, -step)?) / (2.0 * step);
            all[(0, k)] = slope.x;
            all[(1, k)] = slope.y;
        }
        Some(all)
    };
    Some((columns(PARAMETERS, &with)?, columns(POSE, &posed)?))
}
