use super::*;
use crate::board::Polarity;
use crate::camera::Pose;
use crate::camera::{Distortion, Intrinsics, PlumbBob};
use crate::centre::{Centre, Ellipse, RingEllipses};
use crate::detect::Ring;
use crate::ros::parameters::ParameterValues;
use nalgebra::{Matrix3, Point2, Vector3};
use ros2_client::ParameterValue;

const CAMERA: Camera = Camera {
    width: 640,
    height: 480,
    intrinsics: Intrinsics {
        fx: 600.0,
        fy: 602.0,
        cx: 322.0,
        cy: 238.0,
    },
    distortion: Distortion::PlumbBob(PlumbBob {
        k1: -0.1,
        k2: 0.01,
        p1: 0.0,
        p2: 0.0,
        k3: 0.0,
    }),
};

fn board() -> Board {
    Board::new(7, 7, 0.0269, 0.003, 0.006, Polarity::DarkOnLight).unwrap()
}

fn configuration(changes: &[(&str, ParameterValue)]) -> Configuration {
    let mut values = ParameterValues::default();
    let file = ParameterValue::String("/c4.yaml".to_owned());
    values.set("board_file", file).unwrap();
    for (name, value) in changes {
        values.set(name, value.clone()).unwrap();
    }
    Configuration {
        settings: Settings::of(&values).unwrap(),
        board: board(),
    }
}

fn calibrator(changes: &[(&str, ParameterValue)]) -> Calibrator {
    Calibrator::new(configuration(changes), "/image")
}

/// A header of the second `sec` and the size of the camera's frames.
fn facts(sec: i32) -> FrameFacts {
    let mut facts = FrameFacts {
        width: CAMERA.width,
        height: CAMERA.height,
        ..FrameFacts::default()
    };
    facts.header.stamp.sec = sec;
    facts.header.frame_id = "optical".to_owned();
    facts
}

/// What an errorless detector finds of the board at a pose.
fn detection(pose: &Pose) -> Detection {
    let board = board();
    let small = |centre| Ellipse {
        centre,
        major: 2.0,
        minor: 2.0,
        angle: 0.0,
    };
    let rings: Vec<Ring> = board
        .indices()
        .map(|(row, column)| {
            let at = pose.board_to_camera(board.centre_m(row, column));
            let point = CAMERA.project(&at).unwrap();
            Ring {
                row,
                column,
                centre: Centre {
                    point,
                    covariance: None,
                },
                ellipses: RingEllipses {
                    inner: small(point),
                    outer: small(point),
                },
                blur_sigma_px: 3.0,
                kept: None,
            }
        })
        .collect();
    let r = pose.rotation.matrix();
    let k = Matrix3::new(600.0, 0.0, 322.0, 0.0, 602.0, 238.0, 0.0, 0.0, 1.0);
    let plane = Matrix3::from_columns(&[
        r.column(0).into_owned(),
        r.column(1).into_owned(),
        pose.translation_m,
    ]);
    Detection {
        width: 640,
        height: 480,
        indices: Indices::Absolute,
        rings,
        homography: k * plane,
        photometric: None,
        another: None,
    }
}

/// Poses that tell everything about the lens.
fn poses() -> Vec<Pose> {
    let tilts = [
        (0.0, 0.0),
        (0.5, 0.0),
        (-0.5, 0.0),
        (0.0, 0.5),
        (0.0, -0.5),
        (0.4, 0.4),
        (-0.4, 0.4),
        (0.4, -0.4),
        (-0.4, -0.4),
        (0.3, 0.1),
        (0.1, 0.3),
        (-0.2, 0.45),
    ];
    let place = |(at, (x, y)): (usize, (f64, f64))| {
        let shift = 0.02 * (at % 5) as f64 - 0.04;
        Pose::from_rotation_vector(
            Vector3::new(x, y, 0.0),
            Vector3::new(-0.08 + shift, -0.08 - 0.5 * shift, 0.32),
        )
    };
    tilts.into_iter().enumerate().map(place).collect()
}

