//! Single rings: the bound, honest covariances, clipped pixels, both shapes of blur.

use super::super::*;
use super::{scene, true_shape};
use crate::centre::Ellipse;
use crate::frame::{Frame, Linear};
use crate::simulate::{self, BitDepth, Scene};

/// A ring in fair light with 1 % of noise, 16 bit.
fn noisy(outer_px: f64, size: u32, blur: &Blur) -> Scene {
    let mut scene = scene(outer_px, size, blur);
    (scene.light.paper, scene.light.ring) = (0.85, 0.1);
    scene.sensor.read_noise = 0.01;
    scene.sensor.depth = BitDepth::Sixteen;
    scene
}

fn measure(frame: &Frame, outline: &Ellipse, sigma_px: f64, psf: PsfChoice) -> RingFitted {
    let linear = Linear::new(1.0, true);
    let start = RingStart {
        seen: Seen {
            outline: Ellipse {
                major: 1.1 * outline.major,
                minor: 1.1 * outline.minor,
                ..*outline
            },
            ratio: 0.5,
            sign: 1.0,
        },
        sigma_px: 0.8 * sigma_px,
        psf,
        linear: &linear,
    };
    measure_ring(frame, &start, &mut Workspace::default()).unwrap()
}

/// Where the changes are those of the model itself.
#[test]
fn the_gradient_from_kept_changes_is_that_of_the_normal_equations() {
    for blur in [
        Blur::gaussian(0.3),
        Blur::gaussian(2.0),
        Blur::gaussian(8.0),
        Blur::disc(6.0),
    ] {
        let scene = noisy(22.0, 110, &blur);
        let shape = true_shape(&scene);
        let model = RingModel {
            shape,
            blur,
            paper: 0.8,
            ring: 0.13,
            inside: 0.82,
            shading: [0.05, -0.1],
            sheet: None,
        };
        let frame = simulate::render(&scene, 3).unwrap().frame;
        let outline = shape.ellipse(1.0).unwrap();
        let linear = Linear::new(1.0, true);
        let mut window = window(&frame, &outline, blur.sigma_px(), 3.0, &linear).unwrap();
        window.keep(|x, y| x + y > 70.0);
        let problem = problem::Problem {
            window: &window,
            ratio: 0.5,
            around: None,
            noise: 0.0,
        };
        let mut room = Workspace::default();
        let normal = room.normal(&problem, &model).unwrap();
        let (gradient, squares) = room.gradient(&problem, &model).unwrap();
        assert!((squares / normal.squares - 1.0).abs() < 1e-5, "{blur:?}");
        for k in 0..model::RING_PARAMETERS {
            // beside what the residuals could make of it
            let most = (normal.matrix[(k, k)] * normal.squares).sqrt();
            let off = gradient[k] - normal.gradient[k];
            assert!(off.abs() < 1e-5 * most, "{blur:?} {k}: {off} of {most}");
        }
    }
}

#[test]
fn errors_are_those_of_the_bound_and_covariances_are_honest() {
    // heavy blur of both shapes; the disc of 13 px inverts the inner circle's contrast
    for blur in [Blur::gaussian(5.0), Blur::gaussian(8.0), Blur::disc(13.0)] {
        let scene = noisy(22.0, 110, &blur);
        let shape = true_shape(&scene);
        let outline = shape.ellipse(1.0).unwrap();
        let truth = RingModel {
            shape,
            blur,
            paper: 0.85,
            ring: 0.1,
            inside: 0.85,
            shading: [0.0; 2],
            sheet: None,
        };
        const TRIALS: u64 = 60;
        let (mut squares, mut normalised, mut bound) = (0.0, 0.0, 0.0);
        for seed in 0..TRIALS {
            let frame = simulate::render(&scene, seed).unwrap().frame;
            let choice = PsfChoice::Fixed(blur.psf);
            let fitted = measure(&frame, &outline, blur.sigma_px(), choice);
            let off = fitted.model.shape.centre - shape.centre;
            let inverse = fitted.centre_covariance().try_inverse().unwrap();
            squares += off.norm_squared();
            normalised += off.dot(&(inverse * off));
            if seed == 0 {
                let linear = Linear::new(1.0, true);
                let window = window(&frame, &outline, blur.sigma_px(), 3.0, &linear).unwrap();
                let noise = 0.01 / window.grid.pixel_px;
                let least = cramer_rao_bound(&window, &truth, 0.5, noise, false).unwrap();
                let known = cramer_rao_bound(&window, &truth, 0.5, noise, true).unwrap();
                bound = least.trace().sqrt();
                assert!(known.trace() < 0.6 * least.trace());
            }
        }
        let rmse = (squares / TRIALS as f64).sqrt();
        // 60 trials of two coordinates: either figure is known within about 10 %
        assert!(
            rmse < 1.25 * bound && rmse > 0.8 * bound,
            "{blur:?}: {rmse} {bound}"
        );
        let mean = normalised / TRIALS as f64;
        assert!((1.4..2.8).contains(&mean), "{blur:?}: {mean}");
    }
}

