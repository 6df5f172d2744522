//! Views made by projecting a board with a known camera, for tests.

use crate::board::{Board, Polarity};
use crate::camera::{Camera, Intrinsics, PlumbBob, Pose};
use crate::centre::{Centre, Ellipse, RingEllipses};
use crate::detect::{Detection, Indices, Ring};
use crate::session::View;
use nalgebra::{Matrix2, Point2, Rotation3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// 7 x 7 rings, 26.9 mm apart.
pub fn board() -> Board {
    Board::new(7, 7, 0.0269, 0.003, 0.006, Polarity::DarkOnLight).unwrap()
}

/// A wide lens: 400 px on 640 x 480, strong barrel distortion.
pub fn wide() -> Camera {
    camera(
        (640, 480),
        [401.5, 399.2, 322.4, 236.1],
        [-0.3, 0.09, 0.0008, -0.0012, -0.01],
    )
}

/// An ordinary lens on 1280 x 960.
pub fn ordinary() -> Camera {
    camera(
        (1280, 960),
        [1203.0, 1201.0, 641.0, 470.0],
        [-0.12, 0.05, 0.0004, -0.0003, 0.0],
    )
}

/// A 50 mm lens on pixels of 2.4 um.
pub fn long() -> Camera {
    camera(
        (5496, 3672),
        [20830.0, 20841.0, 2760.0, 1820.0],
        [-0.06, 0.3, 0.0002, 0.0003, 0.0],
    )
}

fn camera(size: (u32, u32), k: [f64; 4], d: [f64; 5]) -> Camera {
    Camera {
        width: size.0,
        height: size.1,
        intrinsics: Intrinsics {
            fx: k[0],
            fy: k[1],
            cx: k[2],
            cy: k[3],
        },
        distortion: PlumbBob {
            k1: d[0],
            k2: d[1],
            p1: d[2],
            p2: d[3],
            k3: d[4],
        }
        .into(),
    }
}

/// The board's middle on the ray through `pixel`, so far that the board is `fill` of the frame's height tall, tilted by
/// a rotation vector (rad).
pub fn pose_at(camera: &Camera, board: &Board, pixel: [f64; 2], fill: f64, turn: [f64; 3]) -> Pose {
    let ray = camera.unproject(&Point2::from(pixel)).unwrap();
    let height_m = f64::from(board.rows() - 1) * board.pitch_m();
    let distance = camera.intrinsics.fy * height_m / (fill * f64::from(camera.height));
    let rotation = Rotation3::new(Vector3::from(turn));
    let [x, y] = board.middle_m();
    Pose {
        rotation,
        translation_m: Vector3::new(ray.x, ray.y, 1.0) * distance
            - rotation * Vector3::new(x, y, 0.0),
    }
}

/// 12 poses over the frame, tilted by up to 35 degrees in all directions.
pub fn poses(camera: &Camera, board: &Board) -> Vec<Pose> {
    let (w, h) = (f64::from(camera.width), f64::from(camera.height));
    (0..12)
        .map(|i| {
            let angle = f64::from(i) * 2.4;
            let (x, y) = (f64::from(i % 4), f64::from(i / 4));
            let pixel = [w * (0.3 + 0.4 * x / 3.0), h * (0.35 + 0.3 * y / 2.0)];
            let tilt = if i % 3 == 0 { 0.35 } else { 0.6 };
            let turn = [tilt * angle.cos(), tilt * angle.sin(), 0.2 * (x - 1.5)];
            pose_at(camera, board, pixel, 0.55, turn)
        })
        .collect()
}

/// The views of these poses, with Gaussian noise of `sigma_px` on each coordinate.
pub fn views(
    camera: &Camera,
    board: &Board,
    poses: &[Pose],
    sigma_px: f64,
    seed: u64,
) -> Vec<View> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut noise = || -> f64 {
        let unit: f64 = StandardNormal.sample(&mut random);
        sigma_px * unit
    };
    poses
        .iter()
        .enumerate()
        .map(|(i, pose)| {
            let detection = detection(camera, board, pose, &mut noise);
            View::of_file(format!("view {i}"), &detection)
        })
        .collect()
}

/// A detection of the whole board, each coordinate moved by `noise`.
pub fn detection(
    camera: &Camera,
    board: &Board,
    pose: &Pose,
    noise: &mut dyn FnMut() -> f64,
) -> Detection {
    let rings = board
        .indices()
        .map(|(row, column)| {
            let point = pose.board_to_camera(board.centre_m(row, column));
            let exact = camera.project(&point).expect("in front of the camera");
            let centre = Point2::new(exact.x + noise(), exact.y + noise());
            let ellipse = |radius_m: f64| Ellipse {
                centre,
                major: camera.intrinsics.fx * radius_m / point.z,
                minor: camera.intrinsics.fx * radius_m / point.z,
                angle: 0.0,
            };
            Ring {
                row,
                column,
                centre: Centre {
                    point: centre,
                    covariance: None,
                },
                ellipses: RingEllipses {
                    inner: ellipse(board.inner_radius_m()),
                    outer: ellipse(board.outer_radius_m()),
                },
                blur_sigma_px: 3.0,
                kept: None,
            }
        })
        .collect();
    let k = &camera.intrinsics;
    let matrix = nalgebra::Matrix3::new(k.fx, 0.0, k.cx, 0.0, k.fy, k.cy, 0.0, 0.0, 1.0);
    let rotation = pose.rotation.matrix();
    let motion = nalgebra::Matrix3::from_columns(&[
        rotation.column(0).into_owned(),
        rotation.column(1).into_owned(),
        pose.translation_m,
    ]);
    Detection {
        width: camera.width as usize,
        height: camera.height as usize,
        indices: Indices::Absolute,
        rings,
        homography: matrix * motion,
        photometric: None,
        another: None,
    }
}

/// The same covariance for every ring of the views.
pub fn with_covariance(views: &mut [View], covariance: Matrix2<f64>) {
    for ring in views.iter_mut().flat_map(|view| &mut view.rings) {
        ring.centre.covariance = Some(covariance);
    }
}