/// Shows every pose long enough to be still, and answers with the second of the last frame.
fn show_all(calibrator: &mut Calibrator) -> i32 {
    let mut sec = 0;
    for pose in poses() {
        for _ in 0..2 {
            sec += 1;
            calibrator.observe(&facts(sec), Ok(&detection(&pose)), Duration::ZERO);
        }
    }
    sec
}

fn state(calibrator: &Calibrator) -> String {
    calibrator.status(FrameCounts::default()).state
}

fn solved(calibrator: &mut Calibrator) -> Solved {
    calibrator.start_calibration().unwrap().solve()
}

#[test]
fn a_node_goes_from_waiting_to_calibrated() {
    let mut calibrator = calibrator(&[]);
    assert_eq!(state(&calibrator), "waiting");
    let status = calibrator.status(FrameCounts::default());
    assert!(status.guidance.contains("/image") && status.rms.is_nan());
    let last = show_all(&mut calibrator);
    assert_eq!(state(&calibrator), "collecting");
    assert_eq!(calibrator.camera_info(), None);
    let job = calibrator.start_calibration().unwrap();
    assert_eq!(state(&calibrator), "calibrating");
    let busy = calibrator.start_calibration().unwrap_err();
    assert!(busy.starts_with("busy"), "{busy}");
    let answer = calibrator.finish_calibration(job.solve());
    assert!(
        matches!(&answer, Answer::Done(text) if text.contains("12 views")),
        "{answer:?}"
    );
    let status = calibrator.status(FrameCounts::default());
    assert_eq!(status.state, "calibrated");
    assert!(status.rms < 1e-6 && status.last_result.contains("12 views"));
    let info = calibrator.camera_info_of(&facts(last)).unwrap();
    assert_eq!(info.header, facts(last).header);
    assert!((info.k[0] - 600.0).abs() < 1e-3);
    assert_eq!(calibrator.to_save().unwrap().0.width, 640);
}

#[test]
fn too_few_views_are_refused_with_what_to_do() {
    let mut calibrator = calibrator(&[]);
    let reason = calibrator.start_calibration().unwrap_err();
    assert!(
        reason.contains("0 of the 10") && reason.contains("show the board"),
        "{reason}"
    );
    assert!(calibrator.to_save().unwrap_err().contains("~/calibrate"));
    // a refusal leaves nothing behind
    show_all(&mut calibrator);
    assert!(calibrator.start_calibration().is_ok());
}

#[test]
fn what_is_seen_is_told_ring_by_ring() {
    let mut calibrator = calibrator(&[]);
    let found = detection(&poses()[0]);
    let message = calibrator.observe(&facts(1), Ok(&found), Duration::from_millis(5));
    assert_eq!((message.width, message.height), (640, 480));
    assert_eq!(
        (message.rows, message.columns, message.centres.len()),
        (7, 7, 49)
    );
    assert!(message.indices_absolute && message.reason.is_empty());
    let last = &message.centres[48];
    assert_eq!((last.row, last.column, last.blur_sigma), (6, 6, 3.0));
    assert_eq!(Point2::new(last.x, last.y), found.rings[48].centre.point);
    assert!(last.covariance.iter().all(|v| v.is_nan()));
    let status = calibrator.status(FrameCounts::default());
    assert!(status.board_found);
    assert_eq!((status.processing_time, status.blur_sigma), (0.005, 3.0));
}

#[test]
fn misses_and_failures_say_why_and_are_counted_apart() {
    let mut calibrator = calibrator(&[]);
    let message = calibrator.observe(&facts(1), Err("no ring seen".to_owned()), Duration::ZERO);
    assert_eq!(
        (message.reason.as_str(), message.centres.len()),
        ("no ring seen", 0)
    );
    assert_eq!(message.header, facts(1).header);
    let message = calibrator.failed(&facts(2), "unknown encoding".to_owned());
    assert_eq!(message.reason, "unknown encoding");
    let counts = FrameCounts {
        received: 9,
        dropped: 7,
    };
    let status = calibrator.status(counts);
    assert_eq!((status.frames_processed, status.frames_failed), (1, 1));
    assert_eq!((status.frames_received, status.frames_dropped), (9, 7));
    assert_eq!(status.last_error, "unknown encoding");
    assert_eq!(status.header.stamp.sec, 2);
}

