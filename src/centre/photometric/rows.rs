//! Rows of pixels under a model: their light, and how it changes with every parameter.

use super::coverage::{Coverage, Plane};
use super::model::{BLUR, RingModel, SHEET};
use super::real::{Floats, Real, columns};
use super::sheet::SheetRow;
use super::window::{Grid, Window};
use pulp::{Arch, Simd, WithSimd};

/// Rows of pixels whose derivatives are kept together, so that sums over them stay in registers for longer.
const TOGETHER: usize = 4;

/// Derivatives of the light of a few rows of pixels by every parameter, each times the pixel's weight, and the residuals.
#[derive(Debug, Clone, Default)]
pub(super) struct Rows {
    /// Parameter by parameter, `TOGETHER` rows of `stride` pixels each; the residuals behind them.
    data: Vec<f32>,
    stride: usize,
    /// Rows filled in.
    rows: usize,
    /// Parameters: those that the model has.
    pub(super) parameters: usize,
    pub(super) sheet: SheetRow,
}

impl Rows {
    /// Forgets the rows.
    pub(super) fn clear(&mut self) {
        self.rows = 0;
    }

    /// Whether no more row fits in.
    pub(super) fn is_full(&self) -> bool {
        self.rows == TOGETHER
    }

    /// Derivatives by a parameter, or (behind the last) the residuals, of all rows filled in.
    #[inline(always)]
    pub(super) fn column(&self, k: usize) -> &[f32] {
        let begin = k * TOGETHER * self.stride;
        &self.data[begin..begin + self.rows * self.stride]
    }

    /// The same of the last row.
    #[inline(always)]
    fn last_mut(&mut self, k: usize) -> &mut [f32] {
        let begin = (k * TOGETHER + self.rows - 1) * self.stride;
        &mut self.data[begin..begin + self.stride]
    }

    /// The residuals of the last row.
    pub(super) fn residuals(&mut self) -> &[f32] {
        self.last_mut(self.parameters)
    }

    /// Fills in all derivatives and the residuals of one more row. The derivatives by shape and blur come from the coverage's changes, those by
    /// the levels from its circles.
    pub(super) fn fill(&mut self, model: &RingModel, window: &Window, row: usize, of: &Coverage) {
        let grid = &window.grid;
        let stride = grid.stride();
        self.stride = stride;
        self.parameters = model.count();
        self.rows += 1;
        let size = TOGETHER * stride * (self.parameters + 1);
        if self.data.len() < size {
            self.data.resize(size, 0.0);
        }
        if let Some(end) = &model.sheet {
            self.sheet.fill(end, &model.blur, grid, row);
        }
        Arch::new().dispatch(Derivatives {
            rows: self,
            lit: Lit::new(model, grid, row),
            model,
            window,
            row,
            coverage: of,
        });
    }

    /// Replaces what the last row says of one pixel.
    pub(super) fn set_pixel(&mut self, i: usize, derivatives: &[f64], residual: f64) {
        for (k, derivative) in derivatives.iter().enumerate() {
            self.last_mut(k)[i] = *derivative as f32;
        }
        let residuals = self.parameters;
        self.last_mut(residuals)[i] = residual as f32;
    }
}

/// Light of the pixels of one row, from the coverages of both circles there; with the window's pixels what they show beyond it, where they count.
pub(super) fn light(
    (model, grid): (&RingModel, &Grid),
    row: usize,
    [outer, inner]: &[Plane; 2],
    shown: Option<&Window>,
    (sheet, out): (&mut SheetRow, &mut [f32]),
) {
    if let Some(end) = &model.sheet {
        sheet.fill(end, &model.blur, grid, row);
    }
    let stride = grid.stride();
    let span = row * stride..(row + 1) * stride;
    Arch::new().dispatch(Light {
        lit: Lit::new(model, grid, row),
        circles: [&outer[span.clone()], &inner[span.clone()]],
        missing: model.sheet.is_some().then_some(sheet.missing.as_slice()),
        shown: shown.map(|window| [&window.values[span.clone()], &window.weights[span]]),
        out,
    });
}

/// Levels and shading of a model along one row.
#[derive(Clone, Copy)]
pub(super) struct Lit {
    paper: f32,
    dark: f32,
    light: f32,
    /// Beyond the sheet's end less paper.
    beyond: f32,
    /// The shading at the first column and its slope.
    shade: [f32; 2],
    /// What the shading's parameters are multiplied with: across at the first column, its slope, down.
    pub(super) place: [f32; 3],
}

impl Lit {
    pub(super) fn new(model: &RingModel, grid: &Grid, row: usize) -> Self {
        let width = grid.width as f64;
        let v = (row as f64 - 0.5 * (grid.height as f64 - 1.0)) / width;
        let u0 = -0.5 * (width - 1.0) / width;
        let [across, down] = model.shading;
        let [dark, light] = model.contrasts().map(|c| c as f32);
        let beyond = model.sheet.map_or(0.0, |end| end.beyond - model.paper);
        Self {
            paper: model.paper as f32,
            dark,
            light,
            beyond: beyond as f32,
            shade: [
                (1.0 + across * u0 + down * v) as f32,
                (across / width) as f32,
            ],
            place: [u0 as f32, (1.0 / width) as f32, v as f32],
        }
    }

