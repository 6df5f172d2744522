//! Frame -> [`Detection`]: where every ring of the board is in one frame.

mod band_pass;
mod blobs;
mod candidates;
mod centres;
mod detection;
mod detector;
mod edges;
mod ellipse_fit;
mod grid;
mod labelling;
mod orientation;
mod places;
mod plausible;
mod profile;
mod ring_fit;
mod rings;

pub use detection::{Detection, Indices, Miss, Ring};
pub use detector::{DetectOptions, Detector};
