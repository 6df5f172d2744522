//! Reported uncertainties against Monte Carlo, folds, and views held against a camera.

use super::*;
use crate::calibrate::{Known, Range, cross_validate, resect};
use crate::centre::Estimator;
use nalgebra::{Point3, Vector6};

const SIGMA_PX: f64 = 0.05;

fn trial(camera: &Camera, seed: u64) -> Calibration {
    let poses = poses(camera, &board());
    let mut views = views(camera, &board(), &poses, SIGMA_PX, seed);
    with_covariance(&mut views, Matrix2::identity() * SIGMA_PX * SIGMA_PX);
    solved(&board(), &views)
}

/// Where the camera of another set of views sees what the true camera sees at a pixel, carried by the boards as the definition says.
fn carried(
    camera: &Camera,
    result: &Calibration,
    pixel: &Point2<f64>,
    range: Range,
) -> nalgebra::Vector2<f64> {
    let ray = camera.ray(pixel).unwrap();
    let mut sum = Vector3::zeros();
    let poses = poses(camera, &board());
    for (truth, fit) in poses.iter().zip(&result.views) {
        let found = fit.pose.unwrap();
        sum += match range {
            Range::Infinity => found.rotation * (truth.rotation.inverse() * ray),
            Range::At(distance_m) => {
                let on_board = truth.rotation.inverse() * (ray * distance_m - truth.translation_m);
                found.rotation * on_board + found.translation_m
            }
        };
    }
    let point = Point3::from(sum / poses.len() as f64);
    result.camera.project(&point).unwrap() - pixel
}

#[test]
fn projection_and_pose_uncertainty_agree_with_monte_carlo() {
    let runs = 800;
    let camera = ordinary();
    let distance_m = trial(&camera, 0).typical_distance_m();
    let places = [
        Point2::new(640.0, 470.0),
        Point2::new(60.0, 50.0),
        Point2::new(1200.0, 500.0),
    ];
    let ranges = [
        Range::Infinity,
        Range::At(distance_m),
        Range::At(0.3 * distance_m),
    ];
    let mut ratios = [[0.0; 3]; 3];
    let mut pose_chi2 = 0.0;
    for seed in 0..runs {
        let result = trial(&camera, seed);
        for (row, range) in ratios.iter_mut().zip(ranges) {
            for (ratio, pixel) in row.iter_mut().zip(&places) {
                let off = carried(&camera, &result, pixel, range);
                let covariance = result.projection_covariance(pixel, range).unwrap();
                *ratio += off.dot(&(covariance.try_inverse().unwrap() * off)) / runs as f64;
            }
        }
        let view = 3;
        let (truth, found) = (
            poses(&camera, &board())[view],
            result.views[view].pose.unwrap(),
        );
        let turn = (found.rotation * truth.rotation.inverse()).scaled_axis();
        let shift = found.translation_m - truth.translation_m;
        let off = Vector6::new(turn.x, turn.y, turn.z, shift.x, shift.y, shift.z);
        let covariance = result.pose_covariance(view).unwrap();
        pose_chi2 += off.dot(&covariance.cholesky().unwrap().solve(&off)) / runs as f64;
    }
    // chi-square of two degrees: 2, and its mean of 800 has a standard deviation of 0.07
    for ratio in ratios.iter().flatten() {
        assert!((ratio - 2.0).abs() < 0.3, "{ratios:?}");
    }
    assert!((pose_chi2 - 6.0).abs() < 0.5, "{pose_chi2}");
}

#[test]
fn left_out_views_are_predicted_about_as_well_as_those_that_were_used() {
    let camera = ordinary();
    let views = views(&camera, &board(), &poses(&camera, &board()), SIGMA_PX, 3);
    let options = CalibrateOptions::default();
    let result = solved(&board(), &views);
    let validated = cross_validate(&board(), &views, &options, &result).unwrap();
    assert_eq!(validated.folds, 5);
    let ratio = validated.rms_px / result.rms_px;
    assert!((0.99..1.25).contains(&ratio), "{ratio}");
    assert_eq!(validated.view_factors.len(), 12);
    assert!(validated.view_factors.iter().all(Option::is_some));
    let few = cross_validate(
        &board(),
        &views[..3],
        &options,
        &solved(&board(), &views[..3]),
    );
    assert!(few.is_err());
}

#[test]
fn a_view_held_against_the_true_camera_gives_its_pose() {
    let camera = wide();
    let poses = poses(&camera, &board());
    let views = views(&camera, &board(), &poses, 0.0, 3);
    let known = Known {
        camera,
        sheet: Default::default(),
        estimator: Estimator::Photometric,
    };
    for (found, truth) in resect(&board(), &views, &known).unwrap().iter().zip(&poses) {
        let pose = found.fit.pose.unwrap();
        assert!((pose.translation_m - truth.translation_m).norm() < 1e-9);
        assert!(found.fit.rms_px < 1e-8);
        assert_eq!(found.degrees, 92.0);
    }
}

#[test]
fn what_is_predicted_of_a_view_is_what_a_calibration_of_the_others_predicts() {
    let camera = wide();
    let views = views(&camera, &board(), &poses(&camera, &board()), SIGMA_PX, 3);
    let options = CalibrateOptions::default();
    let result = solved(&board(), &views);
    let validated = cross_validate(&board(), &views, &options, &result).unwrap();
    for fold in 0..validated.folds {
        let apart = |inside: bool| -> Vec<View> {
            let all = views.iter().enumerate();
            let part = all.filter(|(at, _)| (at % validated.folds == fold) == inside);
            part.map(|(_, view)| view.clone()).collect()
        };
        let rest = solved(&board(), &apart(false));
        let known = Known {
            camera: rest.camera,
            sheet: rest.sheet,
            estimator: options.estimator,
        };
        let found = resect(&board(), &apart(true), &known).unwrap();
        let factors = validated
            .view_factors
            .iter()
            .skip(fold)
            .step_by(validated.folds);
        for (view, factor) in found.iter().zip(factors) {
            let off = factor.unwrap() / (view.cost / view.degrees) - 1.0;
            assert!(off.abs() < 0.02, "{off}");
        }
    }
}
