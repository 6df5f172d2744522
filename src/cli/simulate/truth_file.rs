//! `truth.json`: the camera in the words of ROS, and each frame's pose, blur and rings.

use crate::camera::Camera;
use crate::simulate::{Defocus, Psf, Scene, Truth};
use serde::Serialize;

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
    parameters: Parameters,
}

#[derive(Debug, Serialize)]
struct Parameters {
    fx: f64,
    fy: f64,
    cx: f64,
    cy: f64,
    k1: f64,
    k2: f64,
    p1: f64,
    p2: f64,
    k3: f64,
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
        let (k, d) = (&camera.intrinsics, &camera.distortion);
        Self {
            camera: CameraTruth {
                model: "plumb_bob",
                width: camera.width,
                height: camera.height,
                parameters: Parameters {
                    fx: k.fx,
                    fy: k.fy,
                    cx: k.cx,
                    cy: k.cy,
                    k1: d.k1,
                    k2: d.k2,
                    p1: d.p1,
                    p2: d.p2,
                    k3: d.k3,
                },
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
