//! Boards that are seen in part, twice, in bad light or not at all: right numbers, or a reason that helps.

use nalgebra::{Rotation3, Vector3};
use ringcal::board::{Board, Polarity};
use ringcal::camera::{Camera, Distortion, Intrinsics, PlumbBob, Pose};
use ringcal::detect::{DetectOptions, Detection, Detector, Indices, Miss, Required};
use ringcal::frame::{Frame, Pixels, Plane};
use ringcal::simulate::{Defocus, Rendering, Scene, render};

const CAMERA: Camera = Camera {
    width: 800,
    height: 600,
    intrinsics: Intrinsics {
        fx: 800.0,
        fy: 800.0,
        cx: 400.0,
        cy: 300.0,
    },
    distortion: Distortion::PlumbBob(PlumbBob {
        k1: -0.1,
        k2: 0.02,
        p1: 0.0,
        p2: 0.0,
        k3: 0.0,
    }),
};

fn board(rows: u16, columns: u16) -> Board {
    Board::new(rows, columns, 0.0269, 0.003, 0.006, Polarity::DarkOnLight).unwrap()
}

/// The board at a place, its middle moved by so many pitches to the right and down.
fn rendered(board: &Board, right: f64, down: f64, sigma_px: f64) -> Rendering {
    turned(board, 0.15, (right, down), sigma_px)
}

/// The same, turned in its plane by an angle.
fn turned(board: &Board, turn_rad: f64, (right, down): (f64, f64), sigma_px: f64) -> Rendering {
    let in_plane = Rotation3::from_euler_angles(0.0, 0.0, turn_rad);
    let rotation = Rotation3::from_euler_angles(0.25, -0.2, 0.0) * in_plane;
    let [x, y] = board.middle_m();
    let middle = Vector3::new(0.0269 * right, 0.0269 * down, 0.3);
    let pose = Pose {
        rotation,
        translation_m: middle - rotation * Vector3::new(x, y, 0.0),
    };
    let mut scene = Scene::new(CAMERA, board.clone(), pose);
    scene.defocus = Defocus::gaussian(sigma_px);
    scene.light.margin = 2.0;
    scene.sensor.read_noise = 0.005;
    render(&scene, 3).unwrap()
}

fn detect(frame: &Frame, board: &Board, required: usize) -> Result<Detection, Miss> {
    let options = DetectOptions {
        required: Required::rings(required),
        ..DetectOptions::default()
    };
    Detector::new(board.clone(), options).detect(frame)
}

/// Every ring is where the truth says that a ring is which is so many rows and columns further on.
fn assert_numbers(found: &Detection, rendering: &Rendering, rows: u16, columns: u16) {
    for ring in &found.rings {
        let same = rendering
            .truth
            .rings
            .iter()
            .find(|t| (t.row, t.column) == (ring.row + rows, ring.column + columns));
        let off = (same.unwrap().centre - ring.centre.point).norm();
        assert!(
            off < 0.3,
            "row {} column {}: {off} {:?} {:?}",
            ring.row,
            ring.column,
            ring.centre.covariance,
            found.notes()
        );
    }
}

fn map(frame: &Frame, change: impl Fn(usize, usize, u8) -> u8) -> Frame {
    let Pixels::U8(plane) = &frame.pixels else {
        panic!("an 8-bit rendering")
    };
    let width = plane.width();
    let changed = plane.data().iter().enumerate();
    let data = changed.map(|(i, &grey)| change(i % width, i / width, grey));
    Frame::from_u8(
        Plane::from_vec(width, plane.height(), data.collect()).unwrap(),
        "",
    )
}

#[test]
fn rings_behind_a_hand_are_left_out_and_the_others_keep_their_numbers() {
    let board = board(6, 7);
    for sigma_px in [0.7, 3.0] {
        let rendering = rendered(&board, 0.0, 0.0, sigma_px);
        let hidden = |x: usize, y: usize| x > 330 && x < 470 && y > 200 && y < 600;
        let frame = map(&rendering.frame, |x, y, grey| {
            if hidden(x, y) {
                110 + (x % 7) as u8
            } else {
                grey
            }
        });
        let found = detect(&frame, &board, 0).unwrap();
        assert_eq!(found.indices, Indices::Absolute);
        assert!(
            (26..=36).contains(&found.rings.len()),
            "{} rings",
            found.rings.len()
        );
        assert_numbers(&found, &rendering, 0, 0);
    }
}

#[test]
fn a_board_cut_by_the_border_is_a_miss_that_says_so_unless_fewer_rings_will_do() {
    let board = board(6, 7);
    for sigma_px in [0.7, 3.0] {
        let rendering = rendered(&board, -3.2, 0.0, sigma_px);
        let miss = detect(&rendering.frame, &board, 0).unwrap_err();
        // whole columns are seen, or rings of a column more: the size of what is left is told, too
        let told = match &miss {
            Miss::CutOff { .. } => true,
            Miss::Smaller { .. } => miss.to_string().contains("outside the image"),
            _ => false,
        };
        assert!(told, "{miss}");
        let found = detect(&rendering.frame, &board, 20).unwrap();
        assert_eq!(found.indices, Indices::Relative);
        assert!(found.rings.len() >= 20);
        assert!(found.rings.iter().any(|ring| ring.column == 0));
        let hidden = 7 - found
            .rings
            .iter()
            .map(|ring| ring.column + 1)
            .max()
            .unwrap();
        assert!(hidden > 0);
        assert_numbers(&found, &rendering, 0, hidden);
        assert!(detect(&rendering.frame, &board, 41).is_err());
    }
}

