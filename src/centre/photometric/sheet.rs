//! The end of the sheet beside a ring: one straight edge, or two at a corner, blurred like the ring, and another light beyond.
//!
//! Of the sheet's light `paper` the part O is missing and `beyond` is there instead: `(beyond - paper) O` is added to the grey
//! values. A half-plane at the signed distance d, blurred, is F(d / s); of a corner O = 1 - (1 - F_1) (1 - F_2), corrected for the
//! corner's angle (`corner`). The pixel's box is taken as so much more blur: it is small against s wherever an edge that is
//! worth a model (and not left out) is in reach.
//!
//! A lens bends the edge by a few tenths of a pixel over a window. Once the map through the rings says how, that is part of the
//! distance: a straight edge would move the ring by half the noise of a good camera.

use super::blur::{Blur, Psf};
use super::corner::Corner;
use super::normal::density_and_cumulative;
use super::real::{Real, arccos, columns};
use super::window::Grid;
use nalgebra::{Point2, Vector2};
use pulp::{Arch, Simd, WithSimd};
use std::f32::consts::{FRAC_1_PI, FRAC_2_PI};

/// Parameters of an edge: how far out it is, and its direction.
pub(super) const EDGE_PARAMETERS: usize = 2;
/// Parameters of the sheet's end: the light beyond, and two edges.
pub(super) const SHEET_PARAMETERS: usize = 1 + 2 * EDGE_PARAMETERS;

/// An edge of the sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// From where the offset is counted, px of the frame; it does not move in a fit.
    pub anchor: Point2<f64>,
    /// How far from the anchor the edge is, px.
    pub offset_px: f64,
    /// Direction that leads off the sheet, rad from the frame's x towards its y.
    pub angle: f64,
    /// How a lens bends it, px^-1: at t px along the edge it is t^2 / 2 times this farther out. It does not change in a fit.
    pub bend: f64,
}

impl Edge {
    /// Unit vector that leads off the sheet.
    pub(super) fn normal(&self) -> Vector2<f64> {
        let (sin, cos) = self.angle.sin_cos();
        Vector2::new(cos, sin)
    }
}

/// Where the sheet ends beside a ring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SheetEnd {
    /// Light beyond, 1 at full scale.
    pub beyond: f64,
    /// The edge.
    pub edge: Edge,
    /// The other edge, at a corner.
    pub other: Option<Edge>,
}

impl SheetEnd {
    /// How many of its parameters there are.
    pub(super) fn count(&self) -> usize {
        1 + EDGE_PARAMETERS * (1 + usize::from(self.other.is_some()))
    }

    pub(super) fn parameters(&self) -> [f64; SHEET_PARAMETERS] {
        let other = self.other.map_or([0.0; 2], |e| [e.offset_px, e.angle]);
        [
            self.beyond,
            self.edge.offset_px,
            self.edge.angle,
            other[0],
            other[1],
        ]
    }

    pub(super) fn with_parameters(&self, p: &[f64]) -> Self {
        let with = |edge: &Edge, k: usize| Edge {
            offset_px: p[k],
            angle: p[k + 1],
            ..*edge
        };
        Self {
            beyond: p[0],
            edge: with(&self.edge, 1),
            other: self.other.map(|other| with(&other, 1 + EDGE_PARAMETERS)),
        }
    }
}

/// One row of what is missing of the sheet, and how that changes.
#[derive(Debug, Clone, Default)]
pub(super) struct SheetRow {
    /// O.
    pub(super) missing: Vec<f32>,
    /// Change by the square of the blur's size, px^-2 of the frame.
    pub(super) by_blur: Vec<f32>,
    /// Change by each edge's offset (px) and angle.
    pub(super) by_edge: [Vec<f32>; 2 * EDGE_PARAMETERS],
}

impl SheetRow {
    /// Fills in one row of a window.
    pub(super) fn fill(&mut self, end: &SheetEnd, blur: &Blur, grid: &Grid, row: usize) {
        let stride = grid.stride();
        let planes = [&mut self.missing, &mut self.by_blur];
        for plane in planes.into_iter().chain(&mut self.by_edge) {
            plane.resize(stride, 0.0);
        }
        Arch::new().dispatch(Fill {
            sheet: self,
            step: Profile::new(blur, grid),
            first: Line::new(&end.edge, grid, row),
            second: end
                .other
                .map(|other| Turn::new(&end.edge, &other, grid, row)),
        });
    }
}

/// The second edge of a corner.
#[derive(Clone, Copy)]
struct Turn {
    line: Line,
    corner: Corner,
    /// Change of the normals' cosine by the first angle.
    turn: f32,
}

impl Turn {
    fn new(edge: &Edge, other: &Edge, grid: &Grid, row: usize) -> Self {
        let normals = (edge.normal(), other.normal());
        Self {
            line: Line::new(other, grid, row),
            corner: Corner::new(normals.0.dot(&normals.1)),
            turn: normals.0.perp(&normals.1) as f32,
        }
    }
}

/// What pixels miss of the sheet, and its changes by the blur's square and the edges' offsets and angles.
#[derive(Clone, Copy)]
struct Missing<T> {
    value: T,
    by_blur: T,
    by_edge: [T; 2 * EDGE_PARAMETERS],
}

struct Fill<'a> {
    sheet: &'a mut SheetRow,
    step: Profile,
    first: Line,
    second: Option<Turn>,
}

