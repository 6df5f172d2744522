//! Lines of the image in homogeneous coordinates, and where they meet conics.

use super::CentreError;
use nalgebra::{Matrix3, Point2, Vector3};

/// The line a x + b y + c = 0, scaled so that (a, b) has length 1: `distance` is then in px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line(Vector3<f64>);

impl Line {
    /// From homogeneous coordinates of any scale.
    pub(super) fn from_homogeneous(line: Vector3<f64>) -> Result<Self, CentreError> {
        let scale = line.x.hypot(line.y);
        if scale > 0.0 && scale.is_finite() {
            Ok(Self(line / scale))
        } else {
            Err(CentreError::Degenerate)
        }
    }

    /// Through two points.
    pub(super) fn through(p: &Point2<f64>, q: &Point2<f64>) -> Result<Self, CentreError> {
        Self::from_homogeneous(p.to_homogeneous().cross(&q.to_homogeneous()))
    }

    /// Signed distance of a point, px.
    pub(super) fn distance(&self, p: &Point2<f64>) -> f64 {
        self.0.dot(&p.to_homogeneous())
    }

    /// Where two lines meet.
    pub(super) fn meet(&self, other: &Self) -> Result<Point2<f64>, CentreError> {
        let p = self.0.cross(&other.0);
        let point = Point2::new(p.x / p.z, p.y / p.z);
        if point.x.is_finite() && point.y.is_finite() {
            Ok(point)
        } else {
            Err(CentreError::Degenerate)
        }
    }

    /// The two points of a conic on this line.
    pub(super) fn meet_conic(&self, conic: &Matrix3<f64>) -> Result<[Point2<f64>; 2], CentreError> {
        let direction = Vector3::new(-self.0.y, self.0.x, 0.0);
        // the point of the line nearest to the conic's centre keeps the quadratic well conditioned
        let block = conic.fixed_view::<2, 2>(0, 0).into_owned();
        let inverse = block.try_inverse().ok_or(CentreError::Degenerate)?;
        let centre = Point2::from(inverse * -conic.fixed_view::<2, 1>(0, 2));
        let base = centre - self.0.xy() * self.distance(&centre);
        let base = base.to_homogeneous();
        let a = direction.dot(&(conic * direction));
        let b = direction.dot(&(conic * base));
        let c = base.dot(&(conic * base));
        let discriminant = b * b - a * c;
        if !discriminant.is_finite() || a == 0.0 {
            return Err(CentreError::Degenerate);
        }
        if discriminant < 0.0 {
            return Err(CentreError::NotNested);
        }
        let root = discriminant.sqrt();
        Ok([(-b - root) / a, (-b + root) / a].map(|t| {
            let p = base + direction * t;
            Point2::new(p.x, p.y)
        }))
    }
}
