//! The projective image of two concentric circles, up to what a circle does not show.
//!
//! In coordinates x' = x - c about the projected centre c, a circle of radius a (in outer radii) is the curve
//! `Q_a(x') = x'^T N x' - a^2 (1 - q . x')^2 = 0`: N is the affine shape (the inverse square of the semi-axes for a
//! frontal ring), q the perspective. Derivation: a homography that carries the circles' centre to c is u = T x' followed by
//! X = u / (1 - g . u), with T symmetric because a rotation of the circle shows nothing; |X|^2 = a^2, N = T^2, q = T g.

use crate::centre::Ellipse;
use nalgebra::{Matrix2, Point2, Vector2};

/// Parameters of a shape, in the order of `Shape::parameters`.
pub const SHAPE_PARAMETERS: usize = 7;
/// Where the affine form stands among them, and the perspective.
pub(super) const AFFINE: usize = 2;
pub(super) const PERSPECTIVE: usize = 5;

/// Most of the way from a ring's centre to its plane's horizon that its outer circle may reach. A board held so close that its
/// rings look like that shows no board; a fit that was led there lays an outline through the whole frame.
const MOST_OF_THE_WAY: f64 = 0.6;

/// Where a ring is and how it is tilted; px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    /// The projected centre c, px.
    pub centre: Point2<f64>,
    /// N: xx, xy, yy, px^-2.
    pub affine: [f64; 3],
    /// q, px^-1.
    pub perspective: Vector2<f64>,
}

impl Shape {
    /// A ring without perspective whose outer circle is this ellipse.
    pub fn frontal(outer: &Ellipse) -> Self {
        let conic = outer.conic();
        Self {
            centre: outer.centre,
            affine: [conic[(0, 0)], conic[(0, 1)], conic[(1, 1)]],
            perspective: Vector2::zeros(),
        }
    }

    /// The ring of this perspective whose outer circle is this ellipse.
    pub fn in_perspective(outer: &Ellipse, perspective: Vector2<f64>) -> Option<Self> {
        let conic = outer.conic();
        let form = conic.fixed_view::<2, 2>(0, 0).into_owned();
        let q = perspective;
        // Q_1 = (x - m)^T s E (x - m) - s with s = 1 + q^T E^-1 q / s and m = -E^-1 q / s
        let moved = form.try_inverse()? * q;
        let s = 0.5 * (1.0 + (1.0 + 4.0 * q.dot(&moved)).sqrt());
        let affine = form * s + q * q.transpose();
        Some(Self {
            centre: outer.centre + moved / s,
            affine: [affine[(0, 0)], affine[(0, 1)], affine[(1, 1)]],
            perspective: q,
        })
    }

    /// The same ring, larger by a factor.
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            centre: self.centre,
            affine: self.affine.map(|v| v / (factor * factor)),
            perspective: self.perspective,
        }
    }

    /// Radius of a circle as large as the outer one without its perspective, px.
    pub(super) fn size_px(&self) -> f64 {
        let [xx, xy, yy] = self.affine;
        (xx * yy - xy * xy).max(f64::MIN_POSITIVE).powf(-0.25)
    }

    /// Centre x, y; affine xx, xy, yy; perspective x, y.
    pub(super) fn parameters(&self) -> [f64; SHAPE_PARAMETERS] {
        let [xx, xy, yy] = self.affine;
        let (c, q) = (self.centre, self.perspective);
        [c.x, c.y, xx, xy, yy, q.x, q.y]
    }

    pub(super) fn from_parameters(p: &[f64; SHAPE_PARAMETERS]) -> Self {
        Self {
            centre: Point2::new(p[0], p[1]),
            affine: [p[2], p[3], p[4]],
            perspective: Vector2::new(p[5], p[6]),
        }
    }

    /// The part of the way to the horizon, (q^T N^-1 q)^(1/2), that the outer circle reaches; `None` where N is no ellipse's.
    fn way_to_the_horizon(&self) -> Option<f64> {
        let [xx, xy, yy] = self.affine;
        let q = self.perspective;
        let determinant = xx * yy - xy * xy;
        let square = (yy * q.x * q.x - 2.0 * xy * q.x * q.y + xx * q.y * q.y) / determinant;
        (xx > 0.0 && determinant > 0.0 && square >= 0.0).then(|| square.sqrt())
    }

    /// The matrix and vector of Q_a = x'^T M x' + 2 m . x' - a^2.
    pub(super) fn quadric(&self, radius: f64) -> (Matrix2<f64>, Vector2<f64>) {
        let [xx, xy, yy] = self.affine;
        let (q, a2) = (self.perspective, radius * radius);
        let matrix = Matrix2::new(xx, xy, xy, yy) - q * q.transpose() * a2;
        (matrix, q * a2)
    }

    /// The image of the circle of this radius (in outer radii); `None` where it is no ellipse, or the plane's horizon is too near.
    pub fn ellipse(&self, radius: f64) -> Option<Ellipse> {
        if self.way_to_the_horizon()? * radius > MOST_OF_THE_WAY {
            return None;
        }
        let (m, l) = self.quadric(radius);
        let conic = nalgebra::Matrix3::new(
            m[(0, 0)],
            m[(0, 1)],
            l.x, //
            m[(0, 1)],
            m[(1, 1)],
            l.y, //
            l.x,
            l.y,
            -radius * radius,
        );
        let ellipse = Ellipse::from_conic(&conic)?;
        Some(Ellipse {
            centre: self.centre + ellipse.centre.coords,
            ..ellipse
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frontal_keeps_the_outer_ellipse() {
        let outer = Ellipse {
            centre: Point2::new(50.0, 40.0),
            major: 20.0,
            minor: 12.0,
            angle: 0.3,
        };
        let back = Shape::frontal(&outer).ellipse(1.0).unwrap();
        assert!((back.major - 20.0).abs() < 1e-9 && (back.angle - 0.3).abs() < 1e-9);
    }

    #[test]
    fn perspective_keeps_the_outer_ellipse_too() {
        let outer = Ellipse {
            centre: Point2::new(50.0, 40.0),
            major: 20.0,
            minor: 12.0,
            angle: 0.3,
        };
        let q = Vector2::new(0.004, -0.007);
        let shape = Shape::in_perspective(&outer, q).unwrap();
        let back = shape.ellipse(1.0).unwrap();
        assert!((back.centre - outer.centre).norm() < 1e-9);
        assert!((back.major - 20.0).abs() < 1e-9 && (back.minor - 12.0).abs() < 1e-9);
        assert!((shape.centre - outer.centre).norm() > 0.1);
    }

    #[test]
    fn a_ring_that_reaches_for_the_horizon_is_none() {
        let at = |way: f64| Shape {
            centre: Point2::new(50.0, 40.0),
            affine: [1.0 / 400.0, 0.0, 1.0 / 144.0],
            perspective: Vector2::new(0.0, way / 12.0),
        };
        assert!(at(0.5).ellipse(1.0).is_some());
        assert!(at(0.7).ellipse(1.0).is_none());
        assert!(
            at(0.7).ellipse(0.5).is_some(),
            "the inner circle reaches half as far"
        );
    }
}
