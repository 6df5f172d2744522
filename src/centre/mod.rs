//! The estimators of a ring's projected centre, one file each behind one trait.

mod ellipse;

pub use ellipse::Ellipse;

use nalgebra::{Matrix2, Point2};

/// The two ellipses of one ring in the image, px; the inner one is the image of the inner circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingEllipses {
    /// Image of the inner circle (the paper's C_S).
    pub inner: Ellipse,
    /// Image of the outer circle (the paper's C_B).
    pub outer: Ellipse,
}

/// A projected centre: the image of the common centre of the two circles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Centre {
    /// Where it is, px.
    pub point: Point2<f64>,
    /// Its covariance, px^2, where the estimator knows one.
    pub covariance: Option<Matrix2<f64>>,
}

/// Which construction gives the projected centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Estimator {
    /// Centre of the outer ellipse (the paper's BC): biased by perspective, for comparison.
    BigEllipse,
    /// Centre of the inner ellipse (the paper's SC and GCS): biased by perspective, for comparison.
    SmallEllipse,
    /// Tangents on one side (the paper's Fei; Hao et al.).
    OneSided,
    /// The paper's construction, equations 26 to 29.
    #[default]
    Cross,
    /// The isolated eigenvector of the two conics.
    PolePolar,
}

impl Estimator {
    /// Every estimator, in the order of the documentation.
    pub const ALL: [Self; 5] = [
        Self::BigEllipse,
        Self::SmallEllipse,
        Self::OneSided,
        Self::Cross,
        Self::PolePolar,
    ];

    /// The name on the command line and in parameters.
    pub fn name(self) -> &'static str {
        match self {
            Self::BigEllipse => "big_ellipse",
            Self::SmallEllipse => "small_ellipse",
            Self::OneSided => "one_sided",
            Self::Cross => "cross",
            Self::PolePolar => "pole_polar",
        }
    }
}

impl std::str::FromStr for Estimator {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|estimator| estimator.name() == name)
            .ok_or_else(|| {
                let known = Self::ALL.map(Self::name).join(", ");
                format!("unknown estimator {name:?}; known are {known}")
            })
    }
}
