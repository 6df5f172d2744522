//! The projective image of two concentric circles, up to what a circle does not show.
//!
//! In coordinates x' = x - c about the projected centre c, a circle of radius a (in outer radii) is the curve
//! `Q_a(x') = x'^T N x' - a^2 (1 - q . x')^2 = 0`: N is the affine shape (the inverse square of the semi-axes for a
//! frontal ring), q the perspective. Derivation: a homography that carries the circles' centre to c is u = T x' followed by
//! X = u / (1 - g . u), with T symmetric because a rotation of the circle shows nothing; |X|^2 = a^2, N = T^2, q = T g.

use crate::centre::Ellipse;
use nalgebra::{Matrix2, Point2, Vector2};

/// Parameters of a shape, in the order of [`Shape::parameters`].
pub const SHAPE_PARAMETERS: usize = 7;

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

/// Where a horizontal line crosses a circle's image, and how the crossings move with the parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Chord {
    /// Left and right crossing, px.
    pub(super) ends: [f64; 2],
    /// Derivatives of both with respect to the parameters.
    pub(super) derivatives: [[f64; SHAPE_PARAMETERS]; 2],
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

    /// The matrix and vector of Q_a = x'^T M x' + 2 m . x' - a^2.
    fn quadric(&self, radius: f64) -> (Matrix2<f64>, Vector2<f64>) {
        let [xx, xy, yy] = self.affine;
        let (q, a2) = (self.perspective, radius * radius);
        let matrix = Matrix2::new(xx, xy, xy, yy) - q * q.transpose() * a2;
        (matrix, q * a2)
    }

    /// The image of the circle of this radius (in outer radii); `None` where it is no ellipse.
    pub fn ellipse(&self, radius: f64) -> Option<Ellipse> {
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

    /// First and last y of a circle's image, px; `None` where it is no ellipse.
    pub(super) fn rows(&self, radius: f64) -> Option<(f64, f64)> {
        let (m, l) = self.quadric(radius);
        let determinant = m.determinant();
        let inverse = m
            .try_inverse()
            .filter(|_| determinant > 0.0 && m[(0, 0)] > 0.0)?;
        let middle = inverse * -l;
        let value = radius * radius + l.dot(&(inverse * l));
        let half = (inverse[(1, 1)] * value).sqrt();
        half.is_finite().then_some((
            self.centre.y + middle.y - half,
            self.centre.y + middle.y + half,
        ))
    }

    /// The chord of a circle's image at height `y`; `None` beside it.
    pub(super) fn chord(&self, radius: f64, y: f64) -> Option<Chord> {
        let (m, l) = self.quadric(radius);
        let v = y - self.centre.y;
        // A x'^2 + 2 B x' + C = 0
        let (a, b) = (m[(0, 0)], m[(0, 1)] * v + l.x);
        let c = m[(1, 1)] * v * v + 2.0 * l.y * v - radius * radius;
        let discriminant = b * b - a * c;
        if !(discriminant > 0.0 && a > 0.0) {
            return None;
        }
        let root = discriminant.sqrt();
        let ends = [(-b - root) / a, (-b + root) / a];
        let slopes = [-2.0 * root, 2.0 * root];
        let derivatives =
            [0, 1].map(|i| self.end_derivatives(radius, ends[i], v, slopes[i], &m, &l));
        Some(Chord {
            ends: ends.map(|x| x + self.centre.x),
            derivatives,
        })
    }

    /// How the crossing at (x', v) moves: the implicit function theorem on Q, whose slope along x is given.
    fn end_derivatives(
        &self,
        radius: f64,
        x: f64,
        v: f64,
        slope: f64,
        m: &Matrix2<f64>,
        l: &Vector2<f64>,
    ) -> [f64; SHAPE_PARAMETERS] {
        let along_y = 2.0 * (m[(0, 1)] * x + m[(1, 1)] * v + l.y);
        let depth = 2.0 * radius * radius * (1.0 - self.perspective.x * x - self.perspective.y * v);
        [
            1.0,
            along_y / slope,
            -x * x / slope,
            -2.0 * x * v / slope,
            -v * v / slope,
            -depth * x / slope,
            -depth * v / slope,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(crate) const SHAPE: [f64; SHAPE_PARAMETERS] =
        [31.2, 28.9, 0.0031, 0.0004, 0.0042, 0.002, -0.0015];

    #[test]
    fn chord_derivatives_agree_with_finite_differences() {
        let h = 1e-6;
        for (radius, y) in [(1.0, 22.0), (0.5, 30.0)] {
            let chord = Shape::from_parameters(&SHAPE).chord(radius, y).unwrap();
            for k in 0..SHAPE_PARAMETERS {
                let moved = |sign: f64| {
                    let mut p = SHAPE;
                    p[k] += sign * h * SHAPE[k].abs();
                    Shape::from_parameters(&p).chord(radius, y).unwrap().ends
                };
                let (up, down) = (moved(1.0), moved(-1.0));
                for i in 0..2 {
                    let slope = (up[i] - down[i]) / (2.0 * h * SHAPE[k].abs());
                    let error = (chord.derivatives[i][k] - slope).abs();
                    assert!(error < 1e-4 * slope.abs().max(1.0), "{k} {i}: {slope}");
                }
            }
        }
    }

    #[test]
    fn the_curve_s_ellipse_has_its_chords_and_rows() {
        let shape = Shape::from_parameters(&SHAPE);
        for radius in [1.0, 0.5] {
            let ellipse = shape.ellipse(radius).unwrap();
            let (top, bottom) = shape.rows(radius).unwrap();
            for k in 0..12 {
                let p = ellipse.point(0.5 * f64::from(k));
                assert!(p.y > top - 1e-9 && p.y < bottom + 1e-9);
                if let Some(chord) = shape.chord(radius, p.y) {
                    let near = (chord.ends[0] - p.x).abs().min((chord.ends[1] - p.x).abs());
                    assert!(near < 1e-6);
                }
            }
        }
    }

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
}
