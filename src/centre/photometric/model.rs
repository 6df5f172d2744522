//! The grey values of a blurred ring: levels of paper, ring and inner disc, blur, and linear shading across the window.
//!
//! `I = (paper + (ring - paper) B_1 + (inside - ring) B_r) (1 + s . (x - x0) / w)`: B_1 and B_r are the blurred coverages of the
//! outer and the inner circle (`coverage`), s the shading over the window's width w, x0 the window's middle.

use super::blur::Blur;
use super::coverage::{COVERAGE_PARAMETERS, WithDerivatives};
use super::shape::{SHAPE_PARAMETERS, Shape};
use super::window::Grid;
use nalgebra::{SMatrix, SVector};

/// All parameters: shape (7), blur (1), levels (3), shading (2).
pub(super) const PARAMETERS: usize = COVERAGE_PARAMETERS + 5;
const PAPER: usize = COVERAGE_PARAMETERS;
const RING: usize = PAPER + 1;
const INSIDE: usize = PAPER + 2;
const SHADING: usize = PAPER + 3;

/// Everything the grey values of one window depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingModel {
    /// Where the ring is and how it is tilted.
    pub shape: Shape,
    /// Blur.
    pub blur: Blur,
    /// Grey of the paper around the ring, 0..1.
    pub paper: f64,
    /// Grey of the ring.
    pub ring: f64,
    /// Grey of the inner disc.
    pub inside: f64,
    /// Relative change of the light over the window's width, across and down.
    pub shading: [f64; 2],
}

pub(super) type Vector = SVector<f64, PARAMETERS>;
pub(super) type Matrix = SMatrix<f64, PARAMETERS, PARAMETERS>;

/// What the model says of one pixel.
#[derive(Debug)]
pub(super) struct PixelModel {
    pub(super) grey: f64,
    pub(super) derivatives: Vector,
    /// The derivatives before this one are zero, whatever they say: the pixel sees no outline.
    pub(super) first: usize,
}

/// Room for the coverages of both circles, to be used again and again.
#[derive(Debug, Default)]
pub(super) struct Circles {
    outer: WithDerivatives,
    inner: WithDerivatives,
}

impl RingModel {
    pub(super) fn parameters(&self) -> Vector {
        let mut p = Vector::zeros();
        p.as_mut_slice()[..SHAPE_PARAMETERS].copy_from_slice(&self.shape.parameters());
        p[SHAPE_PARAMETERS] = self.blur.size_px;
        p[PAPER] = self.paper;
        p[RING] = self.ring;
        p[INSIDE] = self.inside;
        p[SHADING] = self.shading[0];
        p[SHADING + 1] = self.shading[1];
        p
    }

    /// This model with other parameters; what kind of blur it has stays.
    pub(super) fn with_parameters(&self, p: &Vector) -> Self {
        let mut shape = [0.0; SHAPE_PARAMETERS];
        shape.copy_from_slice(&p.as_slice()[..SHAPE_PARAMETERS]);
        Self {
            shape: Shape::from_parameters(&shape),
            blur: Blur {
                size_px: p[SHAPE_PARAMETERS],
                ..self.blur
            },
            paper: p[PAPER],
            ring: p[RING],
            inside: p[INSIDE],
            shading: [p[SHADING], p[SHADING + 1]],
        }
    }

    /// Calls `visit` with every pixel, row by row; `None` where the shape is no ring.
    pub(super) fn for_each_pixel(
        &self,
        grid: &Grid,
        ratio: f64,
        circles: &mut Circles,
        mut visit: impl FnMut(usize, &PixelModel),
    ) -> Option<()> {
        let Circles { outer, inner } = circles;
        outer.fill(grid, &self.shape, 1.0, &self.blur)?;
        inner.fill(grid, &self.shape, ratio, &self.blur)?;
        let (dark, light) = (self.ring - self.paper, self.inside - self.ring);
        let width_px = grid.width as f64 * grid.pixel_px;
        let mut pixel = PixelModel {
            grey: 0.0,
            derivatives: Vector::zeros(),
            first: 0,
        };
        for row in 0..grid.height {
            let v = (row as f64 - 0.5 * (grid.height as f64 - 1.0)) * grid.pixel_px / width_px;
            for column in 0..grid.width {
                let u =
                    (column as f64 - 0.5 * (grid.width as f64 - 1.0)) * grid.pixel_px / width_px;
                let i = row * grid.width + column;
                let shade = 1.0 + self.shading[0] * u + self.shading[1] * v;
                let (b1, br) = (outer.value(i), inner.value(i));
                let flat = self.paper + dark * b1 + light * br;
                let derivatives = &mut pixel.derivatives;
                let near = outer.sees_outline(i) || inner.sees_outline(i);
                pixel.first = if near { 0 } else { PAPER };
                if near {
                    let mut changes = [0.0; COVERAGE_PARAMETERS];
                    outer.add_derivatives(i, shade * dark, &mut changes);
                    inner.add_derivatives(i, shade * light, &mut changes);
                    derivatives.as_mut_slice()[..COVERAGE_PARAMETERS].copy_from_slice(&changes);
                }
                derivatives[PAPER] = shade * (1.0 - b1);
                derivatives[RING] = shade * (b1 - br);
                derivatives[INSIDE] = shade * br;
                derivatives[SHADING] = flat * u;
                derivatives[SHADING + 1] = flat * v;
                pixel.grey = flat * shade;
                visit(i, &pixel);
            }
        }
        Some(())
    }
}
