//! What the fit of a ring measures where a lens bends its circles.
//!
//! The model's curves are those of a ring in perspective; a lens adds bends that no perspective makes. The fit then settles where grey
//! values agree best, which is where the curves agree best: edges of equal contrast and blur weigh by their length. So
//! the model's curves are laid through the bent ones by least squares, with the perspective that [`shape_under`] gives them
//! in the fit too, and the centre that comes out less the true one is what the fit is off by: a few thousandths of a
//! pixel for rings of 50 px before a lens of 90 degrees, which is ten times its noise.

use super::boundary::by_shape;
use super::lens_map::shape_under;
use super::shape::{PERSPECTIVE, SHAPE_PARAMETERS, Shape};
use nalgebra::{Matrix2, Point2, SMatrix, SVector, Vector2};

/// Points of each circle.
const POINTS: usize = 16;
/// Gauss-Newton steps; the start is off by a thousandth of the radius.
const STEPS: usize = 3;

/// Where a camera sees a place about a ring's centre, in outer radii.
pub(super) trait Image: Fn(Vector2<f64>) -> Option<Point2<f64>> {}
impl<F: Fn(Vector2<f64>) -> Option<Point2<f64>>> Image for F {}

/// What a lens's bends do to one ring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bent {
    /// The ring without its bends.
    pub(super) straight: Shape,
    /// The shape of the same perspective whose curves lie along the bent ones.
    laid: Shape,
    /// How far the outer curve lies beside that of the first, px (root mean square).
    pub(super) beside_px: f64,
    /// The bent ones, px, and the inner one's radius, outer radii.
    curves: Curves,
    ratio: f64,
}

/// Points of the outer and the inner circle.
type Curves = [[Point2<f64>; POINTS]; 2];

impl Bent {
    /// For a map from outer radii about the ring's centre to the frame and its inner over its outer radius; `None` where the map has no image
    /// of the ring.
    pub(super) fn of(image: &impl Image, ratio: f64) -> Option<Self> {
        Self::beside(shape_under(image)?, image, ratio)
    }

    /// The same, where the ring without its bends is known.
    pub(super) fn beside(straight: Shape, image: &impl Image, ratio: f64) -> Option<Self> {
        let curves = [curve(image, 1.0)?, curve(image, ratio)?];
        let laid = laid_along::<PERSPECTIVE>(&straight, &curves, ratio)?;
        let squares = curves[0].map(|point| {
            let (value, _, slope) = implicit(&laid, &point, 1.0);
            (value / slope.norm()).powi(2)
        });
        Some(Self {
            straight,
            laid,
            beside_px: (squares.iter().sum::<f64>() / POINTS as f64).sqrt(),
            curves,
            ratio,
        })
    }

    /// The shape whose curves lie along the bent ones if its perspective is free too.
    pub(super) fn free(&self) -> Option<Shape> {
        laid_along::<SHAPE_PARAMETERS>(&self.straight, &self.curves, self.ratio)
    }

    /// As large as a fit makes it, in its place: what is left beside its curves has no part that a window's pixels could take for a move.
    pub(super) fn as_large(&self) -> Shape {
        Shape {
            centre: self.straight.centre,
            ..self.laid
        }
    }

    /// How far what a free fit finds under this blur may be from what the curves alone say, px: blur mixes the two circles. The more so the larger
    /// it is against the ring; measured before lenses of 90 degrees, rings of 10 to 68 px.
    pub(super) fn unlike_px(&self, sigma_px: f64) -> f64 {
        let blur = sigma_px / self.straight.size_px();
        self.beside_px * (0.01 + blur * (0.5 + 10.0 * blur))
    }

    /// The centre that the fit of the ring gives less the true one, px.
    pub(super) fn moved(&self) -> Vector2<f64> {
        self.laid.centre - self.straight.centre
    }
}

/// The shape whose curves lie along these, the first N of its parameters found and the others those of `start`.
fn laid_along<const N: usize>(start: &Shape, curves: &Curves, ratio: f64) -> Option<Shape> {
    let mut shape = *start;
    for _ in 0..STEPS {
        let mut normal = SMatrix::<f64, N, N>::zeros();
        let mut right = SVector::<f64, N>::zeros();
        for (curve, radius) in curves.iter().zip([1.0, ratio]) {
            for (i, point) in curve.iter().enumerate() {
                let along = curve[(i + 1) % POINTS] - curve[(i + POINTS - 1) % POINTS];
                let (value, row, slope) = implicit(&shape, point, radius);
                let row = row.fixed_rows::<N>(0);
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

fn curve(image: &impl Image, radius: f64) -> Option<[Point2<f64>; POINTS]> {
    let mut points = [Point2::origin(); POINTS];
    for (i, point) in points.iter_mut().enumerate() {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / POINTS as f64).sin_cos();
        *point = image(Vector2::new(cos, sin) * radius)?;
    }
    Some(points)
}

/// Q_a of [`Shape`] at a point, its derivatives by the shape, and by the point.
fn implicit(
    shape: &Shape,
    point: &Point2<f64>,
    radius: f64,
) -> (f64, SVector<f64, SHAPE_PARAMETERS>, Vector2<f64>) {
    let u = point - shape.centre;
    let ([xx, xy, yy], q) = (shape.affine, shape.perspective);
    let affine = Matrix2::new(xx, xy, xy, yy);
    let square = radius * radius;
    let depth = 1.0 - q.dot(&u);
    let value = u.dot(&(affine * u)) - square * depth * depth;
    let slope = affine * u * 2.0 + q * (2.0 * square * depth);
    let row = by_shape(shape.affine, [q.x, q.y], 2.0 * square, [u.x, u.y]);
    (value, row.into(), slope)
}

/// The Gauss-Newton step, columns scaled to unit length: px and px^-2 differ by many orders of magnitude.
fn solve<const N: usize>(
    normal: &SMatrix<f64, N, N>,
    right: &SVector<f64, N>,
) -> Option<SVector<f64, N>> {
    let scale = normal.diagonal().map(|square| square.sqrt().recip());
    let unit = SMatrix::<f64, N, N>::from_diagonal(&scale);
    let factor = (unit * normal * unit).cholesky()?;
    Some(-(unit * factor.solve(&(unit * right))))
}

fn moved<const N: usize>(shape: &Shape, step: &SVector<f64, N>) -> Shape {
    let mut parameters = shape.parameters();
    for (parameter, step) in parameters.iter_mut().zip(step.iter()) {
        *parameter += step;
    }
    Shape::from_parameters(&parameters)
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
        let off = Bent::of(&map, 0.5).unwrap().moved();
        assert!(off.norm() < 1e-3, "{off}");
    }

    #[test]
    fn a_bend_moves_the_fit_and_more_so_for_larger_rings() {
        let bend = |radius_px: f64| {
            let map = |d: Vector2<f64>| {
                let at = Vector2::new(500.0, 300.0) + d * radius_px;
                Some(Point2::from(at * (1.0 - 1e-6 * at.norm_squared())))
            };
            Bent::of(&map, 0.5).unwrap().moved().norm()
        };
        let (small, large) = (bend(10.0), bend(20.0));
        assert!(small > 1e-5 && large > 3.0 * small, "{small} {large}");
    }
}
