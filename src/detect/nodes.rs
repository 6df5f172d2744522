//! Rings on a plane: which are near which, and which can be neighbours.

use super::nearby::Nearby;
use crate::centre::Ellipse;
use nalgebra::{Matrix2, Point2};

/// A ring's place and the map to the coordinates in which its outer ellipse is the unit circle.
pub(super) struct Node {
    pub(super) centre: Point2<f64>,
    pub(super) major_px: f64,
    /// Logarithm of its mean radius.
    size: f64,
    pub(super) to_unit: Matrix2<f64>,
}

impl Node {
    fn of(outer: &Ellipse) -> Self {
        let (sin, cos) = outer.angle.sin_cos();
        let turn = Matrix2::new(cos, sin, -sin, cos);
        let shrink = Matrix2::new(1.0 / outer.major, 0.0, 0.0, 1.0 / outer.minor);
        Self {
            centre: outer.centre,
            major_px: outer.major,
            size: outer.mean_radius().ln(),
            to_unit: turn.transpose() * shrink * turn,
        }
    }
}

/// All rings, and which are near which.
pub(super) struct Nodes {
    pub(super) all: Vec<Node>,
    pub(super) nearby: Nearby,
    /// How different the sizes of neighbours may be (logarithm).
    alike: f64,
}

impl Nodes {
    pub(super) fn of(outers: &[Ellipse], alike: f64) -> Self {
        Self {
            all: outers.iter().map(Node::of).collect(),
            nearby: Nearby::new(outers.iter().map(|outer| outer.centre)),
            alike,
        }
    }

    /// Whether two rings can stand next to each other by their sizes.
    pub(super) fn are_alike(&self, a: usize, b: usize) -> bool {
        (self.all[a].size - self.all[b].size).abs() < self.alike
    }

    /// The nearest usable ring less than `tolerance_px` from a place.
    pub(super) fn nearest(
        &self,
        place: Point2<f64>,
        tolerance_px: f64,
        usable: impl Fn(usize) -> bool,
    ) -> Option<usize> {
        self.nearby
            .within(place, tolerance_px)
            .filter(|&(i, _)| usable(i))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(i, _)| i)
    }
}
