//! Lens models beside plumb_bob.

use super::*;
use crate::camera::{Equidistant, RationalPolynomial};
use nalgebra::Point3;

pub fn options(model: LensModel) -> CalibrateOptions {
    CalibrateOptions {
        model,
        ..CalibrateOptions::default()
    }
}

/// A camera with another lens, and views of it.
fn with_lens(lens: impl Into<Distortion>, focal: f64, sigma_px: f64) -> (Camera, Vec<View>) {
    with_lens_and_noise(lens, focal, (sigma_px, 3))
}

/// A camera that needs the rational model, as depth cameras have it.
pub fn kinect(sigma_px: f64, seed: u64) -> (Camera, Vec<View>) {
    let lens = RationalPolynomial {
        k1: 0.35,
        k2: 0.06,
        k3: 0.002,
        p1: 0.0004,
        p2: -0.0003,
        k4: 0.62,
        k5: 0.11,
        k6: 0.012,
    };
    with_lens_and_noise(lens, 620.0, (sigma_px, seed))
}

fn with_lens_and_noise(
    lens: impl Into<Distortion>,
    focal: f64,
    (sigma_px, seed): (f64, u64),
) -> (Camera, Vec<View>) {
    let mut camera = ordinary();
    camera.distortion = lens.into();
    (camera.intrinsics.fx, camera.intrinsics.fy) = (focal, focal * 1.004);
    let (w, h) = (f64::from(camera.width), f64::from(camera.height));
    let poses: Vec<_> = (0..25)
        .map(|i| {
            let (x, y) = (f64::from(i % 5), f64::from(i / 5));
            let pixel = [w * (0.12 + 0.19 * x), h * (0.14 + 0.18 * y)];
            let ray = camera.ray(&Point2::from(pixel)).unwrap();
            // facing the camera, then tilted
            let facing = nalgebra::Rotation3::rotation_between(&Vector3::z(), &ray).unwrap();
            let a = f64::from(i) * 2.4;
            let tilt = nalgebra::Rotation3::new(Vector3::new(0.5 * a.cos(), 0.5 * a.sin(), 0.1));
            let rotation = facing * tilt;
            let [mx, my] = board().middle_m();
            Pose {
                rotation,
                translation_m: ray * (focal / 1700.0) - rotation * Vector3::new(mx, my, 0.0),
            }
        })
        .filter(|pose| {
            board().indices().all(|(row, column)| {
                let point = pose.board_to_camera(board().centre_m(row, column));
                camera
                    .project(&point)
                    .is_some_and(|p| (0.0..w).contains(&p.x) && (0.0..h).contains(&p.y))
            })
        })
        .collect();
    assert!(poses.len() > 8, "{}", poses.len());
    let views = views(&camera, &board(), &poses, sigma_px, seed);
    (camera, views)
}

#[test]
fn a_fisheye_of_180_degrees_is_found_from_nothing_but_its_views() {
    let lens = Equidistant {
        k: [-0.012, 0.004, -0.002, 0.0003],
    };
    let (camera, views) = with_lens(lens, 410.0, 0.03);
    let found = calibrate(&board(), &views, &options(LensModel::Equidistant)).unwrap();
    assert_eq!(found.views_used(), views.len());
    for degrees in [0.0_f64, 40.0, 70.0, 85.0] {
        for around in [0.2_f64, 2.0, 4.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let point = Point3::new(sin * around.cos(), sin * around.sin(), cos);
            let (a, b) = (camera.project(&point), found.camera.project(&point));
            let off = (a.unwrap() - b.unwrap()).norm();
            assert!(off < 0.2, "{degrees} degrees: {off} px");
        }
    }
}

#[test]
fn a_rational_lens_is_found_and_chosen_where_plumb_bob_does_not_do() {
    let rational = RationalPolynomial {
        k1: 0.6,
        k2: 0.05,
        k4: 0.95,
        k5: 0.2,
        ..RationalPolynomial::default()
    };
    let (camera, views) = with_lens(rational, 520.0, 0.02);
    let found = calibrate(&board(), &views, &options(LensModel::RationalPolynomial)).unwrap();
    let chi2 = found.rms_px / (0.02 * 2.0_f64.sqrt());
    assert!((0.9..1.05).contains(&chi2), "{chi2}");
    let pixel = Point2::new(100.0, 120.0);
    let (a, b) = (
        camera.ray(&pixel).unwrap(),
        found.camera.ray(&pixel).unwrap(),
    );
    assert!(a.angle(&b) * 520.0 < 0.5, "{}", a.angle(&b) * 520.0);
    let (chosen, scores) = choose_model(&board(), &views, &CalibrateOptions::default()).unwrap();
    assert_ne!(chosen, LensModel::PlumbBob, "{scores:?}");
    let (_, plain) = with_lens(PlumbBob::default(), 900.0, 0.05);
    let (chosen, scores) = choose_model(&board(), &plain, &CalibrateOptions::default()).unwrap();
    assert_eq!(chosen, LensModel::PlumbBob, "{scores:?}");
}

