//! Two-dimensional Otsu: the pair of thresholds with the largest scatter between the classes (equations 13 to 19).
//!
//! As printed, (14) and (15) lack the division by the class weights, without which the maximum of (18) lies in the wrong
//! place; here the class means are means. The sums over rectangles come from cumulative tables, so that all L^2 pairs
//! cost O(L^2). The tables are integers: pairs that divide the pixels in the same way score exactly the same.

use super::JointHistogram;

/// Thresholds on levels: the dark class is `i <= s` and `j <= t`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LevelThresholds {
    /// Largest grey level of the dark class.
    pub s: usize,
    /// Largest mean level of the dark class.
    pub t: usize,
}

/// Pixels of a rectangle of the histogram and the sums of their levels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Moments {
    count: i64,
    grey: i64,
    mean: i64,
}

impl Moments {
    fn plus(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            grey: self.grey + other.grey,
            mean: self.mean + other.mean,
        }
    }

    fn minus(self, other: Self) -> Self {
        Self {
            count: self.count - other.count,
            grey: self.grey - other.grey,
            mean: self.mean - other.mean,
        }
    }

    /// One term of (18) times the number of pixels: weight times squared distance of the class's mean vector from
    /// `centre`.
    fn scatter(self, centre: [f64; 2]) -> f64 {
        let count = self.count as f64;
        let grey = self.grey as f64 / count - centre[0];
        let mean = self.mean as f64 / count - centre[1];
        count * (grey * grey + mean * mean)
    }
}

/// The thresholds (s', t') of (19); `None` where no pair leaves pixels in both classes.
///
/// Of pairs that score the same the one with the smallest |s - t| is taken, of those the one with the smallest `s`.
pub fn otsu_2d(histogram: &JointHistogram) -> Option<LevelThresholds> {
    let levels = histogram.levels();
    let last = levels.checked_sub(1)?;
    let low = cumulative(histogram);
    let total = low[levels * levels - 1];
    if total.count == 0 {
        return None;
    }
    let centre = [
        total.grey as f64 / total.count as f64,
        total.mean as f64 / total.count as f64,
    ];
    let mut best: Option<(f64, LevelThresholds)> = None;
    for s in 0..last {
        for t in 0..last {
            let dark = low[s * levels + t];
            // everything, less i <= s, less j <= t, plus what was taken twice
            let light = total
                .minus(low[s * levels + last])
                .minus(low[last * levels + t])
                .plus(dark);
            if dark.count == 0 || light.count == 0 {
                continue;
            }
            let score = dark.scatter(centre) + light.scatter(centre);
            let better = best.is_none_or(|(top, at)| {
                score > top || (score == top && s.abs_diff(t) < at.s.abs_diff(at.t))
            });
            if better {
                best = Some((score, LevelThresholds { s, t }));
            }
        }
    }
    best.map(|(_, thresholds)| thresholds)
}

