//! One ring before the camera, and what an estimator makes of it.

use anyhow::{Context, Result};
use nalgebra::{Matrix3, Point2, Rotation3, Vector2, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use ringcal::board::{Board, Polarity};
use ringcal::camera::{Camera, Intrinsics, PlumbBob, Pose};
use ringcal::centre::Estimator;
use ringcal::centre::photometric::{Blur, RingModel, Shape, cramer_rao_bound, window};
use ringcal::detect::{DetectOptions, Detector};
use ringcal::frame::{Frame, Linear, Plane};
use ringcal::simulate::{Defocus, Scene, irradiance};

const FOCAL_PX: f64 = 800.0;
const OUTER_M: f64 = 0.1;
const RATIO: f64 = 0.5;
const PAPER: f64 = 0.875;
const RING: f64 = 0.125;
const TILTS_DEGREES: (f64, f64) = (45.0, 20.0);

/// A ring at one place of the frame: its light without noise, and the truth.
pub struct Place {
    light: Plane<f32>,
    shape: Shape,
    sigma_px: f64,
}

impl Place {
    /// The ring with an outer radius of about `outer_px`; `number` shifts it by fractions of a pixel.
    pub fn new(outer_px: f64, sigma_px: f64, number: usize) -> Result<Self> {
        let side = (2.6 * outer_px + 8.0 * sigma_px + 40.0) as u32;
        let middle = 0.5 * (f64::from(side) - 1.0);
        let intrinsics = Intrinsics {
            fx: FOCAL_PX,
            fy: FOCAL_PX,
            cx: middle,
            cy: middle,
        };
        let camera = Camera {
            width: side,
            height: side,
            intrinsics,
            distortion: PlumbBob::default().into(),
        };
        let depth_m = FOCAL_PX * OUTER_M / outer_px;
        let shift = |step: f64| (step * number as f64).fract() * depth_m / FOCAL_PX;
        let (roll, pitch) = TILTS_DEGREES;
        let pose = Pose {
            rotation: Rotation3::from_euler_angles(roll.to_radians(), pitch.to_radians(), 0.3),
            translation_m: Vector3::new(shift(0.381_966), shift(0.618_034), depth_m),
        };
        let mut scene = Scene::new(camera, board()?, pose);
        (scene.light.paper, scene.light.ring) = (PAPER, RING);
        scene.light.margin = f64::INFINITY;
        scene.light.texture = 0.0;
        scene.defocus = Defocus::gaussian(sigma_px);
        Ok(Self {
            light: irradiance(&scene)?,
            shape: shape(&scene).context("the ring is seen edge on")?,
            sigma_px,
        })
    }

    /// The frame with noise, 16 bit.
    pub fn frame(&self, noise: f64, seed: u64) -> Result<Frame> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let grey = self.light.data().iter().map(|light| {
            let normal: f64 = StandardNormal.sample(&mut random);
            let noisy = (f64::from(*light) + noise * normal).clamp(0.0, 1.0);
            (noisy * 65535.0).round() as u16
        });
        let plane = Plane::from_vec(self.light.width(), self.light.height(), grey.collect());
        Ok(Frame::from_u16(plane.context("size")?, "figure 10"))
    }

    /// Distance of an estimate from the truth, px; `None` where the ring is not found.
    pub fn error_px(&self, frame: &Frame, estimator: Estimator) -> Result<Option<f64>> {
        let options = DetectOptions {
            estimator,
            ..DetectOptions::default()
        };
        let found = Detector::new(board()?, options).detect(frame);
        let ring = found.ok().and_then(|d| d.rings.into_iter().next());
        Ok(ring.map(|ring| (ring.centre.point - self.shape.centre).norm()))
    }

    /// The Cramer-Rao bound of the distance, px; `None` where it does not exist.
    pub fn bound_px(&self, frame: &Frame, noise: f64) -> Option<f64> {
        let outline = self.shape.ellipse(1.0)?;
        let linear = Linear::new(1.0, false);
        let window = window(frame, &outline, self.sigma_px, 3.0, &linear)?;
        let model = RingModel {
            shape: self.shape,
            blur: Blur::gaussian(self.sigma_px),
            paper: PAPER,
            ring: RING,
            inside: PAPER,
            shading: [0.0; 2],
            sheet: None,
        };
        // a pixel of the window is the mean of many
        let noise = noise / window.grid.pixel_px;
        Some(
            cramer_rao_bound(&window, &model, RATIO, noise, false)?
                .trace()
                .sqrt(),
        )
    }
}

fn board() -> Result<Board> {
    Ok(Board::new(
        1,
        1,
        0.0,
        RATIO * OUTER_M,
        OUTER_M,
        Polarity::DarkOnLight,
    )?)
}

/// The ring's shape from camera and pose.
fn shape(scene: &Scene) -> Option<Shape> {
    let k = &scene.camera.intrinsics;
    let camera = Matrix3::new(k.fx, 0.0, k.cx, 0.0, k.fy, k.cy, 0.0, 0.0, 1.0);
    let rotation = scene.pose.rotation.matrix();
    let plane = Matrix3::from_columns(&[
        rotation.column(0) * OUTER_M,
        rotation.column(1) * OUTER_M,
        scene.pose.translation_m,
    ]);
    let centre = camera * scene.pose.translation_m;
    let back = (camera * plane).try_inverse()? * centre.z;
    let linear = back.fixed_view::<2, 2>(0, 0);
    let form = linear.tr_mul(&linear);
    Some(Shape {
        centre: Point2::new(centre.x / centre.z, centre.y / centre.z),
        affine: [form[(0, 0)], form[(0, 1)], form[(1, 1)]],
        perspective: -Vector2::new(back[(2, 0)], back[(2, 1)]),
    })
}
