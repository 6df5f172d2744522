//! The most conspicuous patch of a frame: where a ring stands that blur has left no edge.
//!
//! The frame is halved until it is small, a plane through its border is taken for the paper, and what is darker (or lighter) than
//! that is one patch by its moments. Blur of any symmetric kernel leaves the first moment where it is.

use crate::centre::Ellipse;
use crate::frame::{Frame, Level, Plane, half, half_of_frame};
use nalgebra::{Matrix2, Matrix3, Point2, Vector3};

/// The frame is halved until its longer side is at most this, px.
const SMALL_PX: usize = 128;
/// Width of the border that shows paper, as a fraction of the shorter side.
const BORDER: f64 = 0.06;
/// Pixels belong to the patch from this fraction of its depth on.
const SKIRT: f64 = 0.15;
/// A patch is at least this deep, light at full scale 1.
const LEAST_DEPTH: f64 = 0.02;
/// Semi-axes of the patch in standard deviations of its mass.
const AXES: f64 = 2.0;

/// The outline of the patch; `sign` is 1 where it is darker than the paper, -1 where it is lighter. `None` where nothing stands out.
pub(super) fn patch(frame: &Frame, sign: f64) -> Option<Ellipse> {
    let (mut picture, mut level) = (half_of_frame(frame)?, 1);
    while picture.width().max(picture.height()) > SMALL_PX {
        picture = half(&picture)?;
        level += 1;
    }
    let paper = paper(&picture)?;
    let depth = |x: usize, y: usize| {
        let ground = paper.dot(&Vector3::new(1.0, x as f64, y as f64));
        sign * (ground - f64::from(picture.at(x, y)))
    };
    let (seed, deepest) = deepest(&picture, depth)?;
    if deepest < LEAST_DEPTH {
        return None;
    }
    let members = connected(&picture, seed, |x, y| depth(x, y) > SKIRT * deepest);
    let (mut mass, mut first, mut second) = (0.0, nalgebra::Vector2::zeros(), Matrix2::zeros());
    for &(x, y) in &members {
        let (weight, at) = (depth(x, y), nalgebra::Vector2::new(x as f64, y as f64));
        mass += weight;
        first += at * weight;
        second += at * at.transpose() * weight;
    }
    let centre = first / mass;
    let spread = second / mass - centre * centre.transpose();
    let eigen = spread.symmetric_eigen();
    let (a, b) = (eigen.eigenvalues[0], eigen.eigenvalues[1]);
    let (long, (high, low)) = if a >= b { (0, (a, b)) } else { (1, (b, a)) };
    let axis = eigen.eigenvectors.column(long);
    let scale = Level(level).scale();
    let ellipse = Ellipse {
        centre: Point2::new(
            Level(level).to_frame(centre.x),
            Level(level).to_frame(centre.y),
        ),
        major: AXES * high.max(0.0).sqrt() * scale,
        minor: AXES * low.max(0.0).sqrt() * scale,
        angle: (axis[1] / axis[0]).atan(),
    };
    (ellipse.minor > scale).then_some(ellipse)
}

/// The plane through the picture's border: grey at (0, 0), along x and along y.
fn paper(picture: &Plane<f32>) -> Option<Vector3<f64>> {
    let (width, height) = (picture.width(), picture.height());
    let border = ((BORDER * width.min(height) as f64) as usize).max(1);
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for y in 0..height {
        for x in 0..width {
            let inside = x.min(width - 1 - x).min(y.min(height - 1 - y));
            if inside < border {
                let row = Vector3::new(1.0, x as f64, y as f64);
                normal += row * row.transpose();
                right += row * f64::from(picture.at(x, y));
            }
        }
    }
    normal.cholesky().map(|c| c.solve(&right))
}

/// The pixel whose 3 x 3 neighbourhood is deepest, and how deep that is.
fn deepest(
    picture: &Plane<f32>,
    depth: impl Fn(usize, usize) -> f64,
) -> Option<((usize, usize), f64)> {
    let (width, height) = (picture.width(), picture.height());
    let mean = |x: usize, y: usize| {
        let around = (y - 1..=y + 1).flat_map(|v| (x - 1..=x + 1).map(move |u| (u, v)));
        around.map(|(u, v)| depth(u, v)).sum::<f64>() / 9.0
    };
    (1..height.checked_sub(1)?)
        .flat_map(|y| (1..width.saturating_sub(1)).map(move |x| (x, y)))
        .map(|at| (at, mean(at.0, at.1)))
        .max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The pixels that hang together with a seed, 4-connected.
fn connected(
    picture: &Plane<f32>,
    seed: (usize, usize),
    belongs: impl Fn(usize, usize) -> bool,
) -> Vec<(usize, usize)> {
    let (width, height) = (picture.width(), picture.height());
    let mut seen = vec![false; width * height];
    let (mut members, mut open) = (vec![seed], vec![seed]);
    seen[seed.1 * width + seed.0] = true;
    while let Some((x, y)) = open.pop() {
        let next = [
            (x.wrapping_sub(1), y),
            (x + 1, y),
            (x, y.wrapping_sub(1)),
            (x, y + 1),
        ];
        for (u, v) in next {
            if u < width && v < height && !seen[v * width + u] && belongs(u, v) {
                seen[v * width + u] = true;
                members.push((u, v));
                open.push((u, v));
            }
        }
    }
    members
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_blurred_patch_is_found_in_uneven_light() {
        let data = (0..400 * 300).map(|i| {
            let (x, y) = (f64::from(i % 400), f64::from(i / 400));
            let (u, v) = ((x - 230.0) / 50.0, (y - 140.0) / 35.0);
            let dark = 0.5 * (-0.5 * (u * u + v * v)).exp();
            ((0.8 + 0.0003 * x - dark) * 60000.0) as u16
        });
        let frame = Frame::from_u16(Plane::from_vec(400, 300, data.collect()).unwrap(), "x");
        let found = patch(&frame, 1.0).unwrap();
        assert!((found.centre - Point2::new(230.0, 140.0)).norm() < 4.0);
        assert!(found.major > 60.0 && found.major < 110.0 && found.angle.abs() < 0.1);
        assert!(patch(&frame, -1.0).is_none_or(|p| (p.centre.x - 230.0).abs() > 50.0));
    }

    #[test]
    fn an_even_frame_has_none() {
        assert!(patch(&Frame::from_u8(Plane::filled(300, 200, 90), "x"), 1.0).is_none());
        assert!(patch(&Frame::from_u8(Plane::filled(2, 2, 90), "x"), 1.0).is_none());
    }
}
