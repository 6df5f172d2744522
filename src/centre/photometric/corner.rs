//! The corner of two blurred edges that do not meet at a right angle.
//!
//! With d_1 and d_2 the distances beyond the edges over the blur's sigma, what a Gaussian leaves of the sheet is the bivariate normal
//! probability of (-d_1, -d_2), correlated by rho, the cosine between the edges' normals. It is the product of the single
//! ones and a correction, the integral of the joint density over the correlation from 0 to rho (Plackett 1954); in the angle
//! arcsin(rho) its integrand is smooth, and six Gauss-Legendre points give 1e-5 up to rho = 0.9 (Drezner and Wesolowsky 1990).
//! A disc gets the correction of the Gaussian of its spread.

use super::normal::{density_and_cumulative, exp};
use super::real::Real;
use std::f32::consts::TAU;

/// Gauss-Legendre on [0, 1]: places and weights.
const POINTS: [(f32, f32); 6] = [
    (0.033_765_24, 0.085_662_246),
    (0.169_395_31, 0.180_380_79),
    (0.380_690_4, 0.233_956_97),
    (0.619_309_6, 0.233_956_97),
    (0.830_604_7, 0.180_380_79),
    (0.966_234_76, 0.085_662_246),
];
/// Edges are never closer to parallel than this.
const MOST_CORRELATED: f32 = 0.99;

/// Two edges that meet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corner {
    rho: f32,
    /// sqrt(1 - rho^2).
    sine: f32,
    /// Sine of each point's angle, 1 / (2 cos^2) of it, and its weight.
    points: [[f32; 3]; 6],
}

/// What the corner's angle adds to the product of what both edges leave, and how that changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Correction<T> {
    pub(super) value: T,
    /// By -d_1 and -d_2, each over sigma.
    pub(super) by_depth: [T; 2],
    /// By rho.
    pub(super) by_rho: T,
}

impl Corner {
    /// Of edges with this cosine between their normals.
    pub(super) fn new(rho: f64) -> Self {
        let rho = (rho as f32).clamp(-MOST_CORRELATED, MOST_CORRELATED);
        let whole = rho.asin();
        Self {
            rho,
            sine: (1.0 - rho * rho).sqrt(),
            points: POINTS.map(|(place, weight)| {
                let (sin, cos) = (whole * place).sin_cos();
                [sin, 0.5 / (cos * cos), whole * weight / TAU]
            }),
        }
    }

    /// The correction at depths `a` and `b` on the sheet, in blur sigmas.
    #[inline(always)]
    pub(super) fn at<T: Real>(&self, a: T, b: T) -> Correction<T> {
        let (squares, product) = (a * a + b * b, a * b * 2.0);
        let mut value = a.like(0.0);
        for [sin, scale, weight] in self.points {
            value = value + joint(squares, product, sin, scale) * weight;
        }
        let scale = 0.5 / (self.sine * self.sine);
        Correction {
            value,
            by_depth: [self.given(a, b), self.given(b, a)],
            by_rho: joint(squares, product, self.rho, scale) * (1.0 / (TAU * self.sine)),
        }
    }

    #[inline(always)]
    fn given<T: Real>(&self, x: T, y: T) -> T {
        let (density, _) = density_and_cumulative(x);
        let (_, alone) = density_and_cumulative(y);
        let (_, together) = density_and_cumulative((y - x * self.rho) * (1.0 / self.sine));
        density * (together - alone)
    }
}

/// The joint density but for its factor.
#[inline(always)]
fn joint<T: Real>(squares: T, product: T, sin: f32, scale: f32) -> T {
    exp((product * sin - squares) * scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// P(x < 0, y < 0) of correlated normals is 1/4 + arcsin(rho) / 2 pi (Sheppard 1899).
    #[test]
    fn at_the_corner_itself_its_angle_is_what_is_left() {
        for rho in [-0.8_f64, -0.3, 0.0, 0.5, 0.85] {
            let left = 0.25 + f64::from(Corner::new(rho).at(0.0, 0.0).value);
            let angle = 0.25 + rho.asin() / std::f64::consts::TAU;
            assert!((left - angle).abs() < 1e-5, "{rho}: {left} {angle}");
        }
    }

    #[test]
    fn changes_are_those_of_the_value() {
        let h = 1e-2_f32;
        for (rho, a, b) in [(0.4, 0.3, -0.8), (-0.6, 1.2, 0.5), (0.8, -0.4, -0.1)] {
            let at = |rho: f64, a, b| Corner::new(rho).at(a, b);
            let here = at(rho, a, b);
            let by_a = (at(rho, a + h, b).value - at(rho, a - h, b).value) / (2.0 * h);
            let by_b = (at(rho, a, b + h).value - at(rho, a, b - h).value) / (2.0 * h);
            let step = f64::from(h);
            let by_rho = (at(rho + step, a, b).value - at(rho - step, a, b).value) / (2.0 * h);
            assert!((by_a - here.by_depth[0]).abs() < 3e-4);
            assert!((by_b - here.by_depth[1]).abs() < 3e-4);
            assert!(
                (by_rho - here.by_rho).abs() < 3e-4,
                "{by_rho} {}",
                here.by_rho
            );
        }
    }
}
