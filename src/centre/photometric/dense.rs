//! The coverage by a circle under a Gaussian blur that is not small against it: a few nodes of its outline, each of which shows in the
//! whole window.
//!
//! A node's stamp, integrated over the pixels, is a column times a row, so that all of them together are products of two small
//! matrices: rows by nodes, and nodes by columns. Along a row the nodes' shares are multiplied with their weights once, and the
//! sums over the nodes stay in registers.
//!
//! The outline grows by the blur as it does in a picture that is drawn at another scale: with n the outward normal,
//! `dB/dsigma = integral of K(x - X) (x - X) . n / sigma ds`. `n ds` is what the centre sweeps, and `X . n ds` follows from
//! Q_p: X . grad Q = 2 (xx Q_xx + xy Q_xy + yy Q_yy) + q . Q_q. So the changes by the shape tell it, pixel by pixel. The pixel's box
//! makes sigma^2 larger by 1/12.

use super::boundary::Node;
use super::coverage::{COVERAGE_PARAMETERS, Plane};
use super::gram::WIDEST;
use super::normal::density_and_cumulative;
use super::real::{Floats, Real, columns};
use super::shape::{SHAPE_PARAMETERS, Shape};
use super::window::Grid;
use pulp::{Arch, Simd, WithSimd};

/// Nodes at most: with more, `stamps` are faster, which reach only a part of the window.
pub(super) const MOST_NODES: usize = 48;

/// The shares of the nodes of one outline.
#[derive(Debug, Clone, Default)]
pub(super) struct Dense {
    /// For each vector of columns, of each node the sum of the kernel from the left up to a column (averaged over the pixel), times its rise.
    sums: Vec<f32>,
    /// The same for the share of the kernel in each column.
    across: Vec<f32>,
    /// Share of the kernel in each row, node after node, rows padded.
    down: Vec<f32>,
    /// Of one row, each node's share.
    shares: Vec<f32>,
    /// The same times its sweeps and the contrast.
    weights: Vec<[f32; SHAPE_PARAMETERS]>,
    /// Density and distribution at the edges of a node's columns or rows.
    edges: [Vec<f32>; 2],
}

impl Dense {
    /// Adds the coverage to the first of the planes and, with a contrast, the changes of the shape's circle to the others.
    pub(super) fn cover(
        &mut self,
        (grid, shape): (&Grid, &Shape),
        (nodes, sigma): (&[Node], f64),
        (values, changes): (&mut Plane, &mut [Plane; COVERAGE_PARAMETERS]),
        contrast: Option<f32>,
    ) {
        Arch::new().dispatch(Cover {
            dense: self,
            grid,
            shape,
            nodes,
            sigma: sigma as f32,
            values,
            changes,
            contrast,
        });
    }
}

struct Cover<'a> {
    dense: &'a mut Dense,
    grid: &'a Grid,
    shape: &'a Shape,
    nodes: &'a [Node],
    sigma: f32,
    values: &'a mut Plane,
    changes: &'a mut [Plane; COVERAGE_PARAMETERS],
    contrast: Option<f32>,
}

impl WithSimd for Cover<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let padded = self.grid.height.next_multiple_of(WIDEST);
        self.spread_across(simd);
        self.spread_down(simd, padded);
        for row in 0..self.grid.height {
            self.weigh(row, padded);
            self.add_sums(simd, row);
            if self.contrast.is_some() {
                self.add_changes(simd, row);
            }
        }
    }
}