/// Moments of every rectangle from (0, 0) to (i, j), ends included.
fn cumulative(histogram: &JointHistogram) -> Vec<Moments> {
    let levels = histogram.levels();
    let mut table = vec![Moments::default(); levels * levels];
    for i in 0..levels {
        let mut row = Moments::default();
        for (j, &count) in histogram.row(i).iter().enumerate() {
            let count = i64::from(count);
            row = row.plus(Moments {
                count,
                grey: count * i as i64,
                mean: count * j as i64,
            });
            let above = if i == 0 {
                Moments::default()
            } else {
                table[(i - 1) * levels + j]
            };
            table[i * levels + j] = above.plus(row);
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn histogram(levels: usize, pairs: &[(usize, usize, u32)]) -> JointHistogram {
        let mut counts = vec![0; levels * levels];
        for &(i, j, count) in pairs {
            counts[i * levels + j] += count;
        }
        JointHistogram::from_counts(levels, counts).unwrap()
    }

    /// Equation (18) by summing every class for every pair: O(L^4).
    fn score(histogram: &JointHistogram, s: usize, t: usize) -> Option<f64> {
        let levels = histogram.levels();
        let class = |keep: &dyn Fn(usize, usize) -> bool| {
            let mut sums = [0.0; 3];
            for i in 0..levels {
                for (j, &count) in histogram.row(i).iter().enumerate() {
                    if keep(i, j) {
                        let count = f64::from(count);
                        sums[0] += count;
                        sums[1] += count * i as f64;
                        sums[2] += count * j as f64;
                    }
                }
            }
            sums
        };
        let all = class(&|_, _| true);
        let terms = [
            class(&|i, j| i <= s && j <= t),
            class(&|i, j| i > s && j > t),
        ];
        let mut total = 0.0;
        for [count, grey, mean] in terms {
            if count == 0.0 {
                return None;
            }
            let d = [
                grey / count - all[1] / all[0],
                mean / count - all[2] / all[0],
            ];
            total += count / all[0] * (d[0] * d[0] + d[1] * d[1]);
        }
        Some(total)
    }

    #[test]
    fn two_clusters_are_parted_and_the_tie_goes_to_the_diagonal() {
        // 3 pixels at (1, 1) and 5 at (5, 6) of 8 levels: every s in 1..5 with t in 1..6 parts them; s = t = 1 is the
        // first on the diagonal
        let found = otsu_2d(&histogram(8, &[(1, 1, 3), (5, 6, 5)]));
        assert_eq!(found, Some(LevelThresholds { s: 1, t: 1 }));
        // at (1, 4) and (2, 6): s must be 1, t 4 or 5, and 4 is nearer to the diagonal
        let found = otsu_2d(&histogram(8, &[(1, 4, 3), (2, 6, 5)]));
        assert_eq!(found, Some(LevelThresholds { s: 1, t: 4 }));
    }

    #[test]
    fn pixels_in_the_middle_of_an_edge_belong_to_neither_class() {
        // 8 levels, 10 pixels each at levels 1 and 6 and one each at 3 and 4: the mean is 3.5. s = t = 3 scores
        // 11 (13 / 11 - 3.5)^2 + 11 (64 / 11 - 3.5)^2 = 118.2 on each axis; leaving both out (s = 2, t = 4 or the
        // reverse) scores 10 * 2.5^2 * 2 = 125. s = 1 is as good as s = 2 with t = 4, 5, but farther from the diagonal.
        let edge = histogram(8, &[(1, 1, 10), (3, 3, 1), (4, 4, 1), (6, 6, 10)]);
        assert_eq!(otsu_2d(&edge), Some(LevelThresholds { s: 2, t: 4 }));
        let both = score(&edge, 2, 4).unwrap();
        assert!((both - 2.0 * 125.0 / 22.0).abs() < 1e-12);
        assert!(score(&edge, 3, 3).unwrap() < both);
    }

    #[test]
    fn one_level_and_no_pixels_have_no_threshold() {
        assert_eq!(otsu_2d(&histogram(8, &[(3, 3, 9)])), None);
        assert_eq!(otsu_2d(&histogram(8, &[])), None);
        assert_eq!(
            otsu_2d(&JointHistogram::from_counts(0, vec![]).unwrap()),
            None
        );
        // two pixels that no pair can part: one is darker, the other has the darker neighbours
        assert_eq!(otsu_2d(&histogram(8, &[(2, 5, 1), (5, 2, 1)])), None);
    }

    proptest! {
        #[test]
        fn agrees_with_the_sum_over_every_class_for_every_pair(
            counts in proptest::collection::vec(prop_oneof![Just(0_u32), 0_u32..50], 49),
        ) {
            let histogram = JointHistogram::from_counts(7, counts).unwrap();
            let scores = (0..7).flat_map(|s| (0..7).map(move |t| (s, t)));
            let best = scores.filter_map(|(s, t)| score(&histogram, s, t)).reduce(f64::max);
            let found = otsu_2d(&histogram);
            prop_assert_eq!(found.is_some(), best.is_some());
            if let (Some(found), Some(best)) = (found, best) {
                let score = score(&histogram, found.s, found.t).unwrap();
                prop_assert!((score - best).abs() <= 1e-9 * best);
            }
        }
    }
}
