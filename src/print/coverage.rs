//! How much of a pixel a shape covers, exactly. Lengths are pixels; the pixel (x, y) is the square from (x, y) to (x + 1, y + 1).

/// The part of the pixel at (x, y) inside a circle about the origin, 0 to 1.
pub(super) fn disc(x: f64, y: f64, radius: f64) -> f64 {
    let near = [x, y].map(|v| v.max(-(v + 1.0)).max(0.0));
    let far = [x, y].map(|v| v.abs().max((v + 1.0).abs()));
    if near[0].hypot(near[1]) >= radius {
        0.0
    } else if far[0].hypot(far[1]) <= radius {
        1.0
    } else {
        let below = |x, y| quarter(x, y, radius);
        let (right, down) = (x + 1.0, y + 1.0);
        (below(right, down) - below(x, down) - below(right, y) + below(x, y)).clamp(0.0, 1.0)
    }
}

/// Area of the disc left of x and above y, less what does not change with the corner on either axis: the signed area between
/// the axes and (x, y) within the disc.
fn quarter(x: f64, y: f64, radius: f64) -> f64 {
    let sign = x.signum() * y.signum();
    let (x, y) = (x.abs().min(radius), y.abs().min(radius));
    let r2 = radius * radius;
    // integral of sqrt(r^2 - t^2)
    let under = |t: f64| 0.5 * (t * (r2 - t * t).max(0.0).sqrt() + r2 * (t / radius).asin());
    // the circle comes below y from here on
    let bend = (r2 - y * y).max(0.0).sqrt();
    let area = if x <= bend {
        x * y
    } else {
        bend * y + under(x) - under(bend)
    };
    sign * area
}

/// The part of the length from `at` to `at + 1` between `low` and `high`.
pub(super) fn span(at: f64, low: f64, high: f64) -> f64 {
    (high.min(at + 1.0) - low.max(at)).clamp(0.0, 1.0)
}

/// The part of the pixel at (x, y) inside a triangle, 0 to 1.
pub(super) fn triangle(x: f64, y: f64, corners: &[[f64; 2]; 3]) -> f64 {
    let mut polygon: Vec<[f64; 2]> = corners.iter().map(|c| [c[0] - x, c[1] - y]).collect();
    for axis in 0..2 {
        for (sign, limit) in [(1.0, 1.0), (-1.0, 0.0)] {
            polygon = cut(&polygon, axis, sign, limit);
        }
    }
    let next = polygon.iter().cycle().skip(1);
    let twice: f64 = polygon
        .iter()
        .zip(next)
        .map(|(a, b)| a[0] * b[1] - a[1] * b[0])
        .sum();
    (0.5 * twice.abs()).clamp(0.0, 1.0)
}

/// What of a convex polygon is where `sign` times the coordinate is at most `sign` times `limit`.
fn cut(polygon: &[[f64; 2]], axis: usize, sign: f64, limit: f64) -> Vec<[f64; 2]> {
    let inside = |p: &[f64; 2]| sign * (limit - p[axis]);
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        let (from, to) = (inside(a), inside(b));
        if from >= 0.0 {
            kept.push(*a);
        }
        if (from >= 0.0) != (to >= 0.0) {
            let t = from / (from - to);
            kept.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Fraction of a fine grid of points of the pixel.
    fn counted(x: f64, y: f64, inside: impl Fn(f64, f64) -> bool) -> f64 {
        let n = 300;
        let at = |start: f64, k: i32| start + (f64::from(k) + 0.5) / f64::from(n);
        let all = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let hits = all.filter(|&(i, j)| inside(at(x, i), at(y, j))).count();
        hits as f64 / f64::from(n * n)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]
        #[test]
        fn pixels_are_covered_as_points_say(x in -4.0..3.0_f64, y in -4.0..3.0_f64, radius in 0.2..4.0_f64) {
            let expected = counted(x, y, |x, y| x.hypot(y) < radius);
            prop_assert!((disc(x, y, radius) - expected).abs() < 4e-3, "{} {expected}", disc(x, y, radius));
        }

        #[test]
        fn all_pixels_together_cover_the_disc(cx in 0.0..1.0_f64, cy in 0.0..1.0_f64, radius in 0.1..40.0_f64) {
            let all = (-42..42).flat_map(|x| (-42..42).map(move |y| (f64::from(x), f64::from(y))));
            let area: f64 = all.map(|(x, y)| disc(x - cx, y - cy, radius)).sum();
            let expected = std::f64::consts::PI * radius * radius;
            prop_assert!((area - expected).abs() < 1e-8 * (1.0 + expected));
        }

        #[test]
        fn triangles_too(c in prop::array::uniform3(prop::array::uniform2(-3.0..4.0_f64))) {
            let side = |a: [f64; 2], b: [f64; 2], x: f64, y: f64| (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
            let expected = counted(0.0, 0.0, |x, y| {
                let s = [side(c[0], c[1], x, y), side(c[1], c[2], x, y), side(c[2], c[0], x, y)];
                s.iter().all(|v| *v > 0.0) || s.iter().all(|v| *v < 0.0)
            });
            prop_assert!((triangle(0.0, 0.0, &c) - expected).abs() < 6e-3);
        }
    }

    #[test]
    fn spans_overlap_in_part() {
        assert_eq!(span(2.0, 2.25, 9.0), 0.75);
        assert_eq!(span(2.0, 2.25, 2.5), 0.25);
        assert_eq!(span(2.0, 3.5, 9.0), 0.0);
    }
}
