//! Views that bend the solution towards themselves: their residuals are small because the camera has given way.
//!
//! With few views, one of another board or with rows numbered wrongly may leave residuals everywhere and none that stands
//! out. So it is asked what is gained by leaving the view out altogether. With c its squares, S_v its part of the normal
//! equations and g_v its pull (its own pose eliminated, both), the squares of all views fall by
//!
//! ```text
//!     c + g_v' (S - S_v)^-1 g_v
//! ```
//!
//! were the residuals linear. That over its degrees of freedom, beside what is left over those that are left, is the ratio of
//! two variances and about 1 for a faultless view, whatever its leverage. The view with the largest ratio is named; whether
//! it is true is found out by an adjustment without it.

use super::adjust::Adjusted;
use super::normal_equations::NormalEquations;
use super::roll::Roll;
use super::shared::{Free, Shared};
use super::solve::{degrees_of_freedom, exact};
use super::{CalibrateError, CalibrateOptions, LeftOut, NEEDED_VIEWS};
use crate::board::Board;
use nalgebra::DMatrix;

/// Squares over degrees of freedom of a view over those of all others beyond which it is left out: four times in the residual.
pub(super) const WORSE: f64 = 16.0;

/// Numbers of a pose.
const POSE: f64 = 6.0;

/// A sum of squares and its degrees of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Squares {
    sum: f64,
    degrees: f64,
}

impl Squares {
    fn variance(&self) -> f64 {
        self.sum / self.degrees.max(1.0)
    }
}

/// How many times as large as that of the others the variance is of a view without which `all` is `rest`; no less than
/// `least` counts as a variance of the others.
fn ratio(all: Squares, rest: Squares, least: f64) -> f64 {
    let own = Squares {
        sum: all.sum - rest.sum,
        degrees: all.degrees - rest.degrees,
    };
    own.variance() / rest.variance().max(least)
}

/// The place among the views of the one that bends the solution most, where it may be beyond [`WORSE`]. `rings` counts those of
/// each view, `degrees` are the degrees of freedom of all.
fn suspect(
    equations: &NormalEquations,
    rings: &[usize],
    degrees: f64,
    least: f64,
) -> Option<usize> {
    let information = equations.information()?;
    let pulls = equations.pulls()?;
    let all = Squares {
        sum: equations.squares(),
        degrees,
    };
    let sum = equations.charges()
        + information.iter().fold(
            DMatrix::zeros(pulls.first()?.len(), pulls.first()?.len()),
            |sum, one| sum + one,
        );
    let squares = equations.view_squares();
    let ratios = (0..rings.len()).filter_map(|at| {
        let system = &sum - &information[at];
        let scale = system.diagonal().map(|d| 1.0 / d.sqrt());
        let scaled = DMatrix::from_fn(scale.len(), scale.len(), |i, j| {
            system[(i, j)] * scale[i] * scale[j]
        });
        let pull = pulls[at].component_mul(&scale);
        // views that cannot do without this one have nothing to hold against it
        let follow = pull.dot(&scaled.cholesky()?.solve(&pull));
        let rest = Squares {
            // less than nothing is left only where the residuals are far from linear
            sum: (all.sum - squares[at] - follow).max(0.0),
            degrees: all.degrees - (2 * rings[at]) as f64 + POSE,
        };
        (rest.degrees > 0.0).then(|| (at, ratio(all, rest, least)))
    });
    ratios
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|(_, ratio)| *ratio > WORSE)
        .map(|(at, _)| at)
}

/// The solution without the view that bends it most, where there is one.
pub(super) fn without_bending(
    board: &Board,
    shared: &Shared,
    roll: &Roll,
    (free, options): (&Free, &CalibrateOptions),
    adjusted: &Adjusted,
) -> Result<Option<(Shared, Roll, Adjusted)>, CalibrateError> {
    let degrees = degrees_of_freedom(roll, free)?;
    let active = roll.active();
    let rings: Vec<usize> = active.iter().map(|at| roll.counted(*at)).collect();
    let least = roll.variance(0.0);
    let place = suspect(&adjusted.equations, &rings, degrees, least);
    let Some(at) = place.filter(|_| active.len() > NEEDED_VIEWS) else {
        return Ok(None);
    };
    let (mut shared, mut without) = (*shared, roll.clone());
    without.left_out[active[at]] = Some(LeftOut::Noisy { times: f64::NAN });
    let Ok(rest) = degrees_of_freedom(&without, free) else {
        return Ok(None);
    };
    let better = exact(board, &mut shared, &mut without, (free, options))?;
    let squares = |sum, degrees| Squares { sum, degrees };
    let ratio = ratio(
        squares(adjusted.equations.squares(), degrees),
        squares(better.equations.squares(), rest),
        least,
    );
    without.left_out[active[at]] = Some(LeftOut::Noisy {
        times: ratio.sqrt(),
    });
    Ok((ratio > WORSE).then_some((shared, without, better)))
}
