//! How much of each pixel's light comes from inside the two circles of a ring, after blur and pixel integration, and how that
//! changes with the ring's parameters.
//!
//! Every node of an outline (`boundary`) lays a stamp on the pixels that its kernel reaches: `gaussian` and `disc` make the
//! stamps. Pixels to the right of a stamp all get the same; that is noted once at its end (`steps`) and summed along the
//! rows when all stamps are laid. Rows are padded so that stamps have whole vectors of pixels.

use super::blur::{Blur, Psf};
use super::boundary::{Node, trace};
use super::shape::{SHAPE_PARAMETERS, Shape};
use super::window::Grid;
use super::{disc, gaussian};

/// Pixels that are computed at once; stamps are padded to whole multiples.
pub(super) const LANES: usize = 8;
/// What a ring changes with: its shape, then its blur.
pub(super) const COVERAGE_PARAMETERS: usize = SHAPE_PARAMETERS + 1;

/// One picture of the window, rows padded.
type Plane = Vec<f32>;

/// The coverages of a ring over a window, to be filled again and again.
#[derive(Debug, Clone, Default)]
pub(super) struct Coverage {
    width: usize,
    height: usize,
    stride: usize,
    /// By the outer and the inner circle.
    pub(super) circles: [Plane; 2],
    /// Change of the grey by each parameter, for the contrasts it was computed with.
    pub(super) changes: [Plane; COVERAGE_PARAMETERS],
    /// What begins at a pixel and holds for the rest of its row: coverage, and its change by the blur.
    steps: [Plane; 2],
    nodes: Vec<Node>,
    room: Room,
}

/// Room for the stamps of one node.
#[derive(Debug, Clone, Default)]
pub(super) struct Room {
    pub(super) gaussian: gaussian::Room,
    pub(super) disc: disc::Room,
}

/// Contrasts across the two circles: ring minus paper, inside minus ring.
pub(super) type Contrasts = [f64; 2];

impl Coverage {
    /// Makes room for a window.
    pub(super) fn fit_to(&mut self, grid: &Grid) {
        self.width = grid.width;
        self.height = grid.height;
        self.stride = grid.stride();
    }

    /// Coverages of the two circles of a ring of inner over outer radius `ratio`, on top of what `base` holds (of the rings around
    /// it); `None` where they are no ellipses. With `contrasts` also the changes of the grey.
    #[inline(always)]
    pub(super) fn fill(
        &mut self,
        grid: &Grid,
        (shape, blur): (&Shape, &Blur),
        ratio: f64,
        contrasts: Option<Contrasts>,
        base: Option<&[Plane; 2]>,
    ) -> Option<()> {
        self.fit_to(grid);
        let size = self.stride * self.height;
        if contrasts.is_some() {
            for plane in &mut self.changes {
                clear(plane, size);
            }
            clear(&mut self.steps[1], size);
        }
        for (circle, radius) in [1.0, ratio].into_iter().enumerate() {
            clear(&mut self.circles[circle], size);
            clear(&mut self.steps[0], size);
            let spacing = match blur.psf {
                Psf::Gaussian => gaussian::spacing(blur.size_px / grid.pixel_px),
                Psf::Disc => disc::spacing(blur.size_px / grid.pixel_px),
            };
            let mut nodes = std::mem::take(&mut self.nodes);
            let traced = trace(&mut nodes, grid, shape, radius, spacing);
            let contrast = contrasts.map(|both| both[circle] as f32);
            if traced.is_some() {
                self.stamp(&nodes, grid, circle, blur, contrast);
                self.sum_steps(circle);
            }
            self.nodes = nodes;
            traced?;
            if let Some(base) = base {
                let own = self.circles[circle].iter_mut();
                own.zip(&base[circle]).for_each(|(own, base)| *own += base);
            }
        }
        if contrasts.is_some() {
            let steps = &self.steps[1];
            sum_rows(&mut self.changes[SHAPE_PARAMETERS], steps, self.stride);
        }
        Some(())
    }

    #[inline(always)]
    fn stamp(
        &mut self,
        nodes: &[Node],
        grid: &Grid,
        circle: usize,
        blur: &Blur,
        contrast: Option<f32>,
    ) {
        let size = blur.size_px / grid.pixel_px;
        let mut room = std::mem::take(&mut self.room);
        let mut target = Target {
            width: self.width,
            height: self.height,
            stride: self.stride,
            values: &mut self.circles[circle],
            changes: &mut self.changes,
            steps: &mut self.steps,
            contrast,
        };
        match blur.psf {
            Psf::Gaussian => gaussian::stamp(&mut target, nodes, size, &mut room.gaussian),
            Psf::Disc => disc::stamp(&mut target, nodes, size, &mut room.disc),
        }
        self.room = room;
    }

