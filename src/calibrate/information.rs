//! A camera estimated from some views, and what other views would add to it.
//!
//! A view is held against the estimate first, with its own pose alone: rings that stand apart from its others are left out, and
//! a view whose residuals even a camera changed within its uncertainty does not explain says nothing. Only then is it asked what it
//! adds (`design`): a view that is numbered wrongly would have the most leverage of all.
//!
//! Views may be added and removed without solving again: at the same camera, the uncertainties are those of the views as they
//! are now.

use super::adjust::Solution;
use super::calibration::{Calibration, ViewFit};
use super::design::{self, Total};
use super::normal_equations::NormalEquations;
use super::observations::{Observation, observations};
use super::resect::settle;
use super::roll::{LeftOut, Roll, residual_px};
use super::shared::{Free, Shared};
use super::solve;
use super::uncertainty::{Covariance, Range};
use super::{CalibrateError, CalibrateOptions, NEEDED_RINGS, guess, start_homography};
use crate::board::Board;
use crate::camera::{Camera, Pose};
use crate::centre::Estimator;
use crate::session::View;
use nalgebra::DMatrix;

/// Cells of the frame, across and down, in whose middles the projection uncertainty is asked for.
pub const MAP_CELLS: (usize, usize) = (10, 10);

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
        let rings = observations(board, views)?;
        let mut roll = Roll::new(views, rings);
        solve::enough(&roll)?;
        let solved = solve::solve(board, views, &mut roll, options)?;
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
        let calibration = solve::conclude(solved, roll, options)?;
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
