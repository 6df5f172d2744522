//! A first solution for an ellipse where outliers in plenty draw that of all points to them.

use super::ellipse_fit::{NORMAL, robust_scale, sampson};
use crate::frame::widest;
use nalgebra::{Point2, SVector};

/// Subsets of five points that are tried: with a third of the points elsewhere, one in eight is good.
const SUBSETS: usize = 60;
/// A pivot smaller than this is one of points that determine no curve, in units of their mean radius.
const LEAST_PIVOT: f64 = 1e-9;

/// The ellipse through five of the points with the least median distance to all (Rousseeuw 1984), which are in units of their mean radius.
pub(super) fn least_median(unit: &[Point2<f64>]) -> Option<SVector<f64, 5>> {
    // a fixed sequence (Lehmer's) keeps the result the same from run to run
    let mut state = 48_271_u64;
    let mut pick = || {
        state = state * 48_271 % 2_147_483_647;
        unit[state as usize % unit.len()]
    };
    let columns = Columns::of(unit);
    let mut room = Vec::new();
    let mut residuals = Vec::with_capacity(unit.len());
    let mut best: Option<(f64, SVector<f64, 5>)> = None;
    for _ in 0..SUBSETS {
        let Some(conic) = through([pick(), pick(), pick(), pick(), pick()]) else {
            continue;
        };
        if best.is_some_and(|(least, _)| !columns.half_within(&conic, least)) {
            continue;
        }
        residuals.clear();
        residuals.extend(unit.iter().map(|p| sampson(&conic, p)));
        best = Some((robust_scale(&residuals, &mut room), conic));
    }
    best.map(|(_, conic)| conic)
}

/// The curve through five points, by elimination; `None` where they determine none, or one that is no ellipse.
fn through(points: [Point2<f64>; 5]) -> Option<SVector<f64, 5>> {
    let mut rows = points.map(|p| {
        let (x, y) = (p.x, p.y);
        [x * x, 2.0 * x * y, y * y, 2.0 * x, 2.0 * y, 1.0]
    });
    for k in 0..5 {
        let largest = (k + 1..5).fold(k, |a, b| {
            if rows[b][k].abs() > rows[a][k].abs() {
                b
            } else {
                a
            }
        });
        rows.swap(k, largest);
        let pivot = rows[k];
        if pivot[k].abs() < LEAST_PIVOT {
            return None;
        }
        let scale = pivot[k].recip();
        for row in &mut rows[k + 1..] {
            let factor = row[k] * scale;
            for (to, from) in row[k + 1..].iter_mut().zip(&pivot[k + 1..]) {
                *to -= factor * from;
            }
        }
    }
    let mut conic = SVector::<f64, 5>::zeros();
    for k in (0..5).rev() {
        let known: f64 = (k + 1..5).map(|i| rows[k][i] * conic[i]).sum();
        conic[k] = (rows[k][5] - known) / rows[k][k];
    }
    (conic[0] * conic[2] > conic[1] * conic[1]).then_some(conic)
}

/// Coordinates of many points, each by themselves, so that many are computed at a time.
struct Columns {
    x: Vec<f64>,
    y: Vec<f64>,
}

impl Columns {
    fn of(points: &[Point2<f64>]) -> Self {
        Self {
            x: points.iter().map(|p| p.x).collect(),
            y: points.iter().map(|p| p.y).collect(),
        }
    }

    /// Whether the median distance to a curve is less than that of a scale.
    fn half_within(&self, conic: &SVector<f64, 5>, scale: f64) -> bool {
        let [xx, xy, yy, x1, y1] = [conic[0], conic[1], conic[2], conic[3], conic[4]];
        // the distance is F over the length of its gradient; compared squared, it needs neither root nor division
        let most = 4.0 * (scale / NORMAL).powi(2);
        let within = widest(
            #[inline(always)]
            || {
                let mut within = 0_u64;
                for (&x, &y) in self.x.iter().zip(&self.y) {
                    let (gx, gy) = (xx * x + xy * y + x1, xy * x + yy * y + y1);
                    let f = gx * x + gy * y + x1 * x + y1 * y - 1.0;
                    within += u64::from(f * f < most * (gx * gx + gy * gy));
                }
                within
            },
        );
        within as usize > self.x.len() / 2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_points_of_an_ellipse_give_it_and_a_line_or_one_point_nothing() {
        let at = |t: f64| Point2::new(0.1 + 1.2 * t.cos(), -0.2 + 0.8 * t.sin());
        let conic = through([0.3, 1.1, 2.9, 4.0, 5.5].map(at)).unwrap();
        for t in 0..12 {
            assert!(sampson(&conic, &at(f64::from(t))).0.abs() < 1e-12);
        }
        assert!(through([0.0, 1.0, 2.0, 3.0, 4.0].map(|x| Point2::new(x, 0.5 * x))).is_none());
        assert!(through([Point2::new(0.5, 0.5); 5]).is_none());
    }

    #[test]
    fn half_is_within_what_the_median_is_within() {
        let at = |t: f64| Point2::new(t.cos(), 0.9 * t.sin());
        let conic = through([0.3, 1.1, 2.9, 4.0, 5.5].map(at)).unwrap();
        let points: Vec<Point2<f64>> = (0..21)
            .map(|i| at(0.3 * f64::from(i)) * (1.0 + 0.01 * f64::from(i)))
            .collect();
        let residuals: Vec<(f64, f64)> = points.iter().map(|p| sampson(&conic, p)).collect();
        let median = robust_scale(&residuals, &mut Vec::new());
        let columns = Columns::of(&points);
        assert!(columns.half_within(&conic, 1.001 * median));
        assert!(!columns.half_within(&conic, 0.999 * median));
    }
}
