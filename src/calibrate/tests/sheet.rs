//! A sheet that is not what its board file says, constraints, and guesses.

use super::*;
use crate::board::Polarity;
use crate::calibrate::{SheetOptions, SheetShape};
use crate::centre::Estimator;

/// Views of an oblong board that is bent and stretched.
fn bent(shape: SheetShape, board: &Board, sigma_px: f64) -> (Camera, Vec<View>) {
    let camera = ordinary();
    let poses = poses(&camera, board);
    let mut seen = views(&camera, board, &poses, sigma_px, 5);
    let flat = views(&camera, board, &poses, 0.0, 0);
    for ((view, exact), pose) in seen.iter_mut().zip(&flat).zip(&poses) {
        for (ring, exact) in view.rings.iter_mut().zip(&exact.rings) {
            let place = shape.place_m(board.centre_m(ring.row, ring.column), board.middle_m());
            let point = pose.rotation * place + pose.translation_m;
            let moved = camera.project(&point).unwrap() - exact.centre.point;
            ring.centre.point += moved;
        }
    }
    (camera, seen)
}

#[test]
fn a_bent_and_stretched_board_is_told_and_its_camera_too() {
    let board = Board::new(6, 8, 0.0269, 0.003, 0.006, Polarity::DarkOnLight).unwrap();
    let shape = SheetShape {
        bow_per_m: [0.08, -0.05],
        pitch_ratio: 1.002,
    };
    let (camera, seen) = bent(shape, &board, 0.02);
    let options = CalibrateOptions {
        sheet: SheetOptions {
            bow: true,
            pitch_ratio: true,
        },
        ..CalibrateOptions::default()
    };
    let result = calibrate(&board, &seen, &options).unwrap();
    assert_eq!(result.names[9..], ["bow_x", "bow_y", "pitch_ratio"]);
    let truth = [0.08, -0.05, 1.002];
    for (at, truth) in (9..).zip(truth) {
        let z = (result.values()[at] - truth) / result.std(at);
        assert!(z.abs() < 4.0, "{}: {z}", result.names[at]);
    }
    let z = (result.camera.intrinsics.fx - camera.intrinsics.fx) / result.std(0);
    assert!(z.abs() < 4.0, "{z}");
    let flat = solved(&board, &seen);
    assert!(flat.rms_px > 3.0 * result.rms_px);
}

#[test]
fn what_a_square_board_without_marks_cannot_tell_is_refused_or_tied() {
    let shape = SheetShape {
        bow_per_m: [0.05, 0.05],
        pitch_ratio: 1.0,
    };
    let (_, seen) = bent(shape, &board(), 0.02);
    let of = |bow, pitch_ratio| {
        let options = CalibrateOptions {
            sheet: SheetOptions { bow, pitch_ratio },
            ..CalibrateOptions::default()
        };
        calibrate(&board(), &seen, &options)
    };
    let result = of(true, false).unwrap();
    assert_eq!(result.sheet.bow_per_m[0], result.sheet.bow_per_m[1]);
    assert!((result.sheet.bow_per_m[0] - 0.05).abs() < 4.0 * result.std(9));
    assert_eq!(result.std(9), result.std(10));
    assert_eq!(of(false, true).unwrap_err(), CalibrateError::QuarterTurns);
}

#[test]
fn the_aspect_ratio_is_kept_and_a_guess_is_where_held_values_come_from() {
    let camera = ordinary();
    let seen = views(&camera, &board(), &poses(&camera, &board()), 0.02, 5);
    let options = CalibrateOptions {
        fixed: Fixed::from_entries(["aspect_ratio", "principal_point", "tangential", "radial=2"])
            .unwrap(),
        guess: Some(camera),
        ..CalibrateOptions::default()
    };
    let result = calibrate(&board(), &seen, &options).unwrap();
    let (k, truth) = (result.camera.intrinsics, camera.intrinsics);
    assert!((k.fy / k.fx - truth.fy / truth.fx).abs() < 1e-12);
    assert_eq!((k.cx, k.cy), (truth.cx, truth.cy));
    assert_eq!(result.fixed, ["cx", "cy", "p1", "p2", "k3"]);
    assert_eq!(result.camera.parameters()[6..8], camera.parameters()[6..8]);
    // a tied parameter is as uncertain as the one it follows
    assert!((result.std(1) / result.std(0) - truth.fy / truth.fx).abs() < 1e-9);
    let wrong = CalibrateOptions {
        fixed: Fixed::from_entries(["k5"]).unwrap(),
        ..CalibrateOptions::default()
    };
    let refused = calibrate(&board(), &seen, &wrong).unwrap_err();
    assert!(
        refused.to_string().contains("plumb_bob has no k5"),
        "{refused}"
    );
}

/// Exact ellipses of each ring, measured by a construction that is biased by perspective and distortion.
#[test]
fn a_biased_construction_is_predicted_and_its_camera_is_not_biased() {
    let camera = wide();
    // large rings: 11 mm at a pitch of 26.9
    let board = Board::new(7, 7, 0.0269, 0.0055, 0.011, Polarity::DarkOnLight).unwrap();
    let poses = poses(&camera, &board);
    for estimator in [
        Estimator::BigEllipse,
        Estimator::SmallEllipse,
        Estimator::Cross,
    ] {
        let construction = estimator.construction().unwrap();
        let mut seen = views(&camera, &board, &poses, 0.0, 0);
        for (view, pose) in seen.iter_mut().zip(&poses) {
            for ring in &mut view.rings {
                let [x, y] = board.centre_m(ring.row, ring.column);
                let ellipse = |radius: f64| {
                    let points: [_; 90] = std::array::from_fn(|i| {
                        let (sin, cos) = (4.0 * i as f64).to_radians().sin_cos();
                        let place = [x + radius * cos, y + radius * sin];
                        camera.project(&pose.board_to_camera(place)).unwrap()
                    });
                    crate::detect::ellipse_along(&points).unwrap()
                };
                let ellipses = crate::centre::RingEllipses {
                    inner: ellipse(board.inner_radius_m()),
                    outer: ellipse(board.outer_radius_m()),
                };
                ring.centre.point = construction.estimate(&ellipses).unwrap().point;
            }
        }
        let options = CalibrateOptions {
            estimator,
            ..CalibrateOptions::default()
        };
        let predicted = calibrate(&board, &seen, &options).unwrap();
        let naive = solved(&board, &seen);
        let off = |c: &Calibration| {
            let (found, truth) = (c.camera.intrinsics, camera.intrinsics);
            (found.fx - truth.fx).abs().max((found.cx - truth.cx).abs())
        };
        assert!(
            off(&predicted) < 0.005,
            "{}: {}",
            estimator.name(),
            off(&predicted)
        );
        assert!(
            off(&naive) > 5.0 * off(&predicted),
            "{}: {}",
            estimator.name(),
            off(&naive)
        );
    }
}
