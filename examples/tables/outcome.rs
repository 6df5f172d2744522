//! One calibration beside the truth: its parameters, and its centres.

use crate::bound;
use crate::paper::truth;
use crate::shots::Shot;
use anyhow::{Context, Result};
use nalgebra::{DVector, Matrix2, Vector2};
use ringcal::board::Board;
use ringcal::calibrate::{CalibrateOptions, Calibration, Fixed, ViewFit};
use ringcal::centre::Estimator;
use ringcal::detect::Ring;
use ringcal::refine::calibrate_refined;
use ringcal::session::View;

/// A way to calibrate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// `photometric`, both passes.
    Default,
    /// The paper's construction.
    Cross,
    /// The centres of the small ellipses, and a calibration that knows what they are.
    SmallEllipse,
    /// The same taken for the projected centres, as the paper does.
    Gcs,
}

impl Method {
    pub const ALL: [Self; 4] = [Self::Default, Self::Cross, Self::SmallEllipse, Self::Gcs];

    pub fn name(self) -> &'static str {
        match self {
            Self::Default => "photometric (default)",
            Self::Cross => "cross (PC)",
            Self::SmallEllipse => "small_ellipse, displacement predicted",
            Self::Gcs => "small_ellipse, taken for the centre (GCS)",
        }
    }

    /// What the calibration is told that measured the centres.
    fn measured_by(self) -> Estimator {
        match self {
            // centres without a covariance are then taken for points
            Self::Default | Self::Gcs => Estimator::Photometric,
            Self::Cross => Estimator::Cross,
            Self::SmallEllipse => Estimator::SmallEllipse,
        }
    }

    fn view(self, shot: &Shot) -> Option<View> {
        match self {
            Self::Default => shot.photometric.clone(),
            Self::Cross => shot.cross.clone(),
            Self::SmallEllipse | Self::Gcs => shot.small_ellipse(),
        }
    }
}

/// The parameters that are estimated: fx, fy, cx, cy, k1, k2, the first of a camera.
pub const PARAMETERS: usize = 6;

/// One calibration beside the truth.
#[derive(Debug, Clone)]
pub struct Outcome {
    pub values: [f64; PARAMETERS],
    pub stds: [f64; PARAMETERS],
    /// The least that the true model allows.
    pub bounds: [f64; PARAMETERS],
    /// Squared error of all parameters at once, in their covariance; an honest one makes it [`PARAMETERS`] in the mean.
    pub joint: f64,
    pub rms_px: f64,
    pub views: usize,
    pub centres: Centres,
    /// Those of the rings that are not at the sheet's edge.
    pub inside: Centres,
}

/// Errors of the centres of all views.
#[derive(Debug, Clone, Copy, Default)]
pub struct Centres {
    pub rings: usize,
    pub left_out: usize,
    /// Sum of the squared distances from the true projected centres, px^2.
    pub squares: f64,
    /// The same less the displacement that the calibration predicts of the estimator, px^2.
    pub squares_predicted: f64,
    /// Coordinates with a standard deviation.
    pub scores: usize,
    /// Sum of their squared errors in standard deviations.
    pub score_squares: f64,
    /// Those that are off by more than 2.5 of them.
    pub beyond: usize,
    /// Sum of the rings' variances over what the true model allows.
    pub over_bound: f64,
}

impl Outcome {
    /// Calibrates from the frames in which the board was found.
    pub fn of(method: Method, board: &Board, shots: &[Shot]) -> Result<Self> {
        let found = shots
            .iter()
            .filter_map(|shot| Some((method.view(shot)?, shot)));
        let (views, shots): (Vec<View>, Vec<&Shot>) = found.unzip();
        let options = CalibrateOptions {
            fixed: Fixed::from_entries(["p1", "p2", "k3"])?,
            estimator: method.measured_by(),
            ..CalibrateOptions::default()
        };
        let (calibration, views) = calibrate_refined(board, &views, &options)?;
        let (mut centres, mut inside) = (Centres::default(), Centres::default());
        for ((view, fit), shot) in views.iter().zip(&calibration.views).zip(&shots) {
            let errors = CentreErrors {
                board,
                shot,
                fit,
                calibration: &calibration,
            };
            for (i, ring) in view.rings.iter().enumerate() {
                centres.add(&errors, ring, i);
                if is_inside(board, ring) {
                    inside.add(&errors, ring, i);
                }
            }
        }
        let values = calibration.values();
        let known = shots.iter().map(|shot| (&shot.truth, &shot.bounds[..]));
        let known: Vec<_> = known.collect();
        Ok(Self {
            bounds: bound::camera(board, &known).context("the views do not tell the camera")?,
            values: std::array::from_fn(|i| values[i]),
            stds: std::array::from_fn(|i| calibration.std(i)),
            joint: joint(&calibration),
            rms_px: calibration.rms_px,
            views: calibration.views_used(),
            centres,
            inside,
        })
    }

