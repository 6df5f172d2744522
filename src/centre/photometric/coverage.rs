//! How much of each pixel's light comes from inside the two circles of a ring, after blur and pixel integration, and how that
//! changes with the ring's parameters.
//!
//! Every node of an outline (`boundary`) lays a stamp on the pixels that its kernel reaches: `gaussian` and `disc` know the
//! stamps. They are laid row by row and, in a row, vector by vector of pixels, so that the sums over all nodes stay in
//! registers. Pixels to the right of a stamp all get the same: that is summed once for each vector.

use super::blur::{Blur, Psf};
use super::boundary::{Node, trace};
use super::disc::Disc;
use super::gaussian::Gaussian;
use super::shape::{SHAPE_PARAMETERS, Shape};
use super::window::Grid;

/// Pixels that are computed at once; rows are padded to whole multiples.
pub(super) const LANES: usize = 8;
/// A vector of pixels.
pub(super) type Lanes = [f32; LANES];
/// What a ring changes with: its shape, then its blur.
pub(super) const COVERAGE_PARAMETERS: usize = SHAPE_PARAMETERS + 1;

/// A disc of a smaller radius (pixels of the grid) is a Gaussian of the same spread, within 6e-3: the pixel's own box hides the rest.
const SMALL_DISC: f64 = 0.75;

/// One picture of the window, rows padded.
pub(super) type Plane = Vec<f32>;

/// Contrasts across the two circles: ring minus paper, inside minus ring.
pub(super) type Contrasts = [f64; 2];

/// The coverages of a ring over a window, to be filled again and again.
#[derive(Debug, Clone, Default)]
pub(super) struct Coverage {
    /// By the outer and the inner circle.
    pub(super) circles: [Plane; 2],
    /// Change of the grey by each parameter, for the contrasts it was computed with.
    pub(super) changes: [Plane; COVERAGE_PARAMETERS],
    nodes: Vec<Node>,
    gaussian: Gaussian,
    disc: Disc,
}

impl Coverage {
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
        let size = grid.stride() * grid.height;
        for (circle, plane) in self.circles.iter_mut().enumerate() {
            plane.clear();
            match base {
                Some(base) => plane.extend_from_slice(&base[circle]),
                None => plane.resize(size, 0.0),
            }
        }
        if contrasts.is_some() {
            for plane in &mut self.changes {
                plane.clear();
                plane.resize(size, 0.0);
            }
        }
        let kernel_size = blur.size_px / grid.pixel_px;
        let (psf, kernel_size, growth) = match blur.psf {
            Psf::Disc if kernel_size < SMALL_DISC => (Psf::Gaussian, 0.5 * kernel_size, 0.5),
            psf => (psf, kernel_size, 1.0),
        };
        for (circle, radius) in [1.0, ratio].into_iter().enumerate() {
            let contrast = contrasts.map(|both| both[circle] as f32);
            let (nodes, planes) = (
                &mut self.nodes,
                (&mut self.circles[circle], &mut self.changes),
            );
            let circle = (shape, radius);
            match psf {
                Psf::Gaussian => {
                    cover(
                        &mut self.gaussian,
                        kernel_size,
                        nodes,
                        grid,
                        circle,
                        planes,
                        contrast,
                    )?;
                }
                Psf::Disc => {
                    cover(
                        &mut self.disc,
                        kernel_size,
                        nodes,
                        grid,
                        circle,
                        planes,
                        contrast,
                    )?;
                }
            }
        }
        if growth != 1.0 && contrasts.is_some() {
            let by_blur = self.changes[SHAPE_PARAMETERS].iter_mut();
            by_blur.for_each(|change| *change *= growth);
        }
        Some(())
    }
}

/// A blur's stamps of the nodes of one outline.
pub(super) trait Kernel {
    /// One row of a node's stamp.
    type Row: Copy;

    /// How close the nodes of an outline must be for a kernel of this size, both in pixels of the grid.
    fn spacing(size: f64) -> f64;

    /// Takes its size (pixels of the grid) and computes what the stamps of these nodes have in common.
    fn prepare(&mut self, grid: &Grid, nodes: &[Node], size: f64);

    /// The row of node `j`'s stamp in row `i` of the window, and the vectors of pixels it touches; `None` where it does not reach.
    fn row(&self, node: &Node, j: usize, i: usize) -> Option<(Self::Row, Reach)>;

