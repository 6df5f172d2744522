//! A small grey picture of a frame: what is kept of its pixels for the report.

use super::encode::{Quality, grey_jpeg};
use super::escape::base64;
use super::visible::visible;
use crate::frame::{Frame, Plane, Thumbnail};
use std::collections::BTreeMap;

/// Pixels along the longer side, at most; with [`QUALITY`] a picture takes 5 to 15 kB.
const LONGEST: usize = 320;
const QUALITY: u8 = 70;

/// A small JPEG of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    jpeg: Vec<u8>,
    /// What it shows, px of the frame, from the upper left corner on.
    shows_px: (f64, f64),
    /// Size of the frame, px.
    frame_px: (f64, f64),
}

/// Pictures of frames by their source.
pub type Pictures = BTreeMap<String, Picture>;

impl Picture {
    /// The grey values that a picture is made of: all that has to be kept of a frame until it is clear whether it is shown.
    pub fn reduce(frame: &Frame) -> Thumbnail {
        Thumbnail::with_longest(frame, LONGEST)
    }

    /// Of a frame that was reduced, stretched to be visible; `None` for one without pixels.
    pub fn of(small: &Thumbnail) -> Option<Self> {
        let (frame_px, (columns, rows)) = (small.frame_px(), small.grid());
        if frame_px.0 == 0 || frame_px.1 == 0 {
            return None;
        }
        // 16 bits keep what there is of a dark frame
        let deep = small.cells().iter();
        let deep = deep.map(|grey| (grey * 257.0).round() as u16).collect();
        let deep = Frame::from_u16(Plane::from_vec(columns, rows, deep)?, "");
        let grey = Plane::from_vec(columns, rows, visible(&deep).into_raw())?;
        let jpeg = grey_jpeg(&Frame::from_u8(grey, ""), Quality::new(QUALITY)?).ok()?;
        let side = small.cell_px();
        Some(Self {
            jpeg,
            shows_px: ((columns * side) as f64, (rows * side) as f64),
            frame_px: (frame_px.0 as f64, frame_px.1 as f64),
        })
    }

    /// What it shows, px of the frame.
    pub(super) fn shows_px(&self) -> (f64, f64) {
        self.shows_px
    }

    /// Size of the frame, px.
    pub(super) fn frame_px(&self) -> (f64, f64) {
        self.frame_px
    }

    /// For an image element.
    pub(super) fn data_uri(&self) -> String {
        format!("data:image/jpeg;base64,{}", base64(&self.jpeg))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Stamp;

    #[test]
    fn it_is_small_keeps_its_place_in_the_frame_and_shows_a_dark_one() {
        let dark = (0..1000 * 750_u32)
            .map(|at| (at % 1000 / 10) as u16)
            .collect();
        let frame = Frame::from_u16(Plane::from_vec(1000, 750, dark).unwrap(), "");
        let picture = Picture::of(&Picture::reduce(&frame)).unwrap();
        assert!(picture.jpeg.len() < 20_000, "{}", picture.jpeg.len());
        assert_eq!(
            (picture.shows_px, picture.frame_px),
            ((1000.0, 748.0), (1000.0, 750.0))
        );
        let back = Frame::decode(&picture.jpeg, Stamp::default(), "").unwrap();
        assert_eq!((back.width(), back.height()), (250, 187));
        let crate::frame::Pixels::U8(plane) = &back.pixels else {
            panic!("JPEG is 8 bit");
        };
        assert!(plane.at(2, 90) < 20 && plane.at(247, 90) > 235);
        assert!(
            picture
                .data_uri()
                .starts_with("data:image/jpeg;base64,/9j/")
        );
    }

    #[test]
    fn a_frame_without_pixels_has_none() {
        let empty = Frame::from_u8(Plane::filled(0, 0, 0), "");
        assert_eq!(Picture::of(&Picture::reduce(&empty)), None);
    }
}