impl WithSimd for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let SheetRow {
            missing,
            by_blur,
            by_edge: [a, b, c, d],
        } = self.sheet;
        let missing = S::as_mut_simd_f32s(missing).0;
        let by_blur = S::as_mut_simd_f32s(by_blur).0;
        let edges = [a, b, c, d].map(|plane| S::as_mut_simd_f32s(plane).0);
        for v in 0..missing.len() {
            let column = columns(simd, v);
            let here = match &self.second {
                None => straight(&self.step, &self.first, column),
                Some(second) => bent(&self.step, &self.first, second, column),
            };
            missing[v] = here.value.values;
            by_blur[v] = here.by_blur.values;
            for (k, by) in here.by_edge.into_iter().enumerate() {
                edges[k][v] = by.values;
            }
        }
    }
}

/// Beyond one edge.
#[inline(always)]
fn straight<T: Real>(step: &Profile, line: &Line, column: T) -> Missing<T> {
    let distance = line.distance(column);
    let (value, slope) = step.at(distance);
    let zero = column.like(0.0);
    Missing {
        value,
        by_blur: slope * distance * -step.half_over_square,
        by_edge: [-slope, slope * line.turned(column), zero, zero],
    }
}

/// Beyond one edge or another.
#[inline(always)]
fn bent<T: Real>(step: &Profile, first: &Line, second: &Turn, column: T) -> Missing<T> {
    let Turn { line, corner, turn } = second;
    let (d1, d2) = (first.distance(column), line.distance(column));
    let ((e1, k1), (e2, k2)) = (step.at(d1), step.at(d2));
    let more = corner.at(d1 * -step.spread, d2 * -step.spread);
    let k1 = k1 * (-e2 + 1.0) + more.by_depth[0] * step.spread;
    let k2 = k2 * (-e1 + 1.0) + more.by_depth[1] * step.spread;
    let turned = more.by_rho * *turn;
    Missing {
        value: e1 + e2 - e1 * e2 - more.value,
        by_blur: (k1 * d1 + k2 * d2) * -step.half_over_square,
        by_edge: [
            -k1,
            k1 * first.turned(column) - turned,
            -k2,
            k2 * line.turned(column) + turned,
        ],
    }
}

/// An edge as one row of pixels sees it.
#[derive(Clone, Copy)]
struct Line {
    distance: (f32, f32),
    along: (f32, f32),
    half_bend: f32,
    offset: f32,
}

impl Line {
    fn new(edge: &Edge, grid: &Grid, row: usize) -> Self {
        let normal = edge.normal();
        let begin = Point2::new(grid.x(0), grid.y(row)) - edge.anchor;
        let along = Vector2::new(-normal.y, normal.x);
        Self {
            distance: (
                (begin.dot(&normal) - edge.offset_px) as f32,
                (normal.x * grid.pixel_px) as f32,
            ),
            along: (begin.dot(&along) as f32, (along.x * grid.pixel_px) as f32),
            half_bend: (0.5 * edge.bend) as f32,
            offset: edge.offset_px as f32,
        }
    }

    /// How far beyond the edge a pixel is, px.
    #[inline(always)]
    fn distance<T: Real>(&self, column: T) -> T {
        let along = self.along(column);
        self.beyond_tangent(column) - along * along * self.half_bend
    }

    /// The same of the line that touches the edge at the anchor's foot.
    #[inline(always)]
    fn beyond_tangent<T: Real>(&self, column: T) -> T {
        column * self.distance.1 + self.distance.0
    }

    /// How that distance changes with the edge's angle, px per rad.
    #[inline(always)]
    fn turned<T: Real>(&self, column: T) -> T {
        let across = self.beyond_tangent(column) + self.offset;
        self.along(column) * (across * (2.0 * self.half_bend) + 1.0)
    }

    /// How far along the edge it is from the anchor's foot, px.
    #[inline(always)]
    fn along<T: Real>(&self, column: T) -> T {
        column * self.along.1 + self.along.0
    }
}

/// A blurred step.
#[derive(Clone, Copy)]
pub(super) struct Profile {
    psf: Psf,
    /// 1 / s, px^-1.
    scale: f32,
    /// 1 over the standard deviation, px^-1.
    spread: f32,
    half_over_square: f32,
}

impl Profile {
    pub(super) fn new(blur: &Blur, grid: &Grid) -> Self {
        // the variance of a disc along one axis is a quarter of its radius squared, that of a pixel a twelfth of its side squared
        let (box_share, deviations) = match blur.psf {
            Psf::Gaussian => (1.0 / 12.0, 1.0),
            Psf::Disc => (1.0 / 3.0, 2.0),
        };
        let square = blur.size_px * blur.size_px + box_share * grid.pixel_px * grid.pixel_px;
        Self {
            psf: blur.psf,
            scale: square.sqrt().recip() as f32,
            spread: (deviations / square.sqrt()) as f32,
            half_over_square: (0.5 / square) as f32,
        }
    }

    /// The step and its slope (px^-1) at a distance.
    #[inline(always)]
    pub(super) fn at<T: Real>(&self, distance: T) -> (T, T) {
        let u = distance * self.scale;
        match self.psf {
            Psf::Gaussian => {
                let (density, cumulative) = density_and_cumulative(u);
                (cumulative, density * self.scale)
            }
            Psf::Disc => {
                let u = u.within(-1.0, 1.0);
                let chord = (-(u * u) + 1.0).sqrt();
                let area = (u * chord - arccos(u)) * FRAC_1_PI + 1.0;
                (area, chord * (FRAC_2_PI * self.scale))
            }
        }
    }
}
