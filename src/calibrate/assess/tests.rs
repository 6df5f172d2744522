use super::*;
use crate::calibrate::{CalibrateOptions, Missing, When, calibrate, cross_validate, synthetic};

fn good() -> Facts {
    Facts {
        views: 20,
        coverage: 0.93,
        worst_std_px: 0.0112,
        worst_at: Point2::new(63.5, 47.5),
        rms_px: 0.0055,
        noise_px: 0.0054,
        left_out_rms_px: Some(0.0056),
        contradicting: 0.0,
        change: None,
    }
}

#[test]
fn the_sentence_of_a_good_a_usable_a_poor_and_a_refused_calibration() {
    let sentence = |facts: &Facts| assess(facts).to_string();
    assert_eq!(
        sentence(&good()),
        "good: directions are known to 0.011 px (one standard deviation) everywhere in the frame; the rings of \
         20 views cover 93 % of it"
    );
    let usable = Facts {
        worst_std_px: 0.31,
        coverage: 0.52,
        views: 9,
        ..good()
    };
    assert_eq!(
        sentence(&usable),
        "usable: near pixel (64, 48) directions are known to 0.310 px only (good: at most 0.1 px); the \
         rings cover 52 % of the frame \
         (good: at least 70 %)"
    );
    let poor = Facts {
        views: 4,
        rms_px: 0.8,
        left_out_rms_px: None,
        ..good()
    };
    assert_eq!(
        sentence(&poor),
        "not enough: 0.800 px of the error is more than the noise of the ring centres (usable: at most 0.5 px); 4 views took \
         part (usable: at least 5)"
    );
    let error = CalibrateError::Undetermined {
        name: "fx",
        missing: Missing::TiltBoth,
    };
    assert_eq!(
        refused(&error, read(5, 5, 0)).to_string(),
        "not enough: no calibration was made. The views cannot tell fx: tilt the board by 20 degrees or more about both axes"
    );
}

#[test]
fn every_rule_decides_at_its_limits() {
    for rule in Rule::ALL {
        let [good_limit, usable_limit] = rule.limits();
        let grade = |value: f64| {
            let mut facts = good();
            match rule {
                Rule::Certainty => facts.worst_std_px = value,
                // of an error large enough to matter
                Rule::Prediction => {
                    (facts.rms_px, facts.noise_px) = (0.1, 0.1);
                    facts.left_out_rms_px = Some(0.1 * value);
                }
                Rule::Misfit => {
                    (facts.rms_px, facts.noise_px, facts.left_out_rms_px) =
                        (value, 0.0, Some(value))
                }
                Rule::Coverage => facts.coverage = value,
                Rule::Views => facts.views = value as usize,
                Rule::Steadiness => {
                    facts.change = Some(Change {
                        when: When::At(9),
                        relative: -value,
                        std: 0.1 * value,
                    });
                }
                Rule::Contradicting => facts.contradicting = value,
            }
            let assessment = assess(&facts);
            // no other rule has a say here
            let others = assessment.criteria.iter().filter(|c| c.rule != rule);
            assert!(others.clone().all(|c| c.grade == Grade::Good), "{facts:?}");
            assert_eq!(
                assessment.advice.is_empty(),
                assessment.grade == Grade::Good
            );
            assessment.grade
        };
        let step = if rule == Rule::Views { 1.0 } else { 1e-6 };
        let worse = if rule.rises() { -step } else { step };
        assert_eq!(grade(good_limit - worse), Grade::Good, "{rule:?}");
        assert_eq!(grade(good_limit + worse), Grade::Usable, "{rule:?}");
        assert_eq!(grade(usable_limit - worse), Grade::Usable, "{rule:?}");
        assert_eq!(grade(usable_limit + worse), Grade::NotEnough, "{rule:?}");
    }
}

