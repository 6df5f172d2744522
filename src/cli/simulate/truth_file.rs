//! `truth.json`: the camera in the words of ROS, and each frame's pose, blur and rings.

use crate::camera::Camera;
use crate::simulate::{Defocus, Psf, Scene, Truth};
use serde::Serialize;
use std::collections::BTreeMap;

/// The whole file.
#[derive(Debug, Serialize)]
pub struct TruthFile {
    camera: CameraTruth,
    /// One for each frame, in the order of their names.
    pub views: Vec<ViewTruth>,
}

#[derive(Debug, Serialize)]
struct CameraTruth {
    model: &'static str,
    width: u32,
    height: u32,
    parameters: BTreeMap<&'static str, f64>,
}

/// One frame.
#[derive(Debug, Serialize)]
pub struct ViewTruth {
    source: String,
    rotation_vector: [f64; 3],
    translation_m: [f64; 3],
    blur: Blur,
    rings: Vec<Ring>,
}

#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum Blur {
    None,
    Uniform {
        psf: &'static str,
        size_px: f64,
    },
    ThinLens {
        psf: &'static str,
        f_number: f64,
        focal_length_m: f64,
        pixel_m: f64,
        focus_m: f64,
    },
}

#[derive(Debug, Serialize)]
struct Ring {
    row: u16,
    col: u16,
    x: f64,
    y: f64,
    blur_sigma: f64,
}

impl TruthFile {
    /// A file about frames of this camera, without frames yet.
    pub fn new(camera: &Camera) -> Self {
        let names = camera.parameter_names().iter().copied();
        Self {
            camera: CameraTruth {
                model: camera.model().name(),
                width: camera.width,
                height: camera.height,
                parameters: names.zip(camera.parameters()).collect(),
            },
            views: Vec::new(),
        }
    }
}

impl ViewTruth {
    /// The frame of this name.
    pub fn new(source: &str, scene: &Scene, truth: &Truth) -> Self {
        let rings = truth.rings.iter().map(|ring| Ring {
            row: ring.row,
            col: ring.column,
            x: ring.centre.x,
            y: ring.centre.y,
            blur_sigma: ring.blur_sigma_px,
        });
        Self {
            source: source.to_string(),
            rotation_vector: truth.pose.rotation_vector().into(),
            translation_m: truth.pose.translation_m.into(),
            blur: Blur::of(&scene.defocus),
            rings: rings.collect(),
        }
    }
}

impl Blur {
    fn of(defocus: &Defocus) -> Self {
        let word = |psf: Psf| match psf {
            Psf::Gaussian => "gaussian",
            Psf::Disc => "disc",
        };
        match *defocus {
            Defocus::None => Self::None,
            Defocus::Uniform { psf, size_px } => Self::Uniform {
                psf: word(psf),
                size_px,
            },
            Defocus::ThinLens { psf, lens } => Self::ThinLens {
                psf: word(psf),
                f_number: lens.f_number,
                focal_length_m: lens.focal_length_m,
                pixel_m: lens.pixel_m,
                focus_m: lens.focus_m,
            },
        }
    }
}
