//! PNG, JPEG, PNM, TIFF and BMP bytes to a grey [`Frame`]: image files and `sensor_msgs/CompressedImage`.
//!
//! The format is read from the first bytes; names and format strings are only hints and are not asked. 16-bit pictures
//! stay 16 bit, colour becomes the same BT.601 luma as in `sensor_msgs/Image`, alpha is ignored, and the orientation is the
//! one stored: an EXIF rotation is not applied, because a calibration belongs to the sensor's own pixels.

use super::luma::{luma8, luma16};
use super::{Frame, Pixel, Pixels, Plane, Stamp};
use image::{DynamicImage, ImageFormat};
use std::io::Cursor;

/// Why encoded bytes are not a frame.
#[derive(Debug, thiserror::Error)]
pub enum DecodeError {
    /// No bytes at all.
    #[error("it is empty")]
    Empty,
    /// The first bytes are those of no picture format that is read.
    #[error("it is not a PNG, JPEG, PNM, TIFF or BMP image")]
    NotAnImage,
    /// The format is known, the content is not as the format asks, or ends too early.
    #[error("it is a damaged or truncated {format} image: {reason}")]
    Damaged {
        /// The format, from the first bytes.
        format: &'static str,
        /// What the decoder says.
        reason: String,
    },
    /// A kind of pixel that has no grey value of 8 or 16 bits, or a variant of the format that is not read.
    #[error("its pixels cannot be read: {reason}")]
    Unsupported {
        /// What is not supported.
        reason: String,
    },
}

impl Frame {
    /// Decodes one picture; `source` is the path of its file or the `frame_id` of its message.
    ///
    /// # Errors
    /// [`DecodeError`] where the bytes are no picture, a damaged one or one of an unsupported kind.
    pub fn decode(
        bytes: &[u8],
        stamp: Stamp,
        source: impl Into<String>,
    ) -> Result<Self, DecodeError> {
        if bytes.is_empty() {
            return Err(DecodeError::Empty);
        }
        let format = image::guess_format(bytes).map_err(|_| DecodeError::NotAnImage)?;
        let name = name(format).ok_or(DecodeError::NotAnImage)?;
        if format == ImageFormat::Jpeg && !ends_as_jpeg(bytes) {
            return Err(DecodeError::Damaged {
                format: name,
                reason: "the end marker is missing".into(),
            });
        }
        let mut reader = image::ImageReader::new(Cursor::new(bytes));
        reader.set_format(format);
        let picture = reader.decode().map_err(|error| refusal(name, error))?;
        Ok(Self {
            pixels: grey(picture)?,
            stamp,
            source: source.into(),
        })
    }
}

/// The formats this build reads.
fn name(format: ImageFormat) -> Option<&'static str> {
    match format {
        ImageFormat::Png => Some("PNG"),
        ImageFormat::Jpeg => Some("JPEG"),
        ImageFormat::Pnm => Some("PNM"),
        ImageFormat::Tiff => Some("TIFF"),
        ImageFormat::Bmp => Some("BMP"),
        _ => None,
    }
}

/// Whether the end-of-image marker is there: the decoder fills what is missing of a cut JPEG with grey and says
/// nothing. Some cameras append data, so the marker may stand anywhere in the second half.
fn ends_as_jpeg(bytes: &[u8]) -> bool {
    bytes[bytes.len() / 2..]
        .windows(2)
        .any(|pair| pair == [0xFF, 0xD9])
}

fn refusal(format: &'static str, error: image::ImageError) -> DecodeError {
    match error {
        image::ImageError::Unsupported(error) => DecodeError::Unsupported {
            reason: error.to_string(),
        },
        other => DecodeError::Damaged {
            format,
            reason: other.to_string(),
        },
    }
}

fn grey(picture: DynamicImage) -> Result<Pixels, DecodeError> {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let pixels = match picture {
        DynamicImage::ImageLuma8(p) => eight(width, height, p.into_raw()),
        DynamicImage::ImageLumaA8(p) => eight(width, height, each(&p, |&[v, _]| v)),
        DynamicImage::ImageRgb8(p) => eight(width, height, each(&p, |&[r, g, b]| luma8(r, g, b))),
        DynamicImage::ImageRgba8(p) => {
            eight(width, height, each(&p, |&[r, g, b, _]| luma8(r, g, b)))
        }
        DynamicImage::ImageLuma16(p) => sixteen(width, height, p.into_raw()),
        DynamicImage::ImageLumaA16(p) => sixteen(width, height, each(&p, |&[v, _]| v)),
        DynamicImage::ImageRgb16(p) => {
            sixteen(width, height, each(&p, |&[r, g, b]| luma16(r, g, b)))
        }
        DynamicImage::ImageRgba16(p) => {
            sixteen(width, height, each(&p, |&[r, g, b, _]| luma16(r, g, b)))
        }
        other => {
            return Err(DecodeError::Unsupported {
                reason: format!("{:?} is not 8 or 16 bit", other.color()),
            });
        }
    };
    pixels.ok_or_else(|| DecodeError::Unsupported {
        reason: format!("the decoder did not give {width} x {height} px"),
    })
}

