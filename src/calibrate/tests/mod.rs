//! The calibration against cameras that are known.

mod held;
mod lenses;
mod outliers;
mod rivals;
mod sheet;
mod uncertainty;

use super::synthetic::{board, long, ordinary, pose_at, poses, views, wide, with_covariance};
use super::*;
use crate::camera::{Camera, Distortion, LensModel, PlumbBob, Pose};
use nalgebra::{DMatrix, DVector, Matrix2, Point2, Vector3};
use rand::{RngExt, SeedableRng};

const P: usize = 9;

fn names() -> &'static [&'static str] {
    LensModel::PlumbBob.parameter_names()
}

fn solved(board: &Board, views: &[View]) -> Calibration {
    calibrate(board, views, &CalibrateOptions::default()).unwrap()
}

#[test]
fn perfect_points_give_the_camera_back() {
    for camera in [wide(), ordinary(), long()] {
        let poses = poses(&camera, &board());
        let result = solved(&board(), &views(&camera, &board(), &poses, 0.0, 0));
        let (found, truth) = (result.camera.parameters(), camera.parameters());
        for at in 0..P {
            let scale = if at < 4 { truth[at] } else { 1.0 };
            let error = (found[at] - truth[at]).abs() / scale;
            assert!(error < 1e-6, "{}: {error:e}", names()[at]);
        }
        assert!(result.rms_px < 1e-8, "{}", result.rms_px);
        for (fit, pose) in result.views.iter().zip(&poses) {
            let found = fit.pose.unwrap();
            let turn = found.rotation.matrix() - pose.rotation.matrix();
            assert!(turn.norm() < 1e-7, "{}", turn.norm());
            assert!((found.translation_m - pose.translation_m).norm() < 1e-6);
        }
    }
}

/// (found - truth) in units of the reported covariance: its squared length is chi-square with 9 degrees of freedom.
#[test]
fn the_reported_covariance_is_that_of_the_errors() {
    let runs = 120;
    for (camera, sigma) in [(wide(), 0.1), (ordinary(), 0.05), (long(), 0.2)] {
        let poses = poses(&camera, &board());
        let (mut chi2, mut factor) = (0.0, 0.0);
        let mut standardised = [0.0; P];
        for seed in 0..runs {
            let mut views = views(&camera, &board(), &poses, sigma, seed);
            with_covariance(&mut views, Matrix2::identity() * sigma * sigma);
            let result = solved(&board(), &views);
            let found = DVector::from_vec(result.camera.parameters());
            let error = found - DVector::from_vec(camera.parameters());
            let unit = DMatrix::from_diagonal(&DVector::from_fn(P, |i, _| 1.0 / result.std(i)));
            let scaled = (&unit * &result.covariance * &unit).cholesky().unwrap();
            let error = &unit * error;
            chi2 += error.dot(&scaled.solve(&error)) / runs as f64;
            factor += result.variance_factor / runs as f64;
            for at in 0..P {
                standardised[at] += error[at] * error[at] / runs as f64;
            }
        }
        // the mean of 120 values of chi-square 9 has a standard deviation of 0.39, and 0.13 for one degree
        assert!((chi2 - 9.0).abs() < 1.6, "chi-square {chi2}");
        assert!((factor - 1.0).abs() < 0.02, "variance factor {factor}");
        for (name, ratio) in names().iter().zip(standardised) {
            assert!((0.5..1.6).contains(&ratio), "{name}: {ratio}");
        }
    }
}

#[test]
fn rings_without_covariance_tell_their_noise_themselves() {
    let camera = ordinary();
    let poses = poses(&camera, &board());
    let plain = views(&camera, &board(), &poses, 0.1, 4);
    let mut weighted = plain.clone();
    with_covariance(&mut weighted, Matrix2::identity() * 0.01);
    let (a, b) = (solved(&board(), &plain), solved(&board(), &weighted));
    for at in 0..P {
        // what the fit of a bent ring measures is predicted of rings with a covariance alone: a few thousandths of a pixel
        assert!((a.std(at) / b.std(at) - 1.0).abs() < 1e-3);
    }
    assert!(
        (a.rms_px - 0.1 * 2.0_f64.sqrt()).abs() < 0.01,
        "{}",
        a.rms_px
    );
    assert!((a.variance_factor / (0.01 * b.variance_factor) - 1.0).abs() < 1e-3);
}

