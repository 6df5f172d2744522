//! From checked observations to a solution that everything which takes part agrees with.

use super::adjust::{Adjusted, Goal, adjust};
use super::below::charged;
use super::leverage::without_bending;
use super::observations::{Observation, observations};
use super::roll::Roll;
use super::shared::{Free, Shared, SheetShape};
use super::{CalibrateError, CalibrateOptions, NEEDED_VIEWS, guess, observed};
use crate::board::Board;
use crate::camera::Camera;
use crate::session::View;
use nalgebra::Point2;

/// What is estimated first: enough to bend any guess towards the truth, and never ill-determined among itself ...
const FIRST: [&str; 3] = ["fx", "fy", "k1"];
/// ... and then, where the lens has more coefficients than every set of views tells apart.
const SECOND: [&str; 8] = ["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"];

/// Times that outliers are looked for; each costs an adjustment only where something changed.
const ROUNDS: usize = 24;
/// The part of the views that may be left out because they bend the solution: where more do, it is the lens model that is bent.
const BENDING: f64 = 0.25;
/// Times that the predicted displacement of an estimator is renewed; it moves by a thousandth of itself from one to the next.
const PREDICTIONS: usize = 3;

/// An adjusted solution and what was free in it.
pub(super) struct Solved {
    pub adjusted: Adjusted,
    pub free: Free,
    pub fixed: Vec<&'static str>,
}

/// Refuses too few views.
fn enough(roll: &Roll) -> Result<(), CalibrateError> {
    let (left, given) = (roll.active().len(), roll.rings.len());
    if left >= NEEDED_VIEWS {
        return Ok(());
    }
    if left == given {
        return Err(CalibrateError::TooFewViews { found: left });
    }
    let reason = roll.left_out.iter().flatten().next();
    Err(CalibrateError::TooFewLeft {
        left,
        given,
        reason: reason.map_or_else(String::new, ToString::to_string),
    })
}

/// The solution of the views, whether or not they determine it, and which of them it rests on.
pub(super) fn solved(
    board: &Board,
    views: &[View],
    options: &CalibrateOptions,
) -> Result<(Solved, Roll), CalibrateError> {
    let mut roll = Roll::new(views, observations(board, views)?);
    enough(&roll)?;
    let solved = solve(board, views, &mut roll, options)?;
    Ok((solved, roll))
}

/// Adjusts, leaves out what contradicts, and adjusts again until nothing changes.
fn solve(
    board: &Board,
    views: &[View],
    roll: &mut Roll,
    options: &CalibrateOptions,
) -> Result<Solved, CalibrateError> {
    let pixels = |size: usize| u32::try_from(size).unwrap_or(u32::MAX);
    let size = (pixels(views[0].width), pixels(views[0].height));
    // asked first, so that a wrong name is said before anything is computed
    let fixed = options.fixed.in_model(options.model)?;
    if let Some(guess) = &options.guess {
        let guess = (guess.width, guess.height);
        if guess != size {
            return Err(CalibrateError::GuessSize {
                guess,
                frames: size,
            });
        }
    }
    if options.sheet.pitch_ratio && board.rows() == board.columns() && board.marks().is_empty() {
        return Err(CalibrateError::QuarterTurns);
    }
    let (camera, poses) = guess::guess(roll, size, options)?;
    for at in roll.active() {
        if poses[at].is_none() {
            roll.left_out[at] = Some(super::LeftOut::NoPose);
        }
    }
    roll.poses = poses;
    enough(roll)?;
    let mut free = Free::of(options, &camera, board)?;
    degrees_of_freedom(roll, &free)?;
    let mut shared = Shared {
        camera,
        sheet: SheetShape::default(),
        middle_m: board.middle_m(),
    };
    let unit = coarse(&mut shared, roll, &free)?;
    let straight = shared;
    let mut adjusted = charged(board, &mut shared, roll, (&mut free, options), unit)?;
    let most_bending = (BENDING * roll.active().len() as f64) as usize;
    let mut bending = 0;
    let mut taken_back = false;
    for _ in 0..ROUNDS {
        let mut changed = roll.judge(&shared);
        if !changed && bending < most_bending {
            let better = without_bending(board, &shared, roll, (&free, options), &adjusted)?;
            if let Some(better) = better {
                (shared, *roll, adjusted) = better;
                bending += 1;
                continue;
            }
        }
        if !changed && !taken_back {
            // once: a view may not come and go for ever
            taken_back = true;
            changed = roll.take_back(&shared);
        }
        if !changed {
            break;
        }
        enough(roll)?;
        degrees_of_freedom(roll, &free)?;
        adjusted = if free.is_charged() {
            // what outliers have bent has to begin anew, and is charged for less noise
            shared = straight;
            let unit = coarse(&mut shared, roll, &free)?;
            charged(board, &mut shared, roll, (&mut free, options), unit)?
        } else {
            exact(board, &mut shared, roll, (&free, options))?
        };
    }
    Ok(Solved {
        adjusted,
        free,
        fixed,
    })
}

