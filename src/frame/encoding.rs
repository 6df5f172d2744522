//! `sensor_msgs/Image` to a grey [`Frame`].
//!
//! A message is bytes and a promise of what they mean: `height` rows of `step` bytes, each row `width` pixels of
//! `encoding` and then padding that means nothing. [`RawImage::into_frame`] checks the promise and keeps the
//! pixels in the depth they came in; colour becomes the BT.601 luma, alpha is ignored.
//!
//! How strict: as `cv_bridge`, which most of ROS reads images with. `data` must be `step * height` bytes, not one more
//! or less. In particular the padding of the last row must be there, and data that is too long is refused, because
//! both mean that the numbers are not those of this picture.

use super::luma::luma8;
use super::{Frame, Pixels, Plane, Stamp};

/// The fields of a `sensor_msgs/Image` that describe its pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RawImage {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// A name from `sensor_msgs/image_encodings.hpp`.
    pub encoding: String,
    /// Byte order of 16-bit pixels.
    pub is_bigendian: bool,
    /// Bytes from the start of one row to the start of the next.
    pub step: u32,
    /// The rows with their padding.
    pub data: Vec<u8>,
}

/// Why bytes are not a frame.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FrameError {
    /// An encoding that is not read.
    #[error(
        "image encoding {encoding:?} is not supported; supported are {}",
        supported()
    )]
    UnsupportedEncoding {
        /// The name in the message.
        encoding: String,
    },
    /// A picture without pixels.
    #[error("the image is {width} x {height} px: it has no pixels")]
    Empty {
        /// Width in the message, px.
        width: u32,
        /// Height in the message, px.
        height: u32,
    },
    /// Rows that overlap.
    #[error("step is {step} bytes, but a row of {width} px in {encoding} takes {row_bytes} bytes")]
    StepTooSmall {
        /// Bytes from row to row in the message.
        step: u32,
        /// Width in the message, px.
        width: u32,
        /// The name in the message.
        encoding: String,
        /// Bytes of a row without padding.
        row_bytes: u64,
    },
    /// Data of another length than the header says.
    #[error(
        "the image has {found} bytes of data, but step * height = {step} * {height} = {expected}"
    )]
    DataLength {
        /// Bytes in the message.
        found: usize,
        /// Bytes from row to row in the message.
        step: u32,
        /// Height in the message, px.
        height: u32,
        /// Their product.
        expected: u64,
    },
}

/// What the bytes of one pixel are, in order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Layout {
    Grey8,
    Grey16,
    Rgb,
    Bgr,
    Rgba,
    Bgra,
}

/// Characters of an unknown encoding that an error repeats.
const LONGEST_NAME: usize = 40;

/// Every encoding that is read, by its name in `image_encodings.hpp`.
const LAYOUTS: [(&str, Layout); 8] = [
    ("mono8", Layout::Grey8),
    ("mono16", Layout::Grey16),
    ("rgb8", Layout::Rgb),
    ("bgr8", Layout::Bgr),
    ("rgba8", Layout::Rgba),
    ("bgra8", Layout::Bgra),
    ("8UC1", Layout::Grey8),
    ("16UC1", Layout::Grey16),
];

fn supported() -> String {
    LAYOUTS.map(|(name, _)| name).join(", ")
}

impl Layout {
    fn of(encoding: &str) -> Option<Self> {
        let known = LAYOUTS.into_iter().find(|(name, _)| *name == encoding);
        known.map(|(_, layout)| layout)
    }

    fn pixel_bytes(self) -> usize {
        match self {
            Self::Grey8 => 1,
            Self::Grey16 => 2,
            Self::Rgb | Self::Bgr => 3,
            Self::Rgba | Self::Bgra => 4,
        }
    }
}

