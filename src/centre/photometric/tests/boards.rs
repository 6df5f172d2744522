//! Boards: better than their rings alone, in the presence of a lens and of neighbours.

use crate::board::{Board, Polarity};
use crate::calibrate::CalibrateOptions;
use crate::camera::{Camera, Distortion, Intrinsics, PlumbBob, Pose};
use crate::centre::Estimator;
use crate::detect::{DetectOptions, Detection, Detector};
use crate::refine::{calibrate_refined, refine};
use crate::session::View;
use crate::simulate::{Defocus, Light, Scene, Truth, render, views};
use nalgebra::{Rotation3, Vector3};

pub(super) const CAMERA: Camera = Camera {
    width: 1280,
    height: 960,
    intrinsics: Intrinsics {
        fx: 1200.0,
        fy: 1205.0,
        cx: 645.0,
        cy: 472.0,
    },
    distortion: Distortion::PlumbBob(PlumbBob {
        k1: -0.2,
        k2: 0.08,
        p1: 0.001,
        p2: -0.0005,
        k3: 0.0,
    }),
};

fn board() -> Board {
    Board::new(7, 7, 0.0269, 0.003, 0.006, Polarity::DarkOnLight).unwrap()
}

/// Boards of a view each, detected, with their truths.
pub(super) fn detected(defocus: Defocus, margin: f64, count: usize) -> Vec<(Detection, Truth)> {
    let poses = views(&CAMERA, &board(), count, 0.6, 11).unwrap();
    let options = DetectOptions {
        estimator: Estimator::Photometric,
        ..DetectOptions::default()
    };
    let detector = Detector::new(board(), options);
    poses
        .into_iter()
        .enumerate()
        .map(|(i, pose)| {
            let mut scene = Scene::new(CAMERA, board(), pose);
            scene.defocus = defocus;
            scene.light.margin = margin;
            scene.light.shading = [0.25, -0.1];
            scene.sensor.read_noise = 0.01;
            let rendering = render(&scene, i as u64).unwrap();
            (detector.detect(&rendering.frame).unwrap(), rendering.truth)
        })
        .collect()
}

/// Root mean square of the error, of that of the rings alone, and mean normalised square, over the rings that were measured.
pub(super) fn figures(found: &[(Detection, Truth)]) -> [f64; 3] {
    let (mut shared, mut alone, mut normalised, mut count) = (0.0, 0.0, 0.0, 0.0);
    for (detection, truth) in found {
        let measured = detection
            .rings
            .iter()
            .filter(|r| r.centre.covariance.is_some());
        for ring in measured {
            let of_ring =
                |t: &&crate::simulate::RingTruth| (t.row, t.column) == (ring.row, ring.column);
            let at = truth.rings.iter().find(of_ring).unwrap().centre;
            let off = ring.centre.point - at;
            let own = ring.kept.as_ref().unwrap().fitted.model.shape.centre - at;
            let inverse = ring.centre.covariance.unwrap().try_inverse().unwrap();
            shared += off.norm_squared();
            alone += own.norm_squared();
            normalised += off.dot(&(inverse * off));
            count += 1.0;
        }
    }
    [
        (shared / count).sqrt(),
        (alone / count).sqrt(),
        normalised / count,
    ]
}

#[test]
fn rings_of_a_board_are_better_than_alone_and_honest() {
    for defocus in [Defocus::None, Defocus::gaussian(3.0), Defocus::disc(8.0)] {
        let found = detected(defocus, f64::INFINITY, 3);
        assert!(found.iter().all(|(d, _)| d.rings.len() == 49));
        let [shared, alone, normalised] = figures(&found);
        assert!(shared < 0.7 * alone, "{defocus:?}: {shared} {alone}");
        assert!(
            (1.5..3.0).contains(&normalised),
            "{defocus:?}: {normalised}"
        );
    }
}

#[test]
fn the_second_pass_does_not_make_centres_worse_and_agrees_with_itself() {
    let found = detected(Defocus::gaussian(5.0), f64::INFINITY, 6);
    let kept: Vec<View> = found.iter().map(|(d, _)| View::of_file("x", d)).collect();
    let options = CalibrateOptions::default();
    let (calibration, refined) = calibrate_refined(&board(), &kept, &options).unwrap();
    let error = |views: &[View]| {
        let pairs = views.iter().zip(&found).flat_map(|(view, (_, truth))| {
            view.rings.iter().map(|ring| {
                let of_ring =
                    |t: &&crate::simulate::RingTruth| (t.row, t.column) == (ring.row, ring.column);
                let at = truth.rings.iter().find(of_ring).unwrap().centre;
                (ring.centre.point - at).norm_squared()
            })
        });
        let all: Vec<f64> = pairs.collect();
        (all.iter().sum::<f64>() / all.len() as f64).sqrt()
    };
    let (before, after) = (error(&kept), error(&refined));
    assert!(after < 1.05 * before, "{before} {after}");
    assert!((calibration.camera.intrinsics.fx - 1200.0).abs() < 1.0);
    let again = refine(&board(), &kept, &calibration);
    let moved = again.iter().zip(&refined).flat_map(|(a, b)| {
        let pairs = a.rings.iter().zip(&b.rings);
        pairs.map(|(a, b)| (a.centre.point - b.centre.point).norm())
    });
    assert!(moved.fold(0.0_f64, f64::max) < 0.3 * after);
    for view in &kept {
        let bytes: usize = view
            .rings
            .iter()
            .map(|r| r.kept.as_ref().unwrap().bytes())
            .sum();
        assert!(bytes < 200_000, "{bytes}");
    }
}

