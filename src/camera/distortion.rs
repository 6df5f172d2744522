//! The lens models that ROS knows, as one type.

use super::{Equidistant, PlumbBob, RationalPolynomial};
use nalgebra::{Matrix2, Point2};
use std::fmt;
use std::str::FromStr;

/// Most coefficients of any lens model.
pub(super) const MOST_COEFFICIENTS: usize = 8;

/// A lens model, by its ROS name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum LensModel {
    /// Radial polynomial and tangential terms, five coefficients.
    #[default]
    PlumbBob,
    /// Ratio of two radial polynomials and tangential terms, eight coefficients.
    RationalPolynomial,
    /// Polynomial in the angle from the optical axis (fisheye), four coefficients.
    Equidistant,
}

/// The name of no lens model.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("no lens model {0:?}; known are plumb_bob, rational_polynomial and equidistant")]
pub struct UnknownLensModel(pub String);

impl LensModel {
    /// All of them, the simplest first.
    pub const ALL: [Self; 3] = [Self::PlumbBob, Self::RationalPolynomial, Self::Equidistant];

    /// The name that `distortion_model` has in ROS.
    pub fn name(self) -> &'static str {
        match self {
            Self::PlumbBob => "plumb_bob",
            Self::RationalPolynomial => "rational_polynomial",
            Self::Equidistant => "equidistant",
        }
    }

    /// Names of the camera's parameters in the order of [`super::Camera::parameters`]: px for the first four, no unit
    /// for the coefficients, which are in the order of the message's `d`.
    pub fn parameter_names(self) -> &'static [&'static str] {
        match self {
            Self::PlumbBob => &["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"],
            Self::RationalPolynomial => &[
                "fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6",
            ],
            Self::Equidistant => &["fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4"],
        }
    }

    /// How many coefficients describe the lens.
    pub fn coefficient_count(self) -> usize {
        self.parameter_names().len() - 4
    }

    /// The names of the radial coefficients, from the lowest power.
    pub fn radial_names(self) -> &'static [&'static str] {
        match self {
            Self::PlumbBob => &["k1", "k2", "k3"],
            Self::RationalPolynomial => &["k1", "k2", "k3", "k4", "k5", "k6"],
            Self::Equidistant => &["k1", "k2", "k3", "k4"],
        }
    }
}

impl fmt::Display for LensModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for LensModel {
    type Err = UnknownLensModel;

    fn from_str(name: &str) -> Result<Self, UnknownLensModel> {
        Self::ALL
            .into_iter()
            .find(|model| model.name() == name)
            .ok_or_else(|| UnknownLensModel(name.to_owned()))
    }
}

/// A lens: its model and coefficients.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Distortion {
    /// ROS `plumb_bob`.
    PlumbBob(PlumbBob),
    /// ROS `rational_polynomial`.
    RationalPolynomial(RationalPolynomial),
    /// ROS `equidistant`.
    Equidistant(Equidistant),
}

impl Default for Distortion {
    /// A pinhole.
    fn default() -> Self {
        Self::PlumbBob(PlumbBob::default())
    }
}

impl From<PlumbBob> for Distortion {
    fn from(lens: PlumbBob) -> Self {
        Self::PlumbBob(lens)
    }
}

impl From<RationalPolynomial> for Distortion {
    fn from(lens: RationalPolynomial) -> Self {
        Self::RationalPolynomial(lens)
    }
}

impl From<Equidistant> for Distortion {
    fn from(lens: Equidistant) -> Self {
        Self::Equidistant(lens)
    }
}

impl Distortion {
    /// The model.
    pub fn model(&self) -> LensModel {
        match self {
            Self::PlumbBob(_) => LensModel::PlumbBob,
            Self::RationalPolynomial(_) => LensModel::RationalPolynomial,
            Self::Equidistant(_) => LensModel::Equidistant,
        }
    }

    /// The coefficients in the order of the message's `d`.
    pub fn coefficients(&self) -> Vec<f64> {
        match self {
            Self::PlumbBob(l) => vec![l.k1, l.k2, l.p1, l.p2, l.k3],
            Self::RationalPolynomial(l) => {
                vec![l.k1, l.k2, l.p1, l.p2, l.k3, l.k4, l.k5, l.k6]
            }
            Self::Equidistant(l) => l.k.to_vec(),
        }
    }

    /// A lens of these coefficients in the order of the message's `d`; `None` where their number is not the model's.
    pub fn new(model: LensModel, coefficients: &[f64]) -> Option<Self> {
        match (model, coefficients) {
            (LensModel::PlumbBob, &[k1, k2, p1, p2, k3]) => {
                Some(PlumbBob { k1, k2, p1, p2, k3 }.into())
            }
            (LensModel::RationalPolynomial, &[k1, k2, p1, p2, k3, k4, k5, k6]) => Some(
                RationalPolynomial {
                    k1,
                    k2,
                    p1,
                    p2,
                    k3,
                    k4,
                    k5,
                    k6,
                }
                .into(),
            ),
            (LensModel::Equidistant, &[k1, k2, k3, k4]) => Some(
                Equidistant {
                    k: [k1, k2, k3, k4],
                }
                .into(),
            ),
            _ => None,
        }
    }

    /// Distorted normalised coordinates of an ideal point (X/Z, Y/Z).
    pub fn distort(&self, ideal: &Point2<f64>) -> Point2<f64> {
        match self {
            Self::PlumbBob(lens) => lens.distort(ideal),
            Self::RationalPolynomial(lens) => lens.distort(ideal),
            Self::Equidistant(lens) => lens.distort(ideal),
        }
    }

    /// Derivative of [`Distortion::distort`] with respect to the ideal point.
    pub fn jacobian(&self, ideal: &Point2<f64>) -> Matrix2<f64> {
        match self {
            Self::PlumbBob(lens) => lens.jacobian(ideal),
            Self::RationalPolynomial(lens) => lens.jacobian(ideal),
            Self::Equidistant(lens) => lens.jacobian(ideal),
        }
    }

    /// Ideal point (X/Z, Y/Z) of distorted coordinates; `None` where the lens model folds over before, or where the ray
    /// does not point forward.
    pub fn undistort(&self, distorted: &Point2<f64>) -> Option<Point2<f64>> {
        match self {
            Self::PlumbBob(lens) => lens.undistort(distorted),
            Self::RationalPolynomial(lens) => lens.undistort(distorted),
            Self::Equidistant(lens) => lens.undistort(distorted),
        }
    }

    /// Whether it bends nothing.
    pub fn is_none(&self) -> bool {
        !matches!(self, Self::Equidistant(_)) && self.coefficients().iter().all(|k| *k == 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_coefficients_go_in_and_out() {
        for model in LensModel::ALL {
            assert_eq!(model.name().parse(), Ok(model));
            let numbers: Vec<f64> = (0..model.coefficient_count())
                .map(|i| 0.01 * (1.0 + i as f64))
                .collect();
            let lens = Distortion::new(model, &numbers).unwrap();
            assert_eq!(lens.coefficients(), numbers);
            assert_eq!(lens.model(), model);
            assert_eq!(Distortion::new(model, &numbers[1..]), None);
            assert!(model.coefficient_count() <= MOST_COEFFICIENTS);
        }
        assert!("fisheye".parse::<LensModel>().is_err());
    }
}
