//! Levenberg-Marquardt with analytic derivatives.
//!
//! Derivatives cost several times what values cost, and near the end they hardly change. So once a step is short against the
//! blur, the next ones are made with the derivatives that are there, as long as the steps shrink.

use super::equations::{freeze, shape_of_inverse, solved};
use super::fit::Given;
use super::fitted::{FitError, RingFitted};
use super::model::{
    BLUR, Matrix, PAPER, PARAMETERS, RING, RING_PARAMETERS, RingModel, SHEET, Vector,
};
use super::problem::{Normal, Problem, Workspace};
use super::sheet::EDGE_PARAMETERS;
use super::wall::Wall;

/// A fit is as certain as noise of this part of the contrast would leave it, at best: a ring whose residuals vanish by chance would rule those
/// that the model does not describe to the last digit.
const LEAST_NOISE: f64 = 3e-4;
/// The model's own arithmetic is no better than this, (light at full scale 1)^2.
const LEAST_VARIANCE: f64 = 1e-9;
/// Damping at the start, and how it changes.
const DAMPING: (f64, f64, f64) = (1e-3, 0.1, 8.0);
/// How it changes where it has just been raised: in a bent valley, steps would fail in turn.
const AFTER_FAILURE: f64 = 0.5;
const LEAST_DAMPING: f64 = 1e-4;
/// Derivatives are kept after steps that move the outline less than this fraction of the blur (the pixel's own included).
const SHORT_STEP: f64 = 0.25;
/// They are renewed where a step is expected to gain more than this fraction of what the one before was.
const SLOW: f64 = 0.1;
/// Keeps the blur (its square, px^2) determined whatever the pixels say; as much as a measurement of 300 px^2 uncertainty at
/// 1 % of noise.
pub(super) const BLUR_PRIOR: f64 = 1e-9;
/// The same for the sheet's end: the light beyond, the offset (px) and the angle of an edge. As much as measurements of 0.5, 10 px and
/// 0.3 rad uncertainty at 1 % of noise: an edge that is all but out of reach determines none of them.
const SHEET_PRIOR: [f64; 3] = [4e-4, 1e-6, 1e-3];

/// A fit under way.
pub(super) struct Descent<'a, 'b> {
    problem: &'b Problem<'a>,
    room: &'b mut Workspace,
    start: RingModel,
    parameters: Vector,
    normal: Normal,
    wall: Wall,
    damping: f64,
    /// The last step that was tried went up.
    failed: bool,
    given: Given,
    pixels: usize,
    /// A step that gains less is the last.
    pub(super) least_gain: f64,
}

impl<'a, 'b> Descent<'a, 'b> {
    /// At a start.
    ///
    /// # Errors
    /// [`FitError`] where the pixels are too few or determine no ring.
    pub(super) fn begin(
        problem: &'b Problem<'a>,
        start: &RingModel,
        given: Given,
        room: &'b mut Workspace,
    ) -> Result<Self, FitError> {
        let pixels = problem.window.count() + problem.window.censored.len();
        if pixels < 2 * PARAMETERS {
            return Err(FitError::TooFewPixels { pixels });
        }
        let mut normal = room.normal(problem, start).ok_or(FitError::Undetermined)?;
        let (parameters, wall) = (start.parameters(), Wall::of(&normal.matrix));
        normal.squares += wall.push(&parameters, &mut normal.gradient);
        Ok(Self {
            problem,
            room,
            start: *start,
            parameters,
            normal,
            wall,
            damping: match given {
                Given::Nothing => DAMPING.0,
                Given::NearStart | Given::Shape | Given::Perspective => 0.0,
            },
            failed: false,
            given,
            pixels,
            least_gain: 0.0,
        })
    }

    fn variance(&self) -> f64 {
        let free = self.pixels - self.start.count();
        self.normal.squares.max(f64::MIN_POSITIVE) / free as f64
    }

