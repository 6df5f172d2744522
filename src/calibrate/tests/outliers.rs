//! What contradicts the rest is left out and said.

use super::*;
use crate::calibrate::LeftOut;

fn noisy(camera: &Camera, sigma_px: f64, seed: u64) -> Vec<View> {
    let mut views = views(camera, &board(), &poses(camera, &board()), sigma_px, seed);
    with_covariance(&mut views, Matrix2::identity() * sigma_px * sigma_px);
    views
}

#[test]
fn a_clean_set_loses_nothing() {
    let mut rings_out = 0;
    for seed in 0..40 {
        let result = solved(&board(), &noisy(&ordinary(), 0.05, seed));
        assert_eq!(result.views_used(), 12);
        rings_out += result
            .views
            .iter()
            .map(|v| v.rings_left_out())
            .sum::<usize>();
    }
    // one set in a hundred loses a ring
    assert!(rings_out <= 3, "{rings_out}");
}

/// The done-when of ten percent: in the units of what the noise does anyway.
#[test]
fn a_tenth_of_gross_outliers_changes_the_focal_length_by_less_than_its_deviation() {
    for (camera, sigma_px) in [(wide(), 0.05), (ordinary(), 0.02), (long(), 0.1)] {
        for seed in 0..12 {
            let clean = noisy(&camera, sigma_px, seed);
            let mut spoilt = clean.clone();
            let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
            let mut wrong = 0;
            for ring in spoilt.iter_mut().flat_map(|v| &mut v.rings) {
                if random.random::<f64>() < 0.1 {
                    let (a, r) = (
                        std::f64::consts::TAU * random.random::<f64>(),
                        3.0 + 60.0 * random.random::<f64>(),
                    );
                    ring.centre.point += nalgebra::Vector2::new(a.cos(), a.sin()) * r;
                    wrong += 1;
                }
            }
            let (a, b) = (solved(&board(), &clean), solved(&board(), &spoilt));
            for at in 0..2 {
                let moved = (a.values()[at] - b.values()[at]).abs() / a.std(at);
                assert!(moved < 1.0, "{}: {moved} std", names()[at]);
            }
            let out: usize = b.views.iter().map(|v| v.rings_left_out()).sum();
            assert!((wrong..wrong + 4).contains(&out), "{out} of {wrong}");
        }
    }
}

#[test]
fn views_of_something_else_are_left_out_and_it_is_said_why() {
    let camera = ordinary();
    let mut views = noisy(&camera, 0.03, 1);
    // rows counted from the wrong end: a mirrored board
    for ring in &mut views[2].rings {
        ring.row = 6 - ring.row;
    }
    // a board of another shape
    for ring in &mut views[4].rings {
        ring.centre.point.x += 2.0 * (f64::from(ring.row) * 2.0).sin();
    }
    // labels thrown about
    for (i, ring) in views[6].rings.iter_mut().enumerate() {
        let other = (i * 17) % 49;
        (ring.row, ring.column) = ((other / 7) as u16, (other % 7) as u16);
    }
    views[8].rings.truncate(3);
    views[9].rings.truncate(7);
    let mut again = views[0].clone();
    again.source = "again".into();
    for ring in &mut again.rings {
        ring.centre.point.x += 0.01;
    }
    views.push(again);
    let result = solved(&board(), &views);
    let said = |at: usize| result.views[at].left_out.as_ref().map(ToString::to_string);
    let out: Vec<usize> = (0..views.len())
        .filter(|at| !result.views[*at].used())
        .collect();
    assert_eq!(out, [2, 4, 6, 8, 9, 12]);
    assert!(
        matches!(result.views[2].left_out, Some(LeftOut::NoPose)),
        "{:?}",
        said(2)
    );
    assert!(said(4).unwrap().contains("another board"), "{:?}", said(4));
    assert!(said(8).unwrap().contains("3 rings"), "{:?}", said(8));
    assert!(said(9).unwrap().contains("one line"), "{:?}", said(9));
    assert_eq!(said(12).unwrap(), "repeats the view view 0");
    let error = (result.camera.intrinsics.fx - camera.intrinsics.fx) / result.std(0);
    assert!(error.abs() < 4.0, "{error}");
}

#[test]
fn too_few_views_that_agree_are_refused_with_the_reason() {
    let mut views = noisy(&ordinary(), 0.03, 1);
    views.truncate(4);
    for view in &mut views[2..] {
        for ring in &mut view.rings {
            ring.row = 6 - ring.row;
        }
    }
    let refused = calibrate(&board(), &views, &CalibrateOptions::default()).unwrap_err();
    assert!(
        refused.to_string().starts_with("2 of 4 views can be used"),
        "{refused}"
    );
    assert!(refused.to_string().contains("mirrored"), "{refused}");
}

/// Of few views one of another board leaves residuals in all of them, and none of its own that stands out.
#[test]
fn a_view_that_bends_the_solution_towards_itself_is_left_out() {
    let camera = wide();
    for seed in 0..24 {
        let mut views = noisy(&camera, 0.02, seed);
        views.truncate(9);
        let bad = (seed % 9) as usize;
        // a board whose rows stand a twentieth farther apart
        let stands = poses(&camera, &board())[bad];
        for ring in &mut views[bad].rings {
            let [x, y] = board().centre_m(ring.row, ring.column);
            let place = stands.board_to_camera([x, 1.05 * y]);
            ring.centre.point = camera.project(&place).unwrap();
        }
        let result = solved(&board(), &views);
        assert!(!result.views[bad].used(), "seed {seed}");
        assert_eq!(result.views_used(), 8, "seed {seed}");
        views.remove(bad);
        let clean = solved(&board(), &views);
        let moved = (clean.values()[0] - result.values()[0]).abs() / clean.std(0);
        assert!(moved < 0.5, "seed {seed}: {moved} standard deviations");
    }
}

/// The rational model bends farther towards outliers than others do, and must come back from there.
#[test]
fn outliers_change_a_rational_lens_no_more_than_if_they_had_not_been_there() {
    let options = CalibrateOptions {
        model: LensModel::RationalPolynomial,
        ..CalibrateOptions::default()
    };
    for seed in 0..8 {
        let (_, mut spoilt) = lenses::kinect(0.02, seed);
        with_covariance(&mut spoilt, Matrix2::identity() * 0.0004);
        let mut clean = spoilt.clone();
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        for (spoilt, clean) in spoilt.iter_mut().zip(&mut clean) {
            clean.rings.clear();
            for ring in &mut spoilt.rings {
                if random.random::<f64>() < 0.1 {
                    let angle = std::f64::consts::TAU * random.random::<f64>();
                    let far = 1.0 + 29.0 * random.random::<f64>();
                    ring.centre.point += nalgebra::Vector2::new(angle.cos(), angle.sin()) * far;
                } else {
                    clean.rings.push(ring.clone());
                }
            }
        }
        let clean = calibrate(&board(), &clean, &options).unwrap();
        let spoilt = calibrate(&board(), &spoilt, &options).unwrap();
        for at in 0..4 {
            let moved = (clean.values()[at] - spoilt.values()[at]).abs() / clean.std(at);
            assert!(moved < 0.5, "seed {seed}, {}: {moved}", clean.names[at]);
        }
    }
}
