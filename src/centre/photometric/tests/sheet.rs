//! The end of the sheet: derivatives, and boards whose border rings it reaches.

use super::super::fit::Known;
use super::super::model::{BLUR, PAPER, SHADING, SHEET};
use super::super::problem::Problem;
use super::super::*;
use super::boards::{CAMERA, detected, figures};
use super::{SHAPE, grid};
use crate::board::{Board, Polarity};
use crate::detect::{DetectOptions, Detector};
use crate::frame::{Frame, Linear, Plane};
use crate::simulate::{BitDepth, Defocus, Scene, render, views};
use nalgebra::Point2;

/// A ring near a corner of its sheet.
fn model(blur: Blur, corner: bool) -> RingModel {
    let edge = |offset_px, angle| Edge {
        anchor: Point2::new(31.0, 29.0),
        offset_px,
        angle,
        bend: 2e-3,
    };
    RingModel {
        shape: Shape::from_parameters(&SHAPE),
        blur,
        paper: 0.8,
        ring: 0.1,
        inside: 0.75,
        shading: [0.1, -0.05],
        sheet: Some(SheetEnd {
            beyond: 0.3,
            edge: edge(24.0, 0.3),
            other: corner.then(|| edge(22.0, 1.4)),
        }),
    }
}

#[test]
fn gradients_agree_with_finite_differences() {
    let black = Frame::from_u8(Plane::filled(66, 66, 1), "black");
    let everything = Rectangle {
        x: 0,
        y: 0,
        width: 66,
        height: 66,
    };
    for (blur, bin) in [
        (Blur::gaussian(4.0), 1),
        (Blur::gaussian(6.0), 3),
        (Blur::disc(8.0), 2),
    ] {
        for corner in [false, true] {
            let window = Window::cut(&black, everything, bin, &Linear::new(1.0, false)).unwrap();
            assert_eq!(window.grid, grid(bin as f64, 66.0));
            let problem = Problem {
                window: &window,
                ratio: 0.5,
                around: None,
                noise: 0.0,
            };
            let model = model(blur, corner);
            let mut room = Workspace::default();
            let told = room.normal(&problem, &model).unwrap().gradient;
            let known = Known {
                window: &window,
                ratio: 0.5,
                around: None,
                given: Given::Nothing,
            };
            for k in [BLUR, PAPER, SHADING]
                .into_iter()
                .chain(SHEET..model.count())
            {
                let h = match k {
                    BLUR => 0.02 * blur.size_px * blur.size_px,
                    k if k > SHEET && (k - SHEET) % 2 == 1 => 0.2,
                    _ => 0.01,
                };
                let mut squares_at = |by: f64| {
                    let mut p = model.parameters();
                    p[k] += by;
                    let residuals = room.residuals(&known, &model.with_parameters(&p));
                    residuals.iter().map(|r| f64::from(*r).powi(2)).sum::<f64>()
                };
                // the residuals are what is seen less the model
                let slope = -0.5 * (squares_at(h) - squares_at(-h)) / (2.0 * h);
                let error = (slope / told[k] - 1.0).abs();
                // the corner of a disc is that of a Gaussian, corrected
                let most = if blur.psf == Psf::Disc { 0.05 } else { 0.01 };
                assert!(error < most, "{blur:?} {corner} {k}: {slope} {}", told[k]);
            }
        }
    }
}

#[test]
fn rings_at_the_end_of_the_sheet_are_as_good_as_others() {
    for (defocus, most_px) in [
        (Defocus::gaussian(6.0), 0.025),
        (Defocus::gaussian(8.0), 0.04),
        (Defocus::disc(12.0), 0.03),
    ] {
        let found = detected(defocus, 1.5, 3);
        assert!(found.iter().all(|(d, _)| d.rings.len() == 49));
        let [shared, _, normalised] = figures(&found);
        assert!(shared < most_px, "{defocus:?}: {shared}");
        assert!(
            (1.4..3.0).contains(&normalised),
            "{defocus:?}: {normalised}"
        );
    }
}

/// Where blur all but drowns a row, a blot beyond the opposite side must not take its place.
#[test]
fn no_board_is_numbered_one_row_off() {
    let board = Board::new(7, 7, 0.038, 0.006, 0.012, Polarity::DarkOnLight).unwrap();
    let detector = Detector::new(board.clone(), DetectOptions::default());
    let poses = views(&CAMERA, &board, 4, 40_f64.to_radians(), 11).unwrap();
    for (i, pose) in poses.into_iter().enumerate() {
        let mut scene = Scene::new(CAMERA, board.clone(), pose);
        scene.defocus = Defocus::gaussian(10.0);
        scene.light.margin = 1.5;
        scene.light.shading = [0.25, -0.1];
        scene.sensor.read_noise = 0.01;
        if i % 2 == 1 {
            scene.sensor.depth = BitDepth::Sixteen;
        }
        let rendering = render(&scene, 5 + i as u64).unwrap();
        let found = detector.detect(&rendering.frame).unwrap();
        for ring in &found.rings {
            let at = rendering.truth.rings.iter();
            let mut at = at.filter(|t| (t.row, t.column) == (ring.row, ring.column));
            let off = ring.centre.point - at.next().unwrap().centre;
            assert!(off.norm() < 3.0, "{i}: {} {}", ring.row, ring.column);
        }
    }
}
