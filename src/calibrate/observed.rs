//! What an estimator measures where it is not the projected centre.
//!
//! The constructions of the paper take a ring's image for two ellipses. Perspective displaces an ellipse's centre from the projected
//! one, and the lens bends the curves, which displaces the others too. Camera and pose say by how much: both
//! circles are sent through the camera, ellipses laid through them, the construction repeated. The photometric estimator
//! has the perspective in its model, and has taken off what the lens bends.

use super::observations::Observation;
use super::shared::Shared;
use crate::board::Board;
use crate::camera::Pose;
use crate::centre::{CentreEstimator, Estimator, RingEllipses};
use crate::detect::ellipse_along;
use nalgebra::{Point2, Vector2};
use rayon::prelude::*;

/// Points of a circle that are sent through the camera: what they leave of a bend is of its eleventh period.
const POINTS: usize = 12;

/// A ring of the board before the camera.
struct RingBefore<'a> {
    board: &'a Board,
    shared: &'a Shared,
    pose: &'a Pose,
    centre_m: [f64; 2],
    circle: &'a Circle,
}

/// Points of the circle of radius 1.
type Circle = [Vector2<f64>; POINTS];

/// Predicts `bias_px` of every ring that is measured by this estimator; among rings with a covariance one without was measured on its
/// edges. Says whether anything changed.
pub(super) fn predict(
    board: &Board,
    shared: &Shared,
    poses: &[Option<Pose>],
    rings: &mut [Vec<Observation>],
    estimator: Estimator,
) -> bool {
    let construction = estimator.construction();
    let fallback = Estimator::FALLBACK.construction();
    let with_covariance = rings.iter().flatten().any(|ring| ring.has_covariance);
    let circle: Circle = std::array::from_fn(|i| {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / POINTS as f64).sin_cos();
        Vector2::new(cos, sin)
    });
    let changed = rings.par_iter_mut().zip(poses).map(|(rings, pose)| {
        let Some(pose) = pose else { return false };
        let mut changed = false;
        for ring in rings {
            let before = RingBefore {
                board,
                shared,
                pose,
                centre_m: ring.board_m,
                circle: &circle,
            };
            let last = ring.bias_px;
            let edges = construction
                .as_ref()
                .or(fallback.as_ref().filter(|_| !ring.has_covariance))
                // made by hand, of points: they are what they are
                .filter(|_| construction.is_some() || with_covariance);
            ring.bias_px = edges
                .and_then(|edges| before.bias_on_edges_px(edges.as_ref()))
                .unwrap_or_default();
            changed |= ring.bias_px != last;
        }
        changed
    });
    changed.reduce(|| false, |a, b| a || b)
}

impl RingBefore<'_> {
    /// Where a place about the ring's centre, in outer radii, is seen, px.
    fn image(&self, d: Vector2<f64>) -> Option<Point2<f64>> {
        let radius_m = self.board.outer_radius_m();
        let place_m = [
            self.centre_m[0] + d.x * radius_m,
            self.centre_m[1] + d.y * radius_m,
        ];
        let place = self.shared.sheet.place_m(place_m, self.shared.middle_m);
        let point = self.pose.rotation * place + self.pose.translation_m;
        self.shared.camera.project(&point)
    }

    /// What a construction on the two ellipses gives less the projected centre, px; `None` where the ring has no image.
    fn bias_on_edges_px(&self, construction: &dyn CentreEstimator) -> Option<Vector2<f64>> {
        let ellipse = |radius: f64| {
            let mut points = [Point2::origin(); POINTS];
            for (point, direction) in points.iter_mut().zip(self.circle) {
                *point = self.image(direction * radius)?;
            }
            ellipse_along(&points)
        };
        let ellipses = RingEllipses {
            inner: ellipse(self.board.radius_ratio())?,
            outer: ellipse(1.0)?,
        };
        Some(construction.estimate(&ellipses).ok()?.point - self.image(Vector2::zeros())?)
    }
}