    /// Steps down until one would gain less than `last` variances, `steps` at most.
    pub(super) fn descend(&mut self, (steps, last): (usize, f64)) -> Result<RingFitted, FitError> {
        let (mut fresh, mut gained) = (true, f64::INFINITY);
        let mut undamped = false;
        for _ in 0..steps {
            let step = self.step().ok_or(FitError::Undetermined)?;
            let gain = step.dot(&self.normal.gradient);
            let settled = gain < (last * self.variance().max(LEAST_VARIANCE)).max(self.least_gain);
            if settled && self.damping > 0.0 && !undamped {
                // damping hides how far it still is along what the pixels hardly determine
                (self.damping, undamped) = (0.0, true);
                continue;
            }
            if settled && self.damping > 0.0 {
                // nor did the undamped step gain anything: what is left is rounding
                return self.finish();
            }
            if settled {
                self.parameters = moved(&self.parameters, &step);
                return self.finish();
            }
            if !fresh && gain > SLOW * gained {
                self.renew()?;
                (fresh, gained) = (true, f64::INFINITY);
                continue;
            }
            let next = moved(&self.parameters, &step);
            if self.is_short(&step) {
                match self.gradient(&next) {
                    Some((gradient, squares)) if squares <= self.normal.squares => {
                        self.parameters = next;
                        self.normal.gradient = gradient;
                        self.normal.squares = squares;
                        (fresh, gained, undamped) = (false, gain, false);
                        self.relax();
                    }
                    _ if !fresh => {
                        self.renew()?;
                        (fresh, gained) = (true, f64::INFINITY);
                    }
                    _ if self.damping > 1e8 => return self.finish(),
                    _ => self.damp(),
                }
                continue;
            }
            match self.normal(&next) {
                Some(normal) if normal.squares < self.normal.squares => {
                    self.parameters = next;
                    self.normal = normal;
                    (fresh, gained, undamped) = (true, f64::INFINITY, false);
                    self.relax();
                }
                _ if self.damping > 1e8 => return self.finish(),
                _ => self.damp(),
            }
        }
        Err(FitError::NotConverged { steps })
    }

    fn relax(&mut self) {
        self.damping *= if self.failed {
            AFTER_FAILURE
        } else {
            DAMPING.1
        };
        self.failed = false;
    }

    fn damp(&mut self) {
        self.failed = true;
        self.damping = (self.damping * DAMPING.2).max(LEAST_DAMPING);
    }

    /// Computes the derivatives where the fit stands.
    fn renew(&mut self) -> Result<(), FitError> {
        let parameters = self.parameters;
        self.normal = self.normal(&parameters).ok_or(FitError::Undetermined)?;
        Ok(())
    }

    /// The normal equations elsewhere.
    fn normal(&mut self, parameters: &Vector) -> Option<Normal> {
        let model = self.start.with_parameters(parameters);
        let mut normal = self.room.normal(self.problem, &model)?;
        normal.squares += self.wall.push(parameters, &mut normal.gradient);
        Some(normal)
    }

    /// Gradient and sum of squares elsewhere, with the derivatives that are there.
    fn gradient(&mut self, parameters: &Vector) -> Option<(Vector, f64)> {
        let model = self.start.with_parameters(parameters);
        let (mut gradient, squares) = self.room.gradient(self.problem, &model)?;
        let pushed = self.wall.push(parameters, &mut gradient);
        Some((gradient, squares + pushed))
    }

    /// The damped step (Marquardt's scaling).
    fn step(&self) -> Option<Vector> {
        let mut matrix = self.matrix();
        self.wall.stiffen(&self.parameters, &mut matrix);
        self.solve(matrix, self.normal.gradient, 1.0 + self.damping)
    }

