//! What is no board is never taken for one, and what is one is never seen inside out, however little blur leaves of it.

use nalgebra::{Rotation3, Vector3};
use ringcal::board::{Board, Polarity};
use ringcal::camera::{Camera, Distortion, Intrinsics, PlumbBob, Pose};
use ringcal::detect::{DetectOptions, Detection, Detector, Miss};
use ringcal::simulate::{Defocus, Light, Scene, render, views};

const CAMERA: Camera = Camera {
    width: 960,
    height: 720,
    intrinsics: Intrinsics {
        fx: 900.0,
        fy: 900.0,
        cx: 480.0,
        cy: 360.0,
    },
    distortion: Distortion::PlumbBob(PlumbBob {
        k1: -0.1,
        k2: 0.02,
        p1: 0.0,
        p2: 0.0,
        k3: 0.0,
    }),
};

fn board(rows: u16, columns: u16, inner_m: f64, polarity: Polarity) -> Board {
    Board::new(rows, columns, 0.0269, inner_m, 0.006, polarity).unwrap()
}

fn detect(scene: &Scene, wanted: Board) -> Result<Detection, Miss> {
    let frame = render(scene, 7).unwrap().frame;
    Detector::new(wanted, DetectOptions::default()).detect(&frame)
}

#[test]
fn plain_dots_are_no_rings_however_blurred() {
    let dots = board(6, 6, 0.000_06, Polarity::DarkOnLight);
    for (seed, ratio) in [(11, 0.4), (12, 0.6)] {
        let pose = views(&CAMERA, &dots, 1, 0.6, seed).unwrap()[0];
        for defocus in [
            Defocus::None,
            Defocus::gaussian(3.0),
            Defocus::gaussian(5.0),
            Defocus::gaussian(8.0),
            Defocus::disc(6.0),
            Defocus::disc(10.0),
        ] {
            let mut scene = Scene::new(CAMERA, dots.clone(), pose);
            scene.defocus = defocus;
            scene.sensor.read_noise = 0.01;
            let wanted = board(6, 6, 0.006 * ratio, Polarity::Auto);
            let found = detect(&scene, wanted);
            assert!(found.is_err(), "{defocus:?} ratio {ratio}");
        }
    }
}

#[test]
fn the_gaps_between_light_rings_are_no_dark_rings() {
    let rings = Board::new(3, 4, 0.033, 0.0062, 0.01, Polarity::Auto).unwrap();
    let pose = Pose {
        rotation: Rotation3::from_euler_angles(0.3, -0.2, 0.5),
        translation_m: Vector3::new(-0.04, -0.045, 0.2),
    };
    for defocus in [Defocus::gaussian(2.0), Defocus::disc(8.0)] {
        let mut scene = Scene::new(CAMERA, rings.clone(), pose);
        scene.light = Light::on(Polarity::LightOnDark);
        scene.light.margin = 3.0;
        scene.defocus = defocus;
        let rendering = render(&scene, 7).unwrap();
        let found = Detector::new(rings.clone(), DetectOptions::default())
            .detect(&rendering.frame)
            .unwrap();
        assert_eq!(found.rings.len(), 12);
        for ring in &found.rings {
            let near = rendering.truth.rings.iter();
            let mut near = near.map(|t| (t.centre - ring.centre.point).norm());
            assert!(near.any(|off| off < 0.5), "{defocus:?}");
        }
    }
}

#[test]
fn discs_that_invert_the_inner_circle_are_told() {
    let rings = board(5, 6, 0.003, Polarity::DarkOnLight);
    let poses = views(&CAMERA, &rings, 3, 0.5, 4).unwrap();
    for (pose, inner_radii) in poses.into_iter().zip([1.15, 1.3, 1.42]) {
        let mut scene = Scene::new(CAMERA, rings.clone(), pose);
        let inner_px = CAMERA.intrinsics.fx * 0.003 / pose.translation_m.z;
        scene.defocus = Defocus::disc(inner_radii * inner_px);
        scene.sensor.read_noise = 0.01;
        let rendering = render(&scene, 9).unwrap();
        let found = Detector::new(rings.clone(), DetectOptions::default())
            .detect(&rendering.frame)
            .unwrap();
        assert_eq!(found.rings.len(), 30);
        for ring in &found.rings {
            let at = (usize::from(ring.row) * 6) + usize::from(ring.column);
            let off = (rendering.truth.rings[at].centre - ring.centre.point).norm();
            assert!(off < 0.3, "{} {}: {off}", ring.row, ring.column);
        }
    }
}

#[test]
fn a_wall_of_rings_is_not_the_board() {
    let wall = board(20, 24, 0.003, Polarity::DarkOnLight);
    let [x, y] = wall.middle_m();
    let pose = Pose {
        rotation: Rotation3::from_euler_angles(0.1, 0.05, 0.02),
        translation_m: Vector3::new(-x, -y, 0.75),
    };
    let scene = Scene::new(CAMERA, wall, pose);
    let miss = detect(&scene, board(5, 6, 0.003, Polarity::Auto)).unwrap_err();
    assert!(matches!(miss, Miss::WrongSize { .. }), "{miss}");
}

/// A large disc of blur leaves dark spots, much smaller than the rings.
#[test]
fn spots_half_as_large_as_the_rings_are_the_board() {
    let board = board(4, 5, 0.0027, Polarity::DarkOnLight);
    for pose in views(&CAMERA, &board, 4, 0.5, 6).unwrap() {
        let mut scene = Scene::new(CAMERA, board.clone(), pose);
        let outer_px = CAMERA.intrinsics.fx * board.outer_radius_m() / pose.translation_m.z;
        scene.defocus = Defocus::disc(0.95 * outer_px);
        scene.sensor.read_noise = 0.005;
        let rendering = render(&scene, 3).unwrap();
        let found = Detector::new(board.clone(), DetectOptions::default())
            .detect(&rendering.frame)
            .unwrap();
        assert_eq!(found.rings.len(), board.ring_count());
        for ring in &found.rings {
            let at = usize::from(ring.row) * 5 + usize::from(ring.column);
            let off = (rendering.truth.rings[at].centre - ring.centre.point).norm();
            assert!(off < 0.5, "{} {}: {off}", ring.row, ring.column);
        }
    }
}
