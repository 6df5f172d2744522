//! Clipped pixels: they say that their light is at least (or at most) what they show, no more.
//!
//! The likelihood of a pixel clipped at the top is that of any light beyond, Phi((model - top) / s) for noise s (Tobin 1958). Its
//! gradient is that of a residual s lambda(a), lambda the inverse Mills ratio at a = (top - model) / s, and its curvature
//! that of one pixel times lambda (lambda - a).

use super::coverage::{COVERAGE_PARAMETERS, Coverage};
use super::model::{BLUR, PARAMETERS, RING_PARAMETERS, RingModel, SHEET};
use super::problem::Problem;
use super::rows::Rows;
use super::sheet::SheetRow;
use super::window::{End, Grid};
use std::f64::consts::{FRAC_1_SQRT_2, PI};
use std::ops::Range;

/// Less noise than this is none, fraction of full scale.
const LEAST_NOISE: f64 = 1e-4;
/// A light so many standard deviations beyond the end is clipped for certain: the pixel says nothing more (1e-11 of a variance).
const CERTAIN: f64 = -7.0;

/// The censored pixels of a window under a model.
pub(super) struct Censored<'a> {
    problem: &'a Problem<'a>,
    model: &'a RingModel,
    coverage: &'a Coverage,
}

impl<'a> Censored<'a> {
    pub(super) fn new(problem: &'a Problem, model: &'a RingModel, coverage: &'a Coverage) -> Self {
        Self {
            problem,
            model,
            coverage,
        }
    }

    /// Fills in derivatives and residuals of the censored pixels of one row (given by its span of indices) so that their products
    /// are the likelihood's gradient and curvature. Returns what is missing in the sum of squares: -2 s^2 ln likelihood less
    /// the squares of these residuals.
    pub(super) fn patch(&self, span: Range<usize>, out: &mut Rows) -> f64 {
        let noise = self.problem.noise.max(LEAST_NOISE);
        let pixels = &self.problem.window.censored;
        let first = pixels.partition_point(|&(at, _)| at < span.start);
        let row = span.start / self.problem.window.grid.stride();
        let mut missing = 0.0;
        for &(at, end) in pixels[first..].iter().take_while(|&&(at, _)| at < span.end) {
            let i = at - span.start;
            let sign = match end {
                End::Top => 1.0,
                End::Bottom => -1.0,
            };
            // the row's derivatives were filled in a moment ago, and its sheet with them
            let pixel = self.pixel(at, row, i, &out.sheet);
            let value = f64::from(self.problem.window.values[at]);
            let a = sign * (value - pixel.flat * pixel.shade) / noise;
            if a < CERTAIN {
                out.set_pixel(i, &[0.0; PARAMETERS][..out.parameters], 0.0);
                continue;
            }
            let (log_likelihood, mills) = beyond(a);
            let curvature = (mills * (mills - a)).clamp(1e-12, 1.0).sqrt();
            let residual = sign * noise * mills / curvature;
            let derivatives = self.derivatives(at, i, &pixel, &out.sheet);
            let derivatives = derivatives.map(|derivative| derivative * curvature);
            out.set_pixel(i, &derivatives[..out.parameters], residual);
            missing -= 2.0 * noise * noise * log_likelihood + residual * residual;
        }
        missing
    }

    fn pixel(&self, at: usize, row: usize, column: usize, sheet: &SheetRow) -> Pixel {
        let grid: &Grid = &self.problem.window.grid;
        let model = self.model;
        let width = grid.width as f64;
        let u = (column as f64 - 0.5 * (width - 1.0)) / width;
        let v = (row as f64 - 0.5 * (grid.height as f64 - 1.0)) / width;
        let shade = 1.0 + model.shading[0] * u + model.shading[1] * v;
        let [outer, inner] = [0, 1].map(|c: usize| f64::from(self.coverage.circles[c][at]));
        let [dark, light] = model.contrasts();
        let step = model.sheet.map_or(0.0, |end| end.beyond - model.paper);
        let missing = match model.sheet {
            Some(_) => f64::from(sheet.missing[column]),
            None => 0.0,
        };
        Pixel {
            at: [u, v],
            shade,
            circles: [outer, inner],
            missing,
            step,
            flat: model.paper + dark * outer + light * inner + step * missing,
        }
    }

    /// How a pixel's light changes with each parameter.
    fn derivatives(
        &self,
        at: usize,
        column: usize,
        pixel: &Pixel,
        sheet: &SheetRow,
    ) -> [f64; PARAMETERS] {
        let (grid, model): (&Grid, _) = (&self.problem.window.grid, self.model);
        let Pixel {
            at: [u, v],
            shade,
            circles: [outer, inner],
            missing,
            step,
            flat,
        } = *pixel;
        let mut derivatives = [0.0; PARAMETERS];
        for (k, plane) in self.coverage.changes.iter().enumerate() {
            derivatives[k] = shade * plane.get(at).copied().map_or(0.0, f64::from);
        }
        derivatives[BLUR] *= model.by_blur(grid);
        let rest = [
            shade * (1.0 - outer - missing),
            shade * (outer - inner),
            shade * inner,
            flat * u,
            flat * v,
        ];
        derivatives[COVERAGE_PARAMETERS..RING_PARAMETERS].copy_from_slice(&rest);
        if let Some(end) = &model.sheet {
            derivatives[BLUR] += shade * step * f64::from(sheet.by_blur[column]);
            derivatives[SHEET] = shade * missing;
            for (k, by) in sheet.by_edge[..end.count() - 1].iter().enumerate() {
                derivatives[SHEET + 1 + k] = shade * step * f64::from(by[column]);
            }
        }
        derivatives
    }
}

/// What a pixel sees under the model.
struct Pixel {
    /// Where it is, of the window's width from its middle.
    at: [f64; 2],
    shade: f64,
    /// Coverages by the outer and the inner circle.
    circles: [f64; 2],
    /// The part of it beyond the sheet's end, and the light there over that of the paper.
    missing: f64,
    step: f64,
    /// Its light without the shade.
    flat: f64,
}

/// Logarithm of the probability that a normal variable exceeds `a`, and its density at `a` over that probability.
fn beyond(a: f64) -> (f64, f64) {
    let density = -0.5 * a * a - 0.5 * (2.0 * PI).ln();
    if a > 30.0 {
        // the tail's leading term: the probability itself underflows
        return (density - a.ln(), a + 1.0 / a);
    }
    let log = (0.5 * libm::erfc(a * FRAC_1_SQRT_2)).ln();
    (log, (density - log).exp())
}

#[cfg(test)]
mod tests {
    use super::beyond;

    #[test]
    fn the_mills_ratio_is_the_slope_of_the_logarithm() {
        for a in [-5.0, -1.0, 0.0, 1.0, 4.0, 12.0, 29.0, 40.0] {
            let h = 1e-5;
            let slope = (beyond(a + h).0 - beyond(a - h).0) / (2.0 * h);
            assert!((slope + beyond(a).1).abs() < 1e-4 * (1.0 + a.abs()), "{a}");
        }
    }
}
