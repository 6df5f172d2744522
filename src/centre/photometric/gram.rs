//! Sums of products over pixels: the normal matrix and the gradient of a least-squares fit.
//!
//! Pixels come a few rows at a time in `f32`, as many at once as the machine's vectors hold; after a few rows the sums go on in
//! `f64`, so that their error stays that of a few dozen additions.

use super::coverage::LANES;
use super::model::{Matrix, PARAMETERS, Vector};
use super::rows::Rows;
use pulp::{Arch, Simd, WithSimd};

/// Columns of a row at most: the parameters and the residuals.
const COLUMNS: usize = PARAMETERS + 1;
/// Columns that are multiplied with one another at once.
const TILE: usize = 4;
const TILES: usize = COLUMNS.div_ceil(TILE);
/// Visits between two transfers to `f64`.
const VISITS: usize = 4;
/// Numbers in the widest vectors of any machine.
pub(super) const WIDEST: usize = 16;

type Lanes = [f32; LANES];

/// Sums of products of all pairs of columns.
#[derive(Debug, Clone)]
pub(super) struct Gram {
    /// A vector for each pair of a tile's columns, tile after tile.
    tiles: Vec<f32>,
    sums: [[f64; COLUMNS]; COLUMNS],
    /// Columns of the rows that came.
    columns: usize,
    visits: usize,
    /// Numbers in a vector.
    lanes: usize,
}

impl Gram {
    pub(super) fn new() -> Self {
        Self {
            tiles: vec![0.0; TILES * (TILES + 1) / 2 * TILE * TILE * WIDEST],
            sums: [[0.0; COLUMNS]; COLUMNS],
            columns: 0,
            visits: 0,
            lanes: 1,
        }
    }

    pub(super) fn add(&mut self, rows: &Rows) {
        self.columns = rows.parameters + 1;
        let tiles = &mut self.tiles;
        self.lanes = Arch::new().dispatch(AddProducts { tiles, rows });
        self.visits += 1;
        if self.visits == VISITS {
            self.transfer();
        }
    }

    fn transfer(&mut self) {
        let lanes = self.lanes;
        let mut tiles = self.tiles.chunks_exact_mut(TILE * TILE * lanes);
        for a in 0..self.columns.div_ceil(TILE) {
            for b in 0..=a {
                let Some(tile) = tiles.next() else { return };
                for (ij, vector) in tile.chunks_exact(lanes).enumerate() {
                    let (i, j) = (a * TILE + ij / TILE, b * TILE + ij % TILE);
                    if j <= i && i < self.columns {
                        self.sums[i][j] += f64::from(vector.iter().sum::<f32>());
                    }
                }
                tile.fill(0.0);
            }
        }
        self.visits = 0;
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

/// Adds the products of all columns of some rows to the tiles; says how many numbers a vector holds.
struct AddProducts<'a> {
    tiles: &'a mut [f32],
    rows: &'a Rows,
}

impl WithSimd for AddProducts<'_> {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> usize {
        let lanes = S::F32_LANES;
        let last = self.rows.parameters;
        let columns = |tile: usize| -> [&[S::f32s]; TILE] {
            // beyond the last column its products are formed again, and not used
            std::array::from_fn(|i| {
                S::as_simd_f32s(self.rows.column((tile * TILE + i).min(last))).0
            })
        };
        let mut tiles = self.tiles.chunks_exact_mut(TILE * TILE * lanes);
        for a in 0..(last + 1).div_ceil(TILE) {
            for b in 0..=a {
                let Some(tile) = tiles.next() else { break };
                add_tile(simd, S::as_mut_simd_f32s(tile).0, columns(a), columns(b));
            }
        }
        lanes
    }
}

#[inline(always)]
fn add_tile<S: Simd>(
    simd: S,
    tile: &mut [S::f32s],
    left: [&[S::f32s]; TILE],
    right: [&[S::f32s]; TILE],
) {
    let count = left[0].len();
    let (left, right) = (left.map(|c| &c[..count]), right.map(|c| &c[..count]));
    let mut sums = [[simd.splat_f32s(0.0); TILE]; TILE];
    for k in 0..count {
        let right = right.map(|column| column[k]);
        for (sums, left) in sums.iter_mut().zip(left) {
            for (sum, right) in sums.iter_mut().zip(right) {
                *sum = simd.mul_add_e_f32s(left[k], right, *sum);
            }
        }
    }
    for (total, sum) in tile.iter_mut().zip(sums.into_iter().flatten()) {
        *total = simd.add_f32s(*total, sum);
    }
}

/// Sums of the products of residuals and derivatives: the gradient alone.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gradient {
    lanes: [Lanes; COLUMNS],
    sums: [f64; COLUMNS],
    parameters: usize,
    visits: usize,
}

impl Gradient {
    pub(super) fn new() -> Self {
        Self {
            lanes: [[0.0; LANES]; COLUMNS],
            sums: [0.0; COLUMNS],
            parameters: 0,
            visits: 0,
        }
    }

    #[inline(always)]
    pub(super) fn add(&mut self, rows: &Rows) {
        self.parameters = rows.parameters;
        let residuals = rows.column(rows.parameters);
        for (k, sums) in self.lanes.iter_mut().enumerate().take(rows.parameters + 1) {
            let mut lanes = *sums;
            let chunks = rows.column(k).chunks_exact(LANES);
            for (column, residuals) in chunks.zip(residuals.chunks_exact(LANES)) {
                for i in 0..LANES {
                    lanes[i] += column[i] * residuals[i];
                }
            }
            *sums = lanes;
        }
        self.visits += 1;
        if self.visits == VISITS {
            self.transfer();
        }
    }

    fn transfer(&mut self) {
        for (sum, lanes) in self.sums.iter_mut().zip(&mut self.lanes) {
            *sum += f64::from(lanes.iter().sum::<f32>());
            *lanes = [0.0; LANES];
        }
        self.visits = 0;
    }

    /// The gradient and the sum of squared residuals.
    pub(super) fn finish(mut self) -> (Vector, f64) {
        self.transfer();
        let count = self.parameters;
        let gradient = Vector::from_fn(|i, _| if i < count { self.sums[i] } else { 0.0 });
        (gradient, self.sums[count])
    }
}
