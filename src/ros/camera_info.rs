//! A camera as sensor_msgs/msg/CameraInfo.

use super::messages::CameraInfo;
use crate::camera::Camera;

/// The message of a camera that is not rectified: R is the identity, P the camera matrix with a column of zeros. The
/// header is left empty.
pub fn camera_info(camera: &Camera) -> CameraInfo {
    let i = &camera.intrinsics;
    CameraInfo {
        height: camera.height,
        width: camera.width,
        distortion_model: camera.model().name().to_owned(),
        d: camera.distortion.coefficients(),
        k: [i.fx, 0.0, i.cx, 0.0, i.fy, i.cy, 0.0, 0.0, 1.0],
        r: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p: [
            i.fx, 0.0, i.cx, 0.0, 0.0, i.fy, i.cy, 0.0, 0.0, 0.0, 1.0, 0.0,
        ],
        ..CameraInfo::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Intrinsics, PlumbBob};

    #[test]
    fn numbers_stand_where_ros_looks_for_them() {
        let camera = Camera {
            width: 640,
            height: 480,
            intrinsics: Intrinsics {
                fx: 500.0,
                fy: 501.0,
                cx: 320.0,
                cy: 240.0,
            },
            distortion: PlumbBob {
                k1: 0.1,
                k2: 0.2,
                p1: 0.3,
                p2: 0.4,
                k3: 0.5,
            }
            .into(),
        };
        let info = camera_info(&camera);
        assert_eq!((info.width, info.height), (640, 480));
        assert_eq!(info.d, [0.1, 0.2, 0.3, 0.4, 0.5]);
        // u = K X / Z and u = P (X, 1) / Z for a point before the camera
        let (x, y, z) = (0.2, -0.1, 2.0);
        let expected = (500.0 * x / z + 320.0, 501.0 * y / z + 240.0);
        let row = |m: &[f64], width: usize, r: usize| {
            let point = [x, y, z, 1.0];
            (0..width).map(|c| m[r * width + c] * point[c]).sum::<f64>()
        };
        for (m, width) in [(&info.k[..], 3), (&info.p[..], 4)] {
            let w = row(m, width, 2);
            assert!((row(m, width, 0) / w - expected.0).abs() < 1e-12);
            assert!((row(m, width, 1) / w - expected.1).abs() < 1e-12);
        }
    }
}
