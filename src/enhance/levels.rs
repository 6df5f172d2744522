//! Grey values to the 256 levels of the joint histogram and back.

use crate::frame::{Pixel, Plane};

/// Levels of the joint histogram (the paper's L).
pub(super) const LEVELS: usize = 256;

/// An integer grey value.
pub(super) trait Grey: Pixel + Ord + Into<u16> + Into<u32> {
    /// How many grey values there are.
    const VALUES: usize;

    /// The grey value nearest to `value` among those there are.
    fn nearest(value: f64) -> Self;

    /// The grey value as an index.
    fn index(self) -> usize {
        usize::from(Into::<u16>::into(self))
    }

    /// The mean of nine grey values from their sum, rounded.
    fn mean_of_nine(sum: u32) -> Self;

    /// The smallest and largest value between which the levels are laid.
    fn level_range(plane: &Plane<Self>) -> (u32, u32);
}

impl Grey for u8 {
    const VALUES: usize = 256;

    fn nearest(value: f64) -> Self {
        value.round() as Self // `as` saturates
    }

    fn mean_of_nine(sum: u32) -> Self {
        ((sum + 4) / 9) as Self // nine times 255 at most
    }

    /// All 256 values, each its own level.
    fn level_range(_: &Plane<Self>) -> (u32, u32) {
        (0, 255)
    }
}

impl Grey for u16 {
    const VALUES: usize = 65_536;

    fn nearest(value: f64) -> Self {
        value.round() as Self // `as` saturates
    }

    fn mean_of_nine(sum: u32) -> Self {
        ((sum + 4) / 9) as Self // nine times 65535 at most
    }

    /// What the picture uses: many 16-bit pictures hold 10 or 12 bits.
    fn level_range(plane: &Plane<Self>) -> (u32, u32) {
        let (low, high) = plane
            .data()
            .iter()
            .fold((Self::MAX, 0), |(low, high), &v| (low.min(v), high.max(v)));
        (u32::from(low.min(high)), u32::from(high))
    }
}

/// 256 equal classes of grey values between the ends of a picture's range.
pub(super) struct Levels<T> {
    /// Level of every grey value; those outside the range take the end levels.
    table: Vec<u8>,
    /// Largest grey value of every level, or of the nearest level below that has one.
    largest: Vec<T>,
}

impl<T: Grey> Levels<T> {
    /// The levels of one picture.
    pub fn of(plane: &Plane<T>) -> Self {
        let (low, high) = T::level_range(plane);
        let values = u64::from(high - low) + 1;
        let table = (0..T::VALUES as u64)
            .map(|v| {
                let above = v.clamp(low.into(), high.into()) - u64::from(low);
                (above * LEVELS as u64 / values) as u8
            })
            .collect();
        // level(v) <= k exactly where (v - low) * 256 < (k + 1) * values
        let largest = (1..=LEVELS as u64)
            .map(|next| T::nearest((u64::from(low) + (next * values - 1) / LEVELS as u64) as f64))
            .collect();
        Self { table, largest }
    }

    /// The level of a grey value.
    pub fn of_value(&self, value: T) -> usize {
        usize::from(self.table[value.index()])
    }

    /// The largest grey value whose level is at most `level`.
    pub fn largest_in(&self, level: usize) -> T {
        self.largest[level.min(LEVELS - 1)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn eight_bit_values_are_their_own_levels() {
        let levels = Levels::of(&Plane::filled(2, 1, 90_u8));
        for v in 0..=255_u8 {
            assert_eq!(levels.of_value(v), usize::from(v));
            assert_eq!(levels.largest_in(usize::from(v)), v);
        }
    }

    #[test]
    fn sixteen_bit_values_are_stretched_to_256_levels() {
        // 1024 values from 5000 on: four to a level
        let plane = Plane::from_vec(3, 1, vec![5000_u16, 6023, 5512]).unwrap();
        let levels = Levels::of(&plane);
        assert_eq!(levels.of_value(5003), 0);
        assert_eq!(levels.of_value(5004), 1);
        assert_eq!(levels.of_value(6023), 255);
        assert_eq!(levels.largest_in(0), 5003);
        assert_eq!(levels.largest_in(255), 6023);
    }

    proptest! {
        #[test]
        fn a_threshold_on_levels_is_the_same_threshold_on_values(
            a: u16, b: u16, v: u16, level in 0..LEVELS,
        ) {
            let plane = Plane::from_vec(2, 1, vec![a, b]).unwrap();
            let levels = Levels::of(&plane);
            let v = v.clamp(a.min(b), a.max(b));
            prop_assert_eq!(levels.of_value(v) <= level, v <= levels.largest_in(level));
        }
    }
}
