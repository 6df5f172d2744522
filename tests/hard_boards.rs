//! Boards at the edge of what can be seen: rings of a few pixels, discs of blur as large as the rings, steep and sharp ones. Each is found
//! whole, and where the simulator says it is.

use nalgebra::{Rotation3, Vector3};
use ringcal::board::{Board, Polarity};
use ringcal::camera::{Camera, Distortion, Intrinsics, PlumbBob, Pose};
use ringcal::detect::{DetectOptions, Detection, Detector, Miss};
use ringcal::frame::{Frame, Pixels};
use ringcal::simulate::{Defocus, Light, Rendering, Scene, render};

const CAMERA: Camera = Camera {
    width: 800,
    height: 600,
    intrinsics: Intrinsics {
        fx: 900.0,
        fy: 900.0,
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
const OUTER_M: f64 = 0.006;

/// A scene of a board whose rings have this radius (px) in its middle, turned by these angles (rad).
fn scene(board: &Board, radius_px: f64, (x, y, z): (f64, f64, f64)) -> Scene {
    let rotation = Rotation3::from_euler_angles(x, y, z);
    let [mx, my] = board.middle_m();
    let distance = CAMERA.intrinsics.fx * OUTER_M / radius_px;
    let translation_m = Vector3::new(0.0, 0.0, distance) - rotation * Vector3::new(mx, my, 0.0);
    let pose = Pose {
        rotation,
        translation_m,
    };
    Scene::new(CAMERA, board.clone(), pose)
}

fn detect(board: &Board, frame: &Frame) -> Result<Detection, Miss> {
    Detector::new(board.clone(), DetectOptions::default()).detect(frame)
}

/// All rings are there, none farther from its place than `most_px`, and all by their grey values.
fn assert_found(board: &Board, rendering: &Rendering, most_px: f64, what: &str) {
    let found = detect(board, &rendering.frame).unwrap_or_else(|miss| panic!("{what}: {miss}"));
    assert_eq!(found.rings.len(), board.ring_count(), "{what}");
    for ring in &found.rings {
        let at = usize::from(ring.row) * usize::from(board.columns()) + usize::from(ring.column);
        let off = (rendering.truth.rings[at].centre - ring.centre.point).norm();
        assert!(off < most_px, "{what}: {} {}: {off}", ring.row, ring.column);
        assert!(ring.centre.covariance.is_some(), "{what}");
    }
}

#[test]
fn rings_of_nine_pixels_are_seen() {
    for (i, (ratio, polarity)) in [
        (0.4, Polarity::DarkOnLight),
        (0.5, Polarity::LightOnDark),
        (0.5, Polarity::Auto),
        (0.6, Polarity::DarkOnLight),
    ]
    .into_iter()
    .enumerate()
    {
        let board = Board::new(4, 6, 0.021, ratio * OUTER_M, OUTER_M, polarity).unwrap();
        for defocus in [
            Defocus::gaussian(0.4),
            Defocus::gaussian(0.8),
            Defocus::disc(1.2),
        ] {
            let turn = (0.15, -0.1, 0.2 * i as f64);
            let mut scene = scene(&board, 4.6, turn);
            scene.light = Light::on(polarity);
            scene.defocus = defocus;
            scene.sensor.read_noise = 0.005;
            let rendering = render(&scene, 5).unwrap();
            assert_found(
                &board,
                &rendering,
                0.3,
                &format!("{ratio} {polarity:?} {defocus:?}"),
            );
        }
    }
}

/// So near to each other that every window holds the light of all rings around.
#[test]
fn discs_nearly_as_large_as_the_rings_are_told_though_their_skirts_overlap() {
    for (rows, columns, ratio, part) in [(4, 6, 0.5, 0.73), (5, 5, 0.4, 0.88), (7, 7, 0.5, 0.8)] {
        let polarity = Polarity::DarkOnLight;
        let board = Board::new(rows, columns, 0.0192, ratio * OUTER_M, OUTER_M, polarity).unwrap();
        for turn in [(0.1, 0.05, 0.3), (-0.3, 0.3, 0.1)] {
            let mut scene = scene(&board, 18.0, turn);
            scene.defocus = Defocus::disc(part * 18.0);
            scene.sensor.read_noise = 0.002;
            let rendering = render(&scene, 8).unwrap();
            assert_found(&board, &rendering, 0.3, &format!("{ratio} {part} {turn:?}"));
        }
    }
}

#[test]
fn sharp_rings_seen_at_a_steep_angle_are_fitted() {
    let board = Board::new(5, 5, 0.018, 0.5 * OUTER_M, OUTER_M, Polarity::DarkOnLight).unwrap();
    for turn in [(0.94, 0.0, 0.4), (-0.9, 0.2, 0.1), (0.3, 0.95, 0.2)] {
        let mut scene = scene(&board, 25.0, turn);
        scene.defocus = Defocus::gaussian(0.35);
        scene.sensor.read_noise = 0.003;
        let rendering = render(&scene, 2).unwrap();
        assert_found(&board, &rendering, 0.05, &format!("{turn:?}"));
    }
}

/// What stands beside the board is looked at even where no candidate for it was seen: scratches join the discs of the last
/// column with the paper, and one ring of the others is covered, so that the whole frame has to be searched.
#[test]
fn a_board_that_goes_on_where_rings_are_scratched_is_none() {
    let wall = Board::new(5, 7, 0.021, 0.5 * OUTER_M, OUTER_M, Polarity::DarkOnLight).unwrap();
    let wanted = Board::new(5, 6, 0.021, 0.5 * OUTER_M, OUTER_M, Polarity::DarkOnLight).unwrap();
    let mut scene = scene(&wall, 16.0, (0.05, 0.03, 0.0));
    scene.defocus = Defocus::gaussian(0.8);
    scene.sensor.read_noise = 0.003;
    let rendering = render(&scene, 4).unwrap();
    let at = |row: usize, column: usize| rendering.truth.rings[row * 7 + column].centre;
    let Pixels::U8(plane) = &rendering.frame.pixels else {
        panic!("eight bits were asked for");
    };
    let paper = {
        let between = (at(1, 1).coords + at(2, 2).coords) * 0.5;
        plane.at(between.x as usize, between.y as usize)
    };
    let altered = |scratched: bool| {
        let mut plane = plane.clone();
        let width = plane.width();
        let covered = at(2, 3);
        for (i, grey) in plane.data_mut().iter_mut().enumerate() {
            let (x, y) = ((i % width) as f64, (i / width) as f64);
            let cover = (x - covered.x).hypot(y - covered.y) < 20.0;
            let beside = (0..5).any(|row| {
                let ring = at(row, 6);
                let (dx, dy) = ((x - ring.x).abs(), (y - ring.y).abs());
                let size = if scratched { 2.5 } else { 20.0 };
                dx < size && dy < 20.0
            });
            if cover || beside {
                *grey = paper;
            }
        }
        Frame::from_u8(plane, "altered")
    };
    let found = detect(&wanted, &altered(false)).unwrap();
    assert_eq!(found.rings.len(), 29);
    let miss = detect(&wanted, &altered(true)).unwrap_err();
    assert!(
        matches!(
            miss,
            Miss::WrongSize {
                found_rows: 5,
                found_columns: 7,
                ..
            }
        ),
        "{miss}"
    );
}

/// Of the inner discs a point of light is left, which is neither an inner circle nor none.
#[test]
fn discs_as_large_as_the_inner_circle_are_seen_through() {
    for (polarity, angle) in [(Polarity::DarkOnLight, 0.3), (Polarity::LightOnDark, -0.2)] {
        let board = Board::new(4, 5, 0.0213, 0.6 * OUTER_M, OUTER_M, polarity).unwrap();
        for blur in [1.0, 1.1] {
            let mut scene = scene(&board, 26.0, (0.1, 0.1, angle));
            scene.light = Light::on(polarity);
            scene.defocus = Defocus::disc(blur * 0.6 * 26.0);
            scene.sensor.read_noise = 0.002;
            let what = format!("{polarity:?}, disc {blur} of the inner circle");
            assert_found(&board, &render(&scene, 7).unwrap(), 0.2, &what);
        }
    }
}

/// The far columns of a steep board are smaller than the disc of blur: edges do not show them.
#[test]
fn columns_that_blur_drowns_are_found_by_their_grey_values() {
    let ratio = 0.45;
    let board = Board::new(
        5,
        7,
        0.0203,
        ratio * OUTER_M,
        OUTER_M,
        Polarity::LightOnDark,
    )
    .unwrap();
    for disc in [9.0, 10.0, 11.0] {
        let mut scene = scene(&board, 15.0, (0.2, 0.95, 0.1));
        scene.light = Light::on(Polarity::LightOnDark);
        scene.defocus = Defocus::disc(disc);
        scene.sensor.read_noise = 0.003;
        let found = detect(&board, &render(&scene, 5).unwrap().frame);
        let found = found.unwrap_or_else(|miss| panic!("disc of {disc} px: {miss}"));
        assert!(found.rings.len() >= 30, "{disc}: {}", found.rings.len());
        let truth = render(&scene, 5).unwrap().truth;
        for ring in &found.rings {
            let at = usize::from(ring.row) * 7 + usize::from(ring.column);
            let off = (truth.rings[at].centre - ring.centre.point).norm();
            assert!(
                off < 0.5,
                "disc of {disc} px: {} {}: {off}",
                ring.row,
                ring.column
            );
        }
    }
}
