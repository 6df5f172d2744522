//! Boards of which a large disc of blur leaves only dark spots, much smaller than the rings.

use ringcal::board::{Board, Polarity};
use ringcal::camera::{Camera, Distortion, Intrinsics, PlumbBob};
use ringcal::detect::{DetectOptions, Detector};
use ringcal::simulate::{Defocus, Scene, render, views};

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

#[test]
fn spots_half_as_large_as_the_rings_are_the_board() {
    let outer_m = 0.006;
    let board = Board::new(4, 5, 0.0269, 0.0027, outer_m, Polarity::DarkOnLight).unwrap();
    for pose in views(&CAMERA, &board, 4, 0.5, 6).unwrap() {
        let mut scene = Scene::new(CAMERA, board.clone(), pose);
        let outer_px = CAMERA.intrinsics.fx * outer_m / pose.translation_m.z;
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
