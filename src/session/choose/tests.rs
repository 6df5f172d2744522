//! The choice out of a long stream, against truth and against other choices.

use super::super::stream::{misnumbered, random_places, stream};
use super::*;
use crate::calibrate::synthetic::{board, ordinary, pose_at};
use crate::calibrate::{Calibration, Range, calibrate};

const VIEWS: usize = 400;
const CHOSEN: usize = 15;

fn calibrated(views: &[View], places: &[usize]) -> Calibration {
    let chosen: Vec<View> = places.iter().map(|at| views[*at].clone()).collect();
    calibrate(&board(), &chosen, &CalibrateOptions::default()).unwrap()
}

/// Standard deviation of fx and the worst projection uncertainty, px, for residuals of unit variance.
fn uncertainty(views: &[View], places: &[usize]) -> (f64, f64) {
    let calibration = calibrated(views, places);
    let unit = calibration.variance_factor.sqrt();
    let map = calibration.projection_std_map((10, 10), Range::Infinity);
    let worst = map.into_iter().flatten().fold(0.0, f64::max);
    (calibration.std(0) / unit, worst / unit)
}

fn chosen(views: &[View], count: usize) -> Vec<usize> {
    choose(&board(), views, count, &CalibrateOptions::default())
}

#[test]
fn the_choice_tells_more_than_the_first_and_than_random_views() {
    for seed in [7, 8, 9] {
        let views = stream(&ordinary(), &board(), VIEWS, seed);
        let best = chosen(&views, CHOSEN);
        assert!(best.len() == CHOSEN && best.is_sorted());
        let (fx, worst) = uncertainty(&views, &best);
        let first: Vec<usize> = (0..CHOSEN).collect();
        let others = (0..10).map(|seed| random_places(VIEWS, CHOSEN, seed));
        for other in others.chain([first]) {
            let (other_fx, other_worst) = uncertainty(&views, &other);
            assert!(fx < 0.7 * other_fx, "{fx} {other_fx}");
            assert!(worst < 0.7 * other_worst, "{worst} {other_worst}");
        }
        // the camera is the true one, as far as its uncertainty goes
        let calibration = calibrated(&views, &best);
        let error = calibration.camera.intrinsics.fx - 1203.0;
        assert!(error.abs() < 4.0 * calibration.std(0), "{error}");
    }
}

#[test]
fn misnumbered_views_are_not_chosen_though_they_would_have_the_most_leverage() {
    let mut views = stream(&ordinary(), &board(), 200, 3);
    let wrong: Vec<usize> = (0..200).step_by(10).collect();
    for at in &wrong {
        views[*at] = misnumbered(&views[*at], 1 + (at / 10 % 5) as u16);
    }
    let best = chosen(&views, CHOSEN);
    assert_eq!(best.len(), CHOSEN);
    assert!(best.iter().all(|at| !wrong.contains(at)), "{best:?}");
}

#[test]
fn the_choice_is_the_same_every_time_and_the_first_of_equals() {
    let mut views = stream(&ordinary(), &board(), 60, 4);
    let best = chosen(&views, CHOSEN);
    assert_eq!(best, chosen(&views, CHOSEN));
    // everything twice: the copies say the same and are passed over
    views.extend(views.clone());
    assert!(chosen(&views, CHOSEN).iter().all(|at| *at < 60));
    let all = chosen(&views, 1000);
    assert!(all.len() <= 60 && all.iter().all(|at| *at < 60));
    let single = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    assert_eq!(
        single.install(|| chosen(&views, CHOSEN)),
        chosen(&views, CHOSEN)
    );
}

#[test]
fn views_that_do_not_tell_the_camera_are_chosen_by_how_they_differ() {
    let camera = ordinary();
    let parallel: Vec<View> = (0..40)
        .map(|i| {
            let pixel = [300.0 + 17.0 * f64::from(i), 480.0];
            let pose = pose_at(&camera, &board(), pixel, 0.4, [0.0; 3]);
            crate::calibrate::synthetic::views(&camera, &board(), &[pose], 0.1, 1).remove(0)
        })
        .collect();
    let best = chosen(&parallel, 5);
    assert!(
        best.len() == 5 && best.contains(&0) && best.contains(&39),
        "{best:?}"
    );
    assert!(chosen(&[], 5).is_empty());
    assert!(chosen(&parallel[..2], 5).len() == 2);
    assert!(chosen(&parallel, 0).is_empty());
}

#[test]
fn views_of_another_size_or_without_a_pose_are_passed_over() {
    let mut views = stream(&ordinary(), &board(), 60, 5);
    views[0].width = 640;
    views[1].rings.truncate(3);
    let best = chosen(&views, 60);
    assert!(best.len() > 40 && best.iter().all(|at| *at > 1), "{best:?}");
}
