//! The photometric estimator: maximum likelihood of a blurred ring's grey values.
//!
//! ```text
//! ellipses -> start     the window and the first guess: levels, blur, size
//!          -> fit       Levenberg-Marquardt on `model`
//!                       model = levels x coverage (blurred circles of `shape`) x shading
//! ```
//!
//! No construction on edges can be right under blur: an edge is displaced by the neighbouring edge and by its own
//! curvature. The model knows both. It is fitted to the raw pixels of the frame, binned by half the blur at most.

mod blur;
mod coverage;
mod disc;
mod fit;
mod gaussian;
mod model;
mod outline;
mod shape;
mod start;
mod window;

pub use blur::{Blur, Psf};
pub use fit::{FitError, RingFitted, fit};
pub use model::RingModel;
pub use shape::{SHAPE_PARAMETERS, Shape};
pub use start::{start, window};
pub use window::{Grid, Rectangle, Window};

#[cfg(test)]
mod tests;
