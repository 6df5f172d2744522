//! The one trait of the estimators and the choice among them.

use super::{BigEllipse, Cross, OneSided, PolePolar, RingEllipses, SmallEllipse};
use nalgebra::{Matrix2, Point2};

/// A projected centre: the image of the common centre of the two circles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Centre {
    /// Where it is, px.
    pub point: Point2<f64>,
    /// Its covariance, px^2, where the estimator knows one.
    pub covariance: Option<Matrix2<f64>>,
}

/// Why two ellipses have no projected centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum CentreError {
    /// The tangents of the inner ellipse do not meet the outer one: the inner is not inside.
    #[error("the inner ellipse does not lie inside the outer one")]
    NotNested,
    /// The construction's lines are parallel or its numbers not finite.
    #[error("the two ellipses are degenerate")]
    Degenerate,
}

/// A construction of the projected centre from the two ellipses of a ring.
pub trait CentreEstimator: Send + Sync {
    /// The projected centre, px.
    ///
    /// # Errors
    /// [`CentreError`] where the ellipses cannot be the images of two concentric circles.
    fn estimate(&self, ring: &RingEllipses) -> Result<Centre, CentreError>;
}

/// What gives the projected centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Estimator {
    /// Centre of the outer ellipse (the paper's BC): biased by perspective, for comparison.
    BigEllipse,
    /// Centre of the inner ellipse (the paper's SC and GCS): biased by perspective, for comparison.
    SmallEllipse,
    /// Tangents on one side (the paper's Fei; Hao et al.).
    OneSided,
    /// The paper's construction, equations 26 to 29.
    Cross,
    /// The isolated eigenvector of the two conics.
    PolePolar,
    /// Maximum likelihood of the blurred ring's grey values: looks at the pixels, not at edges.
    #[default]
    Photometric,
}

impl Estimator {
    /// What gives the centre of a ring that the photometric estimator cannot measure.
    pub const FALLBACK: Self = Self::Cross;

    /// Every estimator, in the order of the documentation.
    pub const ALL: [Self; 6] = [
        Self::BigEllipse,
        Self::SmallEllipse,
        Self::OneSided,
        Self::Cross,
        Self::PolePolar,
        Self::Photometric,
    ];

    /// The name on the command line and in parameters.
    pub fn name(self) -> &'static str {
        match self {
            Self::BigEllipse => "big_ellipse",
            Self::SmallEllipse => "small_ellipse",
            Self::OneSided => "one_sided",
            Self::Cross => "cross",
            Self::PolePolar => "pole_polar",
            Self::Photometric => "photometric",
        }
    }

    /// The construction on ellipses, with its default settings; `None` for the photometric estimator, which needs the
    /// frame (see [`super::photometric`]).
    pub fn construction(self) -> Option<Box<dyn CentreEstimator>> {
        Some(match self {
            Self::BigEllipse => Box::new(BigEllipse),
            Self::SmallEllipse => Box::new(SmallEllipse),
            Self::OneSided => Box::new(OneSided),
            Self::Cross => Box::new(Cross::default()),
            Self::PolePolar => Box::new(PolePolar),
            Self::Photometric => return None,
        })
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
