//! The grey values of a blurred ring: levels of paper, ring and inner disc, blur, and linear shading across the window.
//!
//! `I = (paper + (ring - paper) B_1 + (inside - ring) B_r) (1 + s . (x - x0) / w)`: B_1 and B_r are the blurred coverages of the
//! outer and the inner circle (`coverage`), s the shading over the window's width w, x0 the window's middle. Where the sheet
//! ends beside the ring, `(beyond - paper) O` is added in the first bracket (`sheet`).

use super::blur::Blur;
use super::coverage::{COVERAGE_PARAMETERS, Contrasts, Coverage};
use super::shape::{SHAPE_PARAMETERS, Shape};
use super::sheet::{SHEET_PARAMETERS, SheetEnd, SheetRow};
use super::window::Grid;
use nalgebra::{SMatrix, SVector};

/// Parameters of every ring: shape (7), blur (1), levels (3), shading (2).
pub(super) const RING_PARAMETERS: usize = COVERAGE_PARAMETERS + 5;
/// All parameters: those of the sheet's end come last, and most rings have none.
pub(super) const PARAMETERS: usize = RING_PARAMETERS + SHEET_PARAMETERS;
/// Where each stands among the parameters.
pub(super) const BLUR: usize = SHAPE_PARAMETERS;
pub(super) const PAPER: usize = COVERAGE_PARAMETERS;
pub(super) const RING: usize = PAPER + 1;
pub(super) const INSIDE: usize = PAPER + 2;
pub(super) const SHADING: usize = PAPER + 3;
pub(super) const SHEET: usize = RING_PARAMETERS;

/// Everything the grey values of one window depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingModel {
    /// Where the ring is and how it is tilted.
    pub shape: Shape,
    /// Blur.
    pub blur: Blur,
    /// Light of the paper around the ring, 1 at full scale.
    pub paper: f64,
    /// Light of the ring.
    pub ring: f64,
    /// Light of the inner disc.
    pub inside: f64,
    /// Relative change of the light over the window's width, across and down.
    pub shading: [f64; 2],
    /// Where the sheet ends, if it does within reach.
    pub sheet: Option<SheetEnd>,
}

pub(super) type Vector = SVector<f64, PARAMETERS>;
pub(super) type Matrix = SMatrix<f64, PARAMETERS, PARAMETERS>;

impl RingModel {
    pub(super) fn parameters(&self) -> Vector {
        let mut p = Vector::zeros();
        p.as_mut_slice()[..SHAPE_PARAMETERS].copy_from_slice(&self.shape.parameters());
        // by its square: the picture changes with that, from zero on
        p[BLUR] = self.blur.size_px * self.blur.size_px;
        p[PAPER] = self.paper;
        p[RING] = self.ring;
        p[INSIDE] = self.inside;
        p[SHADING] = self.shading[0];
        p[SHADING + 1] = self.shading[1];
        if let Some(end) = &self.sheet {
            p.as_mut_slice()[SHEET..].copy_from_slice(&end.parameters());
        }
        p
    }

    /// How many parameters it has: the first of all.
    pub(super) fn count(&self) -> usize {
        RING_PARAMETERS + self.sheet.map_or(0, |end| end.count())
    }

    /// This model with other parameters; what kind of blur it has stays.
    pub(super) fn with_parameters(&self, p: &Vector) -> Self {
        let mut shape = [0.0; SHAPE_PARAMETERS];
        shape.copy_from_slice(&p.as_slice()[..SHAPE_PARAMETERS]);
        Self {
            shape: Shape::from_parameters(&shape),
            blur: Blur {
                size_px: p[BLUR].max(0.0).sqrt(),
                ..self.blur
            },
            paper: p[PAPER],
            ring: p[RING],
            inside: p[INSIDE],
            shading: [p[SHADING], p[SHADING + 1]],
            sheet: self
                .sheet
                .map(|end| end.with_parameters(&p.as_slice()[SHEET..])),
        }
    }

