//! Views -> camera: guess, bundle adjustment, uncertainty, and the refusal of views that cannot tell.
//!
//! 1. `observations` checks the views and pairs their rings with the board's.
//! 2. `guess` takes a homography of each view and a camera without distortion from them (`zhang`).
//! 3. `adjust` minimises the reprojection error over camera and poses, first over the focal lengths and k1, then over
//!    everything that is free, on the `normal_equations` with the poses eliminated.
//! 4. The covariance of the parameters is that of least squares. Views that leave a focal length or the principal
//!    point open are refused, however small their residuals are.

mod adjust;
mod calibration;
mod error;
mod guess;
mod normal_equations;
mod observations;
mod options;
mod zhang;

pub use calibration::{Calibration, ViewFit};
pub use error::CalibrateError;
pub use options::{CalibrateOptions, Fixed, FixedError};
pub use zhang::{focal_length_px, plane_normal, pose};

use crate::board::Board;
use crate::camera::{Camera, Pose};
use crate::session::View;
use adjust::{Adjusted, adjust};
use nalgebra::{DMatrix, Point2, Vector3};
use observations::{Observation, observations};

/// Views below which nothing is tried.
pub const NEEDED_VIEWS: usize = 3;

/// Rings of a view below which it has no pose.
pub const NEEDED_RINGS: usize = 4;

/// What is estimated first: enough to bend any guess towards the truth, and never ill-determined among itself.
const FIRST: [&str; 3] = ["fx", "fy", "k1"];

/// Standard deviation over value beyond which a focal length counts as left open.
const OPEN_FOCAL: f64 = 0.02;
/// Standard deviation of the principal point over the longer side of the frame beyond which it counts as left open.
const OPEN_CENTRE: f64 = 0.1;
/// Noise of a centre that is assumed at least when asking whether a parameter is left open, px: views that
/// fit by accident, or are made up, must not pass for that.
const LEAST_NOISE_PX: f64 = 0.01;

/// Largest angle between the normals of the views below which they count as parallel, degrees. Distortion can tell the
/// focal length even then, but only as far as the lens model is exactly true.
const PARALLEL_DEG: f64 = 2.0;

/// Estimates the camera that took `views` of `board`.
///
/// The residuals are weighted by the covariance of each ring. A ring without one gets the median variance of those that
/// have one; where none has, all weights are equal.
///
/// # Errors
/// [`CalibrateError`] says what the views lack, or which of them is wrong.
pub fn calibrate(
    board: &Board,
    views: &[View],
    options: &CalibrateOptions,
) -> Result<Calibration, CalibrateError> {
    let rings = observations(board, views)?;
    let free = options.fixed.free();
    let degrees = degrees_of_freedom(&rings, free.len())?;
    let start = guess::guess(views, &rings, &options.fixed)?;
    let adjusted = solve(start, &rings, &free)?;
    not_parallel(&adjusted.poses, &options.fixed)?;
    let variance_factor = adjusted.equations.cost() / degrees;
    let covariance = covariance(&adjusted, &rings, &free, variance_factor)?;
    if !adjusted.converged {
        return Err(CalibrateError::NotConverged {
            iterations: adjusted.iterations,
        });
    }
    plausible(&adjusted.camera, &rings)?;
    Ok(report(
        &adjusted,
        &rings,
        variance_factor,
        covariance,
        options.fixed.names(),
    ))
}

fn degrees_of_freedom(rings: &[Vec<Observation>], free: usize) -> Result<f64, CalibrateError> {
    let measured = 2 * rings.iter().map(Vec::len).sum::<usize>();
    let unknown = free + 6 * rings.len();
    if measured <= unknown {
        return Err(CalibrateError::TooFewMeasurements { measured, unknown });
    }
    Ok((measured - unknown) as f64)
}

fn solve(
    start: (Camera, Vec<Pose>),
    rings: &[Vec<Observation>],
    free: &[usize],
) -> Result<Adjusted, CalibrateError> {
    let first: Vec<usize> = free
        .iter()
        .copied()
        .filter(|at| FIRST.contains(&Camera::PARAMETER_NAMES[*at]))
        .collect();
    adjust(start, rings, &first)
        .and_then(|coarse| adjust((coarse.camera, coarse.poses), rings, free))
        .ok_or(CalibrateError::NotConverged { iterations: 0 })
}

