//! The rays of a wide lens brought together: what a fisheye is and a polynomial is not.
//!
//! A lens that sees far to the side maps the tangent r of a ray's angle to about atan(w r) / w (Devernay and Faugeras 2001): with w = 1 over its
//! focal length that is the equidistant fisheye, with w = 0 it is perspective. No polynomial in r follows it far, for r grows
//! without end; beside it, a polynomial has little left to do.

use nalgebra::{Matrix2, Point2, Vector2};

/// w r below which series are better than quotients.
const SMALL: f64 = 1e-3;
/// Angles (rad) from which on there is no tangent to speak of.
const WIDEST: f64 = 1.5;

/// Which lens: w, in the unit of r to the power of -1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Fan(pub(super) f64);

impl Fan {
    /// Where a place in perspective comes to lie.
    pub(super) fn apply(self, at: &Point2<f64>) -> Point2<f64> {
        Point2::from(at.coords * self.scale(at.coords.norm()))
    }

    /// atan(w r) / (w r).
    fn scale(self, r: f64) -> f64 {
        let turn = self.0 * r;
        if turn < SMALL {
            1.0 - turn * turn / 3.0
        } else {
            turn.atan() / turn
        }
    }

    /// Derivatives of [`Fan::apply`] by the place.
    pub(super) fn jacobian(self, at: &Point2<f64>) -> Matrix2<f64> {
        let r = at.coords.norm();
        let (turn, scale) = (self.0 * r, self.scale(r));
        // the scale's derivative by r, over r
        let slope = if turn < SMALL {
            -2.0 / 3.0 * self.0 * self.0
        } else {
            (1.0 / (1.0 + turn * turn) - scale) / (r * r)
        };
        Matrix2::identity() * scale + at.coords * at.coords.transpose() * slope
    }

    /// The place in perspective of one after it; `None` at right angles to the axis and beyond.
    pub(super) fn undo(self, at: &Point2<f64>) -> Option<Point2<f64>> {
        let turn = self.0 * at.coords.norm();
        if turn < SMALL {
            return Some(*at);
        }
        (turn < WIDEST).then(|| Point2::from(Vector2::from(at.coords) * (turn.tan() / turn)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_undoes_itself_and_knows_its_derivatives() {
        for (fan, at) in [
            (Fan(0.0), Point2::new(0.3, -0.2)),
            (Fan(1.6), Point2::new(0.8, -1.1)),
            (Fan(1.6), Point2::new(1e-5, 2e-5)),
        ] {
            let there = fan.apply(&at);
            let back = fan.undo(&there).unwrap();
            assert!((back - at).norm() < 1e-9, "{back}");
            let h = 1e-6;
            let step =
                |d: Vector2<f64>| (fan.apply(&(at + d * h)) - fan.apply(&(at - d * h))) / (2.0 * h);
            let by = Matrix2::from_columns(&[step(Vector2::x()), step(Vector2::y())]);
            assert!((by - fan.jacobian(&at)).norm() < 1e-8, "{by}");
        }
        assert!(Fan(1.6).undo(&Point2::new(1.0, 0.0)).is_none());
    }
}