    /// The light without shading.
    #[inline(always)]
    pub(super) fn flat<T: Real>(&self, [outer, inner]: [T; 2], missing: Option<T>) -> T {
        let lit = outer * self.dark + inner * self.light + self.paper;
        missing.map_or(lit, |missing| lit + missing * self.beyond)
    }

    #[inline(always)]
    pub(super) fn shade<T: Real>(&self, column: T) -> T {
        column * self.shade[1] + self.shade[0]
    }
}

/// The shading along one row of a window.
pub(super) fn shades(
    model: &RingModel,
    grid: &Grid,
    row: usize,
) -> impl Iterator<Item = f32> + use<> {
    let lit = Lit::new(model, grid, row);
    (0..grid.stride()).map(move |i| lit.shade(i as f32))
}

struct Light<'a> {
    lit: Lit,
    circles: [&'a [f32]; 2],
    missing: Option<&'a [f32]>,
    /// What the pixels show, and their weights.
    shown: Option<[&'a [f32]; 2]>,
    out: &'a mut [f32],
}

impl WithSimd for Light<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let read = |plane: &[f32], v: usize| Floats::of(simd, plane, v);
        for (v, out) in S::as_mut_simd_f32s(self.out).0.iter_mut().enumerate() {
            let circles = [read(self.circles[0], v), read(self.circles[1], v)];
            let missing = self.missing.map(|missing| read(missing, v));
            let light = self.lit.flat(circles, missing) * self.lit.shade(columns(simd, v));
            *out = match self.shown {
                Some([values, weights]) => (read(weights, v) * (read(values, v) - light)).values,
                None => light.values,
            };
        }
    }
}

struct Derivatives<'a> {
    rows: &'a mut Rows,
    lit: Lit,
    model: &'a RingModel,
    window: &'a Window,
    row: usize,
    coverage: &'a Coverage,
}

impl WithSimd for Derivatives<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        const _: () = assert!(BLUR == 7 && SHEET == 13);
        let stride = self.rows.stride;
        let span = self.row * stride..(self.row + 1) * stride;
        let read = |plane: &[f32], v: usize| Floats::of(simd, plane, v);
        let [outer, inner] =
            [0, 1].map(|circle: usize| &self.coverage.circles[circle][span.clone()]);
        let changes = self.coverage.changes.each_ref();
        let changes = changes.map(|plane| &plane[span.clone()]);
        let [values, weights] =
            [&self.window.values, &self.window.weights].map(|plane| &plane[span.clone()]);
        let by_blur = self.model.by_blur(&self.window.grid) as f32;
        let (parameters, first) = (self.rows.parameters, self.rows.rows - 1);
        let pitch = TOGETHER * stride / S::F32_LANES;
        let Rows { data, sheet, .. } = self.rows;
        let out = &mut S::as_mut_simd_f32s(data).0[first * stride / S::F32_LANES..];
        let has_sheet = self.model.sheet.is_some();
        let edges = parameters.saturating_sub(SHEET + 1);
        for v in 0..stride / S::F32_LANES {
            let mut put = |k: usize, value: Floats<S>| out[k * pitch + v] = value.values;
            let column = columns(simd, v);
            let weight = read(weights, v);
            let shade = self.lit.shade(column);
            let shaded = shade * weight;
            let circles = [read(outer, v), read(inner, v)];
            let missing = has_sheet.then(|| read(&sheet.missing, v));
            let flat = self.lit.flat(circles, missing);
            for (k, change) in changes[..BLUR].iter().enumerate() {
                put(k, read(change, v) * shaded);
            }
            let mut blurred = read(changes[BLUR], v) * by_blur;
            let mut paper = -circles[0] + 1.0;
            if let Some(missing) = missing {
                blurred = blurred + read(&sheet.by_blur, v) * self.lit.beyond;
                paper = paper - missing;
                put(SHEET, missing * shaded);
                for (k, by) in sheet.by_edge[..edges].iter().enumerate() {
                    put(SHEET + 1 + k, read(by, v) * shaded * self.lit.beyond);
                }
            }
            put(BLUR, blurred * shaded);
            put(BLUR + 1, paper * shaded);
            put(BLUR + 2, (circles[0] - circles[1]) * shaded);
            put(BLUR + 3, circles[1] * shaded);
            let weighted = flat * weight;
            let [u0, step, down] = self.lit.place;
            put(BLUR + 4, weighted * (column * step + u0));
            put(BLUR + 5, weighted * down);
            put(parameters, read(values, v) * weight - flat * shaded);
        }
    }
}
