//! There is no negative light.
//!
//! Under blur as large as the ring its pixels hardly tell a ring from a smaller one of more contrast whose inner disc is darker than
//! black (or which is itself). What the skirts of its neighbours add, before those are known, leads a fit far along that valley. So
//! levels below zero are pushed back, by a spring that is stiff against the pixels: a wall. The covariance does not know of it.

use super::model::{INSIDE, Matrix, PAPER, RING, Vector};

/// The spring's strength over that of the pixels, which see the level through the coverage.
const STIFFNESS: f64 = 0.03;
/// The levels of light among the parameters.
const LEVELS: [usize; 3] = [PAPER, RING, INSIDE];

/// The wall at zero for each level.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wall([f64; LEVELS.len()]);

impl Wall {
    /// For pixels of this normal matrix.
    pub(super) fn of(matrix: &Matrix) -> Self {
        Self(LEVELS.map(|k| STIFFNESS * matrix[(k, k)]))
    }

    /// Adds the push to the gradient; returns what the springs add to the sum of squares.
    pub(super) fn push(&self, parameters: &Vector, gradient: &mut Vector) -> f64 {
        let mut squares = 0.0;
        for (k, stiffness) in LEVELS.into_iter().zip(self.0) {
            let below = parameters[k].min(0.0);
            gradient[k] -= stiffness * below;
            squares += stiffness * below * below;
        }
        squares
    }

    /// Adds the springs to the normal matrix.
    pub(super) fn stiffen(&self, parameters: &Vector, matrix: &mut Matrix) {
        for (k, stiffness) in LEVELS.into_iter().zip(self.0) {
            if parameters[k] < 0.0 {
                matrix[(k, k)] += stiffness;
            }
        }
    }
}
