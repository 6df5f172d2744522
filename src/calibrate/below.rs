//! The numbers below the line of the rational model: how much freedom they get.

use super::adjust::Adjusted;
use super::roll::Roll;
use super::shared::{Free, Shared};
use super::solve::{degrees_of_freedom, exact, folded};
use super::{CalibrateError, CalibrateOptions};
use crate::board::Board;

/// Standard deviations that the last number below the line of the rational model is given at first, the freest first, ...
const BELOW: [f64; 5] = [10.0, 1.0, 0.1, 0.01, 0.001];
/// ... and what it is expected to have: lenses that need the model have numbers of about 1 there, and much more freedom than
/// that is a valley without a bottom.
const EXPECTED: f64 = 1.0;
/// Steps from the one to the other, and by how much the charge falls in one.
const LESSENED: usize = 8;
const STEP: f64 = 30.0;

/// Adjusts everything; of a rational lens with the smallest charge on the numbers below the line that leaves the lens one-to-one.
pub(super) fn charged(
    board: &Board,
    shared: &mut Shared,
    roll: &mut Roll,
    (free, options): (&mut Free, &CalibrateOptions),
    mut unit: f64,
) -> Result<Adjusted, CalibrateError> {
    let start = (*shared, roll.poses.clone());
    let mut last = None;
    for expected in BELOW {
        (*shared, roll.poses) = start.clone();
        let charge = roll.variance(unit) / (expected * expected);
        free.charge(&shared.camera, charge);
        let adjusted = exact(board, shared, roll, (free, options))?;
        if !free.is_charged() {
            return Ok(adjusted);
        }
        unit = adjusted.equations.squares() / degrees_of_freedom(roll, free)?;
        if sound(shared, roll, &adjusted) {
            return let_go(board, shared, roll, (free, options), (adjusted, charge));
        }
        last = Some(adjusted);
    }
    last.ok_or(CalibrateError::NotConverged { iterations: 0 })
}

/// Lessens a charge, which was for what the start could not explain, to one for the noise that is left; as far as the lens stays
/// one-to-one, and in steps, because the way at once leads through poles.
fn let_go(
    board: &Board,
    shared: &mut Shared,
    roll: &mut Roll,
    (free, options): (&mut Free, &CalibrateOptions),
    (mut adjusted, mut charge): (Adjusted, f64),
) -> Result<Adjusted, CalibrateError> {
    for _ in 0..LESSENED {
        let unit = adjusted.equations.squares() / degrees_of_freedom(roll, free)?;
        let wanted = roll.variance(unit) / (EXPECTED * EXPECTED);
        if (0.5..2.0).contains(&(wanted / charge)) {
            break;
        }
        charge = wanted.max(charge / STEP);
        let before = (*shared, roll.poses.clone(), free.clone());
        free.charge(&shared.camera, charge);
        match exact(board, shared, roll, (free, options)) {
            Ok(next) if next.converged && sound(shared, roll, &next) => adjusted = next,
            _ => {
                (*shared, roll.poses, *free) = before;
                break;
            }
        }
    }
    Ok(adjusted)
}

/// Whether a lens is one-to-one where rings are, and determined.
fn sound(shared: &Shared, roll: &Roll, adjusted: &Adjusted) -> bool {
    folded(&shared.camera, &roll.active_rings()).is_none() && adjusted.equations.inverse().is_ok()
}