impl Cover<'_> {
    /// Sums and shares along the columns.
    #[inline(always)]
    fn spread_across<S: Simd>(&mut self, simd: S) {
        let (stride, sigma, count) = (self.grid.stride(), self.sigma, self.nodes.len());
        let scale = 1.0 / sigma;
        let dense = &mut *self.dense;
        dense.sums.resize(count * stride, 0.0);
        dense.across.resize(count * stride, 0.0);
        let sums = S::as_mut_simd_f32s(&mut dense.sums).0;
        let across = S::as_mut_simd_f32s(&mut dense.across).0;
        let vectors = stride / S::F32_LANES;
        for (j, node) in self.nodes.iter().enumerate() {
            let begin = (-0.5 - node.x) * scale;
            fill_edges(simd, &mut dense.edges, stride, (begin, scale));
            let [densities, distributions] = &dense.edges;
            let left = S::as_simd_f32s(densities).0.iter();
            let left = left.zip(S::as_simd_f32s(distributions).0);
            let right = S::as_simd_f32s(&densities[1..]).0.iter();
            let right = right.zip(S::as_simd_f32s(&distributions[1..]).0);
            for (v, (left, right)) in left.zip(right).take(vectors).enumerate() {
                let (d0, c0) = (Floats::new(simd, *left.0), Floats::new(simd, *left.1));
                let (d1, c1) = (Floats::new(simd, *right.0), Floats::new(simd, *right.1));
                let u = columns(simd, v) * scale + begin;
                let share = c1 - c0;
                across[v * count + j] = share.values;
                sums[v * count + j] = ((u.times(share, d1 - d0) * sigma + c1) * node.rise).values;
            }
        }
    }

    /// Shares along the rows.
    #[inline(always)]
    fn spread_down<S: Simd>(&mut self, simd: S, padded: usize) {
        let scale = 1.0 / self.sigma;
        let dense = &mut *self.dense;
        dense.down.resize(self.nodes.len() * padded, 0.0);
        for (node, down) in self.nodes.iter().zip(dense.down.chunks_exact_mut(padded)) {
            let begin = (-0.5 - node.y) * scale;
            fill_edges(simd, &mut dense.edges, padded, (begin, scale));
            let edges = &dense.edges[1];
            let pairs = edges[..padded].iter().zip(&edges[1..=padded]);
            for (share, (above, below)) in down.iter_mut().zip(pairs) {
                *share = below - above;
            }
        }
    }

    /// Shares and weights of the nodes in one row.
    #[inline(always)]
    fn weigh(&mut self, row: usize, padded: usize) {
        let dense = &mut *self.dense;
        let shares = dense.down.chunks_exact(padded).map(|down| down[row]);
        dense.shares.clear();
        dense.shares.extend(shares.take(self.nodes.len()));
        let Some(contrast) = self.contrast else {
            return;
        };
        dense.weights.clear();
        let pairs = self.nodes.iter().zip(&dense.shares);
        dense.weights.extend(pairs.map(|(node, share)| {
            let weight = contrast * share;
            node.sweep.map(|sweep| weight * sweep)
        }));
    }

    #[inline(always)]
    fn add_sums<S: Simd>(&mut self, simd: S, row: usize) {
        let stride = self.grid.stride();
        let values = &mut self.values[row * stride..(row + 1) * stride];
        let sums = S::as_simd_f32s(&self.dense.sums).0;
        let sums = sums.chunks_exact(self.nodes.len());
        for (out, sums) in S::as_mut_simd_f32s(values).0.iter_mut().zip(sums) {
            for (share, sum) in self.dense.shares.iter().zip(sums) {
                *out = simd.mul_add_e_f32s(simd.splat_f32s(*share), *sum, *out);
            }
        }
    }

    #[inline(always)]
    fn add_changes<S: Simd>(&mut self, simd: S, row: usize) {
        const _: () = assert!(SHAPE_PARAMETERS == 7);
        let stride = self.grid.stride();
        let span = row * stride..(row + 1) * stride;
        let across = S::as_simd_f32s(&self.dense.across).0;
        let [p0, p1, p2, p3, p4, p5, p6, by_size] = self
            .changes
            .each_mut()
            .map(|plane| S::as_mut_simd_f32s(&mut plane[span.clone()]).0);
        let by_sigma = BySigma::new(self.grid, self.shape, self.sigma);
        for (v, across) in across.chunks_exact(self.nodes.len()).enumerate() {
            let zero = simd.splat_f32s(0.0);
            let [mut a, mut b, mut c, mut d, mut e, mut f, mut g] = [zero; SHAPE_PARAMETERS];
            for (weights, &share) in self.dense.weights.iter().zip(across) {
                let [wa, wb, wc, wd, we, wf, wg] = *weights;
                a = simd.mul_add_e_f32s(share, simd.splat_f32s(wa), a);
                b = simd.mul_add_e_f32s(share, simd.splat_f32s(wb), b);
                c = simd.mul_add_e_f32s(share, simd.splat_f32s(wc), c);
                d = simd.mul_add_e_f32s(share, simd.splat_f32s(wd), d);
                e = simd.mul_add_e_f32s(share, simd.splat_f32s(we), e);
                f = simd.mul_add_e_f32s(share, simd.splat_f32s(wf), f);
                g = simd.mul_add_e_f32s(share, simd.splat_f32s(wg), g);
            }
            let by = [a, b, c, d, e, f, g].map(|sum| Floats::new(simd, sum));
            let size = by_sigma.at(columns(simd, v), row, &by);
            p0[v] = simd.add_f32s(p0[v], a);
            p1[v] = simd.add_f32s(p1[v], b);
            p2[v] = simd.add_f32s(p2[v], c);
            p3[v] = simd.add_f32s(p3[v], d);
            p4[v] = simd.add_f32s(p4[v], e);
            p5[v] = simd.add_f32s(p5[v], f);
            p6[v] = simd.add_f32s(p6[v], g);
            by_size[v] = simd.add_f32s(by_size[v], size.values);
        }
    }
}

