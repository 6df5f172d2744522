//! Steps 3 and 4: the regions B and D are split at th, their noise takes its median, their edges the target's range.

use super::levels::Grey;
use super::neighbourhood;
use super::regions::Thresholds;
use super::{Round, Sigmoid, Target, otsu_1d};
use crate::frame::Plane;

/// What every grey value becomes in B and D.
pub(super) struct Table<T> {
    new_value: Vec<T>,
    round: Round,
}

impl<T: Grey> Table<T> {
    /// From how often each grey value occurs in B and D; `None` where fewer than two do, so that th does not exist.
    ///
    /// The side of th that is the target's is the edge region A': its range (v3, v4) is mapped onto `range` = (v1, v2).
    /// The other side is the noise region C': it becomes its median, the lower one of an even count.
    pub fn new(histogram: &[u32], target: Target, range: (T, T)) -> Option<Self> {
        let th = otsu_1d(histogram)?;
        let (dark, light) = (0..th + 1, th + 1..histogram.len());
        let (edge, noise) = match target {
            Target::Dark => (dark, light),
            Target::Light => (light, dark),
        };
        let occurs = |value: &usize| histogram[*value] > 0;
        let (v3, v4) = (edge.clone().find(occurs)?, edge.clone().rev().find(occurs)?);
        let median = noise.start + median(&histogram[noise])?;
        let (v1, v2) = (range.0.index() as f64, range.1.index() as f64);
        let sigmoid = Sigmoid::new((v3 as f64, v4 as f64), (v1, v2));
        let mut new_value = vec![T::nearest(median as f64); histogram.len()];
        for value in edge {
            new_value[value] = T::nearest(sigmoid.map(value as f64));
        }
        // grey values are at most 65535
        let [th, v3, v4, median] = [th, v3, v4, median].map(|v| v as u16);
        Some(Self {
            new_value,
            round: Round { th, v3, v4, median },
        })
    }

    /// The values chosen.
    pub fn round(&self) -> Round {
        self.round
    }
}

/// The index at which half of the counts is reached; `None` where there are none.
fn median(counts: &[u32]) -> Option<usize> {
    let total: u64 = counts.iter().map(|&count| u64::from(count)).sum();
    let half = total.div_ceil(2);
    let mut seen = 0;
    counts.iter().position(|&count| {
        seen += u64::from(count);
        count > 0 && seen >= half
    })
}

/// The picture with B and D replaced by the table's values; A and C are kept.
pub(super) fn apply<T: Grey>(
    plane: &Plane<T>,
    thresholds: Thresholds<T>,
    table: &Table<T>,
) -> Plane<T> {
    neighbourhood::map(plane, |value, mean| {
        if thresholds.off_diagonal(value, mean) {
            table.new_value[value.index()]
        } else {
            value
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values 40, 50 (twice), 60 on the dark side, 200, 210, 220 (twice) on the light side; th = 60.
    fn counts() -> Vec<u32> {
        let mut counts = vec![0; 256];
        for value in [40, 50, 50, 60, 200, 210, 220, 220] {
            counts[value] += 1;
        }
        counts
    }

    #[test]
    fn dark_target_spreads_the_dark_side_and_flattens_the_light_one() {
        let table = Table::new(&counts(), Target::Dark, (10_u8, 30)).unwrap();
        let expected = Round {
            th: 60,
            v3: 40,
            v4: 60,
            median: 210,
        };
        assert_eq!(table.round(), expected);
        assert_eq!(
            [40, 50, 60, 200, 220].map(|v| table.new_value[v]),
            [10, 20, 30, 210, 210]
        );
    }

    #[test]
    fn light_target_does_the_reverse() {
        let table = Table::new(&counts(), Target::Light, (230_u8, 250)).unwrap();
        let expected = Round {
            th: 60,
            v3: 200,
            v4: 220,
            median: 50,
        };
        assert_eq!(table.round(), expected);
        assert_eq!(
            [40, 60, 200, 210, 220].map(|v| table.new_value[v]),
            [50, 50, 230, 240, 250]
        );
    }

    #[test]
    fn the_median_of_an_even_count_is_the_lower_one() {
        assert_eq!(median(&[0, 1, 0, 1]), Some(1));
        assert_eq!(median(&[1, 1, 1]), Some(1));
        assert_eq!(median(&[0, 0]), None);
    }

    #[test]
    fn one_value_off_the_diagonal_gives_no_table() {
        let mut counts = vec![0; 256];
        counts[7] = 12;
        assert!(Table::new(&counts, Target::Dark, (0_u8, 5)).is_none());
    }
}
