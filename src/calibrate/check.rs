//! How well a calibration explains views that it was not made from.
//!
//! Each view's pose is found with the camera as it is; what is left over is noise where the camera is right, and a field over the frame
//! where it is not. The pose takes up a part of any error, so that views should fill the frame and differ in distance.
//! Views that can calibrate a camera themselves do so, and the two cameras are held against one another.

use super::resect::{Known, Resection, resect};
use super::{CalibrateError, LeftOut, SheetShape};
use crate::board::Board;
use crate::camera::Camera;
use crate::centre::Estimator;
use crate::session::View;
use nalgebra::Vector2;

mod alone;
mod verdict;

pub use alone::Alone;
use alone::alone;
pub use verdict::Verdict;

/// Cells of the bias field, across and down.
pub const FIELD: (usize, usize) = (8, 6);
/// Rings below which a cell says nothing.
const CELL_RINGS: usize = 5;

/// A cell of the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// Rings in it.
    pub rings: usize,
    /// Mean of measured less predicted, px.
    pub bias_px: Vector2<f64>,
    /// Standard deviation of each coordinate of that mean, px, as the residuals scatter.
    pub std_px: f64,
}

impl Cell {
    /// Whether it has seen enough rings to say anything.
    pub fn tells(&self) -> bool {
        self.rings >= CELL_RINGS
    }
}

/// The result of a check.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// Every view, in the order given.
    pub views: Vec<Resection>,
    /// Root mean square distance between measured and predicted centres, px, over the views that have a pose; `None` where none has.
    pub rms_px: Option<f64>,
    /// The cells of the frame, by rows.
    pub field: Vec<Cell>,
    /// What the views tell of the camera by themselves; `None` where they cannot.
    pub alone: Option<Alone>,
    /// What to make of it.
    pub verdict: Verdict,
}

/// Holds views against a camera.
///
/// # Errors
/// [`CalibrateError`] for views that are not of this board, or of another frame size than the camera's.
pub fn check(
    board: &Board,
    views: &[View],
    camera: &Camera,
    estimator: Estimator,
) -> Result<Check, CalibrateError> {
    let wanted = (camera.width as usize, camera.height as usize);
    if let Some(view) = views.iter().find(|v| (v.width, v.height) != wanted) {
        return Err(CalibrateError::CameraSize {
            source_name: view.source.clone(),
            size: (view.width, view.height),
            camera: wanted,
        });
    }
    let known = Known {
        camera: *camera,
        sheet: SheetShape::default(),
        estimator,
    };
    let resections = resect(board, views, &known)?;
    let field = field(camera, views, &resections);
    let alone = alone(board, views, (camera, estimator), &field);
    Ok(Check {
        rms_px: rms(&resections),
        verdict: if explains_none(&resections) {
            Verdict::ExplainsNone
        } else {
            Verdict::of(&field, alone.as_ref())
        },
        views: resections,
        field,
        alone,
    })
}

/// Whether no view has a pose, and the camera is to blame for one of them at least.
fn explains_none(resections: &[Resection]) -> bool {
    let mut reasons = resections.iter().map(|r| &r.fit.left_out);
    resections.iter().all(|r| !r.fit.used()) && reasons.any(|r| *r == Some(LeftOut::NoPose))
}

fn rms(resections: &[Resection]) -> Option<f64> {
    let used = || resections.iter().filter(|r| r.fit.used());
    let residuals = used().flat_map(|r| &r.fit.residuals).flatten();
    used()
        .next()
        .map(|_| super::calibration::rms(residuals.copied()))
}

fn field(camera: &Camera, views: &[View], resections: &[Resection]) -> Vec<Cell> {
    let mut inside: Vec<Vec<Vector2<f64>>> = vec![Vec::new(); FIELD.0 * FIELD.1];
    let (width, height) = (f64::from(camera.width), f64::from(camera.height));
    for (view, resection) in views.iter().zip(resections) {
        for (ring, residual) in view.rings.iter().zip(&resection.fit.residuals) {
            let at = ring.centre.point;
            let column = ((at.x + 0.5) / width * FIELD.0 as f64).floor();
            let row = ((at.y + 0.5) / height * FIELD.1 as f64).floor();
            let in_frame =
                (0.0..FIELD.0 as f64).contains(&column) && (0.0..FIELD.1 as f64).contains(&row);
            if let (true, Some(residual)) = (in_frame, residual) {
                inside[row as usize * FIELD.0 + column as usize].push(*residual);
            }
        }
    }
    inside.iter().map(|residuals| cell(residuals)).collect()
}

fn cell(residuals: &[Vector2<f64>]) -> Cell {
    let n = residuals.len() as f64;
    let mean = residuals.iter().sum::<Vector2<f64>>() / n.max(1.0);
    let scatter: f64 = residuals.iter().map(|r| (r - mean).norm_squared()).sum();
    Cell {
        rings: residuals.len(),
        bias_px: mean,
        std_px: (scatter / (2.0 * (n - 1.0).max(1.0)) / n.max(1.0)).sqrt(),
    }
}

#[cfg(test)]
mod tests;
