//! The estimators of a ring's projected centre, one file each behind one trait.
//!
//! The centre of neither ellipse is the image of the circles' centre (paper III-B). [`Cross`] is the paper's
//! construction; [`BigEllipse`], [`SmallEllipse`], [`OneSided`] and [`PolePolar`] are what it is compared with.

mod big_ellipse;
mod cross;
mod ellipse;
mod estimator;
mod line;
mod one_sided;
pub mod photometric;
mod pole_polar;
mod small_ellipse;
mod tangents;

pub use big_ellipse::BigEllipse;
pub use cross::Cross;
pub use ellipse::Ellipse;
pub use estimator::{Centre, CentreError, CentreEstimator, Estimator};
pub use one_sided::OneSided;
pub use pole_polar::PolePolar;
pub use small_ellipse::SmallEllipse;

/// The two ellipses of one ring in the image, px; the inner one is the image of the inner circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingEllipses {
    /// Image of the inner circle (the paper's C_S).
    pub inner: Ellipse,
    /// Image of the outer circle (the paper's C_B).
    pub outer: Ellipse,
}

impl RingEllipses {
    /// Width of the ring between its circles, px.
    pub fn width(&self) -> f64 {
        self.outer.mean_radius() - self.inner.mean_radius()
    }
}

#[cfg(test)]
mod tests;
