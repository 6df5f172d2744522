//! What the views of a check tell of the camera by themselves.
//!
//! A pose absorbs the greatest part of a wrong focal length: the board is merely thought nearer or farther. Views that can calibrate
//! a camera have no such way out, and their camera is held against the one that is checked.

use super::{Cell, FIELD};
use crate::board::Board;
use crate::calibrate::{CalibrateOptions, Calibration, Fixed, Range, calibrate, difference};
use crate::camera::Camera;
use crate::centre::Estimator;
use crate::session::View;
use nalgebra::Point2;

/// Standard deviations beyond which a difference is no accident.
const SURE: f64 = 3.0;

/// How far the camera that the views tell is from the one that is checked, at infinity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alone {
    /// The largest difference that is no accident, in the parts of the frame with rings, px; 0 where there is none.
    pub worst_px: f64,
    /// Where it is, px.
    pub at: Point2<f64>,
}

/// Calibrates the camera from the views: all of it or, where they leave the lens open, its focal lengths and principal point.
/// `None` where they cannot tell these either.
pub(super) fn alone(
    board: &Board,
    views: &[View],
    (camera, estimator): (&Camera, Estimator),
    field: &[Cell],
) -> Option<Alone> {
    let mut options = CalibrateOptions {
        model: camera.model(),
        estimator,
        ..CalibrateOptions::default()
    };
    let own = calibrate(board, views, &options).ok().or_else(|| {
        options.fixed = Fixed::from_entries(camera.parameter_names().get(4..)?).ok()?;
        options.guess = Some(*camera);
        calibrate(board, views, &options).ok()
    })?;
    held_against(camera, &own, field)
}

fn held_against(camera: &Camera, own: &Calibration, field: &[Cell]) -> Option<Alone> {
    let apart = difference(camera, &own.camera, FIELD)?;
    let stds = own.projection_std_map(FIELD, Range::Infinity);
    let told: Vec<f64> = stds.iter().flatten().copied().collect();
    let mean_square = told.iter().map(|std| std * std).sum::<f64>() / told.len().max(1) as f64;
    let mut worst = Alone {
        worst_px: 0.0,
        at: Point2::origin(),
    };
    for (at, _) in field.iter().enumerate().filter(|(_, cell)| cell.tells()) {
        let (Some(Some(offset)), Some(Some(std))) = (apart.offsets_px.get(at), stds.get(at)) else {
            continue;
        };
        // the camera checked is as uncertain, and the rotation taken off spreads what any part of the frame is off by
        let std_px = (2.0 * (std * std + mean_square)).sqrt();
        let px = offset.norm();
        if px > SURE * std_px && px > worst.worst_px {
            worst = Alone {
                worst_px: px,
                at: middle(camera, at),
            };
        }
    }
    Some(worst)
}

/// The middle of a cell of the field, px.
fn middle(camera: &Camera, cell: usize) -> Point2<f64> {
    let along = |at: usize, cells: usize, side: u32| {
        (at as f64 + 0.5) * f64::from(side) / cells as f64 - 0.5
    };
    Point2::new(
        along(cell % FIELD.0, FIELD.0, camera.width),
        along(cell / FIELD.0, FIELD.1, camera.height),
    )
}