    #[inline(always)]
    fn sum_steps(&mut self, circle: usize) {
        sum_rows(&mut self.circles[circle], &self.steps[0], self.stride);
    }
}

fn clear(plane: &mut Plane, size: usize) {
    plane.clear();
    plane.resize(size, 0.0);
}

/// Adds to every pixel the steps of its row up to it; four rows side by side, because each sum waits for the one before.
#[inline(always)]
fn sum_rows(plane: &mut [f32], steps: &[f32], stride: usize) {
    let mut rows = plane.chunks_exact_mut(4 * stride);
    let mut row_steps = steps.chunks_exact(4 * stride);
    for (four, steps) in (&mut rows).zip(&mut row_steps) {
        let mut sums = [0.0_f32; 4];
        for x in 0..stride {
            for (k, sum) in sums.iter_mut().enumerate() {
                *sum += steps[k * stride + x];
                four[k * stride + x] += *sum;
            }
        }
    }
    let rest = rows.into_remainder().chunks_exact_mut(stride);
    for (row, steps) in rest.zip(row_steps.remainder().chunks_exact(stride)) {
        let mut sum = 0.0;
        for (pixel, step) in row.iter_mut().zip(steps) {
            sum += step;
            *pixel += sum;
        }
    }
}

/// Where the stamps of one outline go.
pub(super) struct Target<'a> {
    pub(super) width: usize,
    pub(super) height: usize,
    stride: usize,
    values: &'a mut Plane,
    changes: &'a mut [Plane; COVERAGE_PARAMETERS],
    steps: &'a mut [Plane; 2],
    /// Contrast across the outline; `None` where no changes are wanted.
    pub(super) contrast: Option<f32>,
}

impl Target<'_> {
    /// Columns (padded to whole vectors) and rows that a kernel of this reach about a node touches; `None` where it touches none.
    /// All columns right of them get its steps.
    #[inline(always)]
    pub(super) fn reached(&self, node: &Node, reach: f32) -> Option<Reached> {
        let clamp = |v: f32, size: usize| v.clamp(0.0, size as f32) as usize;
        let first_row = clamp((node.y - reach).ceil(), self.height);
        let past_row = clamp((node.y + reach).floor() + 1.0, self.height);
        let first = clamp((node.x - reach).ceil(), self.width);
        let past = clamp((node.x + reach).floor() + 1.0, self.width);
        let empty = first_row >= past_row || node.x - reach > self.width as f32 - 1.0;
        (!empty).then(|| Reached {
            first_row,
            past_row,
            first,
            padded: past.saturating_sub(first).next_multiple_of(LANES),
        })
    }

    /// Adds the sum from the left: `factor` times `sum`, and `factor` times `total` to all beyond.
    #[inline(always)]
    pub(super) fn add_value(&mut self, at: Place, factor: f32, sum: &[f32], total: f32) {
        let start = at.row * self.stride + at.column;
        add(&mut self.values[start..start + sum.len()], factor, sum);
        self.step(0, start + sum.len(), at, sum.len(), factor * total);
    }

    /// The same for the change by the blur.
    #[inline(always)]
    pub(super) fn add_blur(&mut self, at: Place, factor: f32, sum: &[f32], total: f32) {
        let start = at.row * self.stride + at.column;
        let plane = &mut self.changes[SHAPE_PARAMETERS];
        add(&mut plane[start..start + sum.len()], factor, sum);
        self.step(1, start + sum.len(), at, sum.len(), factor * total);
    }

    /// Adds the kernel to the changes by the shape, `factor` times its weight for each parameter.
    #[inline(always)]
    pub(super) fn add_sweep(&mut self, at: Place, factor: f32, sweep: &[f32], kernel: &[f32]) {
        let start = at.row * self.stride + at.column;
        for (plane, weight) in self.changes[..SHAPE_PARAMETERS].iter_mut().zip(sweep) {
            add(&mut plane[start..start + kernel.len()], factor * weight, kernel);
        }
    }

    #[inline(always)]
    fn step(&mut self, which: usize, index: usize, at: Place, length: usize, value: f32) {
        if at.column + length < self.stride {
            self.steps[which][index] += value;
        }
    }
}

/// What a stamp touches.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reached {
    pub(super) first_row: usize,
    pub(super) past_row: usize,
    /// First column.
    pub(super) first: usize,
    /// Columns, a multiple of [`LANES`].
    pub(super) padded: usize,
}

/// Row and first column of one row of a stamp.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) row: usize,
    pub(super) column: usize,
}

#[inline(always)]
fn add(target: &mut [f32], factor: f32, source: &[f32]) {
    let sources = source.chunks_exact(LANES);
    for (target, source) in target.chunks_exact_mut(LANES).zip(sources) {
        for (t, s) in target.iter_mut().zip(source) {
            *t += factor * s;
        }
    }
}