#[test]
fn a_reset_forgets_and_what_was_being_solved_is_dropped() {
    let mut calibrator = calibrator(&[]);
    show_all(&mut calibrator);
    let job = calibrator.start_calibration().unwrap();
    assert_eq!(
        calibrator.reset(),
        Answer::Done("12 views forgotten".to_owned())
    );
    let answer = calibrator.finish_calibration(job.solve());
    assert!(matches!(answer, Answer::Refused(text) if text.contains("started anew")));
    assert_eq!(calibrator.camera_info(), None);
    assert_eq!(state(&calibrator), "collecting");
}

#[test]
fn another_frame_id_or_size_ends_the_calibration() {
    let mut calibrator = calibrator(&[]);
    let sec = show_all(&mut calibrator);
    let solved = solved(&mut calibrator);
    calibrator.finish_calibration(solved);
    let mut other = facts(sec + 1);
    other.header.frame_id = "other".to_owned();
    // a frame of another camera never gets this camera's calibration
    assert_eq!(calibrator.camera_info_of(&other), None);
    assert!(calibrator.camera_info().is_some());
    calibrator.observe(&other, Ok(&detection(&poses()[0])), Duration::ZERO);
    assert_eq!(calibrator.camera_info(), None);
    let status = calibrator.status(FrameCounts::default());
    assert!(status.guidance.contains("anew"), "{}", status.guidance);
}

#[test]
fn a_new_board_or_way_to_measure_starts_anew_and_other_parameters_do_not() {
    let word = |text: &str| ParameterValue::String(text.to_owned());
    for (name, value, anew) in [
        ("estimator", word("pole_polar"), true),
        ("psf", word("disc"), true),
        ("response_gamma", ParameterValue::Double(2.2), true),
        // said in another way
        ("response_gamma", ParameterValue::Integer(1), false),
        ("min_views", ParameterValue::Integer(5), false),
        ("camera_name", word("left"), false),
    ] {
        let mut calibrator = calibrator(&[]);
        show_all(&mut calibrator);
        calibrator.configure(configuration(&[(name, value)]));
        assert_eq!(calibrator.session().views().is_empty(), anew, "{name}");
        let guidance = calibrator.status(FrameCounts::default()).guidance;
        let said = guidance == format!("another {name}: started anew");
        assert_eq!(said, anew, "{guidance}");
    }
    let mut calibrator = calibrator(&[]);
    show_all(&mut calibrator);
    let mut other = configuration(&[]);
    other.board = Board::new(5, 7, 0.0269, 0.003, 0.006, Polarity::DarkOnLight).unwrap();
    calibrator.configure(other);
    assert!(calibrator.session().views().is_empty());
}

#[test]
fn auto_calibrate_waits_for_more_views_before_it_tries_again() {
    let auto = ("auto_calibrate", ParameterValue::Boolean(true));
    let mut idle = calibrator(&[]);
    show_all(&mut idle);
    assert!(idle.start_automatically().is_none());
    let mut calibrator = calibrator(&[auto]);
    assert!(calibrator.start_automatically().is_none());
    show_all(&mut calibrator);
    let job = calibrator.start_automatically().unwrap();
    assert!(calibrator.start_automatically().is_none());
    calibrator.finish_calibration(job.solve());
    assert!(calibrator.start_automatically().is_none());
    calibrator.reset();
    show_all(&mut calibrator);
    assert!(calibrator.start_automatically().is_some());
}

#[test]
fn a_solver_that_gives_no_result_does_not_block_the_next() {
    let mut calibrator = calibrator(&[]);
    show_all(&mut calibrator);
    calibrator.start_calibration().unwrap();
    assert!(matches!(
        calibrator.abandon_calibration(),
        Answer::Refused(_)
    ));
    assert!(calibrator.start_calibration().is_ok());
}