    /// The step that a matrix and a gradient say, the diagonal times `damping`.
    fn solve(&self, mut matrix: Matrix, mut gradient: Vector, damping: f64) -> Option<Vector> {
        self.given.held().for_each(|k| gradient[k] = 0.0);
        if self.parameters[BLUR] <= 0.0 && gradient[BLUR] <= 0.0 {
            // no blur at all, and less were better still
            freeze(&mut matrix, BLUR);
            gradient[BLUR] = 0.0;
        }
        if self.start.sheet.is_none() {
            solved::<RING_PARAMETERS>(&matrix, &gradient, damping)
        } else {
            solved::<PARAMETERS>(&matrix, &gradient, damping)
        }
    }

    /// The normal matrix of what is free.
    fn matrix(&self) -> Matrix {
        let mut matrix = self.normal.matrix;
        add_priors(&mut matrix, self.start.count());
        self.given.held().for_each(|k| freeze(&mut matrix, k));
        matrix
    }

    /// Whether a step moves the outline by little against the blur.
    fn is_short(&self, step: &Vector) -> bool {
        let model = self.start.with_parameters(&self.parameters);
        // a relative change of the affine form moves the outline by half of it, in radii
        let size = model.shape.size_px();
        let affine = step[2].abs().max(step[3].abs()).max(step[4].abs()) * size * size;
        let perspective = step[5].hypot(step[6]) * size;
        let scale = model.blur.sigma_px() + 0.3 * self.problem.window.grid.pixel_px;
        let sheet = step[SHEET + 1].hypot(step[SHEET + 1 + EDGE_PARAMETERS]);
        let moved = step[0].hypot(step[1])
            + sheet
            + size * (0.5 * affine + perspective)
            + 0.5 * step[BLUR].abs() / scale;
        moved < SHORT_STEP * scale
    }

    /// The fit where it stands.
    pub(super) fn finish(&mut self) -> Result<RingFitted, FitError> {
        let variance = self.variance();
        let inverse = if self.start.sheet.is_none() {
            shape_of_inverse::<RING_PARAMETERS>(&self.matrix())
        } else {
            shape_of_inverse::<PARAMETERS>(&self.matrix())
        };
        let model = self.start.with_parameters(&self.parameters);
        let least = LEAST_NOISE * (model.paper - model.ring) / self.problem.window.grid.pixel_px;
        let certain = variance.max(least * least);
        let mut covariance = inverse.ok_or(FitError::Undetermined)? * certain;
        self.given.held().for_each(|k| covariance[(k, k)] = 0.0);
        Ok(RingFitted {
            model,
            covariance,
            noise: variance.sqrt(),
            squares: self.normal.squares,
            pixels: self.pixels,
            darkest: self.darkest(),
        })
    }

    /// The darker of paper and ring over the lighter where the fit would go without the wall.
    fn darkest(&self) -> f64 {
        let mut push = Vector::zeros();
        let is_pushed = self.wall.push(&self.parameters, &mut push) > 0.0;
        let free = is_pushed.then(|| self.solve(self.matrix(), self.normal.gradient - push, 1.0));
        let levels = free
            .flatten()
            .map_or(self.parameters, |step| self.parameters + step);
        let (paper, ring) = (levels[PAPER], levels[RING]);
        paper.min(ring) / paper.max(ring).max(f64::MIN_POSITIVE)
    }
}

/// Adds what keeps the first `count` parameters determined whatever the pixels say.
pub(super) fn add_priors(matrix: &mut Matrix, count: usize) {
    matrix[(BLUR, BLUR)] += BLUR_PRIOR;
    let [light, offset, angle] = SHEET_PRIOR;
    for k in SHEET..count {
        matrix[(k, k)] += match (k - SHEET) % EDGE_PARAMETERS {
            _ if k == SHEET => light,
            1 => offset,
            _ => angle,
        };
    }
}

/// Parameters after a step. There is no less than no blur.
fn moved(parameters: &Vector, step: &Vector) -> Vector {
    let mut moved = parameters + step;
    moved[BLUR] = moved[BLUR].max(0.0);
    moved
}
