//! The files ringcal reads and writes.

mod detection_line;
mod write_by_rename;

pub use detection_line::{DetectionLine, PointLine};
pub use write_by_rename::write_by_rename;