/// The first stages, from any guess into the valley of the solution; answers with the mean squared residual.
fn coarse(shared: &mut Shared, roll: &mut Roll, free: &Free) -> Result<f64, CalibrateError> {
    let first = free.only(&FIRST, &shared.camera);
    let second = free.only(&SECOND, &shared.camera);
    let many = shared.camera.parameter_names().len() > SECOND.len() + 2;
    let stages = [Some(first), many.then_some(second)];
    let mut unit = 0.0;
    for stage in stages.into_iter().flatten() {
        let rings = roll.active_rings();
        let adjusted = adjust(roll.solution(*shared), &rings, &stage, Goal::Coarse)
            .ok_or(CalibrateError::NotConverged { iterations: 0 })?;
        *shared = adjusted.solution.shared;
        roll.stand(&adjusted.solution.poses);
        let counted = rings.iter().flatten().filter(|ring| ring.share > 0.0);
        unit = adjusted.equations.cost() / (2 * counted.count()).max(1) as f64;
    }
    Ok(unit)
}

/// Adjusts everything that is free to rounding, with what the estimators measure predicted from the solution itself.
pub(super) fn exact(
    board: &Board,
    shared: &mut Shared,
    roll: &mut Roll,
    (free, options): (&Free, &CalibrateOptions),
) -> Result<Adjusted, CalibrateError> {
    let mut last: Option<Adjusted> = None;
    for _ in 0..PREDICTIONS {
        let changed = observed::predict(
            board,
            shared,
            &roll.poses,
            &mut roll.rings,
            options.estimator,
        );
        if !changed && last.is_some() {
            break;
        }
        let rings = roll.active_rings();
        let goal = match &last {
            None => Goal::Exact,
            Some(_) => Goal::ExactFromNear,
        };
        let adjusted = adjust(roll.solution(*shared), &rings, free, goal)
            .ok_or(CalibrateError::NotConverged { iterations: 0 })?;
        *shared = adjusted.solution.shared;
        roll.stand(&adjusted.solution.poses);
        let settled = adjusted.iterations <= 1;
        last = Some(adjusted);
        if settled {
            break;
        }
    }
    last.ok_or(CalibrateError::NotConverged { iterations: 0 })
}

/// Numbers measured less numbers estimated.
pub(super) fn degrees_of_freedom(roll: &Roll, free: &Free) -> Result<f64, CalibrateError> {
    let active = roll.active();
    let measured = 2 * active.iter().map(|at| roll.counted(*at)).sum::<usize>();
    let unknown = free.len() + 6 * active.len();
    if measured <= unknown {
        return Err(CalibrateError::TooFewMeasurements { measured, unknown });
    }
    Ok((measured - unknown) as f64)
}

/// Mean squared whitened residual of a solution, at least that of negligible ones; infinite where nothing is left to judge it by.
pub(super) fn variance(solved: &Solved, roll: &Roll) -> f64 {
    let degrees = degrees_of_freedom(roll, &solved.free);
    degrees.map_or(f64::INFINITY, |degrees| {
        roll.variance(solved.adjusted.equations.squares() / degrees)
    })
}

/// A ring that took part and that the camera has no ray for, px.
pub(super) fn folded(camera: &Camera, rings: &[Vec<Observation>]) -> Option<Point2<f64>> {
    let counted = rings.iter().flatten().filter(|ring| ring.share > 0.0);
    counted
        .map(|ring| ring.pixel)
        .find(|pixel| camera.ray(pixel).is_none())
}
