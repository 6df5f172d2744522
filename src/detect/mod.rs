//! Frame -> [`Detection`]: where every ring of the board is in one frame.

mod band_pass;
mod bends;
mod blobs;
mod candidates;
mod centres;
mod detection;
mod detector;
mod edges;
mod ellipse_fit;
mod grid;
mod labelling;
mod light;
mod likeness;
mod margins;
mod marks;
mod measured;
mod nearby;
mod orientation;
mod other_size;
mod outermost;
mod outward;
mod patch;
mod places;
mod plausible;
mod profile;
mod required;
mod ring_fit;
mod rings;
mod runs;
mod scales;
mod single;
mod whole;

pub use detection::{Detection, FellBack, Indices, Measured, Miss, Odd, Ring};
pub use detector::{DetectOptions, Detector};
pub(crate) use ellipse_fit::ellipse_along;
pub use required::Required;
