//! Sums of products over pixels: the normal matrix and the gradient of a least-squares fit.
//!
//! Pixels come row by row in `f32`, 8 at once; after a few rows the sums go on in `f64`, so that their error stays that of a few
//! hundred additions.

use super::coverage::LANES;
use super::model::{Matrix, PARAMETERS, Row, Vector};

/// Columns of a row at most: the parameters and the residuals.
const COLUMNS: usize = PARAMETERS + 1;
/// Columns that are multiplied with one another at once.
const TILE: usize = 4;
const TILES: usize = COLUMNS.div_ceil(TILE);
/// Rows between two transfers to `f64`.
const ROWS: usize = 8;

type Lanes = [f32; LANES];

/// Sums of products of all pairs of columns.
#[derive(Debug, Clone)]
pub(super) struct Gram {
    tiles: Vec<[[Lanes; TILE]; TILE]>,
    sums: [[f64; COLUMNS]; COLUMNS],
    /// Columns of the rows that came.
    columns: usize,
    rows: usize,
}

impl Gram {
    pub(super) fn new() -> Self {
        Self {
            tiles: vec![[[[0.0; LANES]; TILE]; TILE]; TILES * (TILES + 1) / 2],
            sums: [[0.0; COLUMNS]; COLUMNS],
            columns: 0,
            rows: 0,
        }
    }

    #[inline(always)]
    pub(super) fn add(&mut self, row: &Row) {
        self.columns = row.parameters + 1;
        let column = |k: usize| {
            let k = k.min(row.parameters);
            &row.data[k * row.stride..(k + 1) * row.stride]
        };
        let mut tiles = self.tiles.iter_mut();
        for a in 0..self.columns.div_ceil(TILE) {
            for b in 0..=a {
                let Some(tile) = tiles.next() else { return };
                add_tile(
                    tile,
                    std::array::from_fn(|i| column(a * TILE + i)),
                    std::array::from_fn(|i| column(b * TILE + i)),
                );
            }
        }
        self.rows += 1;
        if self.rows == ROWS {
            self.transfer();
        }
    }

    fn transfer(&mut self) {
        let mut tiles = self.tiles.iter_mut();
        for a in 0..self.columns.div_ceil(TILE) {
            for b in 0..=a {
                let Some(tile) = tiles.next() else { return };
                for (i, line) in tile.iter_mut().enumerate() {
                    for (j, lanes) in line.iter_mut().enumerate() {
                        let (i, j) = (a * TILE + i, b * TILE + j);
                        if i < self.columns && j < self.columns {
                            self.sums[i][j] += f64::from(lanes.iter().sum::<f32>());
                        }
                        *lanes = [0.0; LANES];
                    }
                }
            }
        }
        self.rows = 0;
    }

    /// Normal matrix (one on the diagonal for parameters that the rows do not have), gradient and sum of squared residuals.
    pub(super) fn finish(mut self) -> (Matrix, Vector, f64) {
        self.transfer();
        let count = self.columns.saturating_sub(1);
        let matrix = Matrix::from_fn(|i, j| match i.max(j) {
            most if most < count => self.sums[most][i.min(j)],
            _ if i == j => 1.0,
            _ => 0.0,
        });
        let residuals = &self.sums[count];
        let gradient = Vector::from_fn(|i, _| if i < count { residuals[i] } else { 0.0 });
        (matrix, gradient, residuals[count])
    }
}

#[inline(always)]
fn add_tile(tile: &mut [[Lanes; TILE]; TILE], left: [&[f32]; TILE], right: [&[f32]; TILE]) {
    let mut sums = *tile;
    let chunks = left[0].len() / LANES;
    for chunk in 0..chunks {
        let at = |column: &[f32]| -> Lanes {
            let mut lanes = [0.0; LANES];
            lanes.copy_from_slice(&column[chunk * LANES..(chunk + 1) * LANES]);
            lanes
        };
        let right: [Lanes; TILE] = right.map(at);
        for (sums, left) in sums.iter_mut().zip(left) {
            let left = at(left);
            for (sum, right) in sums.iter_mut().zip(&right) {
                for i in 0..LANES {
                    sum[i] += left[i] * right[i];
                }
            }
        }
    }
    *tile = sums;
}

/// Sums of the products of residuals and derivatives: the gradient alone.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gradient {
    lanes: [Lanes; COLUMNS],
    sums: [f64; COLUMNS],
    parameters: usize,
    rows: usize,
}

impl Gradient {
    pub(super) fn new() -> Self {
        Self {
            lanes: [[0.0; LANES]; COLUMNS],
            sums: [0.0; COLUMNS],
            parameters: 0,
            rows: 0,
        }
    }

    #[inline(always)]
    pub(super) fn add(&mut self, row: &Row) {
        self.parameters = row.parameters;
        let residuals = &row.data[row.parameters * row.stride..];
        for (sums, column) in self.lanes.iter_mut().zip(row.data.chunks_exact(row.stride)) {
            let mut lanes = *sums;
            let chunks = column.chunks_exact(LANES);
            for (column, residuals) in chunks.zip(residuals.chunks_exact(LANES)) {
                for i in 0..LANES {
                    lanes[i] += column[i] * residuals[i];
                }
            }
            *sums = lanes;
        }
        self.rows += 1;
        if self.rows == ROWS {
            self.transfer();
        }
    }

    fn transfer(&mut self) {
        for (sum, lanes) in self.sums.iter_mut().zip(&mut self.lanes) {
            *sum += f64::from(lanes.iter().sum::<f32>());
            *lanes = [0.0; LANES];
        }
        self.rows = 0;
    }

    /// The gradient and the sum of squared residuals.
    pub(super) fn finish(mut self) -> (Vector, f64) {
        self.transfer();
        let count = self.parameters;
        let gradient = Vector::from_fn(|i, _| if i < count { self.sums[i] } else { 0.0 });
        (gradient, self.sums[count])
    }
}
