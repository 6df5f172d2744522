//! An ellipse through edge points, robust to those that lie on something else (a shadow's border, a finger).

use super::second_start::least_median;
use crate::centre::Ellipse;
use nalgebra::{Matrix3, Point2, SMatrix, SVector};

/// Reweighted solutions until the weights settle: so many at most. Fewer lose rings of which noise and blur leave little.
const ROUNDS: usize = 12;
/// How well an ellipse has to be known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Precision {
    /// No solution after one that moved the ellipse by less than this fraction of its radius.
    settled: f64,
    /// Fewer inliers than this, or residuals above this fraction of the radius, call for a second start.
    suspicious: (f64, f64),
}

/// Where the ellipse is the result.
pub(super) const EXACT: Precision = Precision {
    settled: 1e-7,
    suspicious: (0.95, 0.02),
};
/// Where something else begins at it.
pub(super) const NEAR: Precision = Precision {
    settled: 1e-3,
    ..EXACT
};
/// Where its points are known to a pixel of a few, and nearly all belong to it.
pub(super) const ROUGH: Precision = Precision {
    settled: 3e-3,
    suspicious: (0.0, f64::INFINITY),
};
/// Tukey's biweight constant: 95 % efficiency on normal noise.
const TUKEY: f64 = 4.685;
/// Residuals below this are never outliers, px: it keeps a perfect fit from rejecting its rounding errors.
const LEAST_SCALE_PX: f64 = 0.01;
/// Standard deviation of normal noise over the median of its absolute values.
pub(super) const NORMAL: f64 = 1.4826;
/// An ellipse has five parameters; fewer points than this determine none reliably.
const LEAST_POINTS: usize = 8;

/// A fitted ellipse and how well the points agree with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EllipseFit {
    /// The ellipse, px.
    pub(super) ellipse: Ellipse,
    /// Robust standard deviation of the distances of the points, px.
    pub(super) scale_px: f64,
    /// Fraction of the points with any weight.
    pub(super) inliers: f64,
}

/// Fits an ellipse by distances to the curve (to first order, Sampson 1982), with Tukey's weights.
///
/// The points must surround the ellipse: their mean lies inside it, so F = q . (x^2, 2xy, y^2, 2x, 2y) - 1 about that mean
/// describes every candidate and each round is a linear problem. `None` where they determine no ellipse.
pub(super) fn fit_ellipse(points: &[Point2<f64>], precision: Precision) -> Option<EllipseFit> {
    if points.len() < LEAST_POINTS {
        return None;
    }
    let n = points.len() as f64;
    let origin: Point2<f64> = (points
        .iter()
        .map(|p| p.coords)
        .sum::<nalgebra::Vector2<f64>>()
        / n)
        .into();
    let radius = points.iter().map(|p| (p - origin).norm()).sum::<f64>() / n;
    if !(radius.is_finite() && radius > 0.0) {
        return None;
    }
    let unit: Vec<Point2<f64>> = points
        .iter()
        .map(|p| ((p - origin) / radius).into())
        .collect();
    let start = solve(&unit, &vec![1.0; unit.len()])?;
    let mut best = reweight(&unit, start, (radius, precision))?;
    if best.inliers < precision.suspicious.0 || best.scale > precision.suspicious.1 {
        // outliers in plenty have drawn the first solution to them
        let second =
            least_median(&unit).and_then(|start| reweight(&unit, start, (radius, precision)));
        best = second
            .into_iter()
            .chain([best])
            .min_by(|a, b| a.scale.total_cmp(&b.scale))?;
    }
    let ellipse = Ellipse::from_conic(&matrix(&best.conic))?;
    Some(EllipseFit {
        ellipse: Ellipse {
            centre: origin + ellipse.centre.coords * radius,
            major: ellipse.major * radius,
            minor: ellipse.minor * radius,
            angle: ellipse.angle,
        },
        scale_px: best.scale * radius,
        inliers: best.inliers,
    })
}

