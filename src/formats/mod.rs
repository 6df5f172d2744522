//! What ringcal writes and reads besides pictures.

mod detection_line;

pub use detection_line::{DetectionLine, PointLine};
