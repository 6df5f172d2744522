//! Where the board is held: at its distance, anywhere in the frame, tilted every way.

use anyhow::{Result, bail};
use nalgebra::{Point2, Rotation3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use ringcal::board::Board;
use ringcal::camera::{Camera, Pose};
use std::f64::consts::TAU;

/// Largest tilt against the optical axis, rad.
const MAX_TILT_RAD: f64 = 0.7;
/// Rotation about the optical axis goes up to this angle either way, rad.
const MAX_ROLL_RAD: f64 = 0.25;
/// The middle of the board is held at its distance within this share of it.
const DISTANCE_PLAY: f64 = 0.03;
/// Between the outermost rings and the border of the frame, px: room for paper and blur.
const MARGIN_PX: f64 = 120.0;
/// Places tried for one view.
const ATTEMPTS: usize = 10_000;
/// The golden angle: successive multiples spread evenly round the circle, rad.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// `count` poses in which the camera sees every ring; the same seed gives the same poses.
pub fn poses(
    camera: &Camera,
    board: &Board,
    distance_m: f64,
    count: usize,
    seed: u64,
) -> Result<Vec<Pose>> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let first = random.random_range(0.0..TAU);
    (0..count)
        .map(|view| {
            let direction = first + GOLDEN_ANGLE * view as f64;
            // every third of the range of tilts in turn
            let third = (view % 3) as f64;
            let tilt = MAX_TILT_RAD * (1.0 - (third + random.random_range(0.0..1.0)) / 3.6);
            let roll = random.random_range(-MAX_ROLL_RAD..MAX_ROLL_RAD);
            let rotation = Rotation3::new(Vector3::z() * roll)
                * Rotation3::new(Vector3::new(direction.cos(), direction.sin(), 0.0) * tilt);
            let depth_m =
                distance_m * random.random_range(1.0 - DISTANCE_PLAY..1.0 + DISTANCE_PLAY);
            place(camera, board, rotation, depth_m, &mut random)
        })
        .collect()
}

/// The board's middle on the ray through a pixel that is drawn until all rings are in the frame.
fn place(
    camera: &Camera,
    board: &Board,
    rotation: Rotation3<f64>,
    depth_m: f64,
    random: &mut ChaCha8Rng,
) -> Result<Pose> {
    let (width, height) = (f64::from(camera.width), f64::from(camera.height));
    let [x, y] = board.middle_m();
    for _ in 0..ATTEMPTS {
        let pixel = Point2::new(
            random.random_range(0.0..width),
            random.random_range(0.0..height),
        );
        let Some(ray) = camera.unproject(&pixel) else {
            continue;
        };
        let pose = Pose {
            rotation,
            translation_m: Vector3::new(ray.x, ray.y, 1.0) * depth_m
                - rotation * Vector3::new(x, y, 0.0),
        };
        if is_inside(camera, board, &pose) {
            return Ok(pose);
        }
    }
    bail!("the board does not fit into the frame at {depth_m:.2} m")
}

/// Whether every ring is in the frame, with some room.
fn is_inside(camera: &Camera, board: &Board, pose: &Pose) -> bool {
    let radius_px = camera.intrinsics.fx * board.outer_radius_m() / pose.translation_m.z;
    let room = MARGIN_PX + radius_px;
    let (right, bottom) = (
        f64::from(camera.width) - room,
        f64::from(camera.height) - room,
    );
    board.indices().all(|(row, column)| {
        let point = pose.board_to_camera(board.centre_m(row, column));
        camera
            .project(&point)
            .is_some_and(|p| p.x > room && p.x < right && p.y > room && p.y < bottom)
    })
}
