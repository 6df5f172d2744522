//! A frame as 8-bit grey that people can see, however little of its range it uses.

use crate::frame::{Frame, Pixel, Pixels, Plane};
use image::GrayImage;

/// Share of the pixels that may become black, and as many white.
const CLIPPED: f64 = 0.005;

/// A picture is not stretched further than this many of its grey values to the whole range: noise stays noise.
const NARROWEST: usize = 16;

/// The frame with its grey values stretched to 0..255: all but the darkest and the brightest half percent keep their
/// order. The answer to "what is there", not to "how bright is it".
pub fn visible(frame: &Frame) -> GrayImage {
    match &frame.pixels {
        Pixels::U8(plane) => stretched(plane, 256, usize::from),
        Pixels::U16(plane) => stretched(plane, 65_536, usize::from),
    }
}

fn stretched<T: Pixel>(plane: &Plane<T>, values: usize, index: impl Fn(T) -> usize) -> GrayImage {
    let mut counts = vec![0_usize; values];
    for &value in plane.data() {
        counts[index(value)] += 1;
    }
    let (low, high) = range(&counts, plane.data().len());
    let table: Vec<u8> = (0..values)
        .map(|v| {
            let part = (v as f64 - low) / (high - low);
            (255.0 * part).round() as u8 // `as` saturates
        })
        .collect();
    let grey = plane.data().iter().map(|&value| table[index(value)]);
    let (width, height) = (plane.width() as u32, plane.height() as u32);
    // the sizes agree: one grey value for each of the plane's pixels
    GrayImage::from_raw(width, height, grey.collect()).unwrap_or_default()
}

/// The grey values that become black and white.
fn range(counts: &[usize], pixels: usize) -> (f64, f64) {
    let clipped = (pixels as f64 * CLIPPED) as usize;
    let first_above = |mut counts: Box<dyn Iterator<Item = &usize> + '_>| {
        let mut seen = 0;
        counts.position(|&count| {
            seen += count;
            seen > clipped
        })
    };
    let low = first_above(Box::new(counts.iter())).unwrap_or(0);
    let high = first_above(Box::new(counts.iter().rev())).map_or(low, |k| counts.len() - 1 - k);
    let missing = NARROWEST.saturating_sub(high - low) as f64;
    (low as f64 - 0.5 * missing, high as f64 + 0.5 * missing)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_narrow_range_fills_the_picture_s() {
        // 12 bits' worth of 16, the lowest tenth of it
        let data: Vec<u16> = (0..400).collect();
        let picture = visible(&Frame::from_u16(Plane::from_vec(40, 10, data).unwrap(), ""));
        // two of 400 pixels may be clipped at each end
        let grey = |x: u32, y: u32| picture.get_pixel(x, y).0[0];
        assert_eq!((grey(0, 0), grey(2, 0)), (0, 0));
        assert_eq!((grey(37, 9), grey(39, 9)), (255, 255));
        assert!(grey(3, 0) > 0 && (i32::from(grey(0, 5)) - 128).abs() <= 1);
    }

    #[test]
    fn noise_and_flat_pictures_stay_grey() {
        let flat = visible(&Frame::from_u8(Plane::filled(5, 5, 0), ""));
        assert!(flat.pixels().all(|p| p.0[0] == 128));
        let noise = (0..100).map(|k| 100 + k % 2).collect();
        let noise = visible(&Frame::from_u8(Plane::from_vec(10, 10, noise).unwrap(), ""));
        assert!(noise.pixels().all(|p| (110..146).contains(&p.0[0])));
        assert_eq!(
            visible(&Frame::from_u8(Plane::filled(0, 0, 0), "")).width(),
            0
        );
    }
}
