//! The grey values of a blurred ring: levels of paper, ring and inner disc, blur, and linear shading across the window.
//!
//! `I = (paper + (ring - paper) B_1 + (inside - ring) B_r) (1 + s . (x - x0) / w)`: B_1 and B_r are the blurred coverages of the
//! outer and the inner circle (`coverage`), s the shading over the window's width w, x0 the window's middle. Where the sheet
//! ends beside the ring, `(beyond - paper) O` is added in the first bracket (`sheet`).

use super::blur::Blur;
use super::coverage::{COVERAGE_PARAMETERS, Contrasts};
use super::shape::{SHAPE_PARAMETERS, Shape};
use super::sheet::{SHEET_PARAMETERS, SheetEnd};
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
}
