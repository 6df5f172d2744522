//! Lays the stamps of an outline's nodes.
//!
//! They are laid in strips as wide as a vector of pixels: all stamps of a kernel are equally high, so that those which reach
//! a row of the strip follow one another in the order of their first rows, and the sums over them stay in registers. Pixels
//! to the right of a stamp all get the same: that is summed once for each vector.

use super::boundary::Node;
use super::coverage::{COVERAGE_PARAMETERS, LANES, Lanes, Plane};
use super::shape::SHAPE_PARAMETERS;
use super::window::Grid;

/// Where a node's stamp lies: rows and vectors of pixels, and where its rows begin in the kernel's table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stamp {
    pub(super) rows: (usize, usize),
    pub(super) vectors: (usize, usize),
    pub(super) table: usize,
}

/// A blur's stamps of the nodes of one outline.
pub(super) trait Kernel {
    /// One row of a node's stamp.
    type Row: Copy;
    /// A node's part in one vector of pixels.
    type Part: Copy;

    /// How close the nodes of an outline must be for a kernel of this size, both in pixels of the grid.
    fn spacing(size: f64) -> f64;

    /// Takes its size (pixels of the grid) and computes the stamps of these nodes.
    fn prepare(&mut self, grid: &Grid, nodes: &[Node], size: f64);

    /// The stamps, one for each node; all of them are equally high where the window does not cut them off.
    fn stamps(&self) -> &[Stamp];

    /// Row `at` of the kernel's table.
    fn row(&self, at: usize) -> Self::Row;

    /// What a node lays on a vector of pixels, as far as it is the same in all rows.
    fn part(&self, node: &Node, j: usize, vector: usize) -> Self::Part;

    /// Sum of the kernel from the left over a vector of pixels, times the node's rise.
    fn sum(&self, row: &Self::Row, part: &Self::Part) -> Lanes;

    /// Sum from the left, the kernel itself, and the change of the sum by the blur's size; sums times the node's rise.
    fn all(&self, row: &Self::Row, part: &Self::Part) -> [Lanes; 3];

    /// What every pixel beyond the stamp gets: of the sum, and of its change.
    fn beyond(&self, row: &Self::Row) -> [f32; 2];
}

/// The rows and vectors of pixels within `reach` of a node; pixels to the left of them get nothing, those to the right all.
#[inline(always)]
pub(super) fn touched(node: &Node, reach: f32, grid: &Grid, table: usize) -> Stamp {
    let within = |at: f32, most: f32| {
        let first = (at - reach).ceil().clamp(0.0, most) as usize;
        let past = ((at + reach).floor() + 1.0).clamp(0.0, most) as usize;
        (first, past.max(first))
    };
    let (left, right) = within(node.x, grid.stride() as f32);
    let first = (left / LANES).min(grid.stride() / LANES);
    Stamp {
        rows: within(node.y, grid.height as f32),
        vectors: (first, right.div_ceil(LANES).max(first)),
        table,
    }
}

/// Room for what the stamps of an outline add up to.
#[derive(Debug, Clone, Default)]
pub(super) struct Room {
    /// What the pixels to the right of the stamps that end before a vector get, of the sum and of its change; row by row.
    beyond: Vec<[f32; 2]>,
    /// The nodes in the order in which their stamps begin.
    order: Vec<usize>,
}

/// One circle of a ring, to be drawn on a window.
pub(super) struct Outline<'a> {
    pub(super) nodes: &'a [Node],
    pub(super) room: &'a mut Room,
    pub(super) grid: &'a Grid,
}

impl Outline<'_> {
    /// Adds the coverage by the circle to the first of the planes, and its changes to the others.
    #[inline(always)]
    pub(super) fn cover<K: Kernel>(
        self,
        kernel: &mut K,
        size: f64,
        (values, changes): (&mut Plane, &mut [Plane; COVERAGE_PARAMETERS]),
        contrast: Option<f32>,
    ) {
        let (nodes, grid) = (self.nodes, self.grid);
        kernel.prepare(grid, nodes, size);
        self.room.sum_beyond(kernel, nodes, grid);
        let mut strip = Strip {
            kernel: &*kernel,
            grid,
            beyond: &self.room.beyond,
            laid: Vec::new(),
            vector: 0,
        };
        for vector in 0..grid.stride() / LANES {
            strip.collect(nodes, &self.room.order, vector);
            match contrast {
                None => strip.lay_sums(values),
                Some(contrast) => strip.lay_all(values, changes, contrast),
            }
        }
    }
}

