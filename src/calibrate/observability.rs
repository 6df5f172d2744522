//! Whether the views can tell what is asked of them, and what is missing where they cannot.
//!
//! Small residuals say nothing about it: parallel views fit any focal length perfectly. The covariance says it, and the noise that
//! is assumed for it is at least [`LEAST_NOISE_PX`], so that views which fit by accident, or are made up, do not pass for certain.

use super::calibration::Calibration;
use super::observations::Observation;
use super::uncertainty::Range;
use super::{CalibrateError, Missing};
use crate::camera::{Camera, LensModel, Pose};
use nalgebra::{Point2, Vector3};

/// Standard deviation over value beyond which a focal length counts as left open.
const OPEN_FOCAL: f64 = 0.02;
/// Standard deviation of the principal point over the longer side of the frame beyond which it counts as left open.
const OPEN_CENTRE: f64 = 0.1;
/// Projection uncertainty at infinity anywhere in the frame beyond which the lens counts as left open there, px, ...
const OPEN_LENS_PX: f64 = 20.0;
/// ... or a smaller one where it is so many times the noise of a centre: the lens is extrapolated from where the board was.
const EXTRAPOLATED_PX: f64 = 2.0;
const EXTRAPOLATED: f64 = 150.0;
/// The part of the frame that may have no ray, as the corners beyond the image circle of a wide lens have none.
pub(super) const DARK: f64 = 0.25;
/// More of it may have none where rings were seen nearly as far out as the lens reaches: up to this fraction of that, inverted. What the
/// polynomial of the lens does so near to rings is measured; farther out it is made up.
const REACH: f64 = 4.0 / 3.0;
/// Noise of a centre that is assumed at least, px.
const LEAST_NOISE_PX: f64 = 0.01;
/// Largest angle between the normals of the views below which they count as parallel, degrees. Distortion can tell the
/// focal length even then, but only as far as the lens model is exactly true.
const PARALLEL_DEG: f64 = 2.0;
/// Tilt about an axis of the picture that tells the focal length well, rad.
const WANTED_TILT_RAD: f64 = 0.26;
/// Cells of the frame, across and down, in whose middles the lens is asked for.
pub(super) const CELLS: (usize, usize) = (8, 6);

/// Parallel planes share their circular points: however many there are, they give the two equations of one.
pub(super) fn not_parallel(poses: &[Pose]) -> Result<(), CalibrateError> {
    let normals: Vec<Vector3<f64>> = poses.iter().map(|p| p.rotation * Vector3::z()).collect();
    // the largest angle is more than half of the largest from any one of them, and less than twice
    let Some(first) = normals.first() else {
        return Ok(());
    };
    let farthest = normals
        .iter()
        .max_by(|a, b| first.angle(a).total_cmp(&first.angle(b)))
        .unwrap_or(first);
    let spread = normals
        .iter()
        .map(|normal| farthest.angle(normal))
        .fold(0.0, f64::max);
    let spread_deg = spread.to_degrees();
    if spread_deg < PARALLEL_DEG {
        return Err(CalibrateError::Parallel { spread_deg });
    }
    Ok(())
}

/// What is to be shown where a parameter is left open.
pub(super) fn missing(name: &str, poses: &[Pose]) -> Missing {
    if !matches!(name, "fx" | "fy" | "cx" | "cy") {
        return match name {
            "bow_x" | "bow_y" | "pitch_ratio" => Missing::Sheet,
            _ => Missing::Corners,
        };
    }
    let wanted = WANTED_TILT_RAD.sin();
    let normals = || poses.iter().map(|p| p.rotation * Vector3::z());
    let leans = |along: fn(&Vector3<f64>) -> f64| {
        normals().any(|n| along(&n) > wanted) && normals().any(|n| along(&n) < -wanted)
    };
    match (leans(|n| n.x), leans(|n| n.y)) {
        (false, false) => Missing::TiltBoth,
        (false, true) => Missing::TiltSideways,
        (true, false) => Missing::TiltUpright,
        (true, true) => Missing::Views,
    }
}

