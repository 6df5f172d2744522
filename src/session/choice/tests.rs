//! Sessions that know the camera: what they keep, refuse and call enough.

use super::super::stream::{misnumbered, random_places, stream};
use super::super::{Guidance, Session, SessionRules, Verdict, View};
use crate::calibrate::synthetic::{board, ordinary, pose_at, views};
use crate::calibrate::{CalibrateOptions, Calibration, Range, calibrate};

/// The node's rules for a board that is always still.
fn rules(max_views: usize, target_px: f64) -> SessionRules {
    SessionRules {
        max_motion_px: None,
        max_views,
        target_px: (target_px > 0.0).then_some(target_px),
        ..SessionRules::default()
    }
}

fn calibrated(views: &[View]) -> Calibration {
    calibrate(&board(), views, &CalibrateOptions::default()).unwrap()
}

/// Standard deviation of fx for the noise that the views have, px, free of how much noise they happen to have.
fn fx_std_px(views: &[View]) -> f64 {
    let calibration = calibrated(views);
    0.1 * calibration.std(0) / calibration.variance_factor.sqrt()
}

fn worst_px(calibration: &Calibration) -> f64 {
    let map = calibration.projection_std_map((10, 10), Range::Infinity);
    map.into_iter().flatten().fold(0.0, f64::max)
}

#[test]
fn a_full_session_exchanges_views_for_better_ones() {
    let all = stream(&ordinary(), &board(), 500, 3);
    let mut session = Session::new(board(), rules(20, 0.01));
    let (mut replaced, mut little) = (0, 0);
    for view in &all {
        let offer = session.offer(view.clone());
        let text = offer.to_string();
        match offer.verdict {
            Verdict::Replaced { views, .. } => {
                assert!(views == 20 && text.contains("which told least"), "{text}");
                replaced += 1;
            }
            Verdict::AddsLittle { .. } => {
                assert!(text.contains("fx would become certain by"), "{text}");
                little += 1;
            }
            Verdict::Contradicts { .. } => panic!("{text}"),
            _ => {}
        }
    }
    assert!(replaced > 5 && little > 50, "{replaced} {little}");
    let kept = session.views();
    assert_eq!(kept.len(), 20);
    assert_eq!(session.ever_kept(), 20 + replaced);
    // in the order of their arrival
    let arrivals = kept.iter().map(|k| all.iter().position(|v| v == k));
    assert!(arrivals.is_sorted());
    let own = fx_std_px(kept);
    let estimate = session.estimate().unwrap();
    assert!((estimate.fx_std_px() / calibrated(kept).std(0) - 1.0).abs() < 0.1);
    for seed in 0..8 {
        let random: Vec<View> = random_places(all.len(), 20, seed)
            .into_iter()
            .map(|at| all[at].clone())
            .collect();
        assert!(
            own < 0.6 * fx_std_px(&random),
            "{own} {}",
            fx_std_px(&random)
        );
    }
}

#[test]
fn a_misnumbered_view_is_refused_whatever_its_leverage() {
    let all = stream(&ordinary(), &board(), 200, 5);
    let mut session = Session::new(board(), rules(30, 0.01));
    let mut refused = 0;
    for (at, view) in all.iter().enumerate() {
        if session.estimate().is_some() && at % 5 == 0 {
            let wrong = session.offer(misnumbered(view, (at % 5) as u16 + 1));
            let text = wrong.to_string();
            assert!(!wrong.kept(), "{text}");
            if matches!(wrong.verdict, Verdict::Contradicts { .. }) {
                assert!(
                    text.starts_with("does not agree with the views kept: its r"),
                    "{text}"
                );
                refused += 1;
            }
        }
        session.offer(view.clone());
    }
    assert!(refused > 10, "{refused}");
    let calibration = calibrated(session.views());
    let fx = calibration.camera.intrinsics.fx;
    assert!((fx - 1203.0).abs() < 4.0 * calibration.std(0), "{fx}");
}

