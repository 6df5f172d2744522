//! Where the rings of a lattice lie in the frame: the homography of their plane, and what the lens bends near each.

use super::labelling::Label;
use crate::camera::homography::{apply, fit_homography};
use crate::centre::Ellipse;
use nalgebra::{Matrix3, Point2, Vector2};

/// Rings this many steps away and nearer say how the lens bends a place.
const REACH: i32 = 2;

/// A map from labels to the frame.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Places {
    /// Label (column, row) to frame px.
    pub(super) homography: Matrix3<f64>,
    /// How far each ring lies from where the homography puts it, px.
    bends: Vec<(Label, Vector2<f64>)>,
}

/// Where a ring is expected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    /// Its centre, px.
    pub(super) at: Point2<f64>,
    /// Distance to the next column there, px.
    pub(super) column_px: f64,
    /// Distance to the next row there, px.
    pub(super) row_px: f64,
}

impl Place {
    /// The shorter of the two steps, px.
    pub(super) fn step_px(&self) -> f64 {
        self.column_px.min(self.row_px)
    }
}

impl Places {
    /// Through rings at known labels; `None` where they determine no plane.
    pub(super) fn fit(rings: impl Iterator<Item = (Label, Point2<f64>)>) -> Option<Self> {
        let rings: Vec<(Label, Point2<f64>)> = rings.collect();
        let pairs: Vec<_> = rings
            .iter()
            .map(|&(label, at)| (plane(label), at))
            .collect();
        let homography = fit_homography(&pairs)?;
        let bends = rings
            .iter()
            .map(|&(label, at)| Some((label, at - apply(&homography, plane(label))?)))
            .collect::<Option<_>>()?;
        Some(Self { homography, bends })
    }

    /// Where the ring with this label is expected from all others; `None` beyond the horizon.
    pub(super) fn expect(&self, label: Label) -> Option<Place> {
        let here = plane(label);
        let ideal = apply(&self.homography, here)?;
        Some(Place {
            at: ideal + self.bend(label),
            column_px: (apply(&self.homography, here + Vector2::x())? - ideal).norm(),
            row_px: (apply(&self.homography, here + Vector2::y())? - ideal).norm(),
        })
    }

    /// The image of a circle about a label, its radius in pitches.
    pub(super) fn circle(&self, label: Label, radius: f64) -> Option<Ellipse> {
        let centre = plane(label);
        let (x, y) = (centre.x, centre.y);
        let circle = Matrix3::new(
            1.0,
            0.0,
            -x, //
            0.0,
            1.0,
            -y, //
            -x,
            -y,
            x * x + y * y - radius * radius,
        );
        let inverse = self.homography.try_inverse()?;
        let ellipse = Ellipse::from_conic(&(inverse.transpose() * circle * inverse))?;
        (ellipse.major < 1e5).then(|| Ellipse {
            centre: ellipse.centre + self.bend(label),
            ..ellipse
        })
    }

    /// The mean bend of the rings around a label, itself left out; the nearer, the more it counts.
    fn bend(&self, label: Label) -> Vector2<f64> {
        let (mut sum, mut weights) = (Vector2::zeros(), 0.0);
        for (other, bend) in &self.bends {
            let (dx, dy) = (other.0 - label.0, other.1 - label.1);
            if (dx, dy) != (0, 0) && dx.abs().max(dy.abs()) <= REACH {
                let weight = f64::from(dx * dx + dy * dy).powi(-2);
                sum += bend * weight;
                weights += weight;
            }
        }
        if weights > 0.0 { sum / weights } else { sum }
    }
}

fn plane(label: Label) -> Point2<f64> {
    Point2::new(f64::from(label.0), f64::from(label.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bent(label: Label) -> Point2<f64> {
        let p = plane(label) - Vector2::new(3.0, 3.0);
        let factor = 100.0 * (1.0 - 0.004 * p.coords.norm_squared());
        Point2::from(p.coords * factor)
    }

    fn labels() -> impl Iterator<Item = Label> {
        (0..7).flat_map(|row| (0..7).map(move |column| (column, row)))
    }

    #[test]
    fn a_bent_grid_is_expected_where_it_is() {
        let places = Places::fit(labels().map(|l| (l, bent(l)))).unwrap();
        for label in labels() {
            let place = places.expect(label).unwrap();
            assert!(
                (place.at - bent(label)).norm() < 0.15 * place.step_px(),
                "{label:?}"
            );
        }
    }

    #[test]
    fn a_plane_is_exact_and_its_circles_are_too() {
        let flat = |l: Label| Point2::new(40.0 * f64::from(l.0) + 7.0, 30.0 * f64::from(l.1) - 2.0);
        let places = Places::fit(labels().map(|l| (l, flat(l)))).unwrap();
        let place = places.expect((9, 2)).unwrap();
        assert!((place.at - flat((9, 2))).norm() < 1e-6);
        assert!((place.column_px - 40.0).abs() < 1e-6 && (place.row_px - 30.0).abs() < 1e-6);
        let circle = places.circle((2, 3), 0.5).unwrap();
        assert!((circle.major - 20.0).abs() < 1e-6 && (circle.minor - 15.0).abs() < 1e-6);
    }
}
