//! Colour to grey: the luma of ITU-R BT.601, rounded to the nearest integer.
//!
//! Y = 0.299 R + 0.587 G + 0.114 B. The weights are held as integers over 2^16 that sum to exactly 2^16, so that grey
//! stays grey (R = G = B = v gives v) and white stays full scale. Integer arithmetic makes the result the same on
//! every machine, and short enough for the compiler to vectorise.

const RED: u32 = 19_595;
const GREEN: u32 = 38_470;
const BLUE: u32 = 7_471;
const HALF: u32 = 1 << 15;

/// BT.601 luma of an 8-bit colour, rounded.
pub(crate) fn luma8(red: u8, green: u8, blue: u8) -> u8 {
    // at most 255: the weights sum to 2^16 and the half cannot carry over it
    weigh(u32::from(red), u32::from(green), u32::from(blue)) as u8
}

/// BT.601 luma of a 16-bit colour, rounded.
pub(crate) fn luma16(red: u16, green: u16, blue: u16) -> u16 {
    // at most 65535 for the same reason
    weigh(u32::from(red), u32::from(green), u32::from(blue)) as u16
}

/// 65535 * 2^16 + 2^15 still fits 32 bits, so no step of the sum can overflow.
fn weigh(red: u32, green: u32, blue: u32) -> u32 {
    (RED * red + GREEN * green + BLUE * blue + HALF) >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grey_stays_grey_over_the_whole_range() {
        assert!((0..=u8::MAX).all(|v| luma8(v, v, v) == v));
        assert!((0..=u16::MAX).all(|v| luma16(v, v, v) == v));
    }

    #[test]
    fn is_the_standard_s_luma_rounded() {
        for red in (0..=255_u8).step_by(5) {
            for green in (0..=255_u8).step_by(5) {
                for blue in (0..=255_u8).step_by(5) {
                    let exact =
                        0.299 * f64::from(red) + 0.587 * f64::from(green) + 0.114 * f64::from(blue);
                    let error = f64::from(luma8(red, green, blue)) - exact;
                    assert!(error.abs() < 0.505, "{red} {green} {blue}: {error}");
                }
            }
        }
        assert_eq!(
            (luma8(255, 0, 0), luma8(0, 255, 0), luma8(0, 0, 255)),
            (76, 150, 29)
        );
    }
}
