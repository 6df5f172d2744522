//! ringcal's own messages; the .msg files in msg/ say what the fields mean.

use super::Header;
use ros2_client::Message;
use serde::{Deserialize, Serialize};

/// ringcal/msg/RingCentre: the projected centre of one ring.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct RingCentre {
    /// Row on the board, counted from 0.
    pub row: u16,
    /// Column on the board, counted from 0.
    pub column: u16,
    /// Projected centre, px, x right.
    pub x: f64,
    /// Projected centre, px, y down.
    pub y: f64,
    /// Covariance xx, xy, yy, px^2; all NaN where unknown.
    pub covariance: [f64; 3],
    /// Blur of the ring's edges, px.
    pub blur_sigma: f64,
}

/// ringcal/msg/RingCentreArray: the board as seen in one frame.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct RingCentreArray {
    /// Of the frame.
    pub header: Header,
    /// Of the frame, px.
    pub width: u32,
    /// Of the frame, px.
    pub height: u32,
    /// Of the board.
    pub rows: u16,
    /// Of the board.
    pub columns: u16,
    /// Row and column are the board's own.
    pub indices_absolute: bool,
    /// By row, then column.
    pub centres: Vec<RingCentre>,
    /// Why no board was found; empty where it was.
    pub reason: String,
}

/// ringcal/msg/CalibrationStatus: what the calibration has collected and what it needs.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct CalibrationStatus {
    /// Of the frame this was said about.
    pub header: Header,
    /// waiting, collecting, calibrating or calibrated.
    pub state: String,
    /// Views kept.
    pub views: u32,
    /// Views needed before a calibration.
    pub min_views: u32,
    /// Views kept at most.
    pub max_views: u32,
    /// Fraction of the frame's area that the views cover.
    pub coverage: f64,
    /// Whether the board was found in this frame.
    pub board_found: bool,
    /// Median blur, px.
    pub blur_sigma: f64,
    /// What to do next.
    pub guidance: String,
    /// Frames that arrived.
    pub frames_received: u64,
    /// Frames looked at.
    pub frames_processed: u64,
    /// Frames replaced by newer ones.
    pub frames_dropped: u64,
    /// Frames that could not be decoded.
    pub frames_failed: u64,
    /// Why the last of these failed.
    pub last_error: String,
    /// Decoded pixels to centres, s.
    pub processing_time: f64,
    /// Reprojection error of the last calibration, px; NaN where there is none.
    pub rms: f64,
    /// What the last ~/calibrate answered.
    pub last_result: String,
    /// Range of the views across the frame, 0 to 1.
    pub progress_x: f64,
    /// Range of the views down the frame, 0 to 1.
    pub progress_y: f64,
    /// Size of the board in the views, 0 to 1.
    pub progress_size: f64,
    /// Skew of the board in the views, 0 to 1.
    pub progress_skew: f64,
    /// Standard deviation of fx from the views kept, px; NaN while they do not tell it.
    pub predicted_fx_std: f64,
    /// Worst projection uncertainty of the frame at infinity from the views kept, px; NaN while they do not tell it.
    pub projection_std: f64,
}

impl Message for RingCentre {}
impl Message for RingCentreArray {}
impl Message for CalibrationStatus {}
