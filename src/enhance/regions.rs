//! The four regions of the joint histogram (paper figure 5, Step 2), as thresholds on grey values.
//!
//! Dark: grey value <= s and mean <= t. Light: both above. The two regions off the diagonal, where value and mean disagree,
//! are B and D. The target A is the dark or the light region, by the board's polarity; the paper's (13) and
//! its Step 2 disagree on which.

use super::Target;
use super::joint_histogram::add_counts;
use super::levels::Grey;
use super::neighbourhood;
use crate::frame::Plane;

/// Thresholds on grey values: each is the largest of the dark side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Thresholds<T> {
    /// On the pixel.
    pub s: T,
    /// On the mean of its neighbourhood.
    pub t: T,
}

impl<T: Grey> Thresholds<T> {
    /// Whether a pixel lies in B or D.
    pub fn off_diagonal(self, value: T, mean: T) -> bool {
        (value <= self.s) != (mean <= self.t)
    }

    /// Whether a pixel lies in the target region A.
    pub fn in_target(self, value: T, mean: T, target: Target) -> bool {
        match target {
            Target::Dark => value <= self.s && mean <= self.t,
            Target::Light => value > self.s && mean > self.t,
        }
    }
}

/// Smallest and largest grey value (v1, v2) of the target region A; `None` where it has no pixel.
pub(super) fn target_range<T: Grey>(
    plane: &Plane<T>,
    thresholds: Thresholds<T>,
    target: Target,
) -> Option<(T, T)> {
    neighbourhood::collect(
        plane,
        || None,
        |range: &mut Option<(T, T)>, row, means| {
            for (&value, &mean) in row.iter().zip(means) {
                if thresholds.in_target(value, mean, target) {
                    *range = widest(*range, Some((value, value)));
                }
            }
        },
        widest,
    )
}

fn widest<T: Grey>(a: Option<(T, T)>, b: Option<(T, T)>) -> Option<(T, T)> {
    match (a, b) {
        (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
        (one, other) => one.or(other),
    }
}

/// How often each grey value occurs in B and D together.
pub(super) fn edge_histogram<T: Grey>(plane: &Plane<T>, thresholds: Thresholds<T>) -> Vec<u32> {
    neighbourhood::collect(
        plane,
        || vec![0; T::VALUES],
        |counts: &mut Vec<u32>, row, means| {
            for (&value, &mean) in row.iter().zip(means) {
                if thresholds.off_diagonal(value, mean) {
                    counts[value.index()] += 1;
                }
            }
        },
        add_counts,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_regions_and_the_target_by_polarity() {
        let at = Thresholds { s: 100_u8, t: 110 };
        for (value, mean, off, dark, light) in [
            (100, 110, false, true, false),
            (101, 111, false, false, true),
            (100, 111, true, false, false),
            (101, 110, true, false, false),
        ] {
            assert_eq!(at.off_diagonal(value, mean), off);
            assert_eq!(at.in_target(value, mean, Target::Dark), dark);
            assert_eq!(at.in_target(value, mean, Target::Light), light);
        }
    }

    #[test]
    fn ranges_and_counts_of_a_small_picture() {
        // rows 10 20 90 90, means 13.3, 40, 66.7, 90: with s = 15, t = 50 the second pixel lies off the diagonal
        let plane = Plane::from_vec(4, 2, [10_u8, 20, 90, 90].repeat(2)).unwrap();
        let at = Thresholds { s: 15, t: 50 };
        assert_eq!(target_range(&plane, at, Target::Dark), Some((10, 10)));
        assert_eq!(target_range(&plane, at, Target::Light), Some((90, 90)));
        let counts = edge_histogram(&plane, at);
        assert_eq!((counts[20], counts.iter().sum::<u32>()), (2, 2));
        let nothing = Thresholds { s: 5, t: 5 };
        assert_eq!(target_range(&plane, nothing, Target::Dark), None);
    }
}
