//! The normal distribution in `f32`, written so that loops over it vectorise: no branch, no call, no table.

/// Density (of unit deviation) and cumulative distribution at `u`; both right within 2e-7 (Abramowitz and Stegun, 26.2.17).
#[inline(always)]
pub(super) fn density_and_cumulative(u: f32) -> (f32, f32) {
    const SCALE: f32 = 0.398_942_3;
    let away = u.abs();
    let density = SCALE * exp(-0.5 * u * u);
    let t = 1.0 / (1.0 + 0.231_641_9 * away);
    let series = 1.330_274_5;
    let series = -1.821_256 + t * series;
    let series = 1.781_477_9 + t * series;
    let series = -0.356_563_78 + t * series;
    let series = 0.319_381_53 + t * series;
    let tail = density * t * series;
    (density, if u > 0.0 { 1.0 - tail } else { tail })
}

/// e to the power of `x`, for x from -80 to 80; relative error 2e-7.
#[inline(always)]
pub(super) fn exp(x: f32) -> f32 {
    // adding this rounds to a whole number and leaves it in the low bits
    const ROUND: f32 = 12_582_912.0;
    let y = x.max(-80.0) * std::f32::consts::LOG2_E;
    let rounded = y + ROUND;
    let part = (y - (rounded - ROUND)) * std::f32::consts::LN_2;
    let series = 1.0 / 720.0;
    let series = 1.0 / 120.0 + part * series;
    let series = 1.0 / 24.0 + part * series;
    let series = 1.0 / 6.0 + part * series;
    let series = 0.5 + part * series;
    let series = 1.0 + part * (1.0 + part * series);
    series * f32::from_bits((rounded.to_bits() << 23).wrapping_add(127 << 23))
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
