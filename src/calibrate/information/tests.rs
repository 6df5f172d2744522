//! What is said without solving, against what solving says.

use super::*;
use crate::calibrate::calibrate;
use crate::calibrate::synthetic::{board, ordinary, pose_at, poses, views, wide};

const SIGMA_PX: f64 = 0.1;

fn noisy(camera: &Camera) -> Vec<View> {
    views(camera, &board(), &poses(camera, &board()), SIGMA_PX, 1)
}

fn estimate(views: &[View]) -> Estimate {
    Estimate::solve(&board(), views, &CalibrateOptions::default()).unwrap()
}

/// A view of its own: near a corner, strongly tilted.
fn corner(camera: &Camera) -> View {
    let pixel = [
        0.74 * f64::from(camera.width),
        0.27 * f64::from(camera.height),
    ];
    let pose = pose_at(camera, &board(), pixel, 0.45, [-0.5, 0.4, 0.1]);
    views(camera, &board(), &[pose], SIGMA_PX, 77).remove(0)
}

#[test]
fn a_solved_estimate_is_as_certain_as_its_calibration() {
    for camera in [ordinary(), wide()] {
        let views = noisy(&camera);
        let calibration = calibrate(&board(), &views, &CalibrateOptions::default()).unwrap();
        let estimate = estimate(&views);
        assert_eq!(estimate.views_used(), 12);
        assert!((estimate.fx_std_px() / calibration.std(0) - 1.0).abs() < 1e-6);
        let map = calibration.projection_std_map(MAP_CELLS, Range::Infinity);
        for (own, its) in estimate.projection_std_px().iter().zip(map) {
            assert!((own.unwrap() / its.unwrap() - 1.0).abs() < 1e-6);
        }
        let (cell, worst) = estimate.least_certain().unwrap();
        assert!([0, 9, 90, 99].contains(&cell) && worst > 0.0, "{cell}");
    }
}

#[test]
fn a_forecast_comes_true() {
    let camera = ordinary();
    let mut views = noisy(&camera);
    let mut estimate = estimate(&views);
    let told = estimate.judge(&board(), &corner(&camera)).unwrap();
    let (gain, forecast) = (estimate.gain_nats(&told), estimate.fx_std_with_px(&told));
    assert!(gain > 0.0 && forecast < estimate.fx_std_px());
    let before = estimate.least_certain().unwrap().1;
    estimate.add(told);
    views.push(corner(&camera));
    let solved = super::tests::estimate(&views);
    assert!((forecast / estimate.fx_std_px() - 1.0).abs() < 1e-9);
    assert!((forecast / solved.fx_std_px() - 1.0).abs() < 0.05);
    let (own, its) = (
        estimate.least_certain().unwrap(),
        solved.least_certain().unwrap(),
    );
    assert!(own.1 < before && (own.1 / its.1 - 1.0).abs() < 0.05);
    // and without it again, as if it had never been there; the one that was put out is the first
    let told = solved.judge(&board(), &views[0]).unwrap();
    estimate.exchange(0, told);
    assert_eq!(estimate.views_used(), 13);
    assert!((estimate.fx_std_px() / solved.fx_std_px() - 1.0).abs() < 0.05);
}

#[test]
fn the_view_that_gives_way_is_the_one_whose_exchange_leaves_most() {
    let camera = ordinary();
    let estimate = estimate(&noisy(&camera));
    let told = estimate.judge(&board(), &corner(&camera)).unwrap();
    let (best, won) = estimate.least_useful(&told).unwrap();
    let log_det = |estimate: &Estimate| {
        let sum = estimate.sum();
        let scale = sum.diagonal().map(|d| 1.0 / d.sqrt());
        let logs: f64 = scale.iter().map(|s| s.ln()).sum();
        let scale = DMatrix::from_diagonal(&scale);
        (&scale * sum * &scale).determinant().ln() - 2.0 * logs
    };
    let after = |at: usize| {
        let mut other = estimate.clone();
        other.exchange(at, told.clone());
        log_det(&other)
    };
    let most = after(best);
    assert!((0..12).all(|at| after(at) <= most + 1e-9));
    assert_eq!(won > 0.0, most > log_det(&estimate));
    assert!(estimate.average_gain_nats() > 0.0);
}

#[test]
fn a_camera_that_is_still_uncertain_does_not_refuse_what_would_mend_it() {
    let camera = ordinary();
    let few: Vec<View> = [[0.4, 0.0], [-0.4, 0.1], [0.0, 0.5], [0.1, -0.4], [0.3, 0.3]]
        .into_iter()
        .zip(1..)
        .map(|([x, y], seed)| {
            let pose = pose_at(&camera, &board(), [640.0, 480.0], 0.75, [x, y, 0.0]);
            views(&camera, &board(), &[pose], SIGMA_PX, seed).remove(0)
        })
        .collect();
    let estimate = estimate(&few);
    // the middle alone leaves the corners to the lens model
    for (pixel, seed) in [
        ([260.0, 250.0], 11),
        ([1020.0, 250.0], 12),
        ([1020.0, 710.0], 13),
    ] {
        let pose = pose_at(&camera, &board(), pixel, 0.45, [-0.5, 0.4, 0.0]);
        let view = views(&camera, &board(), &[pose], SIGMA_PX, seed).remove(0);
        let told = estimate.judge(&board(), &view).unwrap();
        let (before, with) = (estimate.fx_std_px(), estimate.fx_std_with_px(&told));
        assert!(with < 0.97 * before, "{with} {before}");
    }
}

#[test]
fn what_contradicts_is_refused_and_a_single_ring_is_left_out() {
    let camera = ordinary();
    let estimate = estimate(&noisy(&camera));
    let good = corner(&camera);
    let mut one = good.clone();
    one.rings[10].centre.point.y += 5.0;
    let told = estimate.judge(&board(), &one).unwrap();
    assert_eq!(told.rings.iter().filter(|r| r.share <= 0.0).count(), 1);
    let mut shaken = good.clone();
    for (i, ring) in shaken.rings.iter_mut().enumerate() {
        ring.centre.point.x += if i % 2 == 0 { 0.8 } else { -0.8 };
    }
    let unfit = estimate.judge(&board(), &shaken).unwrap_err();
    assert!(
        matches!(unfit, Unfit::Contradicts(LeftOut::Noisy { times }) if times > 4.0),
        "{unfit}"
    );
    let mut mirrored = good.clone();
    for ring in &mut mirrored.rings {
        ring.column = 6 - ring.column;
    }
    let unfit = estimate.judge(&board(), &mirrored).unwrap_err();
    assert_eq!(unfit, Unfit::Contradicts(LeftOut::NoPose));
    let mut foreign = good.clone();
    foreign.rings[0].row = 9;
    let unfit = estimate.judge(&board(), &foreign).unwrap_err();
    assert!(matches!(
        unfit,
        Unfit::Unusable(CalibrateError::Label { .. })
    ));
    let mut few = good;
    few.rings.truncate(3);
    assert!(estimate.judge(&board(), &few).is_err());
}
