//! A camera without distortion from homographies, in closed form (Zhang 2000), and the poses that go with it.
//!
//! The first two columns of a view's homography are K r1 and K r2 up to one factor. r1 and r2 are orthogonal and of equal
//! length, which gives two linear equations in the entries of (K K^T)^-1 a view.

use crate::camera::homography::null_vector;
use crate::camera::{Intrinsics, Pose};
use nalgebra::{DMatrix, Matrix3, Rotation3, Vector3};

/// Second smallest over largest singular value of Zhang's equations below which they leave more than one camera.
const ZHANG_TOLERANCE: f64 = 1e-5;

/// Standard deviation over value of the squared inverse focal length beyond which the views do not agree on one.
const AGREEMENT: f64 = 0.3;

/// Focal lengths and principal point without skew; `None` where the views leave them open or noise makes them imaginary.
pub(super) fn intrinsics(homographies: &[Matrix3<f64>], size: (f64, f64)) -> Option<Intrinsics> {
    let to_unit = centring(size);
    let mut rows = DMatrix::zeros(2 * homographies.len(), 5);
    for (view, homography) in homographies.iter().enumerate() {
        let (a, b) = axes(&(to_unit * homography))?;
        let (cross, aa, bb) = (products(&a, &b), products(&a, &a), products(&b, &b));
        for c in 0..5 {
            rows[(2 * view, c)] = cross[c];
            rows[(2 * view + 1, c)] = aa[c] - bb[c];
        }
    }
    let found = null_vector(&rows, ZHANG_TOLERANCE)?;
    let [b11, b22, b13, b23, b33] = <[f64; 5]>::try_from(found).ok()?;
    let (x, y) = (-b13 / b11, -b23 / b22);
    let scale = b33 - b13 * b13 / b11 - b23 * b23 / b22;
    let (fx, fy) = ((scale / b11).sqrt(), (scale / b22).sqrt());
    let unit = 1.0 / to_unit[(0, 0)];
    let intrinsics = Intrinsics {
        fx: fx * unit,
        fy: fy * unit,
        cx: (x - to_unit[(0, 2)]) * unit,
        cy: (y - to_unit[(1, 2)]) * unit,
    };
    let finite = [fx, fy, x, y].iter().all(|v| v.is_finite());
    (finite && fx > 0.0 && fy > 0.0).then_some(intrinsics)
}

/// Entries of a^T B b for a symmetric B without skew, in the order B11, B22, B13, B23, B33.
fn products(a: &Vector3<f64>, b: &Vector3<f64>) -> [f64; 5] {
    [
        a.x * b.x,
        a.y * b.y,
        a.x * b.z + a.z * b.x,
        a.y * b.z + a.z * b.y,
        a.z * b.z,
    ]
}

/// The focal length (px) of square pixels about the middle of a frame of (width, height) px that the homographies
/// (board plane in m to frame in px) agree on, distortion neglected; `None` where they do not agree on one, as
/// frontal views never do.
pub fn focal_length_px(homographies: &[Matrix3<f64>], size: (f64, f64)) -> Option<f64> {
    let to_unit = centring(size);
    let (mut aa, mut ab, mut bb, mut count) = (0.0, 0.0, 0.0, 0.0);
    for homography in homographies {
        let (p, q) = axes(&(to_unit * homography))?;
        let equations = [
            (p.x * q.x + p.y * q.y, p.z * q.z),
            (
                p.x * p.x + p.y * p.y - q.x * q.x - q.y * q.y,
                p.z * p.z - q.z * q.z,
            ),
        ];
        for (a, b) in equations {
            (aa, ab, bb, count) = (aa + a * a, ab + a * b, bb + b * b, count + 1.0);
        }
    }
    // a u + b = 0 in u = 1 / f^2, least squares
    let u = -ab / aa;
    let variance = (bb + ab * u).max(0.0) / ((count - 1.0) * aa);
    let focal = 1.0 / (u.sqrt() * to_unit[(0, 0)]);
    let agreed = u > 0.0 && variance.sqrt() < AGREEMENT * u && focal.is_finite();
    agreed.then_some(focal)
}

/// Normal of the board plane in the camera frame, pointing away from the camera, for a focal length in px and a frame
/// of (width, height) px; `None` for a degenerate homography.
pub fn plane_normal(
    homography: &Matrix3<f64>,
    focal_px: f64,
    size: (f64, f64),
) -> Option<Vector3<f64>> {
    let intrinsics = centred(focal_px, size);
    let pose = pose(homography, &intrinsics)?;
    let normal = pose.rotation * Vector3::z();
    Some(if normal.z < 0.0 { -normal } else { normal })
}

/// Square pixels about the middle of the frame.
pub(super) fn centred(focal_px: f64, size: (f64, f64)) -> Intrinsics {
    Intrinsics {
        fx: focal_px,
        fy: focal_px,
        cx: 0.5 * (size.0 - 1.0),
        cy: 0.5 * (size.1 - 1.0),
    }
}

/// The pose behind a homography (board plane in m to frame in px): the rotation closest to its columns; `None` for a
/// degenerate homography and for a board seen from behind.
pub fn pose(homography: &Matrix3<f64>, intrinsics: &Intrinsics) -> Option<Pose> {
    let k = Matrix3::new(
        intrinsics.fx,
        0.0,
        intrinsics.cx,
        0.0,
        intrinsics.fy,
        intrinsics.cy,
        0.0,
        0.0,
        1.0,
    );
    let columns = k.try_inverse()? * homography;
    let length = 0.5 * (columns.column(0).norm() + columns.column(1).norm());
    let scale = if columns[(2, 2)] < 0.0 {
        -1.0 / length
    } else {
        1.0 / length
    };
    let columns = columns * scale;
    let (r1, r2) = (
        columns.column(0).into_owned(),
        columns.column(1).into_owned(),
    );
    let nearly = Matrix3::from_columns(&[r1, r2, r1.cross(&r2)]);
    if !nearly.iter().all(|v| v.is_finite()) || nearly.determinant() <= 0.0 {
        return None;
    }
    let svd = nearly.svd(true, true);
    let rotation = Rotation3::from_matrix_unchecked(svd.u? * svd.v_t?);
    let translation_m = columns.column(2).into_owned();
    // the camera looks at the front of the board
    ((rotation * Vector3::z()).dot(&translation_m) > 0.0).then_some(Pose {
        rotation,
        translation_m,
    })
}

/// Moves the origin to the middle of the frame and makes half its longer side the unit.
fn centring(size: (f64, f64)) -> Matrix3<f64> {
    let scale = 2.0 / size.0.max(size.1);
    let centre = centred(1.0, size);
    Matrix3::new(
        scale,
        0.0,
        -scale * centre.cx,
        0.0,
        scale,
        -scale * centre.cy,
        0.0,
        0.0,
        1.0,
    )
}

/// The first two columns at a common scale that makes every view count alike.
fn axes(homography: &Matrix3<f64>) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let (a, b) = (
        homography.column(0).into_owned(),
        homography.column(1).into_owned(),
    );
    let scale = 1.0 / (a.xy().norm() * b.xy().norm()).sqrt();
    scale.is_finite().then(|| (a * scale, b * scale))
}