    /// What turns a change by the blur's size in pixels of the grid into one by its square in frame pixels.
    pub(super) fn by_blur(&self, grid: &Grid) -> f64 {
        let least = self.blur.least_size() * grid.pixel_px;
        0.5 / (self.blur.size_px.max(least) * grid.pixel_px)
    }

    /// Contrast of inner disc and ring over that of paper and ring: 1 where the disc shows the paper.
    pub fn inner_over_outer(&self) -> f64 {
        (self.inside - self.ring) / (self.paper - self.ring)
    }

    /// Contrasts across the outer and the inner circle.
    pub(super) fn contrasts(&self) -> Contrasts {
        [self.ring - self.paper, self.inside - self.ring]
    }

    /// The shading along one row.
    pub(super) fn shades(&self, grid: &Grid, row: usize) -> impl Iterator<Item = f32> + use<> {
        let shades = Shades::new(self, grid, row);
        (0..grid.stride()).map(move |i| shades.at(i))
    }

    /// Light of the pixels of one row, from the coverages of both circles there and what is missing of the sheet.
    #[inline(always)]
    pub(super) fn light(
        &self,
        grid: &Grid,
        row: usize,
        [outer, inner]: [&[f32]; 2],
        sheet: &mut SheetRow,
        out: &mut [f32],
    ) {
        let shades = Shades::new(self, grid, row);
        let paper = self.paper as f32;
        let [dark, light] = self.contrasts().map(|c| c as f32);
        let (outer, inner) = (&outer[..out.len()], &inner[..out.len()]);
        for (i, out) in out.iter_mut().enumerate() {
            *out = (paper + dark * outer[i] + light * inner[i]) * shades.at(i);
        }
        if let Some(end) = &self.sheet {
            sheet.fill(end, &self.blur, grid, row);
            let step = (end.beyond - self.paper) as f32;
            for (i, out) in out.iter_mut().enumerate() {
                *out += step * sheet.missing[i] * shades.at(i);
            }
        }
    }
}

/// The shading along one row.
#[derive(Clone, Copy)]
struct Shades {
    begin: f32,
    slope: f32,
    u0: f32,
    step: f32,
    v: f32,
}

impl Shades {
    #[inline(always)]
    fn new(model: &RingModel, grid: &Grid, row: usize) -> Self {
        let width = grid.width as f64;
        let v = (row as f64 - 0.5 * (grid.height as f64 - 1.0)) / width;
        let u0 = -0.5 * (width - 1.0) / width;
        let [across, down] = model.shading;
        Self {
            begin: (1.0 + across * u0 + down * v) as f32,
            slope: (across / width) as f32,
            u0: u0 as f32,
            step: (1.0 / width) as f32,
            v: v as f32,
        }
    }

    #[inline(always)]
    fn at(&self, column: usize) -> f32 {
        self.begin + self.slope * column as f32
    }

