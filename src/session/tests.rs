//! What the session keeps, refuses and asks for.

use super::*;
use crate::calibrate::synthetic::{board, detection, ordinary, pose_at};
use crate::detect::Indices;
use crate::frame::Stamp;

/// The board about a pixel of a 1280 x 960 frame, turned by a rotation vector (rad).
fn view(pixel: [f64; 2], turn: [f64; 3]) -> View {
    let camera = ordinary();
    let pose = pose_at(&camera, &board(), pixel, 0.5, turn);
    let detection = detection(&camera, &board(), &pose, &mut || 0.0);
    View::of_message("camera", Stamp::default(), &detection)
}

const MIDDLE: [f64; 2] = [640.0, 480.0];

fn session() -> Session {
    Session::new(board(), SessionRules::default())
}

fn offer_twice(session: &mut Session, view: &View) -> Offer {
    session.missed();
    session.offer(view.clone());
    session.offer(view.clone())
}

#[test]
fn a_board_becomes_a_view_once_it_is_still() {
    let mut session = session();
    let still = view(MIDDLE, [0.0; 3]);
    assert_eq!(session.offer(still.clone()).verdict, Verdict::FirstSight);
    let moved = session.offer(view([645.0, 480.0], [0.0; 3]));
    assert!(matches!(moved.verdict, Verdict::Moving { motion_px: Some(px), .. } if px > 4.0));
    assert!(session.offer(view([646.0, 480.0], [0.0; 3])).kept());
    session.missed();
    assert_eq!(session.offer(still).verdict, Verdict::FirstSight);
    assert_eq!(session.views().len(), 1);
}

#[test]
fn only_new_places_and_tilts_are_kept() {
    let mut session = session();
    assert!(offer_twice(&mut session, &view(MIDDLE, [0.0; 3])).kept());
    let again = offer_twice(&mut session, &view([660.0, 480.0], [0.0; 3]));
    assert!(matches!(again.verdict, Verdict::NotNew { shift_px, .. } if shift_px > 19.0));
    assert!(offer_twice(&mut session, &view([720.0, 480.0], [0.0; 3])).kept());
    assert!(offer_twice(&mut session, &view(MIDDLE, [0.0, 0.12, 0.0])).kept());
    // the same tilt to the other side leaves every ring almost where it is
    assert!(offer_twice(&mut session, &view(MIDDLE, [0.0, -0.12, 0.0])).kept());
}

#[test]
fn labels_turned_by_a_quarter_are_no_motion() {
    let still = view(MIDDLE, [0.2, 0.1, 0.7]);
    for indices in [Indices::Absolute, Indices::Relative] {
        let mut turned = still.clone();
        turned.indices = indices;
        for ring in &mut turned.rings {
            (ring.row, ring.column) = (ring.column, 6 - ring.row);
        }
        assert!(motion(&still, &turned).unwrap().max_px < 1e-9);
    }
}

#[test]
fn a_board_seen_in_part_is_compared_by_the_rings_it_shares() {
    let whole = view(MIDDLE, [0.2, 0.1, 0.0]);
    let mut part = whole.clone();
    part.indices = Indices::Relative;
    part.rings.retain(|ring| ring.column >= 2);
    for ring in &mut part.rings {
        ring.column -= 2;
    }
    assert!(motion(&whole, &part).unwrap().max_px < 1e-9);
    assert!(motion(&part, &whole).unwrap().max_px < 1e-9);
    let mut other = whole.clone();
    other.rings.truncate(0);
    assert_eq!(motion(&whole, &other), None);
}

#[test]
fn another_size_or_frame_id_starts_anew_and_says_so() {
    let mut session = session();
    offer_twice(&mut session, &view(MIDDLE, [0.0; 3]));
    let mut other = view(MIDDLE, [0.0; 3]);
    other.frame_id = "left".to_owned();
    let offer = session.offer(other.clone());
    assert!(offer.to_string().contains("\"left\"") && offer.to_string().contains("started anew"));
    assert!(session.views().is_empty());
    assert!(session.offer(other.clone()).kept());
    other.width = 640;
    assert!(matches!(
        session.offer(other).restart,
        Some(Change::Size {
            now: (640, 960),
            ..
        })
    ));
    assert_eq!(session.coverage(), 0.0);
    assert!(!session.set_board(board()));
}

