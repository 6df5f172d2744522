//! Blur that changes across a ring: the picture of it, and what is left of it in the centres of a board.

use super::super::blur::{Blur, Psf};
use super::super::model::RingModel;
use super::super::problem::Workspace;
use super::{circles, grid, scene, true_shape, unpadded};
use crate::board::{Board, Polarity};
use crate::calibrate::synthetic::{ordinary, pose_at};
use crate::detect::{DetectOptions, Detector};
use crate::simulate::{BitDepth, Defocus, Psf as Shape, Scene, ThinLens, irradiance, render};
use nalgebra::{Vector2, Vector3};

fn shape_of(psf: Psf) -> Shape {
    match psf {
        Psf::Disc => Shape::Disc,
        Psf::Gaussian => Shape::Gaussian,
    }
}

/// A thin lens that makes blur of this size at a depth, of a camera with this focal length (px).
fn lens(psf: Psf, focal_px: f64, depth_m: f64, size_px: f64) -> ThinLens {
    let pixel_m = 1e-5;
    let focus_m = 2.0 * depth_m;
    let image_m = focal_px * pixel_m;
    let unit = ThinLens {
        f_number: 1.0,
        focal_length_m: 1.0 / (1.0 / image_m + 1.0 / focus_m),
        pixel_m,
        focus_m,
    };
    let sigmas = Blur { psf, size_px }.sigma_px();
    let f_number = 0.5 * unit.radius_px(depth_m).abs() / sigmas;
    ThinLens { f_number, ..unit }
}

#[test]
fn the_picture_is_that_of_a_thin_lens() {
    for psf in [Psf::Disc, Psf::Gaussian] {
        let blur = Blur::of_sigma(psf, 5.0);
        let mut scene = scene(30.0, 100, &blur);
        let depth_m = scene.pose.translation_m.z;
        let lens = lens(psf, scene.camera.intrinsics.fx, depth_m, blur.size_px);
        let shape = shape_of(psf);
        scene.defocus = Defocus::ThinLens { psf: shape, lens };
        let picture = irradiance(&scene).unwrap();
        // 1/z is linear in the picture of a plane, and so is the blur
        let normal = scene.pose.rotation * Vector3::z();
        let by_inverse_depth = blur.size_px / (0.5 / depth_m);
        let slope = normal.xy()
            * (by_inverse_depth
                / normal.dot(&scene.pose.translation_m)
                / scene.camera.intrinsics.fx);
        let model = RingModel {
            shape: true_shape(&scene),
            blur,
            paper: 0.0,
            ring: 1.0,
            inside: 0.0,
            shading: [0.0, 0.0],
            sheet: None,
        };
        let grid = grid(1.0, 100.0);
        let [outer, inner] = circles(&grid, &model.shape, &blur, 0.5);
        let mut room = Workspace::default();
        let added = unpadded(&grid, room.uneven(&grid, &model, 0.5, slope).unwrap());
        let (mut without, mut with) = (0.0, 0.0);
        for (i, added) in added.iter().enumerate() {
            let row = picture.row(i / grid.width);
            let missing = f64::from(row[i % grid.width]) - (outer[i] - inner[i]);
            without += missing * missing;
            with += (missing - added) * (missing - added);
        }
        let size = f64::sqrt(without / added.len() as f64);
        assert!(size > 3e-3, "{psf:?}: nothing to explain, {size}");
        assert!(with < 0.01 * without, "{psf:?}: {with} of {without}");
    }
}

/// Mean error of the centres of a board that is tilted by 40 degrees before a lens out of focus, without noise.
fn mean_error(psf: Psf) -> Vector2<f64> {
    let board = Board::new(5, 5, 0.0269, 0.004, 0.008, Polarity::DarkOnLight).unwrap();
    let camera = ordinary();
    let pose = pose_at(&camera, &board, [640.0, 480.0], 0.7, [0.0, 0.7, 0.1]);
    let mut scene = Scene::new(camera, board.clone(), pose);
    let depth_m = scene.pose.board_to_camera(board.middle_m()).z;
    let size_px = Blur::of_sigma(psf, 2.5).size_px;
    scene.defocus = Defocus::ThinLens {
        psf: shape_of(psf),
        lens: lens(psf, camera.intrinsics.fx, depth_m, size_px),
    };
    scene.light.margin = f64::INFINITY;
    scene.sensor.depth = BitDepth::Sixteen;
    let rendering = render(&scene, 0).unwrap();
    let detector = Detector::new(board, DetectOptions::default());
    let detection = detector.detect(&rendering.frame).unwrap();
    let errors = detection.rings.iter().map(|ring| {
        let off = |truth: &crate::simulate::RingTruth| ring.centre.point - truth.centre;
        let all = rendering.truth.rings.iter().map(off);
        all.min_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap()
    });
    errors.sum::<Vector2<f64>>() / detection.rings.len() as f64
}

#[test]
fn centres_of_a_tilted_board_are_not_moved() {
    for psf in [Psf::Disc, Psf::Gaussian] {
        let error = mean_error(psf);
        // 0.023 px with one blur for each ring
        assert!(error.norm() < 1e-3, "{psf:?}: {error}");
    }
}