impl Room {
    /// Sorts the nodes and adds up what pixels beyond the stamps get.
    #[inline(always)]
    fn sum_beyond<K: Kernel>(&mut self, kernel: &K, nodes: &[Node], grid: &Grid) {
        let vectors = grid.stride() / LANES;
        self.beyond.clear();
        self.beyond.resize((vectors + 1) * grid.height, [0.0; 2]);
        let stamps = kernel.stamps();
        for (node, stamp) in nodes.iter().zip(stamps) {
            let (first, past) = stamp.rows;
            for (i, row) in (first..past).enumerate() {
                let [sum, change] = kernel.beyond(&kernel.row(stamp.table + i));
                let at = &mut self.beyond[row * (vectors + 1) + stamp.vectors.1];
                at[0] += node.rise * sum;
                at[1] += node.rise * change;
            }
        }
        for row in self.beyond.chunks_exact_mut(vectors + 1) {
            let mut total = [0.0_f32; 2];
            for at in row {
                total = [total[0] + at[0], total[1] + at[1]];
                *at = total;
            }
        }
        self.order.clear();
        self.order
            .extend((0..stamps.len()).filter(|&j| stamps[j].rows.0 < stamps[j].rows.1));
        self.order.sort_unstable_by_key(|&j| (stamps[j].rows, j));
    }
}

/// A node whose stamp reaches a strip.
#[derive(Clone, Copy)]
struct Laid<P> {
    /// Its rows in the window.
    rows: (usize, usize),
    /// What leads from a row of the window to the row of the kernel's table (it may wrap around).
    table: usize,
    part: P,
    sweep: [f32; SHAPE_PARAMETERS],
}

/// One vector wide, as high as the window.
struct Strip<'a, K: Kernel> {
    kernel: &'a K,
    grid: &'a Grid,
    beyond: &'a [[f32; 2]],
    vector: usize,
    /// The nodes that reach it, in the order of their first rows.
    laid: Vec<Laid<K::Part>>,
}

impl<K: Kernel> Strip<'_, K> {
    /// Moves to a vector of pixels.
    #[inline(always)]
    fn collect(&mut self, nodes: &[Node], order: &[usize], vector: usize) {
        let stamps = self.kernel.stamps();
        self.vector = vector;
        self.laid.clear();
        for &j in order {
            let (stamp, node) = (&stamps[j], &nodes[j]);
            if stamp.vectors.0 <= vector && vector < stamp.vectors.1 {
                self.laid.push(Laid {
                    rows: stamp.rows,
                    table: stamp.table.wrapping_sub(stamp.rows.0),
                    part: self.kernel.part(node, j, vector),
                    sweep: node.sweep,
                });
            }
        }
    }

    /// Calls `visit` with every row that is not empty: where it is in a plane, the nodes that reach it, and what lies beyond others.
    #[inline(always)]
    fn for_each_row(&self, mut visit: impl FnMut(usize, usize, &[Laid<K::Part>], [f32; 2])) {
        let stride = self.grid.stride();
        let vectors = stride / LANES;
        let (mut first, mut past) = (0, 0);
        for i in 0..self.grid.height {
            while past < self.laid.len() && self.laid[past].rows.0 <= i {
                past += 1;
            }
            while first < past && self.laid[first].rows.1 <= i {
                first += 1;
            }
            let beyond = self.beyond[i * (vectors + 1) + self.vector];
            if first < past || beyond != [0.0; 2] {
                let at = i * stride + self.vector * LANES;
                visit(i, at, &self.laid[first..past], beyond);
            }
        }
    }

    #[inline(always)]
    fn lay_sums(&self, values: &mut Plane) {
        self.for_each_row(
            #[inline(always)]
            |i, at, laid, beyond| {
                let mut total = [beyond[0]; LANES];
                for node in laid {
                    let row = self.kernel.row(node.table.wrapping_add(i));
                    let sum = self.kernel.sum(&row, &node.part);
                    for l in 0..LANES {
                        total[l] += sum[l];
                    }
                }
                add(&mut values[at..at + LANES], 1.0, &total);
            },
        );
    }

    #[inline(always)]
    fn lay_all(
        &self,
        values: &mut Plane,
        changes: &mut [Plane; COVERAGE_PARAMETERS],
        contrast: f32,
    ) {
        self.for_each_row(
            #[inline(always)]
            |i, at, laid, beyond| {
                let mut total = [beyond[0]; LANES];
                let mut by_blur = [beyond[1]; LANES];
                let mut by_shape = [[0.0_f32; LANES]; SHAPE_PARAMETERS];
                for node in laid {
                    let row = self.kernel.row(node.table.wrapping_add(i));
                    let [sum, share, change] = self.kernel.all(&row, &node.part);
                    for l in 0..LANES {
                        total[l] += sum[l];
                        by_blur[l] += change[l];
                    }
                    for (by, sweep) in by_shape.iter_mut().zip(&node.sweep) {
                        for l in 0..LANES {
                            by[l] += sweep * share[l];
                        }
                    }
                }
                add(&mut values[at..at + LANES], 1.0, &total);
                for (plane, by) in changes.iter_mut().zip(&by_shape) {
                    add(&mut plane[at..at + LANES], contrast, by);
                }
                let by_size = &mut changes[SHAPE_PARAMETERS][at..at + LANES];
                add(by_size, contrast, &by_blur);
            },
        );
    }
}

#[inline(always)]
fn add(target: &mut [f32], factor: f32, source: &Lanes) {
    for (t, s) in target.iter_mut().zip(source) {
        *t += factor * s;
    }
}
