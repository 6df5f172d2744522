//! How far two calibrations of one camera are apart, in pixels over the frame.
//!
//! Each pixel's ray by the first camera is seen by the second one somewhere else. A rotation of the camera is taken off first: which way
//! a camera points within its housing is a matter of its poses and no part of the calibration (as mrcal does it, Kogan
//! 2021). Both are compared at infinity.

use crate::camera::Camera;
use nalgebra::{Matrix3, Point2, Point3, Rotation3, Vector2, Vector3};

/// Gauss-Newton steps for the rotation; it is small, and two are enough.
const STEPS: usize = 20;
/// The rotation has settled, rad.
const SETTLED: f64 = 1e-12;

/// Where the second camera sees what the first one sees, less where the first one does.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// Cells across and down the frame.
    pub cells: (usize, usize),
    /// In the middles of the cells, by rows, px; `None` where either camera has no ray.
    pub offsets_px: Vec<Option<Vector2<f64>>>,
    /// The rotation taken off, as axis times angle in the frame of the second camera, rad.
    pub rotation_rad: Vector3<f64>,
    /// Root mean square length over the frame, px.
    pub rms_px: f64,
    /// The longest one, px.
    pub worst_px: f64,
}

/// Compares two calibrations in the middles of `cells` (across, down) of the first one's frame, with the rotation that best aligns them; a
/// camera of another frame size is compared at the same pixels. `None` where fewer than three cells have rays in both.
pub fn difference(first: &Camera, second: &Camera, cells: (usize, usize)) -> Option<Difference> {
    let (width, height) = (f64::from(first.width), f64::from(first.height));
    let pixels: Vec<Point2<f64>> = (0..cells.0 * cells.1)
        .map(|cell| {
            let x = ((cell % cells.0) as f64 + 0.5) * width / cells.0 as f64 - 0.5;
            let y = ((cell / cells.0) as f64 + 0.5) * height / cells.1 as f64 - 0.5;
            Point2::new(x, y)
        })
        .collect();
    let rays: Vec<Option<Vector3<f64>>> = pixels.iter().map(|pixel| first.ray(pixel)).collect();
    let rotation = aligning(&pixels, &rays, second)?;
    let offsets_px: Vec<Option<Vector2<f64>>> = pixels
        .iter()
        .zip(&rays)
        .map(|(pixel, ray)| {
            let seen = second.project(&Point3::from(rotation * (*ray)?))?;
            Some(seen - pixel)
        })
        .collect();
    let lengths: Vec<f64> = offsets_px.iter().flatten().map(Vector2::norm).collect();
    let squares: f64 = lengths.iter().map(|l| l * l).sum();
    (lengths.len() >= 3).then(|| Difference {
        cells,
        rotation_rad: rotation.scaled_axis(),
        rms_px: (squares / lengths.len() as f64).sqrt(),
        worst_px: lengths.iter().copied().fold(0.0, f64::max),
        offsets_px,
    })
}

/// The rotation that makes the second camera see the rays where the first one does, least squares in px.
fn aligning(
    pixels: &[Point2<f64>],
    rays: &[Option<Vector3<f64>>],
    second: &Camera,
) -> Option<Rotation3<f64>> {
    let mut rotation = closest(pixels, rays, second)?;
    for _ in 0..STEPS {
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for (pixel, ray) in pixels.iter().zip(rays) {
            let Some(turned) = ray.map(|ray| rotation * ray) else {
                continue;
            };
            let Some(seen) = second.project_with_derivatives(&Point3::from(turned)) else {
                continue;
            };
            let by_turn = -seen.wrt_point * turned.cross_matrix();
            normal += by_turn.transpose() * by_turn;
            right += by_turn.transpose() * (seen.pixel - pixel);
        }
        let step = -normal.cholesky()?.solve(&right);
        rotation = Rotation3::new(step) * rotation;
        if step.norm() < SETTLED {
            break;
        }
    }
    Some(rotation)
}

/// The rotation of the rays themselves, in closed form (Kabsch 1976): a start for the one in px.
fn closest(
    pixels: &[Point2<f64>],
    rays: &[Option<Vector3<f64>>],
    second: &Camera,
) -> Option<Rotation3<f64>> {
    let mut sum = Matrix3::zeros();
    for (pixel, ray) in pixels.iter().zip(rays) {
        if let (Some(from), Some(to)) = (ray, second.ray(pixel)) {
            sum += to * from.transpose();
        }
    }
    let svd = sum.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let upright = Vector3::new(1.0, 1.0, (u * v_t).determinant().signum());
    let matrix = u * Matrix3::from_diagonal(&upright) * v_t;
    Some(Rotation3::from_matrix_unchecked(matrix))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::synthetic::{ordinary, wide};

    #[test]
    fn a_camera_differs_from_itself_by_nothing() {
        let found = difference(&wide(), &wide(), (10, 8)).unwrap();
        assert!(found.worst_px < 1e-9 && found.rotation_rad.norm() < 1e-12);
    }

    #[test]
    fn a_shift_of_the_principal_point_is_nearly_a_rotation_and_a_focal_length_is_not() {
        let camera = ordinary();
        let mut shifted = camera;
        shifted.intrinsics.cx += 2.0;
        let found = difference(&camera, &shifted, (10, 8)).unwrap();
        assert!(found.worst_px < 1.0, "{}", found.worst_px);
        let turned = found.rotation_rad.y.abs() * camera.intrinsics.fx;
        assert!((turned - 2.0).abs() < 0.2, "{turned}");
        let mut longer = camera;
        longer.intrinsics.fx *= 1.01;
        let found = difference(&camera, &longer, (10, 8)).unwrap();
        assert!(
            (found.worst_px - 0.01 * 576.0).abs() < 1.0,
            "{}",
            found.worst_px
        );
    }
}
