//! Checks of cameras that are right, a little off, and wrong.

use super::*;
use crate::calibrate::synthetic::{board, ordinary, pose_at, views};

fn all_over(camera: &Camera, sigma_px: f64) -> Vec<View> {
    all_over_with(camera, sigma_px, 2)
}

fn all_over_with(camera: &Camera, sigma_px: f64, seed: u64) -> Vec<View> {
    placed(camera, sigma_px, seed, |at| {
        let a = at as f64 * 2.4;
        [0.3 * a.cos(), 0.3 * a.sin(), 0.0]
    })
}

/// The board at 16 places of the frame, each turned as asked.
fn placed(
    camera: &Camera,
    sigma_px: f64,
    seed: u64,
    turn: impl Fn(usize) -> [f64; 3],
) -> Vec<View> {
    let (w, h) = (f64::from(camera.width), f64::from(camera.height));
    let poses: Vec<_> = (0..16)
        .map(|at| {
            let (x, y) = ((at % 4) as f64, (at / 4) as f64);
            let pixel = [w * (0.2 + 0.2 * x), h * (0.22 + 0.187 * y)];
            pose_at(camera, &board(), pixel, 0.42, turn(at))
        })
        .collect();
    views(camera, &board(), &poses, sigma_px, seed)
}

fn verdict_of(change: impl Fn(&mut Camera)) -> Verdict {
    let camera = ordinary();
    let mut believed = camera;
    change(&mut believed);
    let views = all_over(&camera, 0.03);
    check(&board(), &views, &believed, Estimator::Photometric)
        .unwrap()
        .verdict
}

#[test]
fn the_true_camera_holds_and_others_do_not() {
    let holds = verdict_of(|_| {});
    assert!(
        matches!(holds, Verdict::Holds { worst_px, .. } if worst_px < 0.03),
        "{holds}"
    );
    let drifted = verdict_of(|camera| camera.intrinsics.cx += 10.0);
    assert_ne!(drifted.word(), "holds", "{drifted}");
    let fails = verdict_of(|camera| {
        let mut values = camera.parameters();
        values[4] += 0.1;
        *camera = camera.with_parameters(&values);
    });
    assert_eq!(fails.word(), "fails", "{fails}");
}

#[test]
fn a_camera_that_explains_no_view_fails() {
    let camera = ordinary();
    let mut believed = camera;
    let mut values = camera.parameters();
    values[4..].fill(0.0);
    values[4] = -5.0;
    believed = believed.with_parameters(&values);
    let views = all_over(&camera, 0.03);
    let checked = check(&board(), &views, &believed, Estimator::Photometric).unwrap();
    assert_eq!(checked.verdict, Verdict::ExplainsNone, "{checked:?}");
    assert_eq!(checked.rms_px, None);
    let said = checked.verdict.to_string();
    assert!(
        said.contains("no position of the board explains any"),
        "{said}"
    );
    let json = crate::formats::CheckJson::new(Some((&views, &checked)), None);
    assert_eq!((json.verdict, json.rms_px), (Some("fails"), None));
}

#[test]
fn little_of_the_frame_gives_no_verdict_and_another_size_no_check() {
    let camera = ordinary();
    let views = &all_over(&camera, 0.03)[..2];
    let checked = check(&board(), views, &camera, Estimator::Photometric).unwrap();
    assert!(matches!(checked.verdict, Verdict::NotEnough { .. }));
    let mut other = camera;
    other.width = 640;
    let refused = check(&board(), views, &other, Estimator::Photometric).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "view 0 is 1280 x 960 px, the camera's frames are 640 x 960 px: a calibration holds for one resolution"
    );
}

#[test]
fn a_focal_length_that_hides_in_the_distance_of_the_board_is_found() {
    let fails = verdict_of(|camera| {
        camera.intrinsics.fx *= 1.03;
        camera.intrinsics.fy *= 1.03;
    });
    let said = fails.to_string();
    assert!(
        matches!(fails, Verdict::Another { worst_px, .. } if (10.0..30.0).contains(&worst_px)),
        "{said}"
    );
    assert!(
        said.contains("alone tell another camera") && said.contains("at pixel ("),
        "{said}"
    );
}

#[test]
fn a_true_camera_holds_whatever_the_noise_is_like() {
    let camera = ordinary();
    for seed in 0..40 {
        for sigma_px in [0.01, 0.1] {
            let views = all_over_with(&camera, sigma_px, seed);
            let checked = check(&board(), &views, &camera, Estimator::Photometric).unwrap();
            assert!(checked.alone.is_some());
            let said = &checked.verdict;
            assert!(!matches!(said, Verdict::Another { .. }), "{seed}: {said}");
        }
    }
}

#[test]
fn views_that_cannot_calibrate_say_what_may_hide() {
    let camera = ordinary();
    let views = placed(&camera, 0.01, 2, |_| [0.0; 3]);
    let checked = check(&board(), &views, &camera, Estimator::Photometric).unwrap();
    let said = checked.verdict.to_string();
    assert!(
        checked.alone.is_none() && said.contains("may hide in the distance"),
        "{said}"
    );
}
