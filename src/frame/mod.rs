//! Pixels in: one grey frame in the bit depth it came in, and the views of it that later stages read.
//!
//! A [`Frame`] is grey, 8 or 16 bit, rows contiguous. [`RawImage`] turns a `sensor_msgs/Image` into one,
//! [`Frame::decode`] a `CompressedImage` or an image file.
//! Pixel coordinates everywhere: x right, y down, the centre of the top-left pixel is (0, 0).

mod compressed;
mod encoding;
mod linear;
mod luma;
mod plane;
mod pyramid;
mod thumbnail;
mod vectors;

pub use compressed::DecodeError;
pub use encoding::{FrameError, RawImage};
pub use linear::Linear;
pub use plane::{Pixel, Plane};
pub use pyramid::{Level, half, half_of_frame, quarter_of_frame};
pub use thumbnail::Thumbnail;
pub(crate) use vectors::widest;

/// The pixels of a frame in the depth they came in.
#[derive(Debug, Clone, PartialEq)]
pub enum Pixels {
    /// 8 bit, full scale 255.
    U8(Plane<u8>),
    /// 16 bit in the machine's byte order, full scale 65535.
    U16(Plane<u16>),
}

/// When a frame was taken: seconds and nanoseconds since the publisher's epoch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Stamp {
    /// Whole seconds.
    pub sec: i32,
    /// Nanoseconds within the second.
    pub nanosec: u32,
}

/// One grey picture with its origin.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// The grey values.
    pub pixels: Pixels,
    /// Time of exposure; zero for image files.
    pub stamp: Stamp,
    /// Where it came from: the `frame_id` of a message or the path of a file.
    pub source: String,
}

impl Frame {
    /// A frame of 8-bit pixels.
    pub fn from_u8(plane: Plane<u8>, source: impl Into<String>) -> Self {
        Self {
            pixels: Pixels::U8(plane),
            stamp: Stamp::default(),
            source: source.into(),
        }
    }

    /// A frame of 16-bit pixels.
    pub fn from_u16(plane: Plane<u16>, source: impl Into<String>) -> Self {
        Self {
            pixels: Pixels::U16(plane),
            stamp: Stamp::default(),
            source: source.into(),
        }
    }

    /// Width, px.
    pub fn width(&self) -> usize {
        match &self.pixels {
            Pixels::U8(p) => p.width(),
            Pixels::U16(p) => p.width(),
        }
    }

    /// Height, px.
    pub fn height(&self) -> usize {
        match &self.pixels {
            Pixels::U8(p) => p.height(),
            Pixels::U16(p) => p.height(),
        }
    }
}