#[test]
fn what_is_too_small_to_matter_or_was_not_tried_is_not_held_against_it() {
    let times = Facts {
        rms_px: 0.002,
        left_out_rms_px: Some(0.02),
        ..good()
    };
    assert_eq!(
        assess(&times).grade,
        Grade::Good,
        "ten times nothing is nothing"
    );
    let untried = Facts {
        left_out_rms_px: None,
        ..good()
    };
    let untried = assess(&untried);
    assert_eq!(untried.grade, Grade::Usable);
    assert_eq!(untried.criteria[1].text(), "not told");
    assert_eq!(
        untried.reason,
        "no view could be left out to check the others"
    );
    let nothing = Facts {
        worst_std_px: f64::NAN,
        ..good()
    };
    assert_eq!(
        assess(&nothing).grade,
        Grade::NotEnough,
        "not a number is not certain"
    );
}

#[test]
fn the_facts_of_a_calibration_are_its_own() {
    let (camera, board) = (synthetic::ordinary(), synthetic::board());
    let poses = synthetic::poses(&camera, &board);
    let mut views = synthetic::views(&camera, &board, &poses, 0.1, 1);
    synthetic::with_covariance(&mut views, nalgebra::Matrix2::identity() * 0.01);
    // one view of another board
    for ring in &mut views[5].rings {
        ring.centre.point.x += 40.0 * f64::from((3 * ring.row + 5 * ring.column) % 4);
    }
    let options = CalibrateOptions::default();
    let calibration = calibrate(&board, &views, &options).unwrap();
    let validated = cross_validate(&board, &views, &options, &calibration);
    let facts = Facts::of(&calibration, &views, validated.as_ref());
    assert_eq!(facts.views, 11);
    assert!((facts.contradicting - 1.0 / 12.0).abs() < 0.01, "{facts:?}");
    assert!((0.3..0.99).contains(&facts.coverage), "{facts:?}");
    // true covariances: all of the error is noise
    assert!(
        (facts.noise_px / facts.rms_px - 1.0).abs() < 0.05,
        "{facts:?}"
    );
    let map = calibration.projection_std_map(MAP_CELLS, Range::Infinity);
    let largest = map.into_iter().flatten().fold(0.0, f64::max);
    assert_eq!(facts.worst_std_px, largest);
    // the corners are farthest from the boards
    let from_middle = facts.worst_at - Point2::new(639.5, 479.5);
    assert!(
        from_middle.x.abs() > 500.0 && from_middle.y.abs() > 350.0,
        "{facts:?}"
    );
}

#[test]
fn a_refusal_says_what_to_do() {
    let none = refused(&CalibrateError::TooFewViews { found: 0 }, read(7, 0, 0));
    assert_eq!(none.grade, Grade::NotEnough);
    assert!(none.advice[0].contains("none of the 7 inputs"), "{none:?}");
    let parallel = refused(&CalibrateError::Parallel { spread_deg: 0.4 }, read(5, 5, 0));
    assert!(parallel.advice[0].contains("tilt"), "{parallel:?}");
    assert!(parallel.criteria.is_empty());
}

fn read(all: u64, with_board: u64, moving: u64) -> FramesRead {
    FramesRead {
        all,
        with_board,
        moving,
    }
}

#[test]
fn a_board_that_never_held_still_was_found_all_the_same() {
    let said =
        |found, frames| refused(&CalibrateError::TooFewViews { found }, frames).advice[0].clone();
    let none = said(0, read(20, 20, 19));
    assert!(
        none.starts_with("The board was found in 20 of the 20 inputs, but none was kept as a view. In 19 inputs the board moved"),
        "{none}"
    );
    assert!(none.contains("--max-motion-px 0"), "{none}");
    assert!(said(2, read(20, 20, 18)).starts_with("In 18 inputs the board moved"));
    assert!(said(0, read(1, 1, 0)).contains("in 1 of the 1 input, but none"));
    assert!(said(0, read(1, 0, 0)).contains("none of the 1 input;"));
}