    /// Estimates less truth.
    pub fn errors(&self) -> [f64; PARAMETERS] {
        let truth = truth().parameters();
        std::array::from_fn(|i| self.values[i] - truth[i])
    }
}

/// Squared error of the free parameters in their covariance (Mahalanobis).
fn joint(calibration: &Calibration) -> f64 {
    let free = calibration
        .covariance
        .view((0, 0), (PARAMETERS, PARAMETERS));
    let truth = truth().parameters();
    let values = calibration.values();
    let error = DVector::from_fn(PARAMETERS, |i, _| values[i] - truth[i]);
    // focal lengths in px and k2 differ by many orders: scaled to correlations first
    let scale = DVector::from_fn(PARAMETERS, |i, _| calibration.std(i).recip());
    let diagonal = nalgebra::DMatrix::from_diagonal(&scale);
    let correlation = &diagonal * free * &diagonal;
    let scaled = error.component_mul(&scale);
    correlation
        .cholesky()
        .map_or(f64::NAN, |factor| scaled.dot(&factor.solve(&scaled)))
}

/// What a view's centres are compared with.
struct CentreErrors<'a> {
    board: &'a Board,
    shot: &'a Shot,
    fit: &'a ViewFit,
    calibration: &'a Calibration,
}

impl CentreErrors<'_> {
    /// Measured less true projected centre, and the bound. A square board may be seen turned: its labels are then others, the rings the same.
    fn error(&self, ring: &Ring) -> Option<(Vector2<f64>, Matrix2<f64>)> {
        let known = self.shot.truth.rings.iter().zip(&self.shot.bounds);
        known
            .map(|(known, bound)| (ring.centre.point - known.centre, *bound))
            .min_by(|a, b| a.0.norm().total_cmp(&b.0.norm()))
    }

    /// What the estimator measures less the projected centre, as the calibration predicts it: measured less residual is
    /// the prediction, and that less the projection is the displacement.
    fn displacement(&self, ring: &Ring, at: usize) -> Option<Vector2<f64>> {
        let residual = (*self.fit.residuals.get(at)?)?;
        let on_board = self.board.centre_m(ring.row, ring.column);
        let point = self.fit.pose?.board_to_camera(on_board);
        let projected = self.calibration.camera.project(&point)?;
        Some(ring.centre.point - residual - projected)
    }
}

/// Whether a ring has others on all sides.
fn is_inside(board: &Board, ring: &Ring) -> bool {
    let between = |i: u16, count: u16| i > 0 && i + 1 < count;
    between(ring.row, board.rows()) && between(ring.column, board.columns())
}

impl Centres {
    /// Adds one ring, the view's `at`th.
    fn add(&mut self, errors: &CentreErrors, ring: &Ring, at: usize) {
        let Some((error, bound)) = errors.error(ring) else {
            return;
        };
        let rest = error - errors.displacement(ring, at).unwrap_or_default();
        let used = errors.fit.rings_used.get(at) == Some(&true);
        self.rings += 1;
        self.left_out += usize::from(!used);
        self.squares += error.norm_squared();
        self.squares_predicted += rest.norm_squared();
        if let Some(covariance) = ring.centre.covariance {
            self.add_scores(rest, &covariance);
            self.over_bound += covariance.trace() / bound.trace();
        }
    }

    fn add_scores(&mut self, error: Vector2<f64>, covariance: &Matrix2<f64>) {
        let Some(factor) = covariance.cholesky() else {
            return;
        };
        let Some(white) = factor.l().solve_lower_triangular(&error) else {
            return;
        };
        for score in white.iter() {
            self.scores += 1;
            self.score_squares += score * score;
            self.beyond += usize::from(score.abs() > 2.5);
        }
    }
}
