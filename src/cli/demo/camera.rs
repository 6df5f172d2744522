//! The demonstration's camera: rendered frames as messages, and the truth about them.

use crate::board::Board;
use crate::camera::{Camera, Distortion, Intrinsics, PlumbBob, Pose};
use crate::frame::Pixels;
use crate::ros::messages::{Header, Image, Time};
use crate::simulate::{Defocus, Scene, Sensor, Truth, render, views};
use anyhow::bail;

/// Read noise, fraction of full scale.
const NOISE: f64 = 0.01;

/// Largest tilt of the board, degrees.
const TILT_DEGREES: f64 = 40.0;

/// What nobody tells the node.
const TRUTH: Camera = Camera {
    width: 1280,
    height: 960,
    intrinsics: Intrinsics {
        fx: 1110.0,
        fy: 1108.0,
        cx: 651.0,
        cy: 472.0,
    },
    distortion: Distortion::PlumbBob(PlumbBob {
        k1: -0.21,
        k2: 0.07,
        p1: 0.0008,
        p2: -0.0005,
        k3: 0.0,
    }),
};

/// One frame and the truth about it.
pub struct Shot {
    /// What is published.
    pub image: Image,
    /// What it shows.
    pub truth: Truth,
}

/// A camera out of focus before a board that is held at one place after the other.
pub struct SimulatedCamera {
    board: Board,
    poses: Vec<Pose>,
    blur_sigma_px: f64,
    seed: u64,
}

impl SimulatedCamera {
    /// A camera that sees `board` at `count` places.
    pub fn new(board: Board, count: usize, blur_sigma_px: f64, seed: u64) -> anyhow::Result<Self> {
        Ok(Self {
            poses: views(&TRUTH, &board, count, TILT_DEGREES.to_radians(), seed)?,
            board,
            blur_sigma_px,
            seed,
        })
    }

    /// The camera as it is.
    pub fn truth(&self) -> &'static Camera {
        &TRUTH
    }

    /// How many places the board is held at.
    pub fn views(&self) -> usize {
        self.poses.len()
    }

    /// Frame number `frame` of a view, 30 a second.
    pub fn take(&self, view: usize, frame: u64) -> anyhow::Result<Shot> {
        let scene = Scene {
            defocus: Defocus::gaussian(self.blur_sigma_px),
            sensor: Sensor {
                read_noise: NOISE,
                ..Sensor::default()
            },
            ..Scene::new(TRUTH, self.board.clone(), self.poses[view])
        };
        let number = 1000 * view as u64 + frame;
        let rendering = render(&scene, self.seed.wrapping_add(number << 32))?;
        let Pixels::U8(plane) = rendering.frame.pixels else {
            bail!("the simulated camera has 8 bit");
        };
        let stamp = Time {
            sec: 1 + i32::try_from(view)?,
            nanosec: u32::try_from(frame % 30)? * 33_333_333,
        };
        Ok(Shot {
            image: Image {
                header: Header {
                    stamp,
                    frame_id: "simulated_camera".to_owned(),
                },
                height: TRUTH.height,
                width: TRUTH.width,
                encoding: "mono8".to_owned(),
                is_bigendian: 0,
                step: TRUTH.width,
                data: plane.data().to_vec(),
            },
            truth: rendering.truth,
        })
    }
}
