//! What is rendered: camera, board, pose, defocus, light and sensor, with defaults that give an ordinary frame.

use super::defocus::Defocus;
use crate::board::{Board, Polarity};
use crate::camera::{Camera, Pose};

/// The light that comes from the scene, linear, as a fraction of full scale; above 1 it over-exposes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Paper between the rings and around them.
    pub paper: f64,
    /// Rings.
    pub ring: f64,
    /// Mean of what is around the paper.
    pub background: f64,
    /// Amplitude of the smooth pattern of the background.
    pub texture: f64,
    /// Width of the paper beyond the outermost rings, in outer radii; infinite where paper fills the frame.
    pub margin: f64,
    /// Relative change of light from the left edge to the right and from the top to the bottom; 1 in the middle.
    pub shading: [f64; 2],
}

impl Default for Light {
    fn default() -> Self {
        Self {
            paper: 0.85,
            ring: 0.10,
            background: 0.45,
            texture: 0.03,
            margin: 1.5,
            shading: [0.0, 0.0],
        }
    }
}

impl Light {
    /// Ordinary light on a board of this polarity (`Auto` is taken as dark on light).
    pub fn on(polarity: Polarity) -> Self {
        match polarity {
            Polarity::DarkOnLight | Polarity::Auto => Self::default(),
            Polarity::LightOnDark => Self {
                paper: 0.10,
                ring: 0.85,
                ..Self::default()
            },
        }
    }

    /// Light of the background at a pixel: a few long waves, already out of focus.
    pub(super) fn background_at(&self, waves: &Waves, x: usize, y: usize) -> f64 {
        let [a, b] = waves.across[x];
        let [c, d] = waves.down[y];
        self.background + 0.5 * self.texture * (a * c + b * d)
    }

    /// Factor of the shading at a place in the frame, both coordinates in 0..1.
    pub(super) fn shade(&self, across: f64, down: f64) -> f64 {
        1.0 + self.shading[0] * (across - 0.5) + self.shading[1] * (down - 0.5)
    }
}

/// The pattern of the background as products of one wave across the frame and one down.
#[derive(Debug)]
pub(super) struct Waves {
    across: Vec<[f64; 2]>,
    down: Vec<[f64; 2]>,
}

impl Waves {
    /// The waves over a frame of this size.
    pub(super) fn new(width: usize, height: usize) -> Self {
        let wave = |step: [f64; 2], phase: f64| {
            move |i: usize| step.map(|step| (step * i as f64 + phase).sin())
        };
        Self {
            across: (0..width).map(wave([0.021, 0.043], 0.4)).collect(),
            down: (0..height).map(wave([0.017, 0.037], 1.9)).collect(),
        }
    }
}

/// Bits of a grey value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum BitDepth {
    /// 0 to 255.
    #[default]
    Eight,
    /// 0 to 65535.
    Sixteen,
}

/// What the sensor makes of light. Order: shot noise, read noise, clipping at full scale, response, quantisation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensor {
    /// Bits of a grey value.
    pub depth: BitDepth,
    /// Standard deviation of the read noise, fraction of full scale (of light).
    pub read_noise: f64,
    /// Electrons at full scale, for shot noise; none where there is no shot noise.
    pub full_well_electrons: Option<f64>,
    /// Response: grey is light to the power of 1 / gamma, both 0..1.
    pub gamma: f64,
}

impl Default for Sensor {
    fn default() -> Self {
        Self {
            depth: BitDepth::Eight,
            read_noise: 0.0,
            full_well_electrons: None,
            gamma: 1.0,
        }
    }
}

/// All there is to a frame but the noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The camera.
    pub camera: Camera,
    /// The board it looks at.
    pub board: Board,
    /// Where the board stands before the camera.
    pub pose: Pose,
    /// How far out of focus it is.
    pub defocus: Defocus,
    /// The light from it.
    pub light: Light,
    /// What takes the light.
    pub sensor: Sensor,
}

impl Scene {
    /// A sharp, noiseless 8-bit scene in ordinary light.
    pub fn new(camera: Camera, board: Board, pose: Pose) -> Self {
        Self {
            light: Light::on(board.polarity()),
            camera,
            board,
            pose,
            defocus: Defocus::None,
            sensor: Sensor::default(),
        }
    }
}