impl RawImage {
    /// The grey picture in the depth it came in; `source` is the message's `frame_id`. 8-bit grey is moved, not
    /// copied.
    ///
    /// # Errors
    /// [`FrameError`] where the encoding is not read or the sizes do not add up.
    pub fn into_frame(self, stamp: Stamp, source: impl Into<String>) -> Result<Frame, FrameError> {
        let layout = self.checked_layout()?;
        let (width, height, step) = (
            self.width as usize,
            self.height as usize,
            self.step as usize,
        );
        let big_endian = self.is_bigendian;
        let rows = Rows {
            data: self.data,
            step,
            row_bytes: width * layout.pixel_bytes(),
        };
        let eight = |grey| Plane::from_vec(width, height, grey).map(Pixels::U8);
        let pixels = match layout {
            Layout::Grey8 => eight(rows.into_packed()),
            Layout::Grey16 => {
                Plane::from_vec(width, height, rows.words(big_endian)).map(Pixels::U16)
            }
            Layout::Rgb => eight(rows.map(|&[r, g, b]| luma8(r, g, b))),
            Layout::Bgr => eight(rows.map(|&[b, g, r]| luma8(r, g, b))),
            Layout::Rgba => eight(rows.map(|&[r, g, b, _]| luma8(r, g, b))),
            Layout::Bgra => eight(rows.map(|&[b, g, r, _]| luma8(r, g, b))),
        };
        Ok(Frame {
            // step * height was compared with the data, so every row is there
            pixels: pixels.expect("checked_layout saw height rows of width pixels"),
            stamp,
            source: source.into(),
        })
    }

    fn checked_layout(&self) -> Result<Layout, FrameError> {
        let layout = Layout::of(&self.encoding).ok_or_else(|| FrameError::UnsupportedEncoding {
            // it comes from the network and goes to logs: no longer than any real name
            encoding: self.encoding.chars().take(LONGEST_NAME).collect(),
        })?;
        if self.width == 0 || self.height == 0 {
            return Err(FrameError::Empty {
                width: self.width,
                height: self.height,
            });
        }
        // 32-bit numbers multiplied in 64 bits: neither product can overflow
        let row_bytes = u64::from(self.width) * layout.pixel_bytes() as u64;
        if u64::from(self.step) < row_bytes {
            return Err(FrameError::StepTooSmall {
                step: self.step,
                width: self.width,
                encoding: self.encoding.clone(),
                row_bytes,
            });
        }
        let expected = u64::from(self.step) * u64::from(self.height);
        if self.data.len() as u64 != expected {
            return Err(FrameError::DataLength {
                found: self.data.len(),
                step: self.step,
                height: self.height,
                expected,
            });
        }
        Ok(layout)
    }
}

/// Rows of `step` bytes of which the first `row_bytes` are pixels.
struct Rows {
    data: Vec<u8>,
    step: usize,
    row_bytes: usize,
}

impl Rows {
    fn iter(&self) -> impl Iterator<Item = &[u8]> {
        self.data
            .chunks_exact(self.step)
            .map(|row| &row[..self.row_bytes])
    }

    /// The pixels without padding, in the same memory.
    fn into_packed(mut self) -> Vec<u8> {
        if self.step != self.row_bytes {
            let height = self.data.len() / self.step;
            for y in 1..height {
                let start = y * self.step;
                self.data
                    .copy_within(start..start + self.row_bytes, y * self.row_bytes);
            }
            self.data.truncate(height * self.row_bytes);
        }
        self.data
    }

    /// 16-bit pixels in the machine's byte order.
    fn words(&self, big_endian: bool) -> Vec<u16> {
        if big_endian {
            self.map(|&pair| u16::from_be_bytes(pair))
        } else {
            self.map(|&pair| u16::from_le_bytes(pair))
        }
    }

    /// One grey value for every `N` bytes.
    fn map<const N: usize, T>(&self, grey: impl Fn(&[u8; N]) -> T) -> Vec<T> {
        let mut out = Vec::with_capacity(self.data.len() / N);
        for row in self.iter() {
            out.extend(row.as_chunks::<N>().0.iter().map(&grey));
        }
        out
    }
}

#[cfg(test)]
mod tests;
