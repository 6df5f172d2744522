//! The frames of one board: rendered, detected and dropped; what stays is where the rings were found and where they are.

use crate::Settings;
use crate::bound;
use crate::paper::{FOCUS_M, PIXEL_MM, Target, truth};
use crate::poses::poses;
use anyhow::Result;
use nalgebra::Matrix2;
use rayon::prelude::*;
use ringcal::board::Board;
use ringcal::camera::Pose;
use ringcal::centre::Estimator;
use ringcal::detect::{DetectOptions, Detection, Detector};
use ringcal::session::View;
use ringcal::simulate::{Defocus, Psf, Scene, Sensor, ThinLens, Truth, render};

/// Read noise, fraction of full scale.
const NOISE: f64 = 0.005;

/// What was found in one frame, and the truth about it.
pub struct Shot {
    pub truth: Truth,
    /// How well each ring's centre could be known, px^2.
    pub bounds: Vec<Matrix2<f64>>,
    /// By the default estimator.
    pub photometric: Option<View>,
    /// By the paper's construction.
    pub cross: Option<View>,
}

impl Shot {
    /// The centres of the small ellipses that the paper's construction starts from.
    pub fn small_ellipse(&self) -> Option<View> {
        let construction = Estimator::SmallEllipse.construction()?;
        let mut view = self.cross.clone()?;
        view.rings
            .retain_mut(|ring| match construction.estimate(&ring.ellipses) {
                Ok(centre) => {
                    ring.centre = centre;
                    true
                }
                Err(_) => false,
            });
        Some(view)
    }
}

/// The thin lens whose image distance is the truth's focal length, focused at the paper's distance.
pub fn lens(f_number: f64) -> ThinLens {
    let pixel_m = 1e-3 * PIXEL_MM;
    let image_m = truth().intrinsics.fx * pixel_m;
    ThinLens {
        f_number,
        focal_length_m: 1.0 / (1.0 / image_m + 1.0 / FOCUS_M),
        pixel_m,
        focus_m: FOCUS_M,
    }
}

/// All frames of one board.
pub fn take(target: &Target, seed: u64, settings: &Settings) -> Result<Vec<Shot>> {
    let board = target.board()?;
    let poses = poses(&truth(), &board, target.distance_m, settings.views, seed)?;
    let all = poses.into_par_iter().enumerate();
    all.map(|(i, pose)| {
        let noise_seed = 1000 * seed + i as u64;
        shoot(target, &board, pose, settings, noise_seed)
    })
    .collect()
}

fn shoot(
    target: &Target,
    board: &Board,
    pose: Pose,
    settings: &Settings,
    noise_seed: u64,
) -> Result<Shot> {
    let mut scene = Scene::new(truth(), board.clone(), pose);
    scene.light.margin = target.margin(board);
    let lens = lens(settings.f_number);
    scene.defocus = if settings.even_blur {
        Defocus::disc(lens.radius_px(target.distance_m).abs())
    } else {
        let psf = Psf::Disc;
        Defocus::ThinLens { psf, lens }
    };
    scene.sensor = Sensor {
        read_noise: NOISE,
        ..Sensor::default()
    };
    let rendering = render(&scene, noise_seed)?;
    let found = |estimator| -> Option<Detection> {
        let options = DetectOptions {
            estimator,
            ..DetectOptions::default()
        };
        let detector = Detector::new(board.clone(), options);
        detector.detect(&rendering.frame).ok()
    };
    let view = |estimator| Some(View::of_file(format!("{noise_seed}"), &found(estimator)?));
    Ok(Shot {
        photometric: view(Estimator::Photometric),
        cross: view(Estimator::Cross),
        bounds: bound::centres(&scene, &rendering.frame, &rendering.truth)?,
        truth: rendering.truth,
    })
}
