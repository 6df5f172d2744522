//! One calibration beside the truth: its parameters, and its centres.

use crate::paper::truth;
use crate::shots::Shot;
use anyhow::Result;
use nalgebra::{DVector, Matrix2, Vector2};
use ringcal::board::Board;
use ringcal::calibrate::{CalibrateOptions, Calibration, Fixed, ViewFit};
use ringcal::centre::Estimator;
use ringcal::refine::calibrate_refined;
use ringcal::session::View;
use ringcal::simulate::Truth;

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
            Self::Default => Estimator::Photometric,
            Self::Cross => Estimator::Cross,
            Self::SmallEllipse => Estimator::SmallEllipse,
            // perspective does not displace this one, so that none is accounted for
            Self::Gcs => Estimator::PolePolar,
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
    /// Squared error of all parameters at once, in their covariance; an honest one makes it [`PARAMETERS`] in the mean.
    pub joint: f64,
    pub rms_px: f64,
    pub views: usize,
    pub centres: Centres,
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
}

impl Outcome {
    /// Calibrates from the frames in which the board was found.
    pub fn of(method: Method, board: &Board, shots: &[Shot]) -> Result<Self> {
        let found = shots
            .iter()
            .filter_map(|shot| Some((method.view(shot)?, &shot.truth)));
        let (views, truths): (Vec<View>, Vec<&Truth>) = found.unzip();
        let options = CalibrateOptions {
            fixed: Fixed::from_entries(["p1", "p2", "k3"])?,
            estimator: method.measured_by(),
            ..CalibrateOptions::default()
        };
        let (calibration, views) = calibrate_refined(board, &views, &options)?;
        let mut centres = Centres::default();
        for ((view, fit), truth) in views.iter().zip(&calibration.views).zip(truths) {
            centres.add_view(board, view, fit, truth, &calibration);
        }
        let values = calibration.values();
        Ok(Self {
            values: std::array::from_fn(|i| values[i]),
            stds: std::array::from_fn(|i| calibration.std(i)),
            joint: joint(&calibration),
            rms_px: calibration.rms_px,
            views: calibration.views_used(),
            centres,
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

impl Centres {
    fn add_view(
        &mut self,
        board: &Board,
        view: &View,
        fit: &ViewFit,
        truth: &Truth,
        calibration: &Calibration,
    ) {
        for (i, ring) in view.rings.iter().enumerate() {
            let point = ring.centre.point;
            // a square board may be seen turned: its labels are then others, the rings the same
            let nearest = truth
                .rings
                .iter()
                .map(|known| point - known.centre)
                .min_by(|a, b| a.norm().total_cmp(&b.norm()));
            let Some(error) = nearest else { continue };
            let label = (ring.row, ring.column);
            let displaced = displaced(board, label, i, fit, calibration, point.coords);
            let rest = error - displaced.unwrap_or_default();
            self.rings += 1;
            self.left_out += usize::from(!fit.rings_used.get(i).is_some_and(|used| *used));
            self.squares += error.norm_squared();
            self.squares_predicted += rest.norm_squared();
            if let Some(covariance) = ring.centre.covariance {
                self.add_scores(rest, &covariance);
            }
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

/// What the estimator measures less the projected centre, as the calibration predicts it: measured less residual is
/// the prediction, and that less the projection is the displacement.
fn displaced(
    board: &Board,
    (row, column): (u16, u16),
    ring: usize,
    fit: &ViewFit,
    calibration: &Calibration,
    measured: Vector2<f64>,
) -> Option<Vector2<f64>> {
    let residual = (*fit.residuals.get(ring)?)?;
    let point = fit.pose?.board_to_camera(board.centre_m(row, column));
    let projected = calibration.camera.project(&point)?;
    Some(measured - residual - projected.coords)
}
