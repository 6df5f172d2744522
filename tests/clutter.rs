//! Print beside a board that stands as its next rows and columns would: it hides neither the board nor its size.

use nalgebra::{Point2, Rotation3, Vector3};
use ringcal::board::{Board, Polarity};
use ringcal::camera::{Camera, Distortion, Intrinsics, PlumbBob, Pose};
use ringcal::detect::{DetectOptions, Detection, Detector, Indices, Miss};
use ringcal::frame::{Frame, Pixels};
use ringcal::simulate::{Rendering, Scene, render};

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
        k1: 0.0,
        k2: 0.0,
        p1: 0.0,
        p2: 0.0,
        k3: 0.0,
    }),
};
const PITCH_M: f64 = 0.02;
/// Of the rings, in the frame.
const RADIUS_PX: f64 = 16.0;

fn board(rows: u16, columns: u16) -> Board {
    Board::new(rows, columns, PITCH_M, 0.003, 0.006, Polarity::DarkOnLight).unwrap()
}

/// A board of 5 x 6 with letters O of two sizes beside and below it, and a thumb over two rings.
fn picture() -> Rendering {
    let shown = board(5, 6);
    let rotation = Rotation3::from_euler_angles(0.1, -0.1, 0.05);
    let [x, y] = shown.middle_m();
    let distance = 800.0 * 0.006 / RADIUS_PX;
    let pose = Pose {
        rotation,
        translation_m: Vector3::new(-0.01, -0.01, distance) - rotation * Vector3::new(x, y, 0.0),
    };
    let mut scene = Scene::new(CAMERA, shown, pose);
    scene.sensor.read_noise = 0.005;
    let mut picture = render(&scene, 3).unwrap();
    let at = |row: usize, column: usize| picture.truth.rings[row * 6 + column].centre;
    let beyond = |a: Point2<f64>, b: Point2<f64>, steps: f64| a + (a - b) * steps;
    let mut letters = Vec::new();
    for steps in [1.0, 2.0] {
        letters.extend((0..5).map(|row| beyond(at(row, 5), at(row, 4), steps)));
        letters.extend((0..6).map(|column| beyond(at(4, column), at(3, column), steps)));
    }
    let covered = [at(2, 2), at(2, 3)];
    let Pixels::U8(plane) = &mut picture.frame.pixels else {
        panic!("8 bits were asked for");
    };
    let width = plane.width();
    for (i, pixel) in plane.data_mut().iter_mut().enumerate() {
        let pixel_at = Point2::new((i % width) as f64, (i / width) as f64);
        for (k, letter) in letters.iter().enumerate() {
            let size = if k % 2 == 0 { 0.5 } else { 1.55 } * RADIUS_PX;
            let away = (pixel_at - letter).norm() / size;
            if away < 1.0 {
                *pixel = if away < 0.5 { 200 } else { 40 };
            }
        }
        if covered
            .iter()
            .any(|c| (pixel_at - c).amax() < 1.4 * RADIUS_PX)
        {
            *pixel = 120;
        }
    }
    picture
}

fn detect(frame: &Frame, board: Board) -> Result<Detection, Miss> {
    Detector::new(board, DetectOptions::default()).detect(frame)
}

#[test]
fn a_board_with_covered_rings_is_found_among_letters() {
    let picture = picture();
    let found = detect(&picture.frame, board(5, 6)).unwrap();
    assert_eq!(found.indices, Indices::Absolute);
    assert_eq!(found.rings.len(), 28);
    for ring in &found.rings {
        let at = usize::from(ring.row) * 6 + usize::from(ring.column);
        let off = (picture.truth.rings[at].centre - ring.centre.point).norm();
        assert!(off < 0.1, "{} {}: {off}", ring.row, ring.column);
    }
}

#[test]
fn letters_beside_a_board_make_no_other_size_of_it() {
    let picture = picture();
    for (rows, columns) in [(5, 7), (6, 6), (4, 6), (5, 5)] {
        let miss = detect(&picture.frame, board(rows, columns)).unwrap_err();
        let said = miss.to_string();
        let size = format!("found 5 x 6, the board file says {rows} x {columns}");
        assert!(said.starts_with(&size), "{rows} x {columns}: {said}");
    }
}
