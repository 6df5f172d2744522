//! One calibration, from the views as they were when it was asked for to a sentence about the result.

use super::settings::Settings;
use crate::board::Board;
use crate::calibrate::{CalibrateError, CalibrateOptions, Calibration, ModelChoice};
use crate::camera::LensModel;
use crate::refine::calibrate_chosen;
use crate::session::View;

/// A calibration to be solved: the views as they were when it was asked for.
#[derive(Debug, Clone)]
pub struct Job {
    /// Which of the node's sessions the views are from.
    pub(super) session: u64,
    /// The board they show.
    pub(super) board: Board,
    /// The views.
    pub(super) views: Vec<View>,
    /// The lens model, or that it is to be chosen.
    pub(super) model: ModelChoice,
    /// How to calibrate otherwise.
    pub(super) options: CalibrateOptions,
}

/// A calibration that was solved, or why not.
#[derive(Debug)]
pub struct Solved {
    /// The session of the job.
    pub(super) session: u64,
    /// How many views it had.
    pub(super) views: usize,
    /// What came out.
    pub(super) result: Result<Calibration, CalibrateError>,
}

impl Job {
    /// Solves it; takes as long as it takes.
    pub fn solve(self) -> Solved {
        Solved {
            session: self.session,
            views: self.views.len(),
            result: self.result(),
        }
    }
}

impl Job {
    fn result(&self) -> Result<Calibration, CalibrateError> {
        let how = (&self.options, self.model);
        calibrate_chosen(&self.board, &self.views, how).map(|chosen| chosen.calibration)
    }
}

/// How views are calibrated. Where the lens model is to be chosen, `known` is the one that was, and until then the usual one.
pub(super) fn options(settings: &Settings, known: Option<LensModel>) -> CalibrateOptions {
    let model = match settings.model {
        ModelChoice::Fixed(model) => model,
        ModelChoice::Auto => known.unwrap_or_default(),
    };
    CalibrateOptions {
        model,
        fixed: settings.fixed.clone(),
        estimator: settings.estimator,
        ..CalibrateOptions::default()
    }
}

/// One sentence for people about a calibration.
pub(super) fn describe(calibration: &Calibration, views: usize) -> String {
    let camera = &calibration.camera;
    let i = &camera.intrinsics;
    let mut text = format!(
        "calibrated from {views} views ({}): fx {:.2}, fy {:.2}, cx {:.2}, cy {:.2}, reprojection error {:.4} px",
        camera.model(),
        i.fx,
        i.fy,
        i.cx,
        i.cy,
        calibration.rms_px
    );
    let left_out = views - calibration.views_used();
    if left_out > 0 {
        text += &format!("; {left_out} of the views contradict the others and are left out");
    }
    text
}
