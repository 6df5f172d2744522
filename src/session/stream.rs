//! A hand that carries a board before a camera, for tests.

use super::View;
use crate::board::Board;
use crate::calibrate::synthetic::{pose_at, views};
use crate::camera::{Camera, Pose};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Views with 0.1 px of noise, most of them of a board held almost upright in the middle, as a hand holds it; a fifth anywhere and
/// tilted by up to 40 degrees.
pub fn stream(camera: &Camera, board: &Board, count: usize, seed: u64) -> Vec<View> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let poses: Vec<Pose> = (0..count)
        .map(|at| {
            let wide = if at % 5 == 0 { 1.0 } else { 0.3 };
            let mut within = |range: f64| wide * random.random_range(-range..range);
            let (width, height) = (f64::from(camera.width), f64::from(camera.height));
            let pixel = [width * (0.5 + within(0.28)), height * (0.5 + within(0.24))];
            let turn = [within(0.7), within(0.7), within(0.3)];
            let fill = 0.45 + within(0.12);
            pose_at(camera, board, pixel, fill, turn)
        })
        .collect();
    views(camera, board, &poses, 0.1, seed)
}

/// The view as a detector shows it that missed a row of rings: all rows from `row` on are numbered one too low.
pub fn misnumbered(view: &View, row: u16) -> View {
    let mut wrong = view.clone();
    wrong.rings.retain(|ring| ring.row != row);
    for ring in &mut wrong.rings {
        ring.row -= u16::from(ring.row > row);
    }
    wrong
}

/// `count` different places below `of`, in their order.
pub fn random_places(of: usize, count: usize, seed: u64) -> Vec<usize> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut places: Vec<usize> = (0..of).collect();
    for at in 0..count {
        places.swap(at, random.random_range(at..of));
    }
    places.truncate(count);
    places.sort_unstable();
    places
}