/// Density and distribution at one place more than `count`, from `begin` on, `scale` apart.
#[inline(always)]
fn fill_edges<S: Simd>(
    simd: S,
    edges: &mut [Vec<f32>; 2],
    count: usize,
    (begin, scale): (f32, f32),
) {
    let [densities, distributions] = edges;
    densities.resize(count + WIDEST, 0.0);
    distributions.resize(count + WIDEST, 0.0);
    let densities = S::as_mut_simd_f32s(densities).0.iter_mut();
    let distributions = S::as_mut_simd_f32s(distributions).0.iter_mut();
    for (v, (density, distribution)) in densities.zip(distributions).enumerate() {
        if v * S::F32_LANES > count {
            break;
        }
        let (d, c) = density_and_cumulative(columns(simd, v) * scale + begin);
        (*density, *distribution) = (d.values, c.values);
    }
}

/// How the changes by the shape tell the change by sigma.
struct BySigma {
    form: [f32; 3],
    perspective: [f32; 2],
    /// The first pixel about the ring's centre, px of the frame, and a pixel's side.
    first: [f32; 2],
    pixel_px: f32,
    over: f32,
}

impl BySigma {
    #[inline(always)]
    fn new(grid: &Grid, shape: &Shape, sigma: f32) -> Self {
        Self {
            form: shape.affine.map(|v| 2.0 * v as f32),
            perspective: [shape.perspective.x as f32, shape.perspective.y as f32],
            first: [
                (grid.x(0) - shape.centre.x) as f32,
                (grid.y(0) - shape.centre.y) as f32,
            ],
            pixel_px: grid.pixel_px as f32,
            over: sigma / (sigma * sigma + 1.0 / 12.0),
        }
    }

    #[inline(always)]
    fn at<T: Real>(&self, column: T, row: usize, by_shape: &[T; SHAPE_PARAMETERS]) -> T {
        let [xx, xy, yy] = self.form;
        let [qx, qy] = self.perspective;
        let x = column * self.pixel_px + self.first[0];
        let y = row as f32 * self.pixel_px + self.first[1];
        let outline = by_shape[2] * xx + by_shape[3] * xy + by_shape[4] * yy;
        let tilt = by_shape[5] * qx + by_shape[6] * qy;
        (outline + tilt + x * by_shape[0] + by_shape[1] * y) * self.over
    }
}
