//! The photometric estimator: maximum likelihood of a blurred ring's grey values.
//!
//! ```text
//! outline -> ring      one ring: starts, fit, and the gate that decides whether to believe it
//!            start     the window and the grey levels of a start
//!            psf       Gaussian or disc, by likelihood
//!            fit       Levenberg-Marquardt (`descent`) on `problem`: residuals (`model`, `censored`), their sums (`gram`, `pull`) and `equations`;
//!                      a `wall` keeps light from being negative
//!                      model = levels x coverage x shading, and the end of the `sheet` (`corner`) where it is in reach
//!                      coverage = stamps (`gaussian`, `disc`) along the outlines (`boundary`) of a `shape`
//! outlines -> board    all rings of a view: a `jury` for blur and size (heard among `likes`), the skirts `around` each ring, what of
//!                      the surroundings to `trust`, the steps they take together where they are crowded (`joint`, `crowd`, `gmres`), blur
//!                      that is `uneven`, bends that show (`flatten`), the perspective they share (`law`, `lens_map`), and whether their outlines are `round`
//! kept     -> refit    the second pass: rings that a view kept, their shapes known; what the lens's bends do is taken off (`straight`)
//! ```
//!
//! No construction on edges can be right under blur: an edge is displaced by the neighbouring edge and by its own
//! curvature. The model knows both. It is fitted to the raw pixels of the frame, binned as far as the blur allows.

mod alone;
mod around;
mod bent;
mod blur;
mod board;
mod border;
mod bound;
mod boundary;
mod censored;
mod choice;
mod corner;
mod coverage;
mod crowd;
mod dense;
mod descent;
mod disc;
mod disc_edge;
mod drawing;
mod edge;
mod equations;
mod fan;
mod feet;
mod fit;
mod fitted;
mod flatten;
mod gamma;
mod gauss_edge;
mod gaussian;
mod gmres;
mod gram;
mod hearing;
mod joint;
mod jury;
mod kept;
mod law;
mod lens_map;
mod likes;
mod model;
mod normal;
mod plane;
mod problem;
mod psf;
mod pull;
mod real;
mod refit;
mod response;
mod ring;
mod round;
mod rows;
mod shape;
mod shared;
mod sharp;
mod sheet;
mod sheet_start;
mod sighting;
mod stamps;
mod start;
mod straight;
mod through;
mod trust;
mod unbent;
mod under;
mod uneven;
mod usual;
mod wall;
mod window;

pub use blur::{Blur, Psf};
pub use board::{BoardMeasured, BoardPlace, BoardStart, measure_board};
pub use bound::cramer_rao_bound;
pub use choice::PsfChoice;
pub use fit::{Given, Known, fit};
pub use fitted::{FitError, RingFitted, ShapeCovariance};
pub use gamma::estimate_gamma;
pub use kept::{KeptRing, KeptWindow, RingMeasured};
pub use law::CentreAndCovariance;
pub use lens_map::shape_under;
pub use model::RingModel;
pub use problem::Workspace;
pub use psf::Both;
pub use refit::{KnownRing, refit};
pub use response::ResponseGamma;
pub use ring::{RingError, RingStart, Seen, measure_ring};
pub use shape::{SHAPE_PARAMETERS, Shape};
pub use sheet::{Edge, SheetEnd};
pub use start::window;
pub use window::{End, Grid, Rectangle, Window};

#[cfg(test)]
mod tests;
