//! Which of many places are near one.

use nalgebra::Point2;

/// Places sorted by x, so that a search looks at a narrow strip and not at all of them.
pub(super) struct Nearby {
    by_x: Vec<(Point2<f64>, usize)>,
}

impl Nearby {
    /// Numbers the places in their order.
    pub(super) fn new(places: impl IntoIterator<Item = Point2<f64>>) -> Self {
        let mut by_x: Vec<(Point2<f64>, usize)> = places.into_iter().zip(0..).collect();
        by_x.sort_by(|a, b| a.0.x.total_cmp(&b.0.x));
        Self { by_x }
    }

    /// Number and distance (px) of every place less than `reach_px` from `at`, in no particular but always the same order.
    pub(super) fn within(
        &self,
        at: Point2<f64>,
        reach_px: f64,
    ) -> impl Iterator<Item = (usize, f64)> {
        let first = self.by_x.partition_point(|(p, _)| p.x <= at.x - reach_px);
        self.by_x[first..]
            .iter()
            .take_while(move |(p, _)| p.x < at.x + reach_px)
            .map(move |&(p, i)| (i, (p - at).norm()))
            .filter(move |&(_, distance)| distance < reach_px)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn finds_what_a_look_at_every_place_finds(
            places in prop::collection::vec((-9.0..9.0_f64, -9.0..9.0_f64), 0..60),
            (x, y, reach) in (-9.0..9.0_f64, -9.0..9.0_f64, 0.0..9.0_f64),
        ) {
            let places: Vec<Point2<f64>> = places.into_iter().map(|(x, y)| Point2::new(x, y)).collect();
            let at = Point2::new(x, y);
            let mut found: Vec<usize> = Nearby::new(places.iter().copied()).within(at, reach).map(|(i, _)| i).collect();
            found.sort_unstable();
            let expected: Vec<usize> = (0..places.len()).filter(|&i| (places[i] - at).norm() < reach).collect();
            prop_assert_eq!(found, expected);
        }
    }
}