#[test]
fn a_worse_ring_counts_less() {
    let camera = ordinary();
    let mut views = views(&camera, &board(), &poses(&camera, &board()), 0.0, 0);
    with_covariance(&mut views, Matrix2::identity() * 1e-4);
    for view in &mut views {
        view.rings[3].centre.point.x += 5.0;
        view.rings[3].centre.covariance = Some(Matrix2::new(1e6, 0.0, 0.0, 1e-4));
    }
    let found = solved(&board(), &views).camera.intrinsics;
    assert!(
        (found.fx - camera.intrinsics.fx).abs() < 1e-2,
        "{}",
        found.fx
    );
}

#[test]
fn the_order_of_views_and_rings_does_not_matter() {
    let camera = wide();
    let straight = views(&camera, &board(), &poses(&camera, &board()), 0.1, 7);
    let mut shuffled: Vec<View> = straight.iter().rev().cloned().collect();
    for view in &mut shuffled {
        view.rings.reverse();
    }
    let (a, b) = (solved(&board(), &straight), solved(&board(), &shuffled));
    for at in 0..P {
        let difference = a.camera.parameters()[at] - b.camera.parameters()[at];
        assert!(difference.abs() < 1e-4 * a.std(at), "{difference:e}");
    }
    assert_eq!(a, solved(&board(), &straight), "not even by rounding");
}

#[test]
fn fixed_parameters_stay_and_have_no_deviation() {
    let camera = ordinary();
    let views = views(&camera, &board(), &poses(&camera, &board()), 0.05, 2);
    let options = CalibrateOptions {
        fixed: Fixed::from_entries(["k3", "p1", "p2", "cx", "fy=1201"]).unwrap(),
        ..CalibrateOptions::default()
    };
    let result = calibrate(&board(), &views, &options).unwrap();
    let values = result.camera.parameters();
    let held = [8, 6, 7, 2, 1].map(|at| values[at]);
    assert_eq!(held, [0.0, 0.0, 0.0, 639.5, 1201.0]);
    assert_eq!(result.fixed, ["fy", "cx", "p1", "p2", "k3"]);
    for (at, name) in names().iter().enumerate() {
        assert_eq!(result.std(at) == 0.0, result.fixed.contains(name), "{name}");
    }
    let all = Fixed::from_entries(names()).unwrap();
    let options = CalibrateOptions {
        fixed: all,
        ..CalibrateOptions::default()
    };
    let poses_alone = calibrate(&board(), &views, &options).unwrap();
    assert_eq!(poses_alone.camera.distortion, Default::default());
}

#[test]
fn a_larger_board_stands_further_away_and_changes_nothing_else() {
    let camera = ordinary();
    let views = views(&camera, &board(), &poses(&camera, &board()), 0.1, 3);
    let larger = Board::new(7, 7, 0.269, 0.03, 0.06, board().polarity()).unwrap();
    let (a, b) = (solved(&board(), &views), solved(&larger, &views));
    for at in 0..P {
        let difference = a.camera.parameters()[at] - b.camera.parameters()[at];
        assert!(difference.abs() < 1e-4 * a.std(at));
    }
    for (one, other) in a.views.iter().zip(&b.views) {
        let scaled = one.pose.unwrap().translation_m * 10.0;
        assert!((scaled - other.pose.unwrap().translation_m).norm() < 1e-4 * scaled.norm());
    }
}

#[test]
fn labels_turned_by_a_quarter_leave_the_camera_alone() {
    let camera = ordinary();
    let straight = views(&camera, &board(), &poses(&camera, &board()), 0.1, 3);
    let mut turned = straight.clone();
    for ring in turned.iter_mut().step_by(2).flat_map(|v| &mut v.rings) {
        (ring.row, ring.column) = (ring.column, 6 - ring.row);
    }
    let (a, b) = (solved(&board(), &straight), solved(&board(), &turned));
    for at in 0..P {
        let difference = a.camera.parameters()[at] - b.camera.parameters()[at];
        assert!(difference.abs() < 1e-4 * a.std(at));
    }
}