#[test]
fn of_two_boards_the_larger_is_taken_and_a_warning_given() {
    let board = board(4, 5);
    let small = rendered(&board, -2.9, 0.5, 1.0);
    let large = {
        let rotation = Rotation3::from_euler_angles(-0.1, 0.1, 0.0);
        let [x, y] = board.middle_m();
        let middle = Vector3::new(0.055, 0.0, 0.26);
        let pose = Pose {
            rotation,
            translation_m: middle - rotation * Vector3::new(x, y, 0.0),
        };
        let mut scene = Scene::new(CAMERA, board.clone(), pose);
        scene.defocus = Defocus::gaussian(1.0);
        render(&scene, 4).unwrap()
    };
    let Pixels::U8(right) = &large.frame.pixels else {
        panic!("an 8-bit rendering")
    };
    let frame = map(
        &small.frame,
        |x, y, grey| {
            if x > 365 { right.at(x, y) } else { grey }
        },
    );
    let found = detect(&frame, &board, 0).unwrap();
    assert_numbers(&found, &large, 0, 0);
    assert_eq!(found.another, Some(20));
    assert!(found.notes()[0].contains("another board"));
    assert_eq!(detect(&large.frame, &board, 0).unwrap().another, None);
}

#[test]
fn a_board_file_of_another_size_is_told_what_was_seen() {
    let rendering = rendered(&board(4, 6), 0.0, 0.0, 1.5);
    let miss = detect(&rendering.frame, &board(4, 5), 0).unwrap_err();
    assert_eq!(miss.to_string(), "found 4 x 6, the board file says 4 x 5");
    let miss = detect(&rendering.frame, &board(5, 7), 0).unwrap_err();
    assert_eq!(miss.to_string(), "found 4 x 6, the board file says 5 x 7");
}

#[test]
fn bad_light_is_named() {
    let rendering = rendered(&board(5, 6), 0.0, 0.0, 1.0);
    let board = board(5, 6);
    let say = |change: fn(u8) -> u8| {
        let frame = map(&rendering.frame, |_, _, grey| change(grey));
        detect(&frame, &board, 0).unwrap_err().to_string()
    };
    assert!(say(|grey| grey / 250).starts_with("too dark: the brightest grey value is"));
    assert!(say(|grey| grey.saturating_mul(30)).starts_with("over-exposed"));
    assert!(say(|_| 130).starts_with("hardly any contrast"));
}

#[test]
fn marks_tell_the_first_row_and_column_however_the_board_is_turned() {
    for (rows, columns) in [(5, 6), (5, 5)] {
        let marks = vec![(0, 0), (0, 1), (1, 0)];
        let board = board(rows, columns).with_marks(marks).unwrap();
        for turn in 0..4 {
            for sigma_px in [0.5, 3.0, 6.0] {
                let angle = std::f64::consts::FRAC_PI_2 * f64::from(turn) + 0.2;
                let rendering = turned(&board, angle, (0.0, 0.0), sigma_px);
                let found = detect(&rendering.frame, &board, 0).unwrap();
                assert_eq!(found.indices, Indices::Absolute);
                assert!(found.rings.len() >= board.ring_count() - 3);
                assert_numbers(&found, &rendering, 0, 0);
            }
        }
    }
}

#[test]
fn with_marks_in_view_a_part_of_the_board_has_its_own_numbers() {
    let marks = vec![(5, 5), (5, 4), (4, 5), (2, 4)];
    let board = board(6, 6).with_marks(marks).unwrap();
    for turn in 0..4 {
        let angle = std::f64::consts::FRAC_PI_2 * f64::from(turn) - 0.1;
        let away = [(-3.2, 0.0), (0.0, -3.2), (3.2, 0.0), (0.0, 3.2)][turn as usize];
        let rendering = turned(&board, angle, away, 2.0);
        let found = detect(&rendering.frame, &board, 12).unwrap();
        assert_eq!(found.indices, Indices::Absolute);
        assert_numbers(&found, &rendering, 0, 0);
    }
}

#[test]
fn without_its_marks_in_view_a_part_of_the_board_is_numbered_from_what_was_seen() {
    let marks = vec![(0, 0), (0, 1), (1, 0)];
    let board = board(6, 7).with_marks(marks).unwrap();
    for (turn_rad, right) in [(0.15, -3.2), (3.3, 3.8)] {
        let rendering = turned(&board, turn_rad, (right, 0.0), 2.0);
        let found = detect(&rendering.frame, &board, 12).unwrap();
        let seen: Vec<(u16, u16)> = found.rings.iter().map(|r| (r.row, r.column)).collect();
        assert_eq!(found.indices, Indices::Relative, "{turn_rad} {seen:?}");
        assert!(found.rings.iter().any(|ring| ring.row == 0));
        assert!(found.rings.iter().any(|ring| ring.column == 0));
    }
}

#[test]
fn the_same_bytes_give_the_same_answer_on_any_number_of_threads() {
    let board = board(5, 6);
    let frame = rendered(&board, 0.0, 0.0, 2.5).frame;
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let crowd = rayon::ThreadPoolBuilder::new().num_threads(5).build();
    let first = alone
        .unwrap()
        .install(|| detect(&frame, &board, 0))
        .unwrap();
    let second = crowd
        .unwrap()
        .install(|| detect(&frame, &board, 0))
        .unwrap();
    assert_eq!(first, second);
}
