//! The bundle adjustment: Levenberg and Marquardt's damped least squares.
//!
//! It has converged where the undamped step promises to lower the cost (the sum of the squared whitened residuals) by less
//! than 1e-12 of it, or by less than rounding leaves of residuals that vanish: (1e-11)^2 times the number of residuals.
//! It gives up after 200 iterations, or where no damping lowers the cost any more while the promise is still large.

use super::normal_equations::NormalEquations;
use super::observations::Observation;
use super::shared::{Free, Shared};
use crate::camera::Pose;

/// Linearisations at most.
const MAX_ITERATIONS: usize = 200;
/// Promised decrease over cost at which it has converged.
const RELATIVE_DECREASE: f64 = 1e-12;
/// The same for a solution that another adjustment starts from.
const COARSE_DECREASE: f64 = 1e-2;
/// The same where rounding stops the descent first.
const RELATIVE_ROUNDING: f64 = 1e-8;
/// The same for a solution that others are predicted from, ...
const PREDICTION_DECREASE: f64 = 1e-7;
/// ... and its linearisations at most: what takes more predicts nothing.
const PREDICTION_ITERATIONS: usize = 12;
/// Promised decrease over the mean squared residual at which it is close enough when it has not converged.
const CLOSE: f64 = 1e-4;
/// Whitened residual that counts as none.
const NO_RESIDUAL: f64 = 1e-11;
/// Damping at first, relative to the scaled diagonal.
const FIRST_DAMPING: f64 = 1e-3;
/// The same where it starts next to a solution: then the first step goes all the way.
const NEAR_DAMPING: f64 = 1e-9;
/// Damping beyond which a step moves nothing.
const MAX_DAMPING: f64 = 1e12;

/// What all views share, and the pose of each.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Solution {
    pub shared: Shared,
    pub poses: Vec<Pose>,
}

/// Where the adjustment ended.
#[derive(Debug, Clone)]
pub(super) struct Adjusted {
    pub solution: Solution,
    /// At `solution`.
    pub equations: NormalEquations,
    pub iterations: usize,
    pub converged: bool,
}

/// How well an adjustment has to converge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Goal {
    /// Another adjustment starts from it.
    Coarse,
    /// To rounding.
    Exact,
    /// To rounding, from where another one ended and little has changed since.
    ExactFromNear,
    /// To a thousandth of a standard deviation or so, in a few steps from where another one ended: to be predicted from.
    Prediction,
}

/// Lowers the cost over the free numbers and all poses; `None` where a ring has no image at the start.
pub(super) fn adjust(
    start: Solution,
    rings: &[Vec<Observation>],
    free: &Free,
    goal: Goal,
) -> Option<Adjusted> {
    let mut now = Adjusted {
        equations: NormalEquations::at(&start, rings, free)?,
        solution: start,
        iterations: 0,
        converged: false,
    };
    let residuals = 2 * rings.iter().map(Vec::len).sum::<usize>();
    let nothing = residuals as f64 * NO_RESIDUAL * NO_RESIDUAL;
    let (enough, mut damping) = match goal {
        Goal::Coarse => (COARSE_DECREASE, FIRST_DAMPING),
        Goal::Exact => (RELATIVE_DECREASE, FIRST_DAMPING),
        Goal::ExactFromNear => (RELATIVE_DECREASE, NEAR_DAMPING),
        Goal::Prediction => (PREDICTION_DECREASE, NEAR_DAMPING),
    };
    let most = match goal {
        Goal::Prediction => PREDICTION_ITERATIONS,
        _ => MAX_ITERATIONS,
    };
    while now.iterations < most {
        now.iterations += 1;
        let cost = now.equations.cost();
        // the promise of the undamped step: a damped one promises little however far the solution is
        let promise = now.equations.step(0.0).map(|step| step.predicted);
        if promise.is_some_and(|p| p <= nothing.max(enough * cost)) {
            now.converged = true;
            break;
        }
        match lower(&now, rings, free, &mut damping) {
            Some(next) => now = next,
            None => {
                now.converged = promise.is_some_and(|p| p <= RELATIVE_ROUNDING * cost);
                break;
            }
        }
    }
    if !now.converged {
        now.converged = is_close(&now.equations, residuals);
    }
    Some(now)
}

/// Whether what is left to be gained is a hundredth of a standard deviation: numbers that the views hardly tell apart may move
/// along a valley for ever.
fn is_close(equations: &NormalEquations, residuals: usize) -> bool {
    let promise = equations.step(0.0).map(|step| step.predicted);
    let unit = equations.cost() / residuals.max(1) as f64;
    promise.is_some_and(|promise| promise <= CLOSE * unit)
}

/// The first damping that lowers the cost; `None` where none does.
fn lower(
    now: &Adjusted,
    rings: &[Vec<Observation>],
    free: &Free,
    damping: &mut f64,
) -> Option<Adjusted> {
    let cost = now.equations.cost();
    while *damping <= MAX_DAMPING {
        if let Some(step) = now.equations.step(*damping) {
            let solution = step.apply(&now.solution, free);
            let next = NormalEquations::at(&solution, rings, free);
            if let Some(equations) = next.filter(|equations| equations.cost() < cost) {
                // Nielsen's rule: less damping after a step that kept its promise, more after one that overshot, or the
                // steps swing from side to side of a curved valley
                let gain = (cost - equations.cost()) / step.predicted;
                *damping *= (1.0 - (2.0 * gain - 1.0).powi(3)).clamp(0.1, 2.0);
                *damping = damping.max(1e-15);
                return Some(Adjusted {
                    solution,
                    equations,
                    iterations: now.iterations,
                    converged: false,
                });
            }
        }
        *damping *= 10.0;
    }
    None
}