/// Ten views with the board in different places of the frame and each of these turns.
fn turned(camera: &Camera, turn: impl Fn(f64) -> [f64; 3], sigma: f64, seed: u64) -> Vec<View> {
    let (w, h) = (f64::from(camera.width), f64::from(camera.height));
    let poses: Vec<_> = (0..10)
        .map(|i| {
            let i = f64::from(i);
            let pixel = [
                w * (0.35 + 0.03 * i),
                h * (0.4 + 0.2 * (i * 1.7).sin().abs()),
            ];
            pose_at(camera, &board(), pixel, 0.5, turn(i))
        })
        .collect();
    views(camera, &board(), &poses, sigma, seed)
}

#[test]
fn views_that_cannot_tell_the_focal_length_are_refused() {
    let camera = ordinary();
    let frontal = |_: f64| [0.0, 0.0, 0.0];
    let in_plane = |i: f64| [0.0, 0.0, 0.3 * i];
    let oblique = |_: f64| [0.3, 0.4, 0.0];
    let nearly = |i: f64| [0.004 * (2.0 * i).sin(), 0.004 * (3.0 * i).cos(), 0.0];
    for sigma in [0.0, 0.03, 0.1, 0.5] {
        for seed in 0..5 {
            let cases = [
                ("frontal", turned(&camera, frontal, sigma, seed)),
                ("in plane", turned(&camera, in_plane, sigma, seed)),
                ("oblique", turned(&camera, oblique, sigma, seed)),
                ("nearly", turned(&camera, nearly, sigma.max(0.1), seed)),
            ];
            for (name, views) in cases {
                let answer = calibrate(&board(), &views, &CalibrateOptions::default());
                assert!(
                    matches!(
                        answer,
                        Err(CalibrateError::Undetermined { .. } | CalibrateError::Parallel { .. })
                    ),
                    "{name}, noise {sigma}: {:?}",
                    answer.map(|c| (c.camera.parameters(), c.std(0)))
                );
            }
        }
    }
    let told = turned(
        &camera,
        |i| [0.4 * (2.0 * i).sin(), 0.4 * (3.0 * i).cos(), 0.0],
        0.5,
        1,
    );
    solved(&board(), &told);
}

#[test]
fn three_views_are_enough_where_they_are_tilted() {
    for camera in [wide(), ordinary(), long()] {
        let poses = poses(&camera, &board());
        let three = [poses[1], poses[5], poses[9]];
        let result = solved(&board(), &views(&camera, &board(), &three, 0.05, 1));
        let error = result.camera.intrinsics.fx - camera.intrinsics.fx;
        assert!(
            error.abs() < 4.0 * result.std(0),
            "{error} {}",
            result.std(0)
        );
    }
}

#[test]
fn refusals_say_what_is_wrong() {
    let camera = ordinary();
    let good = views(&camera, &board(), &poses(&camera, &board()), 0.0, 0);
    let refused = |board: &Board, views: &[View]| {
        calibrate(board, views, &CalibrateOptions::default())
            .unwrap_err()
            .to_string()
    };
    let broken = |change: &dyn Fn(&mut View)| {
        let mut views = good.clone();
        change(&mut views[2]);
        refused(&board(), &views)
    };
    let single = Board::new(1, 1, 0.0, 0.003, 0.006, board().polarity()).unwrap();
    assert!(refused(&single, &good).contains("single ring"));
    assert_eq!(
        refused(&board(), &good[..2]),
        "2 views, at least 3 are needed"
    );
    assert_eq!(
        refused(&board(), &good[..1]),
        "1 view, at least 3 are needed"
    );
    assert_eq!(
        broken(&|v| v.rings[8].centre.point.x = f64::NAN),
        "view 2 has no valid position for ring (1, 1)"
    );
    assert_eq!(
        broken(&|v| v.rings[8].centre.covariance = Some(-Matrix2::identity())),
        "view 2 has no valid covariance for ring (1, 1)"
    );
    assert_eq!(
        broken(&|v| v.width = 640),
        "view 2 is 640 x 960 px, the first view is 1280 x 960"
    );
    assert_eq!(
        broken(&|v| v.rings[0].row = 7),
        "view 2 has ring (7, 0), which is outside a board of 7 x 7"
    );
    assert!(broken(&|v| v.rings[0].column = 1).contains("(0, 1), which is twice in"));
    let small = Board::new(2, 2, 0.0269, 0.003, 0.006, board().polarity()).unwrap();
    let few = views(&camera, &small, &poses(&camera, &small)[..3], 0.0, 0);
    assert!(refused(&small, &few).starts_with("24 coordinates measured for 27 unknowns"));
}

