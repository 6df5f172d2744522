//! The pixels of a band that stand out, row by row, as runs.

use super::margins::TILE;
use crate::frame::widest;

/// To which side pixels stand out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    /// Above the surroundings (inner discs of dark rings).
    Light,
    /// Below the surroundings (dark rings).
    Dark,
}

/// Pixels `begin..end` of one row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Run {
    pub(super) begin: u32,
    pub(super) end: u32,
}

/// The runs of rows from the first on.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Runs {
    all: Vec<Run>,
    /// Where those of each row end among all.
    ends: Vec<usize>,
}

impl Runs {
    /// The runs of each row, in the order of the row.
    pub(super) fn rows(&self) -> impl Iterator<Item = &[Run]> {
        let begins = std::iter::once(0).chain(self.ends.iter().copied());
        begins
            .zip(&self.ends)
            .map(|(begin, &end)| &self.all[begin..end])
    }

    /// Adds the rows of others.
    pub(super) fn extend(&mut self, other: Self) {
        let before = self.all.len();
        self.all.extend(other.all);
        self.ends.extend(other.ends.iter().map(|end| before + end));
    }

    /// Adds a row of pixels; `margins` are those of its tiles. Of each tile the pixels that stand out are the bits of a word, and only where
    /// bits change something is done.
    pub(super) fn add_row(&mut self, row: &[f32], margins: &[f32], side: Side) {
        let sign = match side {
            Side::Light => 1.0,
            Side::Dark => -1.0,
        };
        let mut words = Vec::with_capacity(margins.len());
        widest(
            #[inline(always)]
            || {
                let tiles = row.chunks(TILE).zip(margins);
                words.extend(tiles.map(|(tile, &margin)| word(tile, margin, sign)));
            },
        );
        let mut begin = None;
        for (first, &word) in (0..).step_by(TILE).zip(&words) {
            let before = u32::from(begin.is_some());
            let mut changes = word ^ (word << 1 | before);
            while changes != 0 {
                let x = first + changes.trailing_zeros();
                self.turn(x, &mut begin);
                changes &= changes - 1;
            }
        }
        if begin.is_some() {
            self.turn(row.len() as u32, &mut begin);
        }
        self.ends.push(self.all.len());
    }

    fn turn(&mut self, x: u32, begin: &mut Option<u32>) {
        match begin.take() {
            Some(begin) => self.all.push(Run { begin, end: x }),
            None => *begin = Some(x),
        }
    }
}

/// The pixels of a tile that stand out, the first one in the lowest bit.
#[inline(always)]
fn word(tile: &[f32], margin: f32, sign: f32) -> u32 {
    const { assert!(TILE == u32::BITS as usize) };
    let bit = |(i, &value): (usize, &f32)| u32::from(sign * value > margin) << i;
    match <&[f32; TILE]>::try_from(tile) {
        // of a known length it is a few vector instructions
        Ok(tile) => tile.iter().enumerate().map(bit).fold(0, |all, b| all | b),
        Err(_) => tile.iter().enumerate().map(bit).fold(0, |all, b| all | b),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn runs_are_the_pixels_that_stand_out(
            row in prop::collection::vec(prop::sample::select(vec![-2.0_f32, -0.5, 0.5, 2.0]), 0..150),
            one_of in 1..80_usize,
        ) {
            // long stretches of the same make whole tiles
            let row: Vec<f32> = (0..row.len()).map(|i| row[i / one_of * one_of]).collect();
            let margins = vec![1.0; row.len().div_ceil(TILE)];
            for side in [Side::Light, Side::Dark] {
                let mut runs = Runs::default();
                runs.add_row(&row, &margins, side);
                runs.add_row(&row, &margins, side);
                let rows: Vec<&[Run]> = runs.rows().collect();
                prop_assert_eq!(rows.len(), 2);
                prop_assert_eq!(rows[0], rows[1]);
                let mut inside = vec![false; row.len()];
                for run in rows[0] {
                    prop_assert!(run.begin < run.end);
                    inside[run.begin as usize..run.end as usize].fill(true);
                }
                let stands_out = |v: f32| if side == Side::Light { v > 1.0 } else { v < -1.0 };
                let expected: Vec<bool> = row.iter().map(|&v| stands_out(v)).collect();
                prop_assert_eq!(inside, expected);
                prop_assert!(rows[0].windows(2).all(|pair| pair[0].end < pair[1].begin));
            }
        }
    }
}