/// A board in heavy blur before nothing else, seen from these poses.
fn crowded(board: &Board, poses: Vec<Pose>, sigma_px: f64, noise: f64) -> Vec<(Detection, Truth)> {
    let options = DetectOptions {
        estimator: Estimator::Photometric,
        ..DetectOptions::default()
    };
    let of_pose = |pose| {
        let mut scene = Scene::new(CAMERA, board.clone(), pose);
        scene.defocus = Defocus::gaussian(sigma_px);
        scene.light = Light::on(board.polarity());
        scene.light.margin = f64::INFINITY;
        scene.sensor.read_noise = noise;
        let rendering = render(&scene, 3).unwrap();
        let detection = Detector::new(board.clone(), options).detect(&rendering.frame);
        (detection.unwrap(), rendering.truth)
    };
    poses.into_iter().map(of_pose).collect()
}

/// Fitted in turn, crowded rings need dozens of rounds: after three their errors were ten times their standard deviations.
#[test]
fn crowded_rings_settle_together() {
    let board = Board::new(7, 7, 0.03, 0.0055, 0.0105, Polarity::DarkOnLight).unwrap();
    let poses = views(&CAMERA, &board, 2, 0.6, 5).unwrap();
    let found = crowded(&board, poses, 9.5, 0.005);
    let [shared, alone, normalised] = figures(&found);
    assert!(shared < 0.7 * alone, "{shared} {alone}");
    assert!((1.4..2.8).contains(&normalised), "{normalised}");
}

/// Blur of half the radius of rings that stand close: fits went to rings of four times the contrast with inner discs of negative light, or of
/// too much blur, and centres were off by one to two px.
#[test]
fn rings_as_small_as_their_blur_are_told_from_their_neighbours() {
    let board = Board::new(7, 7, 0.0354, 0.0045, 0.01, Polarity::LightOnDark).unwrap();
    let middle = 3.0 * 0.0354;
    for (about_x, about_y, away_m) in [(-0.35, 0.3, 0.55), (0.0, 0.4, 0.58), (0.2, 0.5, 0.52)] {
        let turned = Rotation3::from_euler_angles(about_x, about_y, 0.5);
        let to_middle = turned * Vector3::new(middle, middle, 0.0);
        let pose = Pose {
            rotation: turned,
            translation_m: Vector3::new(0.0, 0.0, away_m) - to_middle,
        };
        let found = crowded(&board, vec![pose], 10.0, 0.01);
        let [shared, _, normalised] = figures(&found);
        assert!(shared < 0.09, "{about_x} {about_y}: {shared}");
        assert!(normalised < 6.0, "{about_x} {about_y}: {normalised}");
        let measured = found[0].0.rings.iter().filter_map(|r| r.kept.as_ref());
        assert!(measured.clone().count() >= 47);
        for model in measured.map(|kept| kept.fitted.model) {
            assert!(model.ring.min(model.inside) > -0.1, "{model:?}");
        }
    }
}

#[test]
fn rings_that_all_but_touch_are_measured_in_heavy_blur() {
    let tight = Board::new(7, 7, 0.03, 0.006, 0.0126, Polarity::DarkOnLight).unwrap();
    let poses = views(&CAMERA, &tight, 4, 0.6, 11).unwrap();
    // blur sigma over the outer radius
    for (pose, blur) in [(poses[2], 0.31), (poses[3], 0.34)] {
        let radius_px = tight.outer_radius_m() * CAMERA.intrinsics.fx / pose.translation_m.z;
        let mut scene = Scene::new(CAMERA, tight.clone(), pose);
        scene.defocus = Defocus::gaussian(blur * radius_px);
        scene.light.margin = f64::INFINITY;
        scene.light.shading = [0.25, -0.1];
        scene.sensor.read_noise = 0.005;
        // errors of crowded rings are alike, so that one frame says little of their covariances
        let detector = Detector::new(tight.clone(), DetectOptions::default());
        let found = (3..6).map(|seed| {
            let rendering = render(&scene, seed).unwrap();
            let detection = detector.detect(&rendering.frame).unwrap();
            assert_eq!(detection.rings.len(), 49);
            (detection, rendering.truth)
        });
        let [shared, _, normalised] = figures(&found.collect::<Vec<_>>());
        assert!(shared < 0.02, "{blur}: {shared}");
        assert!(normalised < 3.8, "{blur}: {normalised}");
    }
}
