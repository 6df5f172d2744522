//! The choice out of a long stream, against truth and against other choices.

use super::super::stream::{random_places, stream};
use super::*;
use crate::calibrate::synthetic::{board, ordinary};
use crate::calibrate::{Calibration, Range, calibrate};

fn calibrated(views: &[View], places: &[usize]) -> Calibration {
    let chosen: Vec<View> = places.iter().map(|at| views[*at].clone()).collect();
    calibrate(&board(), &chosen, &CalibrateOptions::default()).unwrap()
}

/// Standard deviation of fx, and the worst projection uncertainty, px.
fn uncertainty(views: &[View], places: &[usize]) -> (f64, f64) {
    let calibration = calibrated(views, places);
    let map = calibration.projection_std_map((10, 10), Range::Infinity);
    let worst = map.into_iter().flatten().fold(0.0, f64::max);
    (
        calibration.std(0) / calibration.variance_factor.sqrt(),
        worst / calibration.variance_factor.sqrt(),
    )
}

fn chosen(views: &[View], count: usize) -> Vec<usize> {
    choose(&board(), views, count, &CalibrateOptions::default())
}

#[test]
fn the_choice_tells_more_than_the_first_and_than_random_views() {
    let views = stream(&ordinary(), &board(), 400, 7);
    let best = chosen(&views, 15);
    assert_eq!(best.len(), 15);
    assert!(best.is_sorted());
    let (fx, worst) = uncertainty(&views, &best);
    let first: Vec<usize> = (0..15).collect();
    println!(
        "chosen {fx:.3} {worst:.3}, first {:?}",
        uncertainty(&views, &first)
    );
    for seed in 0..10 {
        let random = uncertainty(&views, &random_places(400, 15, seed));
        println!("random {random:?}");
    }
    println!(
        "all {:?}",
        uncertainty(&views, &(0..400).collect::<Vec<_>>())
    );
    let begin = std::time::Instant::now();
    chosen(&views, 40);
    println!("{:?}", begin.elapsed());
}