/// The ellipse that agrees best with all points of a smooth curve which is one but for a bend; `None` where there is none. It is what
/// [`fit_ellipse`] gives of edges along that curve, whose noise is larger than the bend.
pub(crate) fn ellipse_along<const POINTS: usize>(
    points: &[Point2<f64>; POINTS],
) -> Option<Ellipse> {
    let sum: nalgebra::Vector2<f64> = points.iter().map(|p| p.coords).sum();
    let origin = Point2::from(sum / POINTS as f64);
    let scale = POINTS as f64 / points.iter().map(|p| (p - origin).norm()).sum::<f64>();
    let unit = points.map(|p| Point2::from((p - origin) * scale));
    // weights follow from slopes, which the first solution knows to the bend
    let first = solve(&unit, &[1.0; POINTS])?;
    let weights = unit.map(|p| sampson(&first, &p).1.powi(2).max(1e-12).recip());
    let conic = solve(&unit, &weights)?;
    let ellipse = Ellipse::from_conic(&matrix(&conic))?;
    Some(Ellipse {
        centre: origin + ellipse.centre.coords / scale,
        major: ellipse.major / scale,
        minor: ellipse.minor / scale,
        angle: ellipse.angle,
    })
}

/// A solution in units of the points' mean radius.
struct Solution {
    conic: SVector<f64, 5>,
    scale: f64,
    inliers: f64,
}

/// Improves a first solution until the weights of its points settle.
fn reweight(
    unit: &[Point2<f64>],
    start: SVector<f64, 5>,
    (radius_px, precision): (f64, Precision),
) -> Option<Solution> {
    let mut conic = start;
    let mut scale = f64::INFINITY;
    let mut weights = vec![0.0; unit.len()];
    let mut residuals = Vec::with_capacity(unit.len());
    let mut room = Vec::with_capacity(unit.len());
    for _ in 0..ROUNDS {
        residuals.clear();
        residuals.extend(unit.iter().map(|p| sampson(&conic, p)));
        scale = robust_scale(&residuals, &mut room).max(LEAST_SCALE_PX / radius_px);
        for (weight, (distance, gradient)) in weights.iter_mut().zip(&residuals) {
            let t = (distance / (TUKEY * scale)).powi(2);
            let tukey = if t < 1.0 { (1.0 - t).powi(2) } else { 0.0 };
            *weight = tukey / gradient.powi(2).max(1e-12);
        }
        let next = solve(unit, &weights)?;
        let moved = (next - conic).amax();
        conic = next;
        if moved < precision.settled {
            break;
        }
    }
    let near = |p: &&Point2<f64>| sampson(&conic, p).0.abs() < TUKEY * scale;
    Some(Solution {
        inliers: unit.iter().filter(near).count() as f64 / unit.len() as f64,
        conic,
        scale,
    })
}

/// Weighted least squares of F over the points. What it needs of them are their moments up to the fourth.
fn solve(points: &[Point2<f64>], weights: &[f64]) -> Option<SVector<f64, 5>> {
    let (mut x4, mut x3y, mut x2y2, mut xy3, mut y4) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let (mut x3, mut x2y, mut xy2, mut y3) = (0.0, 0.0, 0.0, 0.0);
    let (mut x2, mut xy, mut y2, mut x1, mut y1) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (p, weight) in points.iter().zip(weights) {
        let (x, y) = (p.x, p.y);
        let (wx, wy) = (weight * x, weight * y);
        let (wxx, wxy, wyy) = (wx * x, wx * y, wy * y);
        (x1, y1) = (x1 + wx, y1 + wy);
        (x2, xy, y2) = (x2 + wxx, xy + wxy, y2 + wyy);
        (x3, x2y) = (x3 + wxx * x, x2y + wxx * y);
        (xy2, y3) = (xy2 + wyy * x, y3 + wyy * y);
        (x4, x3y, x2y2) = (x4 + wxx * x * x, x3y + wxx * x * y, x2y2 + wxx * y * y);
        (xy3, y4) = (xy3 + wyy * x * y, y4 + wyy * y * y);
    }
    #[rustfmt::skip]
    let normal = SMatrix::<f64, 5, 5>::new(
        x4, 2.0 * x3y, x2y2, 2.0 * x3, 2.0 * x2y,
        2.0 * x3y, 4.0 * x2y2, 2.0 * xy3, 4.0 * x2y, 4.0 * xy2,
        x2y2, 2.0 * xy3, y4, 2.0 * xy2, 2.0 * y3,
        2.0 * x3, 4.0 * x2y, 2.0 * xy2, 4.0 * x2, 4.0 * xy,
        2.0 * x2y, 4.0 * xy2, 2.0 * y3, 4.0 * xy, 4.0 * y2,
    );
    let right = SVector::<f64, 5>::new(x2, 2.0 * xy, y2, 2.0 * x1, 2.0 * y1);
    normal.cholesky().map(|c| c.solve(&right))
}

