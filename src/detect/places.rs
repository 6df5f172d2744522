//! Where the rings of a lattice lie in the frame: the homography of their plane, and what the lens bends near each.

use super::bends::Bends;
use super::labelling::Label;
use crate::camera::homography::{apply, fit_homography};
use crate::centre::Ellipse;
use nalgebra::{Matrix2, Matrix3, Point2, Vector2};

/// Logarithm of the size of a circle under the homography over that of a small one there, beyond which the latter is believed.
const ALIKE: f64 = 0.25;

/// What a lens does to a board's rings at most, as a factor.
const MOST_STRETCH: f64 = 1.8;

/// A map from labels to the frame.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Places {
    /// Label (column, row) to frame px.
    pub(super) homography: Matrix3<f64>,
    /// The way back.
    inverse: Matrix3<f64>,
    /// How far each place lies from where the homography puts it, by the rings around it, px.
    bends: Bends,
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
        Some(Self {
            homography,
            inverse: homography.try_inverse()?,
            bends: Bends::of(&bends),
        })
    }

    /// Where the ring with this label is expected from all others; `None` beyond the horizon.
    pub(super) fn expect(&self, label: Label) -> Option<Place> {
        let steps = self.steps(label)?;
        Some(Place {
            at: self.at(label)?,
            column_px: steps.column(0).norm(),
            row_px: steps.column(1).norm(),
        })
    }

    /// Where a label is, px.
    fn at(&self, label: Label) -> Option<Point2<f64>> {
        Some(apply(&self.homography, plane(label))? + self.bends.at(label))
    }

    /// From one column, and from one row, to the next about a label, px.
    fn steps(&self, label: Label) -> Option<Matrix2<f64>> {
        let flat = self.flat_steps(label)?;
        Some(self.stretch(label, &flat)? * flat)
    }

    /// The same by the homography alone.
    fn flat_steps(&self, label: Label) -> Option<Matrix2<f64>> {
        let ideal = |dx: f64, dy: f64| apply(&self.homography, plane(label) + Vector2::new(dx, dy));
        Some(Matrix2::from_columns(&[
            (ideal(1.0, 0.0)? - ideal(-1.0, 0.0)?) * 0.5,
            (ideal(0.0, 1.0)? - ideal(0.0, -1.0)?) * 0.5,
        ]))
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
        let around = Ellipse {
            centre: self.at(label)?,
            major: radius,
            minor: radius,
            angle: 0.0,
        };
        let flat_steps = self.flat_steps(label)?;
        let stretch = self.stretch(label, &flat_steps)?;
        let small = stretched(&around, &(stretch * flat_steps))?;
        let flat = self.inverse.transpose() * circle * self.inverse;
        let flat = Ellipse::from_conic(&flat);
        let exact = flat.and_then(|ellipse| {
            Some(Ellipse {
                centre: ellipse.centre + self.bends.at(label),
                ..stretched(&ellipse, &stretch)?
            })
        });
        // where the lens bends much the homography's horizon comes near, and its circles grow beyond bounds
        let alike = |e: &Ellipse| (e.mean_radius() / small.mean_radius()).ln().abs() < ALIKE;
        Some(exact.filter(alike).unwrap_or(small))
    }

    /// What the lens does to small shapes about a label, beside the homography.
    fn stretch(&self, label: Label, flat_steps: &Matrix2<f64>) -> Option<Matrix2<f64>> {
        let between = |a: Label, b: Label| Some((self.at(b)? - self.at(a)?) * 0.5);
        let (column, row) = label;
        let bent = Matrix2::from_columns(&[
            between((column - 1, row), (column + 1, row))?,
            between((column, row - 1), (column, row + 1))?,
        ]);
        let stretch = bent * flat_steps.try_inverse()?;
        // beyond that a quadratic has been carried too far out
        let sizes = stretch.singular_values();
        let sound = sizes.max() < MOST_STRETCH && sizes.min() > MOST_STRETCH.recip();
        Some(if sound { stretch } else { Matrix2::identity() })
    }
}

/// An ellipse under a linear map about its centre.
fn stretched(ellipse: &Ellipse, map: &Matrix2<f64>) -> Option<Ellipse> {
    let (sin, cos) = ellipse.angle.sin_cos();
    let axes = Matrix2::new(
        ellipse.major * cos,
        -ellipse.minor * sin,
        ellipse.major * sin,
        ellipse.minor * cos,
    );
    let svd = (map * axes).svd(true, false);
    let (u, sizes) = (svd.u?, svd.singular_values);
    let first = sizes.imax();
    Some(Ellipse {
        centre: ellipse.centre,
        major: sizes[first],
        minor: sizes[1 - first],
        angle: u[(1, first)].atan2(u[(0, first)]),
    })
}

fn plane(label: Label) -> Point2<f64> {
    Point2::new(f64::from(label.0), f64::from(label.1))
}

/// Where a line of places leads, the next of them first: the parabola through three.
pub(super) fn line_leads(a: Point2<f64>, b: Point2<f64>, c: Point2<f64>) -> Point2<f64> {
    a + 2.0 * (a - b) + (c - b)
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
