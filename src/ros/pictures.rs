//! Pictures as messages: raw and JPEG.

use super::messages::{CompressedImage, Header, Image};
use crate::detect::{Detection, Miss};
use crate::frame::{Frame, Pixels};
use crate::report::{self, EncodeError, Quality, Scale};
use crate::session::Session;
use image::imageops::{self, FilterType};
use image::{GrayImage, ImageBuffer, Luma, Rgb, RgbImage};

/// A picture to be published.
#[derive(Debug, Clone, PartialEq)]
pub enum Picture {
    /// A frame, in the depth it came in.
    Grey(Frame),
    /// Something drawn.
    Colour(RgbImage),
}

/// The frame with what was found in it and the coverage so far.
pub fn drawn(
    frame: &Frame,
    session: &Session,
    found: Result<&Detection, &Miss>,
) -> Option<Picture> {
    let views = session.views().iter();
    let kept: Vec<_> = views
        .flat_map(|view| view.rings.iter().map(|ring| ring.centre.point))
        .collect();
    let picture = report::overlay(frame, session.board(), found, &kept, Scale::FULL);
    Some(Picture::Colour(picture))
}

impl Picture {
    /// The picture as JPEG, 8 bit, in its own size.
    ///
    /// # Errors
    /// What the encoder says, e.g. for a picture of more than 65,535 px.
    pub fn compressed(
        &self,
        header: Header,
        quality: Quality,
    ) -> Result<CompressedImage, EncodeError> {
        // as image_transport writes it: the encoding, and what lies in the JPEG
        let (format, data) = match self {
            Self::Grey(frame) => (
                "mono8; jpeg compressed mono8",
                report::grey_jpeg(frame, quality)?,
            ),
            Self::Colour(picture) => (
                "rgb8; jpeg compressed bgr8",
                report::jpeg(picture, quality)?,
            ),
        };
        Ok(CompressedImage {
            header,
            format: format.to_owned(),
            data,
        })
    }

    /// The picture's bytes, made smaller by `scale` (at most 1); `None` for a frame too large for a picture.
    pub fn raw(&self, header: Header, scale: f64) -> Option<Image> {
        let (size, encoding, pixel_bytes, data) = match self {
            Self::Colour(picture) => {
                let picture = smaller::<Rgb<u8>>(picture.clone(), scale);
                (picture.dimensions(), "rgb8", 3, picture.into_raw())
            }
            Self::Grey(frame) => {
                let width = u32::try_from(frame.width()).ok()?;
                let height = u32::try_from(frame.height()).ok()?;
                match &frame.pixels {
                    Pixels::U8(plane) => {
                        let data = plane.data().to_vec();
                        let picture = GrayImage::from_raw(width, height, data)?;
                        let picture = smaller::<Luma<u8>>(picture, scale);
                        (picture.dimensions(), "mono8", 1, picture.into_raw())
                    }
                    Pixels::U16(plane) => {
                        let data = plane.data().to_vec();
                        let picture = ImageBuffer::from_raw(width, height, data)?;
                        let picture = smaller::<Luma<u16>>(picture, scale);
                        let bytes = picture.as_raw().iter().flat_map(|v| v.to_le_bytes());
                        (picture.dimensions(), "mono16", 2, bytes.collect())
                    }
                }
            }
        };
        Some(Image {
            header,
            height: size.1,
            width: size.0,
            encoding: encoding.to_owned(),
            is_bigendian: 0,
            step: size.0 * pixel_bytes,
            data,
        })
    }
}

/// A picture made smaller; the same where `scale` is 1.
fn smaller<P>(
    picture: ImageBuffer<P, Vec<P::Subpixel>>,
    scale: f64,
) -> ImageBuffer<P, Vec<P::Subpixel>>
where
    P: image::Pixel + Send + Sync + 'static,
    P::Subpixel: Send + Sync + 'static,
{
    let side = |side: u32| ((f64::from(side) * scale).round() as u32).max(1);
    let (width, height) = (side(picture.width()), side(picture.height()));
    if (width, height) == picture.dimensions() {
        return picture;
    }
    imageops::resize(&picture, width, height, FilterType::Triangle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Plane;

    #[test]
    fn raw_pictures_describe_their_bytes() {
        let plane = Plane::from_vec(4, 2, (0..8).map(|i| i * 1000).collect()).unwrap();
        let image = Picture::Grey(Frame::from_u16(plane, ""))
            .raw(Header::default(), 1.0)
            .unwrap();
        assert_eq!((image.width, image.height, image.step), (4, 2, 8));
        assert_eq!(image.encoding, "mono16");
        assert_eq!(image.data[2..4], 1000_u16.to_le_bytes());
        let colour = Picture::Colour(RgbImage::new(100, 51));
        let image = colour.raw(Header::default(), 0.5).unwrap();
        assert_eq!((image.width, image.height, image.step), (50, 26, 150));
        assert_eq!(image.encoding, "rgb8");
        assert_eq!(image.data.len(), 150 * 26);
        let dot = colour.raw(Header::default(), 0.001).unwrap();
        assert_eq!(dot.data.len(), 3);
    }

    #[test]
    fn compressed_pictures_decode_to_what_they_were() {
        let quality = Quality::new(90).unwrap();
        let grey = Picture::Grey(Frame::from_u8(Plane::filled(64, 48, 77), ""));
        let message = grey.compressed(Header::default(), quality).unwrap();
        assert_eq!(message.format, "mono8; jpeg compressed mono8");
        let back = image::load_from_memory(&message.data).unwrap().to_luma8();
        assert_eq!(back.dimensions(), (64, 48));
        let red = RgbImage::from_pixel(32, 32, Rgb([200, 10, 10]));
        let message = Picture::Colour(red)
            .compressed(Header::default(), quality)
            .unwrap();
        let back = image::load_from_memory(&message.data).unwrap().to_rgb8();
        assert!(back.get_pixel(16, 16).0[0] > 180 && back.get_pixel(16, 16).0[2] < 40);
    }
}
