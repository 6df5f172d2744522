//! The sigmoid that maps the grey values of the edge region onto those of the target (paper equations 20 and 21).

/// Half the range is this many units of the logistic function: beyond it the curve is flat to 0.25 %.
const STEEPNESS: f64 = 6.0;

/// Maps (v3, v4) onto (v1, v2), ends onto ends, along an S.
///
/// (21) gives no scale. Here S(z) = 1 / (1 + exp(-z)), m = (v3 + v4) / 2, h = (v4 - v3) / 2, a h = 6 and
/// v = v1 + (v2 - v1) (S(a (x - m)) - S(-a h)) / (S(a h) - S(-a h)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sigmoid {
    from: (f64, f64),
    to: (f64, f64),
}

impl Sigmoid {
    /// The map of `from` = (v3, v4) onto `to` = (v1, v2), each smallest first.
    pub fn new(from: (f64, f64), to: (f64, f64)) -> Self {
        Self { from, to }
    }

    /// The mapped value; `x` outside (v3, v4) maps to the nearer end. Where v3 = v4 that value is the middle of its range
    /// and maps to the middle of (v1, v2).
    pub fn map(&self, x: f64) -> f64 {
        let ((v3, v4), (v1, v2)) = (self.from, self.to);
        let half = 0.5 * (v4 - v3);
        let place = if half > 0.0 {
            ((x - 0.5 * (v3 + v4)) / half).clamp(-1.0, 1.0)
        } else {
            0.0
        };
        let (low, high) = (logistic(-STEEPNESS), logistic(STEEPNESS));
        // the quotient first: it is exactly one at the upper end
        v1 + (v2 - v1) * ((logistic(STEEPNESS * place) - low) / (high - low))
    }
}

fn logistic(z: f64) -> f64 {
    1.0 / (1.0 + (-z).exp())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn ends_map_exactly_onto_ends_and_the_middle_onto_the_middle() {
        let s = Sigmoid::new((70.0, 119.0), (17.0, 70.0));
        assert_eq!(s.map(70.0), 17.0);
        assert_eq!(s.map(119.0), 70.0);
        assert!((s.map(94.5) - 43.5).abs() < 1e-12);
        assert_eq!((s.map(-5.0), s.map(1e9)), (17.0, 70.0));
    }

    #[test]
    fn follows_the_logistic_function() {
        // halfway up the upper half: S(3) = 0.952574, S(6) = 0.997527
        let s = Sigmoid::new((0.0, 4.0), (0.0, 1.0));
        let expected = (0.952_574_126_8 - 0.002_472_623_2) / (0.997_527_376_8 - 0.002_472_623_2);
        assert!((s.map(3.0) - expected).abs() < 1e-9);
    }

    #[test]
    fn a_range_of_one_value_maps_to_the_middle() {
        assert_eq!(Sigmoid::new((9.0, 9.0), (10.0, 20.0)).map(9.0), 15.0);
        assert_eq!(Sigmoid::new((1.0, 5.0), (8.0, 8.0)).map(2.0), 8.0);
    }

    proptest! {
        #[test]
        fn grows_and_stays_within_its_ends(
            v3 in 0_u16..60_000, span in 1_u16..5000, v1 in 0_u16..60_000, width in 0_u16..5000,
            a in 0.0_f64..1.0, b in 0.0_f64..1.0,
        ) {
            let (v3, v1) = (f64::from(v3), f64::from(v1));
            let (v4, v2) = (v3 + f64::from(span), v1 + f64::from(width));
            let s = Sigmoid::new((v3, v4), (v1, v2));
            let at = |part: f64| s.map(v3 + part * (v4 - v3));
            prop_assert!(at(a.min(b)) <= at(a.max(b)));
            prop_assert!(at(a) >= v1 && at(a) <= v2 + 1e-9 * v2);
            prop_assert_eq!(s.map(v3), v1);
            prop_assert_eq!(s.map(v4), v2);
        }
    }
}
