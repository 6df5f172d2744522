//! A camera estimated from some views, and what other views would add to it.
//!
//! A view is held against the estimate first (`judge`), and only then asked what it adds (`design`): a view that is numbered wrongly
//! would have the most leverage of all.
//!
//! Views may be added and removed without solving again: at the same camera, the uncertainties are those of the views as they
//! are now.

use super::adjust::Solution;
use super::calibration::{Calibration, ViewFit};
use super::design::{self, Total};
use super::normal_equations::NormalEquations;
use super::observations::Observation;
use super::roll::LeftOut;
use super::shared::{Free, Shared};
use super::uncertainty::{Covariance, Range};
use super::{CalibrateError, CalibrateOptions};
use super::{conclude, solve};
use crate::board::Board;
use crate::camera::{Camera, Pose};
use crate::centre::Estimator;
use crate::session::View;
use nalgebra::DMatrix;

mod judge;

pub use judge::Unfit;

/// Cells of the frame, across and down, in whose middles the projection uncertainty is asked for.
pub const MAP_CELLS: (usize, usize) = (10, 10);

/// A view held against an estimate: where its board stands, and what it says of the camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Told {
    pose: Pose,
    rings: Vec<Observation>,
    information: DMatrix<f64>,
}

/// A camera estimated from some views.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// As it was solved; what is uncertain in it is that of the members.
    calibration: Calibration,
    shared: Shared,
    free: Free,
    estimator: Estimator,
    /// Variance of the whitened residuals, at least that of negligible ones.
    variance: f64,
    /// What the free numbers themselves are charged.
    charges: DMatrix<f64>,
    /// The views, in their order; `None` for one that the calibration left out.
    members: Vec<Option<Told>>,
    projection_std_px: Vec<Option<f64>>,
}

impl Estimate {
    /// Solves the camera from views.
    ///
    /// # Errors
    /// [`CalibrateError`] where they do not tell it.
    pub fn solve(
        board: &Board,
        views: &[View],
        options: &CalibrateOptions,
    ) -> Result<Self, CalibrateError> {
        let (solved, roll) = solve::solved(board, views, options)?;
        let (free, shared) = (solved.free.clone(), solved.adjusted.solution.shared);
        let information = solved.adjusted.equations.information();
        let mut information = information.unwrap_or_default().into_iter();
        let members = (0..views.len()).map(|at| {
            let active = roll.left_out[at].is_none();
            active.then(|| {
                let (pose, rings) = (roll.poses[at]?, roll.rings[at].clone());
                let information = information.next()?;
                Some(Told {
                    pose,
                    rings,
                    information,
                })
            })?
        });
        let members: Vec<Option<Told>> = members.collect();
        let charges = free.columns.iter().map(|column| column.charge);
        let charges = nalgebra::DVector::from_iterator(free.len(), charges);
        let concluding = roll.clone();
        let calibration = conclude::conclude(solved, roll, options)?;
        let mut estimate = Self {
            variance: concluding.variance(calibration.variance_factor),
            calibration,
            shared,
            free,
            estimator: options.estimator,
            charges: DMatrix::from_diagonal(&charges),
            members,
            projection_std_px: Vec::new(),
        };
        estimate.map();
        Ok(estimate)
    }

    /// The camera.
    pub fn camera(&self) -> &Camera {
        &self.calibration.camera
    }

    /// How many views take part.
    pub fn views_used(&self) -> usize {
        self.members.iter().flatten().count()
    }

    /// Whether the view at this place takes part.
    pub fn uses(&self, at: usize) -> bool {
        self.members.get(at).is_some_and(Option::is_some)
    }

    /// What the members say of the free numbers together.
    fn sum(&self) -> DMatrix<f64> {
        let members = self.members.iter().flatten();
        members.fold(self.charges.clone(), |sum, told| sum + &told.information)
    }

    /// What a view would add, nats: half the logarithm of the factor by which the volume of what is possible shrinks.
    pub fn gain_nats(&self, told: &Told) -> f64 {
        let total = Total::new(self.sum());
        total.map_or(0.0, |total| total.gain_nats(&told.information))
    }

    /// What a view would add that says as much as the members do on average, nats.
    pub fn average_gain_nats(&self) -> f64 {
        let views = self.views_used().max(1) as f64;
        0.5 * self.free.len() as f64 * (1.0 / views).ln_1p()
    }

