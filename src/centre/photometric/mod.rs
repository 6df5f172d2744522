//! The photometric estimator: maximum likelihood of a blurred ring's grey values.
//!
//! ```text
//! ellipses -> ring      one ring: start, fit, and the gate that decides whether to believe it
//!             start     the window and the first guess: levels, blur, size
//!             fit       Levenberg-Marquardt on `model`
//!             psf       Gaussian or disc, by likelihood
//!                       model = levels x coverage (blurred circles of `shape`) x shading
//!          -> board     the rings of a board share their perspective
//! ```
//!
//! No construction on edges can be right under blur: an edge is displaced by the neighbouring edge and by its own
//! curvature. The model knows both. It is fitted to the raw pixels of the frame, binned by half the blur at most.

mod blur;
mod board;
mod choice;
mod coverage;
mod disc;
mod fit;
mod gaussian;
mod model;
mod outline;
mod psf;
mod response;
mod ring;
mod shape;
mod start;
mod window;

pub use blur::{Blur, Psf};
pub use board::{CentreAndCovariance, share_perspective};
pub use choice::PsfChoice;
pub use fit::{FitError, RingFitted, ShapeCovariance, fit};
pub use model::RingModel;
pub use psf::{ViewFitted, fit_psf, fit_view};
pub use response::ResponseGamma;
pub use ring::{RingError, RingStart, measure_ring};
pub use shape::{SHAPE_PARAMETERS, Shape};
pub use start::{start, window};
pub use window::{Grid, Rectangle, Window};

#[cfg(test)]
mod tests;
