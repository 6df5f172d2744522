//! Whether a frame's light is to blame that no board was found.

use super::detection::Miss;
use crate::frame::{Frame, Pixels};

/// Every how many pixels, each way, the grey values are sampled.
const SAMPLING: usize = 5;
/// Fractions of the pixels that are darker than what counts as the darkest and the brightest.
const PERCENTILES: (f64, f64) = (0.02, 0.98);
/// A frame whose brightest grey is below this fraction of full scale is dark.
const DARK: f64 = 0.06;
/// The same in grey steps: 16-bit frames may use a hundredth of their range and be as good as others.
const DARK_STEPS: u16 = 40;
/// Fraction of pixels at the end of the scale from which the frame is over-exposed.
const CLIPPED: f64 = 0.5;
/// The same from which light print or paper is clipped somewhere.
const CLIPPED_SOMEWHERE: f64 = 0.005;
/// Less than so many grey steps between the darkest and the brightest are no picture.
const LEAST_STEPS: u16 = 8;

/// Says so where the frame is too dark, over-exposed or without contrast.
pub(super) fn bad_light(frame: &Frame) -> Option<Miss> {
    let (mut greys, full) = match &frame.pixels {
        Pixels::U8(plane) => (sampled(plane.height(), |y| plane.row(y)), 255),
        Pixels::U16(plane) => (sampled(plane.height(), |y| plane.row(y)), u16::MAX),
    };
    if greys.is_empty() {
        return None;
    }
    let last = (greys.len() - 1) as f64;
    let mut at = |fraction: f64| *greys.select_nth_unstable((last * fraction) as usize).1;
    let (darkest, brightest) = (at(PERCENTILES.0), at(PERCENTILES.1));
    let clipped = greys.iter().filter(|&&grey| grey == full).count() as f64 / greys.len() as f64;
    if brightest < DARK_STEPS && f64::from(brightest) < DARK * f64::from(full) {
        return Some(Miss::TooDark { brightest, full });
    }
    if clipped > CLIPPED {
        let percent = (100.0 * clipped).round() as u8;
        return Some(Miss::OverExposed { percent });
    }
    (brightest - darkest < LEAST_STEPS).then_some(Miss::NoContrast { darkest, brightest })
}

/// Whether the lightest places of a frame are as white as it can say.
pub(super) fn is_clipped(frame: &Frame) -> bool {
    let (greys, full) = match &frame.pixels {
        Pixels::U8(plane) => (sampled(plane.height(), |y| plane.row(y)), 255),
        Pixels::U16(plane) => (sampled(plane.height(), |y| plane.row(y)), u16::MAX),
    };
    let clipped = greys.iter().filter(|&&grey| grey == full).count();
    clipped as f64 > CLIPPED_SOMEWHERE * greys.len() as f64
}

fn sampled<'a, T: Copy + Into<u16> + 'a>(
    height: usize,
    row: impl Fn(usize) -> &'a [T],
) -> Vec<u16> {
    (0..height)
        .step_by(SAMPLING)
        .flat_map(|y| row(y).iter().step_by(SAMPLING).map(|&grey| grey.into()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Plane;

    #[test]
    fn a_frame_with_a_white_patch_is_clipped_and_one_with_a_white_spot_is_not() {
        let frame = |side: usize, white: u8| {
            let grey = |i: usize| {
                if i % 200 < side && i / 200 < side {
                    white
                } else {
                    90
                }
            };
            let data = (0..200 * 100).map(grey).collect();
            Frame::from_u8(Plane::from_vec(200, 100, data).unwrap(), "drawn")
        };
        assert!(is_clipped(&frame(30, 255)));
        assert!(!is_clipped(&frame(30, 254)));
        assert!(!is_clipped(&frame(5, 255)));
    }
}
