//! The normal distribution in `f32`, for numbers and for vectors: no branch, no call, no table.

use super::real::Real;

/// Density (of unit deviation) and cumulative distribution at `u`; both right within 2e-7 (Abramowitz and Stegun, 26.2.17).
#[inline(always)]
pub(super) fn density_and_cumulative<T: Real>(u: T) -> (T, T) {
    const SCALE: f32 = 0.398_942_3;
    let away = u.magnitude();
    let density = exp(u * u * -0.5) * SCALE;
    let t = away.like(1.0) / (away * 0.231_641_9 + 1.0);
    let series = t.polynomial([
        1.330_274_5,
        -1.821_256,
        1.781_477_9,
        -0.356_563_78,
        0.319_381_53,
    ]);
    let tail = density * t * series;
    (density, u.choose(-tail + 1.0, tail))
}

/// e to the power of `x`, for x from -80 to 80; relative error 2e-7.
#[inline(always)]
pub(super) fn exp<T: Real>(x: T) -> T {
    // adding this rounds to a whole number and leaves it in the low bits
    const ROUND: f32 = 12_582_912.0;
    let y = x.at_least(-80.0) * std::f32::consts::LOG2_E;
    let rounded = y + ROUND;
    let part = (y - (rounded - ROUND)) * std::f32::consts::LN_2;
    let series = part.polynomial([
        1.0 / 720.0,
        1.0 / 120.0,
        1.0 / 24.0,
        1.0 / 6.0,
        0.5,
        1.0,
        1.0,
    ]);
    series * rounded.power_of_two()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_error_function() {
        for i in -900..=900 {
            let u = f64::from(i) * 0.01;
            let (density, cumulative) = density_and_cumulative(u as f32);
            let true_density = (-0.5 * u * u).exp() * 0.398_942_280_401_432_7;
            let true_cumulative = 0.5 * libm::erfc(-u * std::f64::consts::FRAC_1_SQRT_2);
            assert!((f64::from(density) - true_density).abs() < 2e-7, "{u}");
            assert!(
                (f64::from(cumulative) - true_cumulative).abs() < 2e-7,
                "{u}"
            );
        }
    }
}