#[test]
fn nonsense_is_refused_and_never_a_panic() {
    let camera = ordinary();
    let mut views = views(&camera, &board(), &poses(&camera, &board()), 0.0, 0);
    for (i, view) in views.iter_mut().enumerate() {
        for (j, ring) in view.rings.iter_mut().enumerate() {
            ring.centre.point = Point2::new(
                640.0 + 600.0 * ((i * 49 + j) as f64 * 12.9898).sin(),
                480.0 + 400.0 * ((i * 49 + j) as f64 * 78.233).sin(),
            );
        }
    }
    assert!(calibrate(&board(), &views, &CalibrateOptions::default()).is_err());
    for ring in views.iter_mut().flat_map(|v| &mut v.rings) {
        ring.centre.point = Point2::new(1e300, -1e300);
    }
    assert!(calibrate(&board(), &views, &CalibrateOptions::default()).is_err());
}

/// The closed form alone, without distortion and noise, is exact.
#[test]
fn the_closed_form_is_exact_for_an_ideal_lens() {
    let mut camera = ordinary();
    camera.distortion = Default::default();
    let views = views(&camera, &board(), &poses(&camera, &board()), 0.0, 0);
    let size = (1280.0, 960.0);
    let homographies: Vec<_> = observations::observations(&board(), &views)
        .unwrap()
        .iter()
        .map(|rings| start_homography::of_marked(rings).unwrap())
        .collect();
    let found = zhang::intrinsics(&homographies, size).unwrap();
    assert!((found.fx - camera.intrinsics.fx).abs() < 1e-5);
    assert!((found.cy - camera.intrinsics.cy).abs() < 1e-5);
    // 1.5 and 9.5 px off the middle cost the one-parameter form about as many px of focal length
    let focal = focal_length_px(&homographies, size).unwrap();
    assert!((focal - 1202.0).abs() < 12.0, "{focal}");
    let pose = pose(&homographies[5], &camera.intrinsics).unwrap();
    let truth = poses(&camera, &board())[5];
    assert!((pose.translation_m - truth.translation_m).norm() < 1e-9);
    assert!((pose.rotation * Vector3::z() - truth.rotation * Vector3::z()).norm() < 1e-9);
}

/// Focal lengths of 0.45 to 12 times 1280 px, barrels and cushions, 3 to 14 views, from no guess but the views.
#[test]
fn cameras_of_all_sorts_are_found() {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(9);
    let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
    let mut open = 0;
    for case in 0..100_u32 {
        let mut camera = ordinary();
        let focal = 1280.0 * between(0.45_f64.ln(), 12.0_f64.ln()).exp();
        (camera.intrinsics.fx, camera.intrinsics.fy) = (focal, focal * between(0.97, 1.03));
        camera.intrinsics.cx = between(600.0, 680.0);
        camera.intrinsics.cy = between(440.0, 520.0);
        let k1 = between(-0.35, 0.15);
        camera.distortion = Distortion::from(PlumbBob {
            k1,
            k2: k1.min(0.0).powi(2),
            ..PlumbBob::default()
        });
        let poses: Vec<_> = (0..3 + case % 12)
            .map(|_| {
                let (tilt, angle) = (between(0.25, 0.75), between(0.0, std::f64::consts::TAU));
                let turn = [tilt * angle.cos(), tilt * angle.sin(), between(-0.5, 0.5)];
                let pixel = [between(450.0, 830.0), between(380.0, 580.0)];
                pose_at(&camera, &board(), pixel, between(0.35, 0.6), turn)
            })
            .collect();
        let seen = views(&camera, &board(), &poses, 0.05, case.into());
        let result = match calibrate(&board(), &seen, &CalibrateOptions::default()) {
            Ok(result) => result,
            // the board was in the middle of the frame, and few views do not tell what the lens does at its corners
            Err(CalibrateError::LensOpen { .. }) => {
                open += 1;
                continue;
            }
            Err(error) => panic!("case {case}, focal length {focal}: {error}"),
        };
        let error = (result.camera.intrinsics.fx - focal) / result.std(0);
        assert!(
            error.abs() < 5.0,
            "case {case}, focal length {focal}: {error} std"
        );
        assert!(result.rms_px < 0.1, "case {case}: {}", result.rms_px);
    }
    assert!(open < 50, "{open}");
}
