//! The pose of a view from the directions of its rays, which needs no image plane: a fisheye has none.

use crate::camera::homography::null_vector;
use crate::camera::{Camera, Pose};
use nalgebra::{DMatrix, Matrix3, Point2, Rotation3, Vector3};

/// Second smallest over largest singular value below which rays do not determine a pose.
const TOLERANCE: f64 = 1e-6;

/// The pose of a plane whose points (m) are seen along these pixels, in closed form: with u the ray and H = [r1 r2 t], u x H (x, y, 1) = 0 is
/// linear in H. `None` for fewer than four points, points in a line, or a plane seen from behind.
pub(super) fn pose_of_rays(camera: &Camera, pairs: &[(Point2<f64>, Point2<f64>)]) -> Option<Pose> {
    let rays = pairs
        .iter()
        .map(|(plane, pixel)| Some((*plane, camera.ray(pixel)?)));
    let rays: Vec<(Point2<f64>, Vector3<f64>)> = rays.collect::<Option<_>>()?;
    if rays.len() < 4 {
        return None;
    }
    let n = rays.len() as f64;
    let middle = rays
        .iter()
        .map(|r| r.0.coords)
        .sum::<nalgebra::Vector2<f64>>()
        / n;
    let size = rays
        .iter()
        .map(|r| (r.0.coords - middle).norm())
        .sum::<f64>()
        / n;
    let mut rows = DMatrix::zeros(3 * rays.len(), 9);
    for (i, (plane, u)) in rays.iter().enumerate() {
        let scaled = (plane.coords - middle) / size;
        let point = [scaled.x, scaled.y, 1.0];
        let cross = u.cross_matrix();
        for (row, line) in cross.row_iter().enumerate() {
            // H by columns
            for (column, p) in point.iter().enumerate() {
                for k in 0..3 {
                    rows[(3 * i + row, 3 * column + k)] = line[k] * p;
                }
            }
        }
    }
    let h = null_vector(&rows, TOLERANCE)?;
    let h = Matrix3::from_column_slice(&h);
    let along: f64 = rays
        .iter()
        .map(|(plane, u)| {
            let scaled = (plane.coords - middle) / size;
            (h * Vector3::new(scaled.x, scaled.y, 1.0)).dot(u)
        })
        .sum();
    let length = 0.5 * (h.column(0).norm() + h.column(1).norm());
    let h = h * (along.signum() / length);
    let nearly = {
        let (r1, r2) = (h.column(0).into_owned(), h.column(1).into_owned());
        Matrix3::from_columns(&[r1, r2, r1.cross(&r2)])
    };
    if !nearly.iter().all(|v| v.is_finite()) {
        return None;
    }
    let svd = nearly.svd(true, true);
    let rotation = Rotation3::from_matrix_unchecked(svd.u? * svd.v_t?);
    let at_middle = h.column(2) * size;
    let pose = Pose {
        rotation,
        translation_m: at_middle - rotation * Vector3::new(middle.x, middle.y, 0.0),
    };
    // the camera looks at the front of the board
    let normal = rotation * Vector3::z();
    (normal.dot(&at_middle) > 0.0).then_some(pose)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Equidistant, Intrinsics};

    #[test]
    fn a_pose_is_found_also_where_rays_point_backward() {
        let camera = Camera {
            width: 1000,
            height: 1000,
            intrinsics: Intrinsics {
                fx: 300.0,
                fy: 300.0,
                cx: 499.5,
                cy: 499.5,
            },
            distortion: Equidistant::default().into(),
        };
        let pose =
            Pose::from_rotation_vector(Vector3::new(0.1, 1.4, 0.2), Vector3::new(0.3, 0.05, 0.02));
        let pairs: Vec<_> = (0..20)
            .map(|i| {
                let plane = [0.03 * f64::from(i % 5), 0.03 * f64::from(i / 5)];
                let pixel = camera.project(&pose.board_to_camera(plane)).unwrap();
                (Point2::from(plane), pixel)
            })
            .collect();
        let found = pose_of_rays(&camera, &pairs).unwrap();
        assert!((found.translation_m - pose.translation_m).norm() < 1e-9);
        assert!((found.rotation.matrix() - pose.rotation.matrix()).norm() < 1e-9);
        let mirrored: Vec<_> = pairs
            .iter()
            .map(|(plane, pixel)| (Point2::new(-plane.x, plane.y), *pixel))
            .collect();
        assert!(pose_of_rays(&camera, &mirrored).is_none());
    }
}
