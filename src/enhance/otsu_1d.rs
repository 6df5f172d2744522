//! One-dimensional Otsu: the threshold with the largest scatter between two classes of grey values.

/// The largest value of the dark class: counts are `histogram[value]`; `None` where fewer than two values occur.
///
/// Of thresholds that score the same the smallest is taken, so the threshold itself always occurs.
pub fn otsu_1d(histogram: &[u32]) -> Option<usize> {
    let weighted = |(value, &count): (usize, &u32)| value as f64 * f64::from(count);
    let total: u64 = histogram.iter().map(|&count| u64::from(count)).sum();
    let total_sum: f64 = histogram.iter().enumerate().map(weighted).sum();
    let (mut count, mut sum) = (0_u64, 0.0);
    let mut best: Option<(f64, usize)> = None;
    for (value, &here) in histogram.iter().enumerate() {
        if here == 0 {
            continue;
        }
        count += u64::from(here);
        sum += weighted((value, &here));
        if count == total {
            break;
        }
        let (dark, light) = (count as f64, (total - count) as f64);
        let between = (total_sum - sum) / light - sum / dark;
        let score = dark * light * between * between;
        if best.is_none_or(|(top, _)| score > top) {
            best = Some((score, value));
        }
    }
    best.map(|(_, value)| value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_where_the_scatter_is_largest() {
        // values 0, 1, 5, 6 once each: after 0: 1 * 3 * (4 - 0)^2 = 48; after 1: 2 * 2 * (5.5 - 0.5)^2 = 100;
        // after 5: 3 * 1 * (6 - 2)^2 = 48
        assert_eq!(otsu_1d(&[1, 1, 0, 0, 0, 1, 1]), Some(1));
        // values 0 (4 times), 3, 4: after 0: 4 * 2 * 3.5^2 = 98; after 3: 5 * 1 * (4 - 0.6)^2 = 57.8
        assert_eq!(otsu_1d(&[4, 0, 0, 1, 1]), Some(0));
    }

    #[test]
    fn a_tie_goes_to_the_smaller_value() {
        // 0, 2, 4 once each: 1 * 2 * 3^2 after 0 and after 2
        assert_eq!(otsu_1d(&[1, 0, 1, 0, 1]), Some(0));
    }

    #[test]
    fn one_value_cannot_be_parted() {
        assert_eq!(otsu_1d(&[0, 7, 0]), None);
        assert_eq!(otsu_1d(&[0, 0]), None);
        assert_eq!(otsu_1d(&[]), None);
    }
}