fn eight(width: usize, height: usize, grey: Vec<u8>) -> Option<Pixels> {
    Plane::from_vec(width, height, grey).map(Pixels::U8)
}

fn sixteen(width: usize, height: usize, grey: Vec<u16>) -> Option<Pixels> {
    Plane::from_vec(width, height, grey).map(Pixels::U16)
}

/// One grey value for every `N` samples.
fn each<const N: usize, T: Pixel>(samples: &[T], grey: impl Fn(&[T; N]) -> T) -> Vec<T> {
    samples.as_chunks::<N>().0.iter().map(grey).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{ImageBuffer, Luma, Rgb, RgbImage, Rgba};

    fn encoded(picture: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        picture.into().write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    fn decoded(bytes: &[u8]) -> Pixels {
        Frame::decode(bytes, Stamp::default(), "a").unwrap().pixels
    }

    fn refused(bytes: &[u8]) -> DecodeError {
        Frame::decode(bytes, Stamp::default(), "a").unwrap_err()
    }

    fn ramp() -> ImageBuffer<Luma<u16>, Vec<u16>> {
        ImageBuffer::from_fn(40, 30, |x, y| Luma([(x * 1500 + y * 7) as u16]))
    }

    #[test]
    fn sixteen_bits_stay_sixteen_bits() {
        let plane = Plane::from_vec(40, 30, ramp().into_raw()).unwrap();
        for format in [ImageFormat::Png, ImageFormat::Pnm, ImageFormat::Tiff] {
            let picture = DynamicImage::ImageLuma16(ramp());
            assert_eq!(
                decoded(&encoded(picture, format)),
                Pixels::U16(plane.clone())
            );
        }
    }

    #[test]
    fn eight_bits_are_the_same_in_every_lossless_format() {
        let grey = ImageBuffer::from_fn(13, 9, |x, y| Luma([(x * 19 + y) as u8]));
        let plane = Plane::from_vec(13, 9, grey.clone().into_raw()).unwrap();
        for format in [
            ImageFormat::Png,
            ImageFormat::Pnm,
            ImageFormat::Tiff,
            ImageFormat::Bmp,
        ] {
            let picture = DynamicImage::ImageLuma8(grey.clone());
            assert_eq!(
                decoded(&encoded(picture, format)),
                Pixels::U8(plane.clone())
            );
        }
    }

    #[test]
    fn colour_is_luma_in_both_depths_and_alpha_is_ignored() {
        let rgba = ImageBuffer::from_pixel(1, 1, Rgba([255_u8, 0, 0, 3]));
        let red = Plane::filled(1, 1, 76_u8);
        assert_eq!(decoded(&encoded(rgba, ImageFormat::Png)), Pixels::U8(red));
        let deep = DynamicImage::ImageRgb16(ImageBuffer::from_pixel(1, 1, Rgb([0, 65535, 0])));
        let green = Plane::filled(1, 1, 38_469_u16); // 0.587 * 65535 = 38469.045
        assert_eq!(
            decoded(&encoded(deep, ImageFormat::Png)),
            Pixels::U16(green)
        );
    }

    #[test]
    fn grey_jpeg_comes_within_its_loss() {
        let grey = ImageBuffer::from_fn(64, 48, |x, _| Luma([(x * 4) as u8]));
        let Pixels::U8(plane) = decoded(&encoded(grey, ImageFormat::Jpeg)) else {
            panic!("JPEG is 8 bit");
        };
        let error = |x: usize| (i32::from(plane.at(x, 20)) - 4 * x as i32).abs();
        assert!((0..64).all(|x| error(x) <= 12));
    }

    #[test]
    fn a_cut_file_is_refused_in_every_format() {
        let noise = RgbImage::from_fn(64, 48, |x, y| {
            let v = (x * 7919 + y * 104_729) % 251;
            Rgb([v as u8, (v * 3) as u8, (v * 7) as u8])
        });
        for format in [
            ImageFormat::Png,
            ImageFormat::Jpeg,
            ImageFormat::Pnm,
            ImageFormat::Tiff,
            ImageFormat::Bmp,
        ] {
            let bytes = encoded(noise.clone(), format);
            for part in [30, 60, 95] {
                let error = refused(&bytes[..bytes.len() * part / 100]);
                assert!(
                    matches!(error, DecodeError::Damaged { .. }),
                    "{format:?} {part} %: {error}"
                );
            }
        }
    }

    #[test]
    fn other_bytes_are_no_image() {
        assert!(matches!(refused(b""), DecodeError::Empty));
        assert!(matches!(refused(b"rows: 7\n"), DecodeError::NotAnImage));
        assert!(matches!(refused(b"GIF89a rest"), DecodeError::NotAnImage));
    }
}