/// Signed distance to the curve to first order, and the length of F's gradient there.
pub(super) fn sampson(q: &SVector<f64, 5>, p: &Point2<f64>) -> (f64, f64) {
    let gx = 2.0 * (q[0] * p.x + q[1] * p.y + q[3]);
    let gy = 2.0 * (q[1] * p.x + q[2] * p.y + q[4]);
    let f = 0.5 * (gx * p.x + gy * p.y) + q[3] * p.x + q[4] * p.y - 1.0;
    // far from the ends of the range: no need of hypot's care
    let gradient = (gx * gx + gy * gy).sqrt();
    (f / gradient.max(1e-9), gradient)
}

fn matrix(q: &SVector<f64, 5>) -> Matrix3<f64> {
    Matrix3::new(q[0], q[1], q[3], q[1], q[2], q[4], q[3], q[4], -1.0)
}

/// Standard deviation from the median of the absolute distances.
pub(super) fn robust_scale(residuals: &[(f64, f64)], absolute: &mut Vec<u64>) -> f64 {
    absolute.clear();
    // numbers that are not negative are in the order of their bits, which are faster to compare
    absolute.extend(residuals.iter().map(|r| r.0.abs().to_bits()));
    let middle = absolute.len() / 2;
    NORMAL * f64::from_bits(*absolute.select_nth_unstable(middle).1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const TRUTH: Ellipse = Ellipse {
        centre: Point2::new(640.3, 211.8),
        major: 31.0,
        minor: 19.5,
        angle: -0.4,
    };

    fn around(n: usize) -> Vec<Point2<f64>> {
        (0..n)
            .map(|i| TRUTH.point(std::f64::consts::TAU * i as f64 / n as f64))
            .collect()
    }

    #[test]
    fn exact_points_give_the_exact_ellipse() {
        let fit = fit_ellipse(&around(40), EXACT).unwrap();
        assert!((fit.ellipse.centre - TRUTH.centre).norm() < 1e-9);
        assert!((fit.ellipse.major - TRUTH.major).abs() < 1e-9);
        assert!((fit.ellipse.angle - TRUTH.angle).abs() < 1e-9);
        assert_eq!(fit.inliers, 1.0);
    }

    #[test]
    fn a_bent_curve_gives_the_ellipse_that_many_edges_on_it_give() {
        // a bend with three periods, as a lens makes it, and what perspective does not
        let bent = |i: usize, n: usize| {
            let t = std::f64::consts::TAU * i as f64 / n as f64;
            TRUTH.point(t) + (TRUTH.point(t) - TRUTH.centre) * (1e-4 * (3.0 * t + 0.4).cos())
        };
        let few: [Point2<f64>; 12] = std::array::from_fn(|i| bent(i, 12));
        let many: [Point2<f64>; 300] = std::array::from_fn(|i| bent(i, 300));
        let few = ellipse_along(&few).unwrap();
        // the bend is of 3e-3 px
        let exact = ellipse_along(&many).unwrap();
        assert!((few.centre - exact.centre).norm() < 3e-5);
        assert!((few.major - exact.major).abs() < 3e-5);
        let robust = fit_ellipse(&many, EXACT).unwrap().ellipse;
        assert!((few.centre - robust.centre).norm() < 1e-4);
        assert!((few.major - robust.major).abs() < 1e-4);
    }

    #[test]
    fn a_fifth_of_the_points_elsewhere_does_not_matter() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut points = around(60);
        for p in &mut points {
            p.x += rng.random_range(-0.1..0.1);
            p.y += rng.random_range(-0.1..0.1);
        }
        for p in points.iter_mut().take(12) {
            *p += (TRUTH.centre - *p) * 0.25;
        }
        let fit = fit_ellipse(&points, EXACT).unwrap();
        assert!((fit.ellipse.centre - TRUTH.centre).norm() < 0.05);
        assert!((fit.ellipse.minor - TRUTH.minor).abs() < 0.1);
        assert!(fit.inliers > 0.75 && fit.inliers < 0.85, "{}", fit.inliers);
    }

    #[test]
    fn points_that_determine_nothing_give_nothing() {
        assert!(fit_ellipse(&around(7), EXACT).is_none());
        assert!(fit_ellipse(&[Point2::new(3.0, 4.0); 20], EXACT).is_none());
        let line: Vec<Point2<f64>> = (0..20).map(|i| Point2::new(f64::from(i), 2.0)).collect();
        assert!(fit_ellipse(&line, EXACT).is_none());
        assert!(fit_ellipse(&[Point2::new(f64::NAN, 0.0); 9], EXACT).is_none());
    }
}