    #[inline(always)]
    fn across(&self, column: usize) -> f32 {
        self.u0 + self.step * column as f32
    }
}

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
    /// Shade times weight of each pixel of a row.
    shades: Vec<f32>,
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

    /// The same of the last row, to be written.
    #[inline(always)]
    fn last_mut(&mut self, k: usize) -> &mut [f32] {
        let begin = (k * TOGETHER + self.rows - 1) * self.stride;
        &mut self.data[begin..begin + self.stride]
    }

    /// Fills in all derivatives of one more row. Those by shape and blur come from the coverage's changes, those by the levels from its
    /// circles.
    #[inline(always)]
    pub(super) fn fill(
        &mut self,
        model: &RingModel,
        grid: &Grid,
        row: usize,
        coverage: &Coverage,
        weights: &[f32],
    ) {
        let stride = grid.stride();
        self.stride = stride;
        self.parameters = model.count();
        self.rows += 1;
        self.data
            .resize(TOGETHER * stride * (self.parameters + 1), 0.0);
        self.shades.resize(stride, 0.0);
        let shades = Shades::new(model, grid, row);
        for (i, (shade, weight)) in self.shades.iter_mut().zip(weights).enumerate() {
            *shade = shades.at(i) * weight;
        }
        let by_blur = model.by_blur(grid) as f32;
        let span = row * stride..(row + 1) * stride;
        let pitch = TOGETHER * stride;
        let first = (self.rows - 1) * stride;
        let mut columns = self
            .data
            .chunks_exact_mut(pitch)
            .map(|column| &mut column[first..first + stride]);
        let shaded = &self.shades[..stride];
        for (k, plane) in coverage.changes.iter().enumerate() {
            let scale = if k == BLUR { by_blur } else { 1.0 };
            let Some(out) = columns.next() else { return };
            let changes = &plane[span.clone()];
            for ((out, change), shade) in out.iter_mut().zip(changes).zip(shaded) {
                *out = scale * change * shade;
            }
        }
        let outer = &coverage.circles[0][span.clone()];
        let inner = &coverage.circles[1][span];
        let [dark, light] = model.contrasts().map(|c| c as f32);
        let paper = model.paper as f32;
        let (Some(by_paper), Some(by_ring), Some(by_inside), Some(by_across), Some(by_down)) = (
            columns.next(),
            columns.next(),
            columns.next(),
            columns.next(),
            columns.next(),
        ) else {
            return;
        };
        for i in 0..stride {
            let shade = shaded[i];
            by_paper[i] = shade * (1.0 - outer[i]);
            by_ring[i] = shade * (outer[i] - inner[i]);
            by_inside[i] = shade * inner[i];
        }
        for i in 0..stride {
            let flat = (paper + dark * outer[i] + light * inner[i]) * weights[i];
            by_across[i] = flat * shades.across(i);
            by_down[i] = flat * shades.v;
        }
        if let Some(end) = &model.sheet {
            self.sheet.fill(end, &model.blur, grid, row);
            self.add_sheet((end.beyond - model.paper) as f32, &shades, weights);
        }
    }

    /// Adds what the sheet's end changes in the derivatives of the ring's parameters, and fills in its own.
    fn add_sheet(&mut self, step: f32, shades: &Shades, weights: &[f32]) {
        let sheet = std::mem::take(&mut self.sheet);
        for k in SHEET..self.parameters {
            self.last_mut(k).fill(0.0);
        }
        let mut add = |k: usize, of: &dyn Fn(usize) -> f32| {
            let column = self.last_mut(k).iter_mut();
            for (i, (out, weight)) in column.zip(weights).enumerate() {
                *out += weight * of(i);
            }
        };
        add(BLUR, &|i| step * sheet.by_blur[i] * shades.at(i));
        add(PAPER, &|i| -sheet.missing[i] * shades.at(i));
        add(SHADING, &|i| step * sheet.missing[i] * shades.across(i));
        add(SHADING + 1, &|i| step * sheet.missing[i] * shades.v);
        add(SHEET, &|i| sheet.missing[i] * shades.at(i));
        let edges = self.parameters - SHEET - 1;
        for (k, by) in sheet.by_edge[..edges].iter().enumerate() {
            let column = self.last_mut(SHEET + 1 + k).iter_mut();
            for (i, (out, weight)) in column.zip(weights).enumerate() {
                *out += weight * step * by[i] * shades.at(i);
            }
        }
        self.sheet = sheet;
    }

    /// Replaces what the last row says of one pixel.
    pub(super) fn set_pixel(&mut self, i: usize, derivatives: &[f64], residual: f64) {
        for (k, derivative) in derivatives.iter().enumerate() {
            self.last_mut(k)[i] = *derivative as f32;
        }
        let residuals = self.parameters;
        self.last_mut(residuals)[i] = residual as f32;
    }

    /// The residuals of the last row, and room for what is missing of the sheet.
    pub(super) fn residuals_mut(&mut self) -> (&mut [f32], &mut SheetRow) {
        let begin = (self.parameters * TOGETHER + self.rows - 1) * self.stride;
        let residuals = &mut self.data[begin..begin + self.stride];
        (residuals, &mut self.sheet)
    }
}
