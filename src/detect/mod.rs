//! Frame -> [`Detection`]: where every ring of the board is in one frame.

mod detection;
mod detector;

pub use detection::{Detection, Indices, Miss, Ring};
pub use detector::{DetectOptions, Detector};