#[test]
fn likelihood_tells_a_disc_from_a_gaussian() {
    for blur in [Blur::disc(6.0), Blur::gaussian(3.0), Blur::disc(13.0)] {
        let scene = noisy(22.0, 110, &blur);
        let outline = true_shape(&scene).ellipse(1.0).unwrap();
        for seed in 0..3 {
            let frame = simulate::render(&scene, seed).unwrap().frame;
            let fitted = measure(&frame, &outline, blur.sigma_px(), PsfChoice::Auto);
            assert_eq!(fitted.model.blur.psf, blur.psf);
            assert!((fitted.model.blur.size_px / blur.size_px - 1.0).abs() < 0.06);
        }
    }
}

#[test]
fn without_noise_a_ring_is_found_exactly() {
    for blur in [Blur::gaussian(0.0), Blur::gaussian(3.0), Blur::disc(9.0)] {
        let mut scene = noisy(22.0, 110, &blur);
        scene.sensor.read_noise = 0.0;
        scene.light.shading = [0.3, -0.2];
        let shape = true_shape(&scene);
        let frame = simulate::render(&scene, 0).unwrap().frame;
        let outline = shape.ellipse(1.0).unwrap();
        let choice = PsfChoice::Fixed(blur.psf);
        let fitted = measure(&frame, &outline, blur.sigma_px().max(0.5), choice);
        let off = (fitted.model.shape.centre - shape.centre).norm();
        assert!(off < 3e-3, "{blur:?}: {off}");
    }
}

#[test]
fn over_exposed_paper_is_censored() {
    let blur = Blur::gaussian(3.0);
    let (mut censored, mut seeds) = (0.0, 0.0);
    for seed in 0..12 {
        let mut scene = noisy(22.0, 110, &blur);
        scene.light.paper = 1.05;
        let shape = true_shape(&scene);
        let frame = simulate::render(&scene, seed).unwrap().frame;
        let outline = shape.ellipse(1.0).unwrap();
        let fitted = measure(
            &frame,
            &outline,
            blur.sigma_px(),
            PsfChoice::Fixed(Psf::Gaussian),
        );
        let off = fitted.model.shape.centre - shape.centre;
        let inverse = fitted.centre_covariance().try_inverse().unwrap();
        censored += off.dot(&(inverse * off));
        seeds += 1.0;
        assert!(
            (fitted.model.blur.size_px - 3.0).abs() < 0.15,
            "{:?}",
            fitted.model
        );
        assert!(
            (fitted.model.inside - 1.05).abs() < 0.03,
            "{:?}",
            fitted.model
        );
    }
    assert!(censored / seeds < 5.0, "{}", censored / seeds);
}

#[test]
fn nothing_and_too_little_are_no_ring() {
    let linear = Linear::new(1.0, false);
    let frame = Frame::from_u8(crate::frame::Plane::filled(90, 80, 120), "");
    let seen = Seen {
        outline: Ellipse {
            centre: nalgebra::Point2::new(45.0, 40.0),
            major: 20.0,
            minor: 15.0,
            angle: 0.4,
        },
        ratio: 0.5,
        sign: 1.0,
    };
    let start = RingStart {
        seen,
        sigma_px: 2.0,
        psf: PsfChoice::Auto,
        linear: &linear,
    };
    let mut room = Workspace::default();
    assert!(measure_ring(&frame, &start, &mut room).is_err());
    let outline = Ellipse {
        centre: nalgebra::Point2::new(400.0, -300.0),
        ..seen.outline
    };
    let outside = RingStart {
        seen: Seen { outline, ..seen },
        ..start
    };
    let error = measure_ring(&frame, &outside, &mut room).unwrap_err();
    assert_eq!(error, RingError::Outside);
}
