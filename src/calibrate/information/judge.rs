//! Whether a view agrees with an estimate.
//!
//! It is asked with its own pose alone: rings that stand apart from its others are left out, and a view whose residuals even a
//! camera changed within its uncertainty does not explain contradicts.

use super::{Estimate, Told};
use crate::board::Board;
use crate::calibrate::adjust::Solution;
use crate::calibrate::normal_equations::NormalEquations;
use crate::calibrate::observations::{Observation, observations};
use crate::calibrate::resect::settle;
use crate::calibrate::roll::{LeftOut, residual_px};
use crate::calibrate::{CalibrateError, NEEDED_RINGS, guess, start_homography};
use crate::camera::Pose;
use crate::session::View;
use nalgebra::DMatrix;

/// Chance that any ring of a faultless view is left out.
const CHANCE: f64 = 0.01;
/// The squared length of two standard normal numbers has this median.
const MEDIAN: f64 = 1.386_294_361_119_890_6;
/// Mean squared residual of a view over that of the estimate beyond which it contradicts it: four times in the residual, as
/// among the views of a calibration.
const WORSE: f64 = 16.0;
/// Times that the rings of a view are judged.
const ROUNDS: usize = 3;

/// Why a view cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Unfit {
    /// It contradicts the estimate.
    #[error("{0}")]
    Contradicts(LeftOut),
    /// It is not a view of this board.
    #[error(transparent)]
    Unusable(#[from] CalibrateError),
}

impl Estimate {
    /// Holds a view against the estimate.
    ///
    /// # Errors
    /// [`Unfit`] where it contradicts the estimate or is not of this board.
    pub fn judge(&self, board: &Board, view: &View) -> Result<Told, Unfit> {
        let rings = observations(board, std::slice::from_ref(view))?;
        let rings = rings.into_iter().next().unwrap_or_default();
        let of = rings.len();
        let (pose, rings) = self.settled(board, rings).map_err(Unfit::Contradicts)?;
        let out = rings.iter().filter(|ring| ring.share <= 0.0).count();
        if 2 * out > of || of - out < NEEDED_RINGS {
            return Err(Unfit::Contradicts(LeftOut::MostRings { out, of }));
        }
        let none = || Unfit::Contradicts(LeftOut::NoPose);
        let solution = Solution {
            shared: self.shared,
            poses: vec![pose],
        };
        let one = [rings];
        let equations = NormalEquations::at(&solution, &one, &self.free).ok_or_else(none)?;
        let information = equations
            .information()
            .and_then(|all| all.into_iter().next());
        let information = information.ok_or_else(none)?;
        let left = self
            .contradiction(&equations, &information)
            .ok_or_else(none)?;
        let degrees = (2 * (of - out)) as f64 - 6.0;
        let worse = left / (degrees.max(1.0) * self.variance);
        if worse > WORSE {
            let times = worse.sqrt();
            return Err(Unfit::Contradicts(LeftOut::Noisy { times }));
        }
        let [rings] = one;
        Ok(Told {
            pose,
            rings,
            information,
        })
    }

    /// The pose of a view with the camera as it is, without the rings that stand apart.
    fn settled(
        &self,
        board: &Board,
        mut rings: Vec<Observation>,
    ) -> Result<(Pose, Vec<Observation>), LeftOut> {
        let found = rings.len();
        if found < NEEDED_RINGS {
            return Err(LeftOut::TooFewRings { found });
        }
        start_homography::mark(&mut rings).ok_or(LeftOut::Degenerate)?;
        let mut pose = guess::pose(self.camera(), &rings).ok_or(LeftOut::NoPose)?;
        for _ in 0..ROUNDS {
            let settled = settle(board, &self.shared, &mut rings, (pose, self.estimator));
            pose = settled.ok_or(LeftOut::NoPose)?.0;
            if !self.judge_rings(&pose, &mut rings) {
                break;
            }
        }
        Ok((pose, rings))
    }

    /// Leaves out rings that stand apart from the others of their view, whose residuals may all be large where the camera is still
    /// uncertain; whether anything changed.
    fn judge_rings(&self, pose: &Pose, rings: &mut [Observation]) -> bool {
        let square = |ring: &Observation| {
            let residual = residual_px(&self.shared, pose, ring);
            residual.map_or(f64::INFINITY, |r| (ring.whitening * r).norm_squared())
        };
        let squares: Vec<f64> = rings.iter().map(square).collect();
        let mut sorted = squares.clone();
        sorted.sort_by(f64::total_cmp);
        let median = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
        let scale = (median / MEDIAN).max(self.variance);
        let limit = -2.0 * (CHANCE / squares.len().max(1) as f64).ln() * scale;
        let mut changed = false;
        for (ring, square) in rings.iter_mut().zip(squares) {
            // not a number is out
            let share = if square <= limit { 1.0 } else { 0.0 };
            changed |= share != ring.share;
            ring.share = share;
        }
        changed
    }

    /// Sum of the squared residuals that no change of the camera explains, when the change costs what the members say against
    /// it: c - g' (S + S_v)^-1 g.
    fn contradiction(
        &self,
        equations: &NormalEquations,
        information: &DMatrix<f64>,
    ) -> Option<f64> {
        let pull = equations.pulls()?.into_iter().next()?;
        if pull.is_empty() {
            return Some(equations.squares());
        }
        let system = self.sum() + information;
        let scale = system.diagonal().map(|d| 1.0 / d.sqrt());
        let scaled = DMatrix::from_fn(pull.len(), pull.len(), |i, j| {
            system[(i, j)] * scale[i] * scale[j]
        });
        let pull = pull.component_mul(&scale);
        let explained = pull.dot(&scaled.cholesky()?.solve(&pull));
        Some((equations.squares() - explained).max(0.0))
    }
}