    /// The member that would be missed least once `told` is there, and what would be won by the exchange, as a part of
    /// what that member tells; infinite where it tells nothing.
    pub fn least_useful(&self, told: &Told) -> Option<(usize, f64)> {
        let now = Total::new(self.sum())?;
        let gain = now.gain_nats(&told.information);
        let then = now.with(&told.information)?;
        let loss = |(at, member): (usize, &Option<Told>)| {
            let loss = member
                .as_ref()
                .map_or(0.0, |m| then.loss_nats(&m.information));
            (at, loss)
        };
        let losses = self.members.iter().enumerate().map(loss);
        let (at, loss) = losses.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let won = if loss > 0.0 {
            (gain - loss) / loss
        } else {
            f64::INFINITY
        };
        Some((at, won))
    }

    /// Standard deviation of fx by the members, px; 0 where it is not estimated.
    pub fn fx_std_px(&self) -> f64 {
        Total::new(self.sum()).map_or(f64::NAN, |total| self.fx_std_of(&total))
    }

    /// The same with one view more, px.
    pub fn fx_std_with_px(&self, told: &Told) -> f64 {
        let total = Total::new(self.sum() + &told.information);
        total.map_or(f64::NAN, |total| self.fx_std_of(&total))
    }

    fn fx_std_of(&self, total: &Total) -> f64 {
        // fx is the first parameter of every lens model
        let Some(place) = self.free.columns.iter().position(|column| column.at == 0) else {
            return 0.0;
        };
        let unit = total.std(place).unwrap_or(f64::NAN);
        unit * self.calibration.variance_factor.sqrt()
    }

    /// Projection uncertainty at infinity by the members, in the worst direction, px: in the middles of [`MAP_CELLS`] of the
    /// frame, by rows; `None` where the camera has no ray.
    pub fn projection_std_px(&self) -> &[Option<f64>] {
        &self.projection_std_px
    }

    /// The cell of [`MAP_CELLS`] that is least certain, and its projection uncertainty, px.
    pub fn least_certain(&self) -> Option<(usize, f64)> {
        let cells = self.projection_std_px.iter().enumerate();
        cells
            .filter_map(|(cell, std)| Some((cell, (*std)?)))
            .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))
    }

    /// Takes in another view, after the others.
    pub fn add(&mut self, told: Told) {
        self.members.push(Some(told));
        self.map();
    }

    /// Takes in another view, after the others, and puts out the one at `at`.
    pub fn exchange(&mut self, at: usize, told: Told) {
        if at < self.members.len() {
            self.members.remove(at);
        }
        self.add(told);
    }

    /// Computes the projection uncertainty for the members as they are.
    fn map(&mut self) {
        let uncertain = self.uncertain();
        let cells = MAP_CELLS.0 * MAP_CELLS.1;
        self.projection_std_px = match uncertain {
            Some(uncertain) => {
                let forecast = Calibration {
                    views: self.members.iter().map(bare_fit).collect(),
                    uncertain,
                    ..self.calibration.clone()
                };
                forecast.projection_std_map(MAP_CELLS, Range::Infinity)
            }
            None => vec![None; cells],
        };
    }

    fn uncertain(&self) -> Option<Covariance> {
        let members = || self.members.iter().flatten();
        let solution = Solution {
            shared: self.shared,
            poses: members().map(|told| told.pose).collect(),
        };
        let rings: Vec<Vec<Observation>> = members().map(|told| told.rings.clone()).collect();
        let equations = NormalEquations::at(&solution, &rings, &self.free)?;
        let mut next = 0..;
        let place = |told: &Option<Told>| told.as_ref().and_then(|_| next.next());
        Some(Covariance {
            inverse: equations.inverse().ok()?,
            camera: self.calibration.uncertain.camera.clone(),
            place: self.members.iter().map(place).collect(),
            free: self.free.clone(),
        })
    }
}

/// A fit that knows the pose alone.
fn bare_fit(told: &Option<Told>) -> ViewFit {
    ViewFit {
        pose: told.as_ref().map(|told| told.pose),
        residuals: Vec::new(),
        rings_used: Vec::new(),
        rms_px: 0.0,
        left_out: told.is_none().then_some(LeftOut::NoPose),
    }
}

/// The places of the views that tell most together, at most `count`, in their order. `None` is no candidate; one that `repeats` a
/// chosen one (chosen, candidate) is passed over; of equally good ones the first is taken.
pub fn most_informative(
    told: &[Option<Told>],
    count: usize,
    repeats: impl FnMut(usize, usize) -> bool,
) -> Vec<usize> {
    let candidates: Vec<_> = told
        .iter()
        .map(|told| told.as_ref().map(|told| &told.information))
        .collect();
    let mut chosen = design::greedy(&candidates, count, repeats);
    chosen.sort_unstable();
    chosen
}

#[cfg(test)]
mod tests;