#[test]
fn files_are_all_kept_but_repeats_and_strays() {
    let mut session = Session::new(board(), SessionRules::for_files());
    assert!(session.offer(view(MIDDLE, [0.0; 3])).kept());
    assert!(session.offer(view([643.0, 480.0], [0.0; 3])).kept());
    let repeat = session.offer(view([643.1, 480.0], [0.0; 3]));
    assert!(
        repeat
            .to_string()
            .starts_with("repeats the view camera at 0.0"),
        "{repeat}"
    );
    let mut stray = view([100.0, 480.0], [0.0; 3]);
    stray.width = 640;
    let stray = session.offer(stray);
    assert!(
        stray
            .to_string()
            .contains("640 x 960 px, those before were 1280 x 960")
    );
    assert_eq!(session.views().len(), 2);
}

#[test]
fn no_more_than_max_views_are_kept() {
    let mut session = session();
    session.set_rules(SessionRules {
        max_views: 1,
        min_views: 1,
        target_px: None,
        ..SessionRules::default()
    });
    offer_twice(&mut session, &view(MIDDLE, [0.0; 3]));
    let full = offer_twice(&mut session, &view([300.0, 480.0], [0.0; 3]));
    assert_eq!(full.verdict, Verdict::Full { max_views: 1 });
    let enough = Guidance::Enough {
        views: 1,
        std_px: None,
    };
    assert_eq!(session.guidance(), enough);
}

#[test]
fn guidance_leads_to_a_session_that_calibrates() {
    let mut session = session();
    assert_eq!(session.guidance(), Guidance::ShowBoard);
    let mut tilted = 0.0;
    for _ in 0..40 {
        let pixel = match session.guidance() {
            Guidance::MoveTo(region) => {
                let x = if region.contains("left") {
                    300.0
                } else if region.contains("right") {
                    980.0
                } else {
                    640.0
                };
                let y = if region.contains("top") {
                    240.0
                } else if region.contains("bottom") {
                    720.0
                } else {
                    480.0
                };
                [x, y]
            }
            Guidance::Enough { .. } => break,
            _ => MIDDLE,
        };
        let turn = match session.guidance() {
            Guidance::Tilt(side) if side.contains("left") => [0.0, 0.4, 0.0],
            Guidance::Tilt(_) => [0.4, 0.0, 0.0],
            Guidance::MoreViews { .. } => {
                tilted += 0.12;
                [0.5 - tilted, tilted - 0.3, 0.0]
            }
            _ => [0.0, 0.0, 0.0],
        };
        let offer = offer_twice(&mut session, &view(pixel, turn));
        assert!(offer.kept(), "{} but {offer}", session.guidance());
    }
    assert!(session.is_ready(), "{}", session.guidance());
    assert!(session.coverage() > 0.8);
    crate::calibrate::calibrate(&board(), session.views(), &Default::default()).unwrap();
}

#[test]
fn coverage_counts_the_cells_that_rings_touch() {
    let mut session = session();
    assert_eq!(session.coverage(), 0.0);
    offer_twice(&mut session, &view(MIDDLE, [0.0; 3]));
    // half the height and as much across: 480 x 480 of 1280 x 960 px between the outer centres, and the cells cut
    let covered = session.coverage();
    assert!((0.2..0.45).contains(&covered), "{covered}");
    assert!(session.coverage_map().cell(4, 5) && !session.coverage_map().cell(0, 0));
}

#[test]
fn a_view_has_enough_rings_for_a_pose() {
    let mut session = session();
    let mut few = view(MIDDLE, [0.0; 3]);
    few.rings.truncate(3);
    let offer = offer_twice(&mut session, &few);
    assert_eq!(offer.verdict, Verdict::TooFewRings { found: 3 });
    assert!(offer.to_string().starts_with("3 rings are too few"));
}
