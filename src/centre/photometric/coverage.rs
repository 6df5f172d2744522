//! How much of each pixel's light comes from inside a circle's image, after blur and pixel integration, and its derivatives.
//!
//! The blurred indicator of a region is an integral over its horizontal chords. Either end of a chord changes the pixels
//! near it and adds the same to all pixels beyond: `gaussian` and `disc` say what, each for its kernel. What is
//! the same for all pixels beyond an end is noted once and summed along the rows at the end.

use super::blur::{Blur, Psf};
use super::outline::{MOMENTS, Outline, TRANSPOSED};
use super::shape::{SHAPE_PARAMETERS, Shape};
use super::window::Grid;
use super::{disc, gaussian};

/// Derivatives of a coverage: with respect to the shape's parameters, then the blur.
pub(super) const COVERAGE_PARAMETERS: usize = SHAPE_PARAMETERS + 1;

/// What a pixel holds: the coverage, its derivative by the blur, the moments of the outline it sees.
pub(super) const VALUE: usize = 0;
pub(super) const BLUR: usize = 1;
const OUTLINE: usize = 2;

/// The coverage alone.
pub(super) type Values = Coverage<1>;
/// The coverage and all derivatives: a cache line a pixel.
pub(super) type WithDerivatives = Coverage<{ OUTLINE + MOMENTS }>;

/// Coverage of every pixel of a window, to be filled again and again.
#[derive(Debug, Clone, Default)]
pub(super) struct Coverage<const N: usize> {
    /// Row by row.
    cells: Vec<[f64; N]>,
    /// What begins at a pixel and holds for the rest of its row: coverage and derivative by the blur. A row has one more than pixels.
    steps: Vec<[f64; 2]>,
    /// Derivatives by the shape's parameters from the moments.
    derivatives: [[f64; MOMENTS]; SHAPE_PARAMETERS],
    width: usize,
    /// Room for a kernel's second pass.
    spare: Option<Box<Self>>,
}

impl<const N: usize> Coverage<N> {
    /// Computes the coverage by the circle of `radius` (in outer radii) of `shape`; `None` where that is no ellipse.
    pub(super) fn fill(
        &mut self,
        grid: &Grid,
        shape: &Shape,
        radius: f64,
        blur: &Blur,
    ) -> Option<()> {
        let outline = Outline::new(shape, radius)?;
        self.clear(grid);
        self.derivatives = outline.derivatives();
        match blur.psf {
            Psf::Gaussian => gaussian::cover(self, grid, &outline, blur.size_px),
            Psf::Disc => disc::cover(self, grid, &outline, blur.size_px),
        }
        Some(())
    }

    /// Makes it zero over a window.
    pub(super) fn clear(&mut self, grid: &Grid) {
        self.width = grid.width;
        self.cells.clear();
        self.cells.resize(grid.width * grid.height, [0.0; N]);
        self.steps.clear();
        self.steps.resize((grid.width + 1) * grid.height, [0.0; 2]);
    }

    /// Pixels of a row.
    pub(super) fn row(&mut self, row: usize) -> Row<'_, N> {
        Row {
            cells: &mut self.cells[row * self.width..(row + 1) * self.width],
            steps: &mut self.steps[row * (self.width + 1)..(row + 1) * (self.width + 1)],
        }
    }

    /// Sums what holds for the rest of the rows.
    pub(super) fn sum_steps(&mut self) {
        let width = self.width.max(1);
        let rows = self.cells.chunks_exact_mut(width);
        for (cells, steps) in rows.zip(self.steps.chunks_exact(width + 1)) {
            let mut sum = [0.0; 2];
            for (cell, step) in cells.iter_mut().zip(steps) {
                sum[0] += step[0];
                cell[VALUE] += sum[0];
                if N > 1 {
                    sum[1] += step[1];
                    cell[BLUR] += sum[1];
                }
            }
        }
    }

    /// A coverage to work with, whatever is in it; [`Self::keep_spare`] brings it back.
    pub(super) fn take_spare(&mut self) -> Box<Self> {
        self.spare.take().unwrap_or_default()
    }

    /// Keeps the room of a coverage for later.
    pub(super) fn keep_spare(&mut self, spare: Box<Self>) {
        self.spare = Some(spare);
    }

    /// Takes the pixels of which `wanted` says yes (row, column) from the coverage of the transposed window.
    pub(super) fn take_transposed(&mut self, other: &Self, wanted: impl Fn(usize, usize) -> bool) {
        for (row, cells) in self.cells.chunks_exact_mut(self.width.max(1)).enumerate() {
            for (column, cell) in cells.iter_mut().enumerate() {
                if wanted(row, column) {
                    *cell = other.cells[column * other.width + row];
                    if N > 1 {
                        let moments: [f64; MOMENTS] =
                            std::array::from_fn(|k| cell[OUTLINE + TRANSPOSED[k]]);
                        cell[OUTLINE..].copy_from_slice(&moments);
                    }
                }
            }
        }
    }

    /// All pixels, row by row.
    pub(super) fn cells_mut(&mut self) -> &mut [[f64; N]] {
        &mut self.cells
    }

    /// The coverage of a pixel.
    pub(super) fn value(&self, pixel: usize) -> f64 {
        self.cells[pixel][VALUE]
    }
}

impl WithDerivatives {
    /// Whether a pixel's coverage depends on anything: it sees a part of the outline.
    pub(super) fn sees_outline(&self, pixel: usize) -> bool {
        self.cells[pixel][OUTLINE] != 0.0
    }

    /// Adds the derivatives of a pixel's coverage times a factor.
    pub(super) fn add_derivatives(
        &self,
        pixel: usize,
        factor: f64,
        sums: &mut [f64; COVERAGE_PARAMETERS],
    ) {
        let cell = &self.cells[pixel];
        if cell[OUTLINE] == 0.0 {
            return;
        }
        let moments: [f64; MOMENTS] = std::array::from_fn(|k| factor * cell[OUTLINE + k]);
        for (sum, factors) in sums.iter_mut().zip(&self.derivatives) {
            for (factor, moment) in factors.iter().zip(&moments) {
                *sum += factor * moment;
            }
        }
        sums[SHAPE_PARAMETERS] += factor * cell[BLUR];
    }
}

/// One row of a coverage.
pub(super) struct Row<'a, const N: usize> {
    pub(super) cells: &'a mut [[f64; N]],
    pub(super) steps: &'a mut [[f64; 2]],
}

/// Adds the moments of an outline, `share` of them.
pub(super) fn add_moments<const N: usize>(
    cell: &mut [f64; N],
    share: f64,
    moments: &[f64; MOMENTS],
) {
    for (sum, moment) in cell[OUTLINE..].iter_mut().zip(moments) {
        *sum += share * moment;
    }
}
