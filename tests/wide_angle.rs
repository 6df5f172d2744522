//! A wide lens that bends its rings: what the bends do to the centres is less than what noise does.

use ringcal::board::{Board, Polarity};
use ringcal::calibrate::{CalibrateOptions, Calibration};
use ringcal::camera::{Camera, Intrinsics, PlumbBob};
use ringcal::detect::{DetectOptions, Detector};
use ringcal::refine::calibrate_refined;
use ringcal::session::View;
use ringcal::simulate::{BitDepth, Defocus, Scene, render, views};

/// 94 degrees across.
fn camera() -> Camera {
    let distortion = PlumbBob {
        k1: -0.3,
        k2: 0.09,
        ..PlumbBob::default()
    };
    Camera {
        width: 1280,
        height: 960,
        intrinsics: Intrinsics {
            fx: 600.0,
            fy: 600.0,
            cx: 639.5,
            cy: 479.5,
        },
        distortion: distortion.into(),
    }
}

/// Twenty views of a board whose rings are about 40 px in diameter.
fn calibration(noise: f64) -> Calibration {
    let camera = camera();
    let board = Board::new(7, 7, 0.0269, 0.003, 0.006, Polarity::DarkOnLight).unwrap();
    let detector = Detector::new(board.clone(), DetectOptions::default());
    let poses = views(&camera, &board, 20, 0.7, 3).unwrap();
    let seen = poses.into_iter().enumerate().map(|(at, pose)| {
        let mut scene = Scene::new(camera, board.clone(), pose);
        scene.defocus = Defocus::gaussian(2.0);
        scene.light.margin = f64::INFINITY;
        scene.sensor.read_noise = noise;
        scene.sensor.depth = BitDepth::Sixteen;
        let frame = render(&scene, at as u64).unwrap().frame;
        View::of_file(format!("view {at}"), &detector.detect(&frame).unwrap())
    });
    let options = CalibrateOptions::default();
    calibrate_refined(&board, &seen.collect::<Vec<_>>(), &options)
        .unwrap()
        .0
}

#[test]
fn bends_of_a_wide_lens_bias_nothing() {
    let (clean, noisy) = (calibration(0.0), calibration(0.005));
    let truth = camera().parameters();
    let names = camera().parameter_names();
    for (k, name) in names.iter().enumerate() {
        let bias = (clean.values()[k] - truth[k]) / noisy.std(k);
        // 3.4 for fx where the bends are neither predicted nor taken off
        let most = if k < 4 { 0.3 } else { 0.9 };
        assert!(bias.abs() < most, "{name}: {bias} standard deviations");
        let z = (noisy.values()[k] - truth[k]) / noisy.std(k);
        assert!(z.abs() < 3.5, "{name}: {z} standard deviations off");
    }
}