#[test]
fn a_misnumbered_view_from_the_start_is_what_gives_way_first() {
    let all = stream(&ordinary(), &board(), 200, 11);
    let wrong = misnumbered(&all[0], 2);
    let mut session = Session::new(board(), rules(12, 0.01));
    assert!(session.offer(wrong.clone()).kept());
    for view in &all[1..] {
        session.offer(view.clone());
    }
    assert!(session.estimate().is_some());
    assert!(!session.views().contains(&wrong));
}

#[test]
fn one_ring_elsewhere_does_not_cost_the_view() {
    let all = stream(&ordinary(), &board(), 120, 2);
    let mut session = Session::new(board(), rules(60, 0.01));
    let mut kept = 0;
    for view in &all {
        let mut view = view.clone();
        if session.estimate().is_some() {
            view.rings[17].centre.point.x += 8.0;
        }
        let offer = session.offer(view);
        assert!(
            !matches!(offer.verdict, Verdict::Contradicts { .. }),
            "{offer}"
        );
        kept += usize::from(offer.kept());
    }
    assert!(kept > 15, "{kept}");
}

#[test]
fn enough_is_when_the_target_is_met_and_not_before() {
    let all = stream(&ordinary(), &board(), 300, 9);
    let target_px = 0.25;
    let mut session = Session::new(board(), rules(60, target_px));
    let mut asked = 0;
    for view in &all {
        if !session.offer(view.clone()).kept() {
            continue;
        }
        match session.guidance() {
            Guidance::Enough { views, std_px } => {
                let truth = worst_px(&calibrated(session.views()));
                assert!(views >= 10 && truth < 1.1 * target_px, "{truth}");
                let said = std_px.unwrap();
                assert!(
                    said <= target_px && (said / truth - 1.0).abs() < 0.15,
                    "{said} {truth}"
                );
                assert!(
                    session
                        .guidance()
                        .to_string()
                        .contains("px at most: calibrate")
                );
                assert!(session.is_enough() && asked > 0);
                return;
            }
            Guidance::Uncertain(least) | Guidance::Full { least, .. } => {
                assert!(least.std_px > target_px);
                assert!(worst_px(&calibrated(session.views())) > 0.9 * target_px);
                asked += 1;
            }
            _ => assert!(!session.is_enough()),
        }
    }
    panic!("never enough: {}", session.guidance());
}

#[test]
fn parallel_boards_are_never_enough_and_give_way_to_tilted_ones() {
    let camera = ordinary();
    let poses: Vec<_> = (0..200)
        .map(|i| {
            let (x, y) = (f64::from(i % 16), f64::from(i / 16 % 12));
            let pixel = [250.0 + 50.0 * x, 230.0 + 45.0 * y];
            pose_at(&camera, &board(), pixel, 0.4, [0.0; 3])
        })
        .collect();
    for sigma_px in [0.0, 0.1] {
        let mut session = Session::new(board(), rules(15, 0.1));
        for view in views(&camera, &board(), &poses, sigma_px, 1) {
            session.offer(view);
            let guidance = session.guidance();
            let ends = matches!(guidance, Guidance::Enough { .. } | Guidance::Full { .. });
            assert!(!ends && session.estimate().is_none(), "{guidance}");
        }
        assert_eq!(session.views().len(), 15);
        assert!(session.not_told().is_some());
        for view in stream(&camera, &board(), 200, 4) {
            session.offer(view);
        }
        assert!(session.estimate().is_some(), "{}", session.guidance());
    }
}

#[test]
fn without_a_choice_every_new_view_is_kept() {
    let all = stream(&ordinary(), &board(), 60, 6);
    let mut session = Session::new(board(), SessionRules::for_files());
    for view in &all {
        assert!(session.offer(view.clone()).kept());
    }
    session.offer(misnumbered(&all[0], 3));
    assert_eq!(session.estimate(), None);
    assert_eq!(session.views().len(), 61);
}

#[test]
fn the_same_stream_gives_the_same_session() {
    let all = stream(&ordinary(), &board(), 150, 8);
    let kept = || {
        let mut session = Session::new(board(), rules(15, 0.1));
        let verdicts: Vec<_> = all
            .iter()
            .map(|v| session.offer(v.clone()).to_string())
            .collect();
        (verdicts, session.guidance(), session.views().to_vec())
    };
    assert_eq!(kept(), kept());
}
