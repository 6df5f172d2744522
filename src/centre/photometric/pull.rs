//! The gradient of a window's sum of squares, with the coverage's changes of an earlier model: they are what costs, and near the end of a fit
//! they hardly change.

use super::coverage::{COVERAGE_PARAMETERS, Coverage};
use super::model::{BLUR, INSIDE, PAPER, RING, RING_PARAMETERS, RingModel, SHADING, Vector};
use super::real::{Floats, columns};
use super::rows::Lit;
use super::window::Window;
use pulp::{Arch, Simd, WithSimd};

/// Rows after which the sums go on in `f64`.
const TOGETHER: usize = 16;
/// The gradient's entries, and the sum of squares.
const SUMS: usize = RING_PARAMETERS + 1;

/// Gradient and sum of squared residuals of a ring whose sheet ends nowhere near; `residuals` (padded rows) are filled in.
pub(super) fn pull(
    model: &RingModel,
    window: &Window,
    coverage: &Coverage,
    residuals: &mut [f32],
) -> (Vector, f64) {
    let mut sums = [0.0; SUMS];
    Arch::new().dispatch(Pull {
        model,
        window,
        coverage,
        residuals,
        sums: &mut sums,
    });
    sums[BLUR] *= model.by_blur(&window.grid);
    let mut gradient = Vector::zeros();
    gradient.as_mut_slice()[..RING_PARAMETERS].copy_from_slice(&sums[..RING_PARAMETERS]);
    (gradient, sums[RING_PARAMETERS])
}

struct Pull<'a> {
    model: &'a RingModel,
    window: &'a Window,
    coverage: &'a Coverage,
    residuals: &'a mut [f32],
    sums: &'a mut [f64; SUMS],
}

impl WithSimd for Pull<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let height = self.window.grid.height;
        for first in (0..height).step_by(TOGETHER) {
            let mut sums = [simd.splat_f32s(0.0); SUMS];
            for row in first..(first + TOGETHER).min(height) {
                self.add_row(simd, row, &mut sums);
            }
            for (total, sum) in self.sums.iter_mut().zip(sums) {
                *total += f64::from(simd.reduce_sum_f32s(sum));
            }
        }
    }
}

impl Pull<'_> {
    /// Adds one row's part to the sums. What is multiplied by the same for all pixels of a row is so here, that of the whole window later.
    #[inline(always)]
    fn add_row<S: Simd>(&mut self, simd: S, row: usize, sums: &mut [S::f32s; SUMS]) {
        const _: () = assert!(COVERAGE_PARAMETERS == BLUR + 1 && SHADING + 2 == RING_PARAMETERS);
        let stride = self.window.grid.stride();
        let span = row * stride..(row + 1) * stride;
        let lit = Lit::new(self.model, &self.window.grid, row);
        let [outer, inner] = self
            .coverage
            .circles
            .each_ref()
            .map(|plane| &plane[span.clone()]);
        let changes = self
            .coverage
            .changes
            .each_ref()
            .map(|plane| &plane[span.clone()]);
        let [values, weights] =
            [&self.window.values, &self.window.weights].map(|plane| &plane[span.clone()]);
        let residuals = S::as_mut_simd_f32s(&mut self.residuals[span]).0;
        let read = |plane: &[f32], v: usize| Floats::of(simd, plane, v);
        let [u0, step, down] = lit.place;
        for (v, out) in residuals.iter_mut().enumerate() {
            let mut add = |k: usize, factor: Floats<S>, value: Floats<S>| {
                sums[k] = simd.mul_add_e_f32s(factor.values, value.values, sums[k]);
            };
            let (column, weight) = (columns(simd, v), read(weights, v));
            let circles = [read(outer, v), read(inner, v)];
            let (shade, flat) = (lit.shade(column), lit.flat(circles, None));
            let residual = (read(values, v) - flat * shade) * weight;
            *out = residual.values;
            let weighted = residual * weight;
            let pull = weighted * shade;
            for (k, change) in changes.iter().enumerate() {
                add(k, read(change, v), pull);
            }
            add(PAPER, -circles[0] + 1.0, pull);
            add(RING, circles[0] - circles[1], pull);
            add(INSIDE, circles[1], pull);
            let bright = flat * weighted;
            add(SHADING, column * step + u0, bright);
            add(SHADING + 1, bright, Floats::all(simd, down));
            add(SUMS - 1, residual, residual);
        }
    }
}
