//! A fisheye from its frames: boards that the lens bends are found whole, and its calibration starts without a homography.

use ringcal::board::{Board, Polarity};
use ringcal::calibrate::CalibrateOptions;
use ringcal::camera::{Camera, Equidistant, Intrinsics, LensModel};
use ringcal::detect::{DetectOptions, Detector};
use ringcal::refine::calibrate_refined;
use ringcal::session::View;
use ringcal::simulate::{Defocus, Scene, render, views};

/// 180 degrees across the frame's diagonal.
fn camera() -> Camera {
    let distortion = Equidistant {
        k: [0.02, -0.005, 0.001, -0.0005],
    };
    Camera {
        width: 960,
        height: 720,
        intrinsics: Intrinsics {
            fx: 292.0,
            fy: 291.0,
            cx: 484.0,
            cy: 357.0,
        },
        distortion: distortion.into(),
    }
}

#[test]
fn a_fisheye_of_180_degrees_calibrates_from_its_frames() {
    let camera = camera();
    let board = Board::new(7, 7, 0.0269, 0.0045, 0.009, Polarity::DarkOnLight).unwrap();
    let poses = views(&camera, &board, 20, 0.6, 3).unwrap();
    let detector = Detector::new(board.clone(), DetectOptions::default());
    let seen = poses.into_iter().enumerate().map(|(at, pose)| {
        let mut scene = Scene::new(camera, board.clone(), pose);
        scene.defocus = Defocus::gaussian(1.5);
        scene.sensor.read_noise = 0.005;
        let frame = render(&scene, at as u64).unwrap().frame;
        let detection = detector.detect(&frame).unwrap();
        assert_eq!(detection.rings.len(), 49, "view {at}");
        View::of_file(format!("view {at}"), &detection)
    });
    let options = CalibrateOptions {
        model: LensModel::Equidistant,
        ..CalibrateOptions::default()
    };
    let (calibration, _) = calibrate_refined(&board, &seen.collect::<Vec<_>>(), &options).unwrap();

    // from the axis out to 85 degrees, in every direction
    let mut worst_px: f64 = 0.0;
    for degrees in 0..=85 {
        for turn in 0..12 {
            let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
            let (y, x) = (std::f64::consts::TAU * f64::from(turn) / 12.0).sin_cos();
            let point = nalgebra::Point3::new(sin * x, sin * y, cos);
            let there = calibration.camera.project(&point).unwrap();
            worst_px = worst_px.max((there - camera.project(&point).unwrap()).norm());
        }
    }
    assert!(worst_px < 0.2, "{worst_px}");
}