/// Refuses a calibration whose covariance says that the views leave the camera open.
pub(super) fn determined(
    calibration: &Calibration,
    rings: &[Vec<Observation>],
) -> Result<(), CalibrateError> {
    let camera = &calibration.camera;
    let poses: Vec<Pose> = calibration.views.iter().filter_map(|v| v.pose).collect();
    let least = least_factor(rings);
    let inflation = (least / calibration.variance_factor).max(1.0).sqrt();
    let noise_px = LEAST_NOISE_PX * (calibration.variance_factor / least).max(1.0).sqrt();
    let side = f64::from(camera.width.max(camera.height));
    for (at, name) in calibration.names.iter().enumerate() {
        let limit = match *name {
            "fx" => OPEN_FOCAL * camera.intrinsics.fx.abs(),
            "fy" => OPEN_FOCAL * camera.intrinsics.fy.abs(),
            "cx" | "cy" => OPEN_CENTRE * side,
            _ => f64::INFINITY,
        };
        // not a number counts as open
        let std = inflation * calibration.std(at);
        let told = std <= limit;
        if !told {
            let missing = missing(name, &poses);
            return Err(CalibrateError::Undetermined { name, missing });
        }
    }
    lens_told(calibration, rings, (inflation, noise_px))
}

/// Refuses a lens that is left open somewhere in the frame.
fn lens_told(
    calibration: &Calibration,
    rings: &[Vec<Observation>],
    (inflation, noise_px): (f64, f64),
) -> Result<(), CalibrateError> {
    let map = calibration.projection_std_map(CELLS, Range::Infinity);
    let dark = (0..map.len()).filter(|cell| map[*cell].is_none());
    let (dark, unseen) = dark.fold((0, 0), |(dark, unseen), cell| {
        let made_up = folds_unseen(&calibration.camera, rings, cell);
        (dark + 1, unseen + usize::from(made_up))
    });
    let worst = map
        .iter()
        .enumerate()
        .filter_map(|(cell, std)| Some((cell, inflation * (*std)?)))
        .max_by(|a, b| a.1.total_cmp(&b.1));
    let part = |cells: usize| cells as f64 / map.len() as f64;
    if part(unseen) > DARK {
        return Err(CalibrateError::LensFolds {
            percent: 100.0 * part(dark),
        });
    }
    let extrapolated = EXTRAPOLATED_PX.max(EXTRAPOLATED * noise_px);
    match worst {
        // not a number counts as open
        Some((_, std_px)) if std_px <= OPEN_LENS_PX.min(extrapolated) => Ok(()),
        Some((cell, std_px)) => Err(CalibrateError::LensOpen {
            at: middle(&calibration.camera, cell),
            std_px,
            below: calibration.camera.model() == LensModel::RationalPolynomial
                && !calibration.fixed.contains(&"k6"),
        }),
        None => Ok(()),
    }
}

/// Whether the lens still has rays well beyond the outermost ring on the way to a cell that it has none for.
fn folds_unseen(camera: &Camera, rings: &[Vec<Observation>], cell: usize) -> bool {
    let axis = Point2::new(camera.intrinsics.cx, camera.intrinsics.cy);
    let counted = rings.iter().flatten().filter(|ring| ring.share > 0.0);
    let outermost = counted
        .map(|ring| (ring.pixel - axis).norm())
        .fold(0.0, f64::max);
    let way = middle(camera, cell) - axis;
    let beyond = axis + way * (REACH * outermost / way.norm()).min(1.0);
    camera.ray(&beyond).is_some()
}

/// The middle of a cell, px.
pub(super) fn middle(camera: &Camera, cell: usize) -> Point2<f64> {
    let (column, row) = (cell % CELLS.0, cell / CELLS.0);
    let (width, height) = (f64::from(camera.width), f64::from(camera.height));
    Point2::new(
        ((column as f64 + 0.5) * width / CELLS.0 as f64).round(),
        ((row as f64 + 0.5) * height / CELLS.1 as f64).round(),
    )
}

/// The variance factor that [`LEAST_NOISE_PX`] would give with the weights of the rings.
fn least_factor(rings: &[Vec<Observation>]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for ring in rings.iter().flatten().filter(|ring| ring.share > 0.0) {
        sum += ring.whitening.norm_squared();
        count += 2.0;
    }
    LEAST_NOISE_PX * LEAST_NOISE_PX * sum / f64::max(count, 1.0)
}
