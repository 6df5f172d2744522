//! The board's plane in the frame: how a ring at a place must look, and what it says of blur.

use super::shape::Shape;
use crate::camera::homography::fit_homography;
use crate::centre::Ellipse;
use nalgebra::{Matrix3, Point2, Vector2, Vector3};

/// A homography of the board, plane (m) to frame (px), seen from the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PlaneView {
    back: Matrix3<f64>,
}

impl PlaneView {
    /// Through points of the plane (m) and of the frame (px); `None` where they determine none.
    pub(super) fn through(pairs: &[(Point2<f64>, Point2<f64>)]) -> Option<Self> {
        let back = fit_homography(pairs)?.try_inverse()?;
        Some(Self { back })
    }

    /// The image of the plane's line at infinity.
    fn horizon(&self) -> Vector3<f64> {
        self.back.row(2).transpose()
    }

    /// The perspective of a ring whose centre is seen here: q = -l_xy / (l . c) for the horizon l.
    pub(super) fn perspective(&self, at: &Point2<f64>) -> Vector2<f64> {
        let horizon = self.horizon();
        -horizon.xy() / horizon.dot(&at.to_homogeneous())
    }

    /// The direction (unit vector in the frame) across the image of the plane's line that stands `far_m` out from a place towards
    /// a side; it leads outwards. `None` where that line is seen edge on.
    pub(super) fn outwards(
        &self,
        place: &Point2<f64>,
        side: &Vector2<f64>,
        far_m: f64,
    ) -> Option<Vector2<f64>> {
        let line = Vector3::new(side.x, side.y, -(side.dot(&place.coords) + far_m));
        let seen = self.back.transpose() * line;
        // at a point of the frame the line's value is the distance times the depth there, which may be negative
        let at = self.back.try_inverse()? * place.to_homogeneous();
        let depth = self.back.row(2).transpose().dot(&at) / at.z;
        (seen.xy() * depth.signum()).try_normalize(f64::MIN_POSITIVE)
    }

    /// The ring at this perspective whose outer circle is this ellipse.
    pub(super) fn ring_of(&self, outer: &Ellipse) -> Option<Shape> {
        Shape::in_perspective(outer, self.perspective(&outer.centre))
    }
}

#[cfg(test)]
mod tests {
    use super::super::lens_map::shape_under;
    use super::*;

    #[test]
    fn a_ring_of_the_plane_has_the_image_of_its_circle() {
        let forth = Matrix3::new(900.0, 40.0, 300.0, -30.0, 700.0, 200.0, 0.6, -0.4, 1.0);
        let place = |x: f64, y: f64| {
            let p = forth * Vector3::new(x, y, 1.0);
            Point2::new(p.x / p.z, p.y / p.z)
        };
        let pairs: Vec<_> = [(0.0, 0.0), (0.3, 0.0), (0.0, 0.2), (0.3, 0.2), (0.1, 0.15)]
            .map(|(x, y)| (Point2::new(x, y), place(x, y)))
            .to_vec();
        let view = PlaneView::through(&pairs).unwrap();
        let (x, y, radius) = (0.12, 0.07, 0.03);
        let shape = shape_under(|d| Some(place(x + radius * d.x, y + radius * d.y))).unwrap();
        let told = view.perspective(&shape.centre);
        assert!((told - shape.perspective).norm() < 2e-3 * told.norm());
        for scale in [1.0, 0.5] {
            let ellipse = shape.ellipse(scale).unwrap();
            let conic = ellipse.conic();
            for k in 0..8 {
                let (sin, cos) = f64::from(k).sin_cos();
                let r = scale * radius;
                let on = place(x + r * cos, y + r * sin).to_homogeneous();
                assert!((on.dot(&(conic * on))).abs() < 1e-3);
            }
        }
        let again = view.ring_of(&shape.ellipse(1.0).unwrap()).unwrap();
        assert!((again.centre - shape.centre).norm() < 0.2);
    }
}
