//! What the fit of a ring measures where a lens bends its circles.
//!
//! The model's curves are those of a ring in perspective; a lens adds bends that no perspective makes. The fit then settles where grey
//! values agree best, which is where the curves agree best: edges of equal contrast and blur weigh by their length. So
//! the model's curves are laid through the bent ones by least squares, with the perspective that [`shape_under`] gives them
//! in the fit too, and the centre that comes out less the true one is what the fit is off by: a few thousandths of a
//! pixel for rings of 50 px before a lens of 90 degrees, which is ten times its noise.

use super::lens_map::shape_under;
use super::shape::Shape;
use nalgebra::{Matrix2, Point2, SMatrix, SVector, Vector2};

/// Points of each circle.
const POINTS: usize = 16;
/// Gauss-Newton steps; the start is off by a thousandth of the radius.
const STEPS: usize = 3;

/// The centre that the fit of a ring gives less the true one, px, for a map from outer radii about the ring's centre to the frame and its
/// inner over its outer radius; `None` where the map has no image of the ring.
pub(super) fn bent(
    map: impl Fn(Vector2<f64>) -> Option<Point2<f64>>,
    ratio: f64,
) -> Option<Vector2<f64>> {
    let start = shape_under(&map)?;
    Some(laid(&map, &start, ratio)?.centre - start.centre)
}

/// How far the outline of a ring lies beside the model's curve through it, px (root mean square).
pub(super) fn bends(map: impl Fn(Vector2<f64>) -> Option<Point2<f64>>) -> Option<f64> {
    let shape = laid(&map, &shape_under(&map)?, 1.0)?;
    let squares = curve(&map, 1.0)?.map(|point| {
        let (value, _, slope) = implicit(&shape, &point, 1.0);
        (value / slope.norm()).powi(2)
    });
    Some((squares.iter().sum::<f64>() / POINTS as f64).sqrt())
}

/// The shape, of the perspective of `start`, whose curves lie along the bent ones.
pub(super) fn laid(
    map: &impl Fn(Vector2<f64>) -> Option<Point2<f64>>,
    start: &Shape,
    ratio: f64,
) -> Option<Shape> {
    let mut shape = *start;
    let curves = [curve(map, 1.0)?, curve(map, ratio)?];
    for _ in 0..STEPS {
        let mut normal = SMatrix::<f64, 5, 5>::zeros();
        let mut right = SVector::<f64, 5>::zeros();
        for (curve, radius) in curves.iter().zip([1.0, ratio]) {
            for (i, point) in curve.iter().enumerate() {
                let along = curve[(i + 1) % POINTS] - curve[(i + POINTS - 1) % POINTS];
                let (value, row, slope) = implicit(&shape, point, radius);
                // length of the piece, and the distance to the curve to first order
                let weight = along.norm() / slope.norm_squared();
                normal += row * row.transpose() * weight;
                right += row * (value * weight);
            }
        }
        shape = moved(&shape, &solve(&normal, &right)?);
    }
    Some(shape)
}

fn curve(
    map: &impl Fn(Vector2<f64>) -> Option<Point2<f64>>,
    radius: f64,
) -> Option<[Point2<f64>; POINTS]> {
    let mut points = [Point2::origin(); POINTS];
    for (i, point) in points.iter_mut().enumerate() {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / POINTS as f64).sin_cos();
        *point = map(Vector2::new(cos, sin) * radius)?;
    }
    Some(points)
}

/// Q_a of [`Shape`] at a point, its derivatives by centre and affine shape, and by the point.
fn implicit(
    shape: &Shape,
    point: &Point2<f64>,
    radius: f64,
) -> (f64, SVector<f64, 5>, Vector2<f64>) {
    let u = point - shape.centre;
    let [xx, xy, yy] = shape.affine;
    let affine = Matrix2::new(xx, xy, xy, yy);
    let (q, a2) = (shape.perspective, radius * radius);
    let depth = 1.0 - q.dot(&u);
    let value = u.dot(&(affine * u)) - a2 * depth * depth;
    let slope = affine * u * 2.0 + q * (2.0 * a2 * depth);
    let row = SVector::<f64, 5>::new(-slope.x, -slope.y, u.x * u.x, 2.0 * u.x * u.y, u.y * u.y);
    (value, row, slope)
}

/// The Gauss-Newton step, columns scaled to unit length: px and px^-2 differ by many orders of magnitude.
fn solve(normal: &SMatrix<f64, 5, 5>, right: &SVector<f64, 5>) -> Option<SVector<f64, 5>> {
    let scale = normal.diagonal().map(|square| square.sqrt().recip());
    let unit = SMatrix::<f64, 5, 5>::from_diagonal(&scale);
    let factor = (unit * normal * unit).cholesky()?;
    Some(-(unit * factor.solve(&(unit * right))))
}

fn moved(shape: &Shape, step: &SVector<f64, 5>) -> Shape {
    let [xx, xy, yy] = shape.affine;
    Shape {
        centre: shape.centre + Vector2::new(step[0], step[1]),
        affine: [xx + step[2], xy + step[3], yy + step[4]],
        perspective: shape.perspective,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_perspective_alone_bends_nothing() {
        let map = |d: Vector2<f64>| {
            let w = 1.0 + 0.02 * d.x - 0.01 * d.y;
            Some(Point2::new(
                300.0 + (24.0 * d.x + 3.0 * d.y) / w,
                200.0 + (-2.0 * d.x + 21.0 * d.y) / w,
            ))
        };
        // what is left is of the third order in the perspective, where the fit's perspective is taken by differences
        let off = bent(map, 0.5).unwrap();
        assert!(off.norm() < 1e-3, "{off}");
    }

    #[test]
    fn a_bend_moves_the_fit_and_more_so_for_larger_rings() {
        let bend = |radius_px: f64| {
            bent(
                |d| {
                    let at = Vector2::new(500.0, 300.0) + d * radius_px;
                    let bent = at * (1.0 - 1e-6 * at.norm_squared());
                    Some(Point2::from(bent))
                },
                0.5,
            )
            .unwrap()
            .norm()
        };
        let (small, large) = (bend(10.0), bend(20.0));
        assert!(small > 1e-5 && large > 3.0 * small, "{small} {large}");
    }
}
