//! From a solution to a calibration: what it is worth, and whether it may be one.

use super::adjust::Adjusted;
use super::calibration::{self, Calibration, ViewFit};
use super::observations::Observation;
use super::roll::{Roll, residual_px};
use super::shared::{Free, Shared};
use super::solve::{Solved, degrees_of_freedom, folded};
use super::uncertainty::Covariance;
use super::{CalibrateError, CalibrateOptions, observability, steady};
use crate::camera::{Camera, Pose};
use nalgebra::DMatrix;

/// The calibration of a solution; refuses where the views leave it open or where it cannot be.
pub(super) fn conclude(
    solved: Solved,
    roll: Roll,
    options: &CalibrateOptions,
) -> Result<Calibration, CalibrateError> {
    let rings = roll.active_rings();
    let converged = solved.adjusted.converged;
    let calibration = unjudged(solved, roll, options)?;
    judged(&calibration, &rings, converged)?;
    Ok(calibration)
}

/// Whether the views determine a calibration, and it can be.
pub(super) fn judged(
    calibration: &Calibration,
    rings: &[Vec<Observation>],
    converged: bool,
) -> Result<(), CalibrateError> {
    observability::determined(calibration, rings)?;
    // asked last: what the views leave open does not converge either, and that is the better thing to say
    if !converged {
        return Err(CalibrateError::NotConverged {
            iterations: calibration.iterations,
        });
    }
    plausible(&calibration.camera, rings)
}

/// The calibration of a solution, whatever it is worth; only views that leave numbers open altogether have none.
pub(super) fn unjudged(
    solved: Solved,
    roll: Roll,
    options: &CalibrateOptions,
) -> Result<Calibration, CalibrateError> {
    let Solved {
        adjusted,
        free,
        fixed,
    } = solved;
    let shared = adjusted.solution.shared;
    let camera = shared.camera;
    if !options.fixed.holds_focal() {
        observability::not_parallel(&adjusted.solution.poses)?;
    }
    let inverse = adjusted.equations.inverse().map_err(|at| {
        let name = free.name(at, &camera);
        let missing = observability::missing(name, &adjusted.solution.poses);
        CalibrateError::Undetermined { name, missing }
    })?;
    let variance_factor = adjusted.equations.squares() / degrees_of_freedom(&roll, &free)?;
    let (names, count) = estimated_names(&camera, &free);
    let all = free.spread(
        &(by_noise(&adjusted, &inverse.shared) * variance_factor),
        count,
    );
    // the names between the camera and the last estimated number of the sheet may not all be estimated
    let chosen: Vec<usize> = names.iter().map(|(at, _)| *at).collect();
    let views: Vec<ViewFit> = (0..roll.rings.len())
        .map(|at| view_fit(&shared, &roll, at))
        .collect();
    let active = roll.active();
    let place = |at: usize| active.binary_search(&at).ok();
    let change = steady::change(
        &adjusted.equations,
        &inverse,
        (&shared, &free),
        (&active, &adjusted.solution.poses),
        roll.variance(variance_factor),
    );
    Ok(Calibration {
        camera,
        sheet: shared.sheet,
        rms_px: calibration::rms(views.iter().filter(|v| v.used()).flat_map(counted)),
        variance_factor,
        names: names.iter().map(|(_, name)| *name).collect(),
        covariance: all.select_rows(&chosen).select_columns(&chosen),
        fixed,
        iterations: adjusted.iterations,
        change,
        uncertain: Covariance {
            inverse,
            camera: camera_places(&camera, &free),
            place: (0..views.len()).map(place).collect(),
            free,
        },
        views,
        rivals: Vec::new(),
    })
}

/// How the free numbers scatter by the noise of the centres, for residuals of unit variance: P^-1 (P - Q) P^-1, where P holds the
/// charges Q. P^-1 alone counts a charge as ignorance about the number charged, as wide as the charge allows; but noise does not move
/// the number so far, because the charge holds it. Without charges both are the same.
fn by_noise(adjusted: &Adjusted, inverse: &DMatrix<f64>) -> DMatrix<f64> {
    inverse - inverse * adjusted.equations.charges() * inverse
}

/// The camera's parameters and what is estimated of the sheet, with their places, and how many numbers reach that far.
fn estimated_names(camera: &Camera, free: &Free) -> (Vec<(usize, &'static str)>, usize) {
    let parameters = camera.parameter_names().len();
    let sheet = |at: usize| {
        let mut columns = free.columns.iter();
        columns.any(|c| c.at == at || c.tied.is_some_and(|tied| tied.0 == at))
    };
    let names = Shared::names(camera);
    let chosen: Vec<(usize, &'static str)> = (0..names.len())
        .filter(|at| *at < parameters || sheet(*at))
        .map(|at| (at, names[at]))
        .collect();
    (chosen, names.len())
}

fn camera_places(camera: &Camera, free: &Free) -> Vec<(usize, usize, f64)> {
    let parameters = camera.parameter_names().len();
    let mut places = Vec::new();
    for (place, column) in free.columns.iter().enumerate() {
        if column.at < parameters {
            places.push((place, column.at, 1.0));
        }
        if let Some((other, factor)) = column.tied.filter(|tied| tied.0 < parameters) {
            places.push((place, other, factor));
        }
    }
    places
}

fn view_fit(shared: &Shared, roll: &Roll, at: usize) -> ViewFit {
    let pose: Option<Pose> = roll.poses[at];
    let rings = roll.rings[at].iter();
    let mut fit = ViewFit {
        pose,
        residuals: rings
            .clone()
            .map(|ring| residual_px(shared, &pose?, ring))
            .collect(),
        rings_used: rings.map(|ring| ring.share > 0.0).collect(),
        rms_px: 0.0,
        left_out: roll.left_out[at].clone(),
    };
    fit.rms_px = calibration::rms(counted(&fit));
    fit
}

/// The residuals of the rings that took part.
fn counted(view: &ViewFit) -> impl Iterator<Item = nalgebra::Vector2<f64>> {
    let rings = view.residuals.iter().zip(&view.rings_used);
    rings.filter_map(|(residual, used)| residual.filter(|_| *used))
}

/// Refuses cameras that least squares may well find but nobody can build.
fn plausible(camera: &Camera, rings: &[Vec<Observation>]) -> Result<(), CalibrateError> {
    let absurd = |what: String| Err(CalibrateError::Absurd { what });
    let k = &camera.intrinsics;
    for (name, value) in [("fx", k.fx), ("fy", k.fy)] {
        if !(value.is_finite() && value > 0.0) {
            return absurd(format!("{name} is {value:.1} px"));
        }
    }
    let (width, height) = (f64::from(camera.width), f64::from(camera.height));
    let near = (-width..2.0 * width).contains(&k.cx) && (-height..2.0 * height).contains(&k.cy);
    if !near {
        return absurd(format!(
            "its principal point ({:.0}, {:.0}) lies far outside the frame",
            k.cx, k.cy
        ));
    }
    match folded(camera, rings) {
        Some(pixel) => absurd(format!(
            "its distortion folds over at ({:.0}, {:.0})",
            pixel.x, pixel.y
        )),
        None => Ok(()),
    }
}
