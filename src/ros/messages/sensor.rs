//! sensor_msgs.

use super::Header;
use super::byte_sequence;
use ros2_client::Message;
use serde::{Deserialize, Serialize};

/// sensor_msgs/msg/Image.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Image {
    /// Time of exposure and the camera's optical frame.
    pub header: Header,
    /// Rows.
    pub height: u32,
    /// Columns.
    pub width: u32,
    /// Meaning of the bytes, e.g. `mono8`.
    pub encoding: String,
    /// Nonzero where numbers of more than one byte start with the highest.
    pub is_bigendian: u8,
    /// Bytes from one row to the next.
    pub step: u32,
    /// `step * height` bytes.
    #[serde(with = "byte_sequence")]
    pub data: Vec<u8>,
}

/// sensor_msgs/msg/CompressedImage.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct CompressedImage {
    /// Time of exposure and the camera's optical frame.
    pub header: Header,
    /// e.g. `jpeg`.
    pub format: String,
    /// A whole file of that format.
    #[serde(with = "byte_sequence")]
    pub data: Vec<u8>,
}

/// sensor_msgs/msg/RegionOfInterest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct RegionOfInterest {
    /// Left edge, px; 0 with the other zeros means the whole frame.
    pub x_offset: u32,
    /// Top edge, px.
    pub y_offset: u32,
    /// Height, px.
    pub height: u32,
    /// Width, px.
    pub width: u32,
    /// Whether the region should be rectified.
    pub do_rectify: bool,
}

/// sensor_msgs/msg/CameraInfo; a zero `k[0]` means uncalibrated.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct CameraInfo {
    /// Of the frame it belongs to.
    pub header: Header,
    /// Height of the calibrated frames, px.
    pub height: u32,
    /// Width of the calibrated frames, px.
    pub width: u32,
    /// e.g. `plumb_bob`.
    pub distortion_model: String,
    /// Distortion coefficients; of plumb_bob k1 k2 t1 t2 k3.
    pub d: Vec<f64>,
    /// Camera matrix, 3 x 3, row by row.
    pub k: [f64; 9],
    /// Rectification, 3 x 3, row by row.
    pub r: [f64; 9],
    /// Projection, 3 x 4, row by row.
    pub p: [f64; 12],
    /// Pixels joined along x; 0 is 1.
    pub binning_x: u32,
    /// Pixels joined along y; 0 is 1.
    pub binning_y: u32,
    /// The part of the frame that is sent.
    pub roi: RegionOfInterest,
}

impl Message for Image {}
impl Message for CompressedImage {}
impl Message for RegionOfInterest {}
impl Message for CameraInfo {}
