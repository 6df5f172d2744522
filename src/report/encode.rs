//! Pictures to PNG and JPEG bytes.

use super::visible::visible;
use crate::frame::{Frame, Pixels};
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, RgbImage};

/// JPEG quality, 1 (small) to 100 (fine).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Quality(u8);

impl Quality {
    /// `None` outside 1..=100.
    pub fn new(percent: u8) -> Option<Self> {
        (1..=100).contains(&percent).then_some(Self(percent))
    }
}

impl Default for Quality {
    /// 80: the debug pictures of a megapixel camera stay near 200 kB.
    fn default() -> Self {
        Self(80)
    }
}

/// A picture that the format cannot hold: no pixels, or sides beyond its limit (65535 for JPEG).
#[derive(Debug, thiserror::Error)]
#[error("a picture of {width} x {height} px cannot be encoded: {reason}")]
pub struct EncodeError {
    width: usize,
    height: usize,
    reason: image::ImageError,
}

/// The JPEG bytes of a colour picture.
///
/// # Errors
/// [`EncodeError`] where the picture is empty or too large for the format.
pub fn jpeg(picture: &RgbImage, quality: Quality) -> Result<Vec<u8>, EncodeError> {
    write_jpeg(
        picture,
        picture.dimensions(),
        ExtendedColorType::Rgb8,
        quality,
    )
}

/// The PNG bytes of a colour picture.
///
/// # Errors
/// [`EncodeError`] where the picture is empty or too large for the format.
pub fn png(picture: &RgbImage) -> Result<Vec<u8>, EncodeError> {
    write_png(picture, picture.dimensions(), ExtendedColorType::Rgb8)
}

/// The JPEG bytes of a frame. An 8-bit frame keeps its grey values, a 16-bit frame is made [`visible`].
///
/// # Errors
/// [`EncodeError`] where the frame is empty or too large for the format.
pub fn grey_jpeg(frame: &Frame, quality: Quality) -> Result<Vec<u8>, EncodeError> {
    let sides = (frame.width() as u32, frame.height() as u32);
    match &frame.pixels {
        Pixels::U8(plane) => write_jpeg(plane.data(), sides, ExtendedColorType::L8, quality),
        Pixels::U16(_) => write_jpeg(&visible(frame), sides, ExtendedColorType::L8, quality),
    }
}

/// The PNG bytes of a frame, in its own depth and lossless.
///
/// # Errors
/// [`EncodeError`] where the frame is empty or too large for the format.
pub fn grey_png(frame: &Frame) -> Result<Vec<u8>, EncodeError> {
    let sides = (frame.width() as u32, frame.height() as u32);
    match &frame.pixels {
        Pixels::U8(plane) => write_png(plane.data(), sides, ExtendedColorType::L8),
        Pixels::U16(plane) => {
            // the encoder takes 16-bit samples as bytes in the machine's order
            let bytes: Vec<u8> = plane.data().iter().flat_map(|v| v.to_ne_bytes()).collect();
            write_png(&bytes, sides, ExtendedColorType::L16)
        }
    }
}

fn write_jpeg(
    samples: &[u8],
    sides: (u32, u32),
    colour: ExtendedColorType,
    quality: Quality,
) -> Result<Vec<u8>, EncodeError> {
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, quality.0);
    checked(encoder, samples, sides, colour)?;
    Ok(bytes)
}

fn write_png(
    samples: &[u8],
    sides: (u32, u32),
    colour: ExtendedColorType,
) -> Result<Vec<u8>, EncodeError> {
    let mut bytes = Vec::new();
    let encoder =
        PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Adaptive);
    checked(encoder, samples, sides, colour)?;
    Ok(bytes)
}

fn checked(
    encoder: impl ImageEncoder,
    samples: &[u8],
    (width, height): (u32, u32),
    colour: ExtendedColorType,
) -> Result<(), EncodeError> {
    encoder
        .write_image(samples, width, height, colour)
        .map_err(|reason| EncodeError {
            width: width as usize,
            height: height as usize,
            reason,
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Plane, Stamp};
    use image::Rgb;

    fn decoded(bytes: &[u8]) -> Frame {
        Frame::decode(bytes, Stamp::default(), "").unwrap()
    }

    #[test]
    fn png_keeps_every_grey_value_in_both_depths() {
        let deep = (0..60_u16).map(|k| k * 1001).collect();
        let deep = Frame::from_u16(Plane::from_vec(10, 6, deep).unwrap(), "");
        assert_eq!(decoded(&grey_png(&deep).unwrap()), deep);
        let flat = Frame::from_u8(Plane::from_vec(3, 1, vec![0, 7, 255]).unwrap(), "");
        assert_eq!(decoded(&grey_png(&flat).unwrap()), flat);
    }

    #[test]
    fn better_quality_is_larger_and_closer() {
        let picture = RgbImage::from_fn(64, 64, |x, y| Rgb([(x * y % 256) as u8, 99, x as u8]));
        let size = |percent| {
            let bytes = jpeg(&picture, Quality::new(percent).unwrap()).unwrap();
            let back = decoded(&bytes);
            assert_eq!((back.width(), back.height()), (64, 64));
            bytes.len()
        };
        assert!(size(10) < size(50) && size(50) < size(100));
        assert_eq!((Quality::new(0), Quality::new(101)), (None, None));
        let same = image::load_from_memory(&png(&picture).unwrap()).unwrap();
        assert_eq!(same.into_rgb8(), picture);
    }

    #[test]
    fn a_dark_sixteen_bit_frame_is_made_visible_as_jpeg() {
        let dim = (0..4096_u16).map(|k| k / 16).collect();
        let dim = Frame::from_u16(Plane::from_vec(64, 64, dim).unwrap(), "");
        let Pixels::U8(plane) = decoded(&grey_jpeg(&dim, Quality::default()).unwrap()).pixels
        else {
            panic!("JPEG is 8 bit");
        };
        assert!(plane.at(0, 0) < 20 && plane.at(63, 63) > 235);
    }

    #[test]
    fn an_empty_picture_is_refused_and_does_not_panic() {
        let empty = Frame::from_u8(Plane::filled(0, 0, 0), "");
        assert!(grey_png(&empty).unwrap_err().to_string().contains("0 x 0"));
        assert!(grey_jpeg(&empty, Quality::default()).is_err());
    }
}
