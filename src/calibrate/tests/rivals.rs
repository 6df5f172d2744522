//! Lens models that explain the same views: what they disagree by is not known.

use super::lenses::{kinect, options};
use super::*;
use crate::calibrate::with_rivals;
use crate::camera::Equidistant;

/// A fisheye of 180 degrees.
fn fisheye() -> Camera {
    let mut camera = ordinary();
    let lens = Equidistant {
        k: [-0.012, 0.004, -0.002, 0.0003],
    };
    camera.distortion = lens.into();
    (camera.intrinsics.fx, camera.intrinsics.fy) = (410.0, 411.6);
    camera
}

/// As `--model auto` does it, of centres that are not found again.
fn auto(views: &[View]) -> Result<Calibration, CalibrateError> {
    let (model, scores) = choose_model(&board(), views, &CalibrateOptions::default())?;
    let options = options(model);
    let calibration = calibrate(&board(), views, &options)?;
    let rivals = scores.iter().filter(|score| score.rival);
    let rivals: Vec<LensModel> = rivals.map(|score| score.model).collect();
    with_rivals(&board(), views, &options, (calibration, &rivals))
}

/// Refused for what the views lack, or right within three standard deviations in what all lens models have.
fn honest(views: &[View], truth: &Camera) {
    match auto(views) {
        Err(error) => assert!(error.is_of_the_views(), "{error}"),
        Ok(found) => {
            for (at, true_value) in truth.parameters().iter().take(4).enumerate() {
                let off = found.values()[at] - true_value;
                let (name, std) = (found.names[at], found.std(at));
                let model = found.camera.model();
                assert!(off.abs() < 3.0 * std, "{model}: {name} off {off} of {std}");
            }
        }
    }
}

#[test]
fn a_fisheye_whose_middle_alone_was_seen_is_not_taken_for_a_certain_plumb_bob() {
    let camera = fisheye();
    let middle = |turn: &dyn Fn(f64) -> [f64; 3]| -> Vec<Pose> {
        let pose = |i: i32| {
            let i = f64::from(i);
            let fill = 0.3 + 0.075 * (i % 5.0);
            pose_at(&camera, &board(), [640.0, 470.0], fill, turn(i))
        };
        (0..20).map(pose).collect()
    };
    let about_x = middle(&|i| [0.6 * (1.3 * i).sin(), 0.0, 0.0]);
    let about_both = middle(&|i| [0.5 * (2.4 * i).cos(), 0.5 * (2.4 * i).sin(), 0.1]);
    for poses in [about_x, about_both] {
        for seed in 0..4 {
            let mut views = views(&camera, &board(), &poses, 0.02, seed);
            with_covariance(&mut views, Matrix2::identity() * 4e-4);
            honest(&views, &camera);
        }
    }
}

#[test]
fn three_views_of_a_rational_lens_are_not_taken_for_another_with_certainty() {
    for seed in 0..4 {
        let (camera, mut views) = kinect(0.02, seed);
        with_covariance(&mut views, Matrix2::identity() * 4e-4);
        honest(&views[..4], &camera);
    }
}

#[test]
fn a_rival_that_says_the_same_adds_nothing_and_one_that_does_not_is_covered() {
    let camera = ordinary();
    let mut views = views(&camera, &board(), &poses(&camera, &board()), 0.05, 2);
    with_covariance(&mut views, Matrix2::identity() * 0.0025);
    let plain = options(LensModel::PlumbBob);
    let own = calibrate(&board(), &views, &plain).unwrap();
    let same = with_rivals(
        &board(),
        &views,
        &plain,
        (own.clone(), &[LensModel::PlumbBob]),
    )
    .unwrap();
    for (with, without) in same.stds().iter().zip(own.stds()) {
        assert!((with / without - 1.0).abs() < 1e-6);
    }
    let other = with_rivals(
        &board(),
        &views,
        &plain,
        (own.clone(), &[LensModel::Equidistant]),
    );
    let other = other.unwrap();
    let rival = &other.rivals[0];
    for at in 0..4 {
        let apart = rival.values()[at] - own.values()[at];
        assert!(other.std(at) >= apart.abs() && other.std(at) >= own.std(at));
        assert!(other.std(at) >= 0.999 * rival.std(at));
    }
}