/// Views before a lens that has rays for half of its frame, a circle of 422 px about the middle; the board's middle goes out to `reach_px`.
fn before_a_fold(reach_px: f64, fill: f64) -> (Camera, Vec<View>) {
    let mut camera = ordinary();
    let lens = PlumbBob {
        k1: -0.3,
        ..PlumbBob::default()
    };
    camera.distortion = lens.into();
    (camera.intrinsics.fx, camera.intrinsics.fy) = (600.0, 600.0);
    (camera.intrinsics.cx, camera.intrinsics.cy) = (639.5, 479.5);
    let poses: Vec<_> = (0..15)
        .map(|i| {
            let (direction, axis) = (2.4 * f64::from(i), 3.12 * f64::from(i) + 0.5);
            let out = if i % 3 == 0 { 0.4 * reach_px } else { reach_px };
            let pixel = [639.5 + out * direction.cos(), 479.5 + out * direction.sin()];
            let tilt = if i % 2 == 0 { 0.55 } else { 0.35 };
            let turn = [tilt * axis.cos(), tilt * axis.sin(), 0.2];
            pose_at(&camera, &board(), pixel, fill, turn)
        })
        .collect();
    (camera, views(&camera, &board(), &poses, 0.003, 3))
}

#[test]
fn a_lens_that_folds_in_the_frame_is_found_where_rings_reach_the_fold_and_refused_where_it_is_made_up()
 {
    let plumb_bob = options(LensModel::PlumbBob);
    // rings out to 390 px of 422
    let (camera, views) = before_a_fold(230.0, 0.3);
    let found = calibrate(&board(), &views, &plumb_bob).unwrap();
    for (k, name) in camera.parameter_names().iter().enumerate() {
        let z = (found.values()[k] - camera.parameters()[k]) / found.std(k);
        assert!(z.abs() < 3.5, "{name}: {z} standard deviations");
    }
    // to 215 px only: what the lens does at 422 px nobody has seen
    let (_, views) = before_a_fold(80.0, 0.2);
    let refused = calibrate(&board(), &views, &plumb_bob).unwrap_err();
    assert!(
        matches!(
            refused,
            CalibrateError::LensFolds { .. } | CalibrateError::LensOpen { .. }
        ),
        "{refused}"
    );
}

#[test]
fn a_model_is_not_out_of_the_choice_because_a_part_of_the_views_does_not_determine_it() {
    let camera = ordinary();
    let three = &views(&camera, &board(), &poses(&camera, &board()), 0.02, 3)[..3];
    let (chosen, scores) = choose_model(&board(), three, &CalibrateOptions::default()).unwrap();
    assert_eq!(chosen, LensModel::PlumbBob, "{scores:?}");
    assert!(scores[0].rms_px.is_err());
}

#[test]
fn views_that_leave_the_camera_open_are_not_saved_by_another_lens_model() {
    let camera = ordinary();
    // in the middle of the frame, tilted: five numbers of a lens cannot be told from there, four can just
    let middle: Vec<_> = (0..10)
        .map(|i| {
            let angle = 2.4 * f64::from(i);
            let turn = [0.5 * angle.cos(), 0.5 * angle.sin(), 0.0];
            pose_at(&camera, &board(), [640.0 + f64::from(i), 480.0], 0.5, turn)
        })
        .collect();
    for sigma_px in [0.005, 0.01, 0.02, 0.04] {
        let views = views(&camera, &board(), &middle, sigma_px, 3);
        let plain = calibrate(&board(), &views, &options(LensModel::PlumbBob));
        let chosen = choose_model(&board(), &views, &CalibrateOptions::default());
        if let Err(refused) = plain {
            assert_eq!(chosen.unwrap_err(), refused);
        } else {
            assert_eq!(chosen.unwrap().0, LensModel::PlumbBob);
        }
    }
}

#[test]
fn the_numbers_of_a_rational_lens_scatter_as_their_deviations_say() {
    let runs = 120;
    let mut told = Vec::new();
    for seed in 0..runs {
        let (_, mut views) = kinect(0.03, seed);
        with_covariance(&mut views, Matrix2::identity() * 9e-4);
        let options = options(LensModel::RationalPolynomial);
        let found = calibrate(&board(), &views, &options).unwrap();
        told.push((found.values(), found.stds()));
    }
    let names = LensModel::RationalPolynomial.parameter_names();
    for (at, name) in names.iter().enumerate() {
        let n = runs as f64;
        let mean = told.iter().map(|(values, _)| values[at]).sum::<f64>() / n;
        let squares = told.iter().map(|(values, _)| (values[at] - mean).powi(2));
        let scatter = (squares.sum::<f64>() / (n - 1.0)).sqrt();
        let stated = (told.iter().map(|(_, stds)| stds[at].powi(2)).sum::<f64>() / n).sqrt();
        let ratio = scatter / stated;
        assert!((0.72..1.25).contains(&ratio), "{name}: {ratio}");
    }
}
