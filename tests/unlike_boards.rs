//! Grids of things that a ring can be laid into, drawn where the board's rings would be: each is refused for what it is.

use nalgebra::{Matrix2, Vector2};
use ringcal::board::{Board, Polarity};
use ringcal::detect::{DetectOptions, Detection, Detector, Miss, Odd};
use ringcal::frame::{Frame, Plane};

const SIZE: (usize, usize) = (640, 480);
const BOARD: (u16, u16) = (5, 6);
/// Outer radius over pitch, inner over outer radius.
const RADIUS: f64 = 0.33;
const RATIO: f64 = 0.5;

/// A picture of `ink` (of the place relative to a ring's centre in pitches, and the ring's number) in a grid, tilted a little and blurred.
fn picture(pitch_px: f64, blur_px: usize, ink: impl Fn(Vector2<f64>, u32) -> bool) -> Frame {
    let (width, height) = SIZE;
    let map = Matrix2::new(0.96, -0.25, 0.2, 0.9) * pitch_px;
    let inverse = map.try_inverse().unwrap();
    let middle = Vector2::new(0.5 * width as f64, 0.5 * height as f64);
    let (rows, columns) = (f64::from(BOARD.0), f64::from(BOARD.1));
    let is_ink = |x: f64, y: f64| {
        let at = inverse * (Vector2::new(x, y) - middle);
        let at = at + Vector2::new(columns - 1.0, rows - 1.0) * 0.5;
        let (column, row) = (at.x.round(), at.y.round());
        let inside = (0.0..columns).contains(&column) && (0.0..rows).contains(&row);
        let number = (row * columns + column).max(0.0) as u32;
        inside && ink(at - Vector2::new(column, row), number)
    };
    const FINE: usize = 4;
    let light = (0..width * height).map(|i| {
        let dark = (0..FINE * FINE).filter(|k| {
            let part = |k: usize| (k as f64 + 0.5) / FINE as f64 - 0.5;
            let (x, y) = ((i % width) as f64, (i / width) as f64);
            is_ink(x + part(k % FINE), y + part(k / FINE))
        });
        205.0 - 150.0 * dark.count() as f64 / (FINE * FINE) as f64
    });
    let mut light: Vec<f64> = light.collect();
    for _ in 0..3 {
        light = mean_along(&light, blur_px, 1);
        light = mean_along(&light, blur_px, width);
    }
    // a little noise, always the same
    let noise = |i: usize| ((i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) % 7;
    let grey = |(i, v): (usize, &f64)| (v + noise(i) as f64 - 3.0).round() as u8;
    let data = light.iter().enumerate().map(grey).collect();
    Frame::from_u8(Plane::from_vec(width, height, data).unwrap(), "drawn")
}

/// The mean over so many pixels to both sides, along one direction; a flat border is kept.
fn mean_along(light: &[f64], reach: usize, step: usize) -> Vec<f64> {
    let margin = reach * step;
    let mean = |i: usize| {
        if i < margin || i + margin >= light.len() {
            return light[i];
        }
        let around = (i - margin..=i + margin).step_by(step);
        around.map(|k| light[k]).sum::<f64>() / (2 * reach + 1) as f64
    };
    (0..light.len()).map(mean).collect()
}

fn detect(frame: &Frame) -> Result<Detection, Miss> {
    let (rows, columns) = BOARD;
    let board = Board::new(rows, columns, 1.0, RADIUS * RATIO, RADIUS, Polarity::Auto).unwrap();
    Detector::new(board, DetectOptions::default()).detect(frame)
}

fn is_ring(at: Vector2<f64>, radius: f64) -> bool {
    (RATIO * radius..radius).contains(&at.norm())
}

#[test]
fn the_board_itself_is_found() {
    for (pitch_px, blur_px) in [(22.0, 0), (40.0, 1), (60.0, 3)] {
        let frame = picture(pitch_px, blur_px, |at, _| is_ring(at, RADIUS));
        let found = detect(&frame).unwrap();
        assert_eq!(found.rings.len(), 30);
        let round = found.photometric.unwrap().out_of_round;
        assert!(round < 0.01, "{round}");
    }
}

#[test]
fn a_board_file_roughly_measured_will_do() {
    for factor in [0.92, 1.08] {
        let frame = picture(40.0, 2, |at, _| is_ring(at, factor * RADIUS));
        assert_eq!(detect(&frame).unwrap().rings.len(), 30);
    }
}

#[test]
fn squares_are_not_round() {
    let squares = |pitch_px, blur_px| {
        let side = |at: Vector2<f64>| at.x.abs().max(at.y.abs());
        // as large as the rings would be
        let frame = picture(pitch_px, blur_px, |at, _| {
            (RATIO * 0.85 * RADIUS..0.85 * RADIUS).contains(&side(at))
        });
        detect(&frame).unwrap_err()
    };
    // large or sharp ones have not even a ring's edges
    for (pitch_px, blur_px) in [(22.0, 0), (40.0, 1), (60.0, 3)] {
        squares(pitch_px, blur_px);
    }
    for (pitch_px, blur_px) in [(22.0, 1), (40.0, 2)] {
        let (miss, odd) = (squares(pitch_px, blur_px), Odd::Outlines);
        assert_eq!(miss, Miss::Unlike { found: 30, odd }, "{pitch_px}: {miss}");
    }
}

#[test]
fn rings_of_another_size_are_told() {
    for factor in [0.78, 1.25] {
        let frame = picture(40.0, 2, |at, _| is_ring(at, factor * RADIUS));
        let miss = detect(&frame).unwrap_err();
        let Miss::OtherRadius { seen, given } = miss else {
            panic!("{miss}");
        };
        assert!((seen / (factor * RADIUS) - 1.0).abs() < 0.03 && (given - RADIUS).abs() < 1e-9);
    }
}

#[test]
fn thin_rings_are_no_broad_ones() {
    // under that much blur a thin ring looks like a larger, broader one in less of it
    let frame = picture(60.0, 3, |at, _| (0.9 * RADIUS..RADIUS).contains(&at.norm()));
    let miss = detect(&frame).unwrap_err();
    assert!(matches!(miss, Miss::OtherRadius { .. }), "{miss}");
}

#[test]
fn inner_circles_of_another_size_are_told() {
    // grey values alone are explained by more blur
    for (ratio, blur_px) in [(0.25, 2), (0.3, 2)] {
        let frame = picture(60.0, blur_px, |at, _| {
            (ratio * RADIUS..RADIUS).contains(&at.norm())
        });
        assert!(detect(&frame).is_err(), "{ratio} {blur_px}");
    }
}

#[test]
fn a_ring_encloses_the_ground_it_is_printed_on() {
    let is_dark = |at: Vector2<f64>| (7919.3 * at.x + 10_473.7 * at.y).fract().abs() < 0.45;
    let frame = picture(40.0, 2, |at, _| {
        is_ring(at, RADIUS) || (at.norm() < RATIO * RADIUS && is_dark(at))
    });
    let (miss, odd) = (detect(&frame).err(), Odd::Insides);
    assert_eq!(miss, Some(Miss::Unlike { found: 30, odd }));
}

#[test]
fn dots_of_all_sizes_are_no_board() {
    for blur_px in [4, 5, 6] {
        let frame = picture(44.0, blur_px, |at, number| {
            at.norm() < RADIUS * (0.7 + 0.1 * f64::from(number * 5 % 7))
        });
        assert!(detect(&frame).is_err());
    }
}

#[test]
fn where_blur_leaves_nothing_of_a_ring_no_board_is_claimed() {
    for blur_px in [6, 7, 8] {
        let side = |at: Vector2<f64>| at.x.abs().max(at.y.abs());
        let frame = picture(26.0, blur_px, |at, _| side(at) < RADIUS);
        assert!(detect(&frame).is_err(), "{blur_px}");
    }
}

#[test]
fn hexagons_are_not_round() {
    let side = |at: Vector2<f64>| {
        let (x, y) = (at.x.abs(), at.y.abs());
        y.max(0.5 * y + 0.866 * x)
    };
    for (pitch_px, blur_px) in [(40.0, 1), (40.0, 2), (60.0, 2)] {
        let frame = picture(pitch_px, blur_px, |at, _| {
            (RATIO * 0.95 * RADIUS..0.95 * RADIUS).contains(&side(at))
        });
        assert!(detect(&frame).is_err(), "{pitch_px} {blur_px}");
    }
}

/// A hexagonal grid seen at an angle may be square in the frame; its circles are not round there.
#[test]
fn rings_in_hexagons_are_no_board_where_perspective_makes_squares_of_them() {
    let on_their_plane = Matrix2::new(1.0, 0.5, 0.0, 0.866) / 0.866_f64.sqrt();
    for (pitch_px, blur_px) in [(40.0, 0), (40.0, 2), (60.0, 3)] {
        let frame = picture(pitch_px, blur_px, |at, _| {
            is_ring(on_their_plane * at, 0.95 * RADIUS)
        });
        assert!(detect(&frame).is_err(), "{pitch_px} {blur_px}");
    }
}