    /// Sum of the kernel from the left over a vector of pixels.
    fn sum(&self, row: &Self::Row, node: &Node, j: usize, vector: usize) -> Lanes;

    /// Sum from the left, the kernel itself, and the change of the sum by the blur's size.
    fn all(&self, row: &Self::Row, node: &Node, j: usize, vector: usize) -> [Lanes; 3];

    /// What every pixel beyond the stamp gets: of the sum, and of its change.
    fn beyond(&self, row: &Self::Row) -> [f32; 2];
}

/// Vectors of pixels from `first` up to `past`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach {
    pub(super) first: usize,
    pub(super) past: usize,
}

/// Vectors of a row within `reach` of a column; those before get nothing, those behind all.
#[inline(always)]
pub(super) fn vectors_within(x: f32, reach: f32, vectors: usize) -> Reach {
    let most = (vectors * LANES) as f32;
    let first = ((x - reach).ceil().clamp(0.0, most) as usize / LANES).min(vectors);
    let past = ((x + reach).floor() + 1.0).clamp(0.0, most) as usize;
    Reach {
        first,
        past: past.div_ceil(LANES).max(first),
    }
}

/// Adds the coverage by one circle of a shape to the first of the planes, and its changes to the others.
#[inline(always)]
fn cover<K: Kernel>(
    kernel: &mut K,
    size: f64,
    nodes: &mut Vec<Node>,
    grid: &Grid,
    (shape, radius): (&Shape, f64),
    (values, changes): (&mut Plane, &mut [Plane; COVERAGE_PARAMETERS]),
    contrast: Option<f32>,
) -> Option<()> {
    trace(nodes, grid, shape, radius, K::spacing(size))?;
    kernel.prepare(grid, nodes, size);
    lay(kernel, nodes, grid, values, changes, contrast);
    Some(())
}

/// A stamp's row with what it is multiplied with.
#[derive(Clone, Copy)]
struct Active<R> {
    row: R,
    j: usize,
    reach: Reach,
}

#[inline(always)]
fn lay<K: Kernel>(
    kernel: &K,
    nodes: &[Node],
    grid: &Grid,
    values: &mut Plane,
    changes: &mut [Plane; COVERAGE_PARAMETERS],
    contrast: Option<f32>,
) {
    let stride = grid.stride();
    let vectors = stride / LANES;
    let mut active: Vec<Active<K::Row>> = Vec::with_capacity(nodes.len());
    let mut beyond = vec![[0.0_f32; 2]; vectors + 1];
    for i in 0..grid.height {
        active.clear();
        beyond.fill([0.0; 2]);
        for (j, node) in nodes.iter().enumerate() {
            if let Some((row, reach)) = kernel.row(node, j, i) {
                let [sum, change] = kernel.beyond(&row);
                beyond[reach.past][0] += node.rise * sum;
                beyond[reach.past][1] += node.rise * change;
                active.push(Active { row, j, reach });
            }
        }
        let mut constant = [0.0_f32; 2];
        for (vector, beyond) in beyond[..vectors].iter().enumerate() {
            constant[0] += beyond[0];
            constant[1] += beyond[1];
            let at = i * stride + vector * LANES;
            let here = active
                .iter()
                .filter(|a| a.reach.first <= vector && vector < a.reach.past);
            match contrast {
                None => {
                    let mut total = [constant[0]; LANES];
                    for a in here {
                        let node = &nodes[a.j];
                        let sum = kernel.sum(&a.row, node, a.j, vector);
                        for l in 0..LANES {
                            total[l] += node.rise * sum[l];
                        }
                    }
                    add(&mut values[at..at + LANES], 1.0, &total);
                }
                Some(contrast) => {
                    let mut total = [constant[0]; LANES];
                    let mut by_blur = [constant[1]; LANES];
                    let mut by_shape = [[0.0_f32; LANES]; SHAPE_PARAMETERS];
                    for a in here {
                        let node = &nodes[a.j];
                        let [sum, share, change] = kernel.all(&a.row, node, a.j, vector);
                        for l in 0..LANES {
                            total[l] += node.rise * sum[l];
                            by_blur[l] += node.rise * change[l];
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
                    add(
                        &mut changes[SHAPE_PARAMETERS][at..at + LANES],
                        contrast,
                        &by_blur,
                    );
                }
            }
        }
    }
}

#[inline(always)]
fn add(target: &mut [f32], factor: f32, source: &Lanes) {
    for (t, s) in target.iter_mut().zip(source) {
        *t += factor * s;
    }
}
