//! One frame in which the board was found.

use crate::detect::{Detection, Indices, Ring};
use crate::frame::Stamp;
use nalgebra::Matrix3;

/// A frame in which the board was found, as a calibration needs it.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// For people: the path of a file, or frame id and stamp of a message.
    pub source: String,
    /// The `frame_id` of the message; empty for a file.
    pub frame_id: String,
    /// Time of exposure; zero for a file.
    pub stamp: Stamp,
    /// Width of the frame, px.
    pub width: usize,
    /// Height of the frame, px.
    pub height: usize,
    /// Whether rows and columns are the board's own. Each view's labels stand alone: where the board has no marks
    /// they may be turned by 180 degrees (or 90, on a square board) or shifted against those of another view. The
    /// lens does not notice, because each view has its own pose.
    pub indices: Indices,
    /// The rings found, by row, then column.
    pub rings: Vec<Ring>,
    /// Board plane (m) to frame (px), distortion neglected.
    pub homography: Matrix3<f64>,
}

impl View {
    /// The view of an image file.
    pub fn of_file(path: impl Into<String>, detection: &Detection) -> Self {
        Self::new(path.into(), String::new(), Stamp::default(), detection)
    }

    /// The view of a message: its `frame_id` and stamp.
    pub fn of_message(frame_id: &str, stamp: Stamp, detection: &Detection) -> Self {
        let source = format!("{frame_id} at {}.{:09}", stamp.sec, stamp.nanosec);
        Self::new(source, frame_id.to_owned(), stamp, detection)
    }

    fn new(source: String, frame_id: String, stamp: Stamp, detection: &Detection) -> Self {
        Self {
            source,
            frame_id,
            stamp,
            width: detection.width,
            height: detection.height,
            indices: detection.indices,
            rings: detection.rings.clone(),
            homography: detection.homography,
        }
    }
}
