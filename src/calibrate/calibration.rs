//! The result of a calibration.

use super::roll::LeftOut;
use super::shared::SheetShape;
use super::steady::Change;
use super::uncertainty::{Covariance, deviations};
use crate::camera::{Camera, Pose};
use nalgebra::{DMatrix, Vector2};

/// A calibrated camera, and how well the views support it.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// The camera.
    pub camera: Camera,
    /// How the printed sheet departs from its board file, as far as that was estimated.
    pub sheet: SheetShape,
    /// The views, in the order given, those that were left out as well.
    pub views: Vec<ViewFit>,
    /// Root mean square of the distance between measured and projected centres, px: the square root of the sum of the
    /// squared distances over the number of rings (not of coordinates), unweighted, as ROS and OpenCV report it. Rings and views
    /// that were left out do not count.
    pub rms_px: f64,
    /// Sum of the squared whitened residuals over the degrees of freedom: about 1 where the covariances of the rings are
    /// true, px^2 where they have none.
    pub variance_factor: f64,
    /// Names of what `covariance` is about: the camera's parameters, then what was estimated of the sheet.
    pub names: Vec<&'static str>,
    /// Covariance of `names` in that order: `variance_factor` times the inverse of the Schur complement of
    /// J^T J, less what the charge on k4 to k6 of the rational model adds to it. Rows and columns of fixed parameters are 0.
    pub covariance: DMatrix<f64>,
    /// Names of the parameters that were not estimated.
    pub fixed: Vec<&'static str>,
    /// Iterations of the last adjustment.
    pub iterations: usize,
    /// A change of the focal length between the views, where there is one beyond chance.
    pub change: Option<Change>,
    /// Calibrations by other lens models that explain the views as well; the covariances cover what they disagree by. None unless the
    /// lens model was chosen by the views (`rivals`).
    pub rivals: Vec<Calibration>,
    pub(super) uncertain: Covariance,
}

/// How one view fits.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewFit {
    /// Where the board stands; `None` where no position explains the view.
    pub pose: Option<Pose>,
    /// Measured less predicted centre of each ring of the view, in its order, px; `None` where the view has no pose or the ring no image.
    pub residuals: Vec<Option<Vector2<f64>>>,
    /// Which rings took part, in their order.
    pub rings_used: Vec<bool>,
    /// As [`Calibration::rms_px`], of this view alone.
    pub rms_px: f64,
    /// Why it did not take part.
    pub left_out: Option<LeftOut>,
}

impl ViewFit {
    /// Whether it took part.
    pub fn used(&self) -> bool {
        self.left_out.is_none()
    }

    /// How many of its rings were left out, of a view that took part.
    pub fn rings_left_out(&self) -> usize {
        self.rings_used.iter().filter(|used| !**used).count()
    }
}

impl Calibration {
    /// Standard deviation of the number at this place of [`Calibration::names`]; 0 for a fixed one.
    ///
    /// It counts the noise of the centres and nothing else: not a bias that the centres share, and not a lens that the
    /// model does not describe.
    pub fn std(&self, at: usize) -> f64 {
        self.covariance
            .get((at, at))
            .map_or(0.0, |variance| variance.max(0.0).sqrt())
    }

    /// All of [`Calibration::std`].
    pub fn stds(&self) -> Vec<f64> {
        deviations(&self.covariance)
    }

    /// The values of [`Calibration::names`].
    pub fn values(&self) -> Vec<f64> {
        let sheet = self.sheet;
        let camera = self.camera.parameters();
        let of_sheet = |name: &str| match name {
            "bow_x" => sheet.bow_per_m[0],
            "bow_y" => sheet.bow_per_m[1],
            _ => sheet.pitch_ratio,
        };
        let names = self.names.iter().skip(camera.len());
        let rest = names.map(|name| of_sheet(name));
        camera.iter().copied().chain(rest).collect()
    }

    /// Numbers measured less numbers estimated.
    pub(super) fn degrees(&self) -> f64 {
        let used = || self.views.iter().filter(|view| view.used());
        let rings: usize = used()
            .map(|view| view.rings_used.len() - view.rings_left_out())
            .sum();
        (2 * rings) as f64 - (self.uncertain.free.len() + 6 * used().count()) as f64
    }

    /// How many views took part.
    pub fn views_used(&self) -> usize {
        self.views.iter().filter(|view| view.used()).count()
    }
}

/// Root mean square length of residuals; 0 for none.
pub(super) fn rms(residuals: impl Iterator<Item = Vector2<f64>>) -> f64 {
    let (sum, count) = residuals.fold((0.0, 0_usize), |(sum, count), r| {
        (sum + r.norm_squared(), count + 1)
    });
    (sum / count.max(1) as f64).sqrt()
}