/// Parallel planes share their circular points: however many there are, they give the two equations of one.
fn not_parallel(poses: &[Pose], fixed: &Fixed) -> Result<(), CalibrateError> {
    if fixed.names().starts_with(&["fx", "fy"]) {
        return Ok(());
    }
    let normals: Vec<Vector3<f64>> = poses.iter().map(|p| p.rotation * Vector3::z()).collect();
    let spread = normals
        .iter()
        .enumerate()
        .flat_map(|(i, a)| normals[i + 1..].iter().map(|b| a.angle(b)))
        .fold(0.0, f64::max);
    let spread_deg = spread.to_degrees();
    if spread_deg < PARALLEL_DEG {
        return Err(CalibrateError::Parallel { spread_deg });
    }
    Ok(())
}

/// Covariance of all parameters; refuses where it says that the views leave the camera open.
fn covariance(
    adjusted: &Adjusted,
    rings: &[Vec<Observation>],
    free: &[usize],
    variance_factor: f64,
) -> Result<DMatrix<f64>, CalibrateError> {
    let unit = adjusted.equations.covariance(free).map_err(|at| {
        let name = Camera::PARAMETER_NAMES[free[at]];
        CalibrateError::Undetermined { name }
    })?;
    let factor = variance_factor.max(least_factor(rings));
    let camera = &adjusted.camera;
    let side = f64::from(camera.width.max(camera.height));
    let values = camera.parameters();
    let mut whole = DMatrix::zeros(Camera::PARAMETER_COUNT, Camera::PARAMETER_COUNT);
    for (i, at) in free.iter().enumerate() {
        let name = Camera::PARAMETER_NAMES[*at];
        let limit = match name {
            "fx" | "fy" => OPEN_FOCAL * values[*at].abs(),
            "cx" | "cy" => OPEN_CENTRE * side,
            _ => f64::INFINITY,
        };
        // not a number counts as open
        let told = (factor * unit[(i, i)]).sqrt() <= limit;
        if !told {
            return Err(CalibrateError::Undetermined { name });
        }
        for (j, other) in free.iter().enumerate() {
            whole[(*at, *other)] = variance_factor * unit[(i, j)];
        }
    }
    Ok(whole)
}

/// The variance factor that [`LEAST_NOISE_PX`] would give with the weights of the rings.
fn least_factor(rings: &[Vec<Observation>]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for ring in rings.iter().flatten() {
        sum += ring.whitening.norm_squared();
        count += 2.0;
    }
    LEAST_NOISE_PX * LEAST_NOISE_PX * sum / count
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
    let folds = |pixel: &Point2<f64>| camera.unproject(pixel).is_none();
    match rings.iter().flatten().find(|ring| folds(&ring.pixel)) {
        Some(ring) => absurd(format!(
            "its distortion folds over at ({:.0}, {:.0})",
            ring.pixel.x, ring.pixel.y
        )),
        None => Ok(()),
    }
}

fn report(
    adjusted: &Adjusted,
    rings: &[Vec<Observation>],
    variance_factor: f64,
    covariance: DMatrix<f64>,
    fixed: Vec<&'static str>,
) -> Calibration {
    let views: Vec<ViewFit> = adjusted
        .poses
        .iter()
        .zip(rings)
        .map(|(pose, rings)| {
            let residuals: Vec<_> = rings
                .iter()
                .filter_map(|ring| {
                    let pixel = adjusted
                        .camera
                        .project(&pose.board_to_camera(ring.board_m))?;
                    Some(ring.pixel - pixel)
                })
                .collect();
            ViewFit {
                pose: *pose,
                rms_px: calibration::rms(residuals.iter()),
                residuals,
            }
        })
        .collect();
    Calibration {
        camera: adjusted.camera,
        rms_px: calibration::rms(views.iter().flat_map(|view| &view.residuals)),
        views,
        variance_factor,
        covariance,
        fixed,
        iterations: adjusted.iterations,
    }
}

#[cfg(test)]
pub(crate) mod synthetic;
#[cfg(test)]
mod tests;