/// Why a scene cannot be rendered.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// A value is not finite or out of its range.
    #[error("{name} must be {needed}, not {value}")]
    Value {
        /// What it is.
        name: &'static str,
        /// The value found.
        value: f64,
        /// What it has to be.
        needed: &'static str,
    },
    /// A part of the board is beside or behind the camera.
    #[error("the board reaches behind the camera at x = {x_m} m, y = {y_m} m on the board")]
    BehindCamera {
        /// The place on the board, m.
        x_m: f64,
        /// The place on the board, m.
        y_m: f64,
    },
    /// The camera looks at the back of the board.
    #[error("the camera sees the board from behind or edge on")]
    FromBehind,
    /// The lens spreads a point of the board over more than a frame.
    #[error("the blur of the board at {depth_m} m is {size_px} px; at most 1000 px are rendered")]
    Blur {
        /// Depth of the place on the board, m.
        depth_m: f64,
        /// Size of the blur there, px.
        size_px: f64,
    },
    /// The board is so near that an outline is many frames long.
    #[error("an outline on the board is {length_px:.0} px long; the board is too near")]
    TooNear {
        /// Length of the outline in the picture, px.
        length_px: f64,
    },
    /// The lens model is not one-to-one where the board is.
    #[error("the lens model folds over at x = {x_m} m, y = {y_m} m on the board")]
    Folded {
        /// The place on the board, m.
        x_m: f64,
        /// The place on the board, m.
        y_m: f64,
    },
}

/// Larger blur than any frame needs; it bounds the work a value can ask for, px.
pub(super) const MAX_SIZE_PX: f64 = 1000.0;

impl Scene {
    /// Whether all values are in range.
    pub(super) fn check(&self) -> Result<(), SceneError> {
        let need = |name, value: f64, ok: bool, needed| {
            if ok {
                Ok(())
            } else {
                Err(SceneError::Value {
                    name,
                    value,
                    needed,
                })
            }
        };
        let positive = |name, value: f64| {
            let ok = value.is_finite() && value > 0.0;
            need(name, value, ok, "finite and positive")
        };
        let not_negative = |name, value: f64| {
            let ok = value.is_finite() && value >= 0.0;
            need(name, value, ok, "finite and not negative")
        };
        let camera = &self.camera;
        for (name, size) in [("width", camera.width), ("height", camera.height)] {
            let ok = (1..=65_536).contains(&size);
            need(name, f64::from(size), ok, "1 to 65536 px")?;
        }
        let k = &camera.intrinsics;
        positive("fx", k.fx)?;
        positive("fy", k.fy)?;
        let (r, t) = (self.pose.rotation_vector(), self.pose.translation_m);
        let pose = [r.x, r.y, r.z, t.x, t.y, t.z];
        for value in camera.parameters().into_iter().chain(pose) {
            let ok = value.is_finite();
            need("each number of camera and pose", value, ok, "finite")?;
        }
        match self.defocus {
            Defocus::None => {}
            Defocus::Uniform { size_px, .. } => {
                let ok = (0.0..=MAX_SIZE_PX).contains(&size_px);
                need("size of the blur", size_px, ok, "0 to 1000 px")?;
            }
            Defocus::ThinLens { lens, .. } => {
                positive("f-number", lens.f_number)?;
                positive("focal length", lens.focal_length_m)?;
                positive("pixel size", lens.pixel_m)?;
                let beyond = lens.focus_m.is_finite() && lens.focus_m > lens.focal_length_m;
                let needed = "finite and more than the focal length";
                need("focus distance", lens.focus_m, beyond, needed)?;
            }
        }
        let light = &self.light;
        not_negative("paper", light.paper)?;
        not_negative("ring", light.ring)?;
        not_negative("background", light.background)?;
        not_negative("texture", light.texture)?;
        let reaches = light.margin >= 0.0;
        need("margin", light.margin, reaches, "0 or more outer radii")?;
        for value in light.shading {
            let ok = value.abs() <= 1.0;
            need("shading", value, ok, "-1 to 1")?;
        }
        let sensor = &self.sensor;
        not_negative("read noise", sensor.read_noise)?;
        positive("gamma", sensor.gamma)?;
        sensor
            .full_well_electrons
            .map_or(Ok(()), |electrons| positive("full well", electrons))
    }
}
