//! How much of each pixel's light comes from inside the two circles of a ring, after blur and pixel integration, and how that
//! changes with the ring's parameters.
//!
//! Every node of an outline (`boundary`) lays a stamp on the pixels that its kernel reaches: `gaussian` and `disc` know the
//! stamps, `stamps` lays those of a Gaussian. Where blur is small against the circle, closed forms are faster: `sharp`, `disc_edge`.

use super::blur::{Blur, Psf};
use super::boundary::{Node, trace};
use super::dense::{self, Dense};
use super::disc::Disc;
use super::disc_edge::DiscEdge;
use super::edge::draw;
use super::feet::Circle;
use super::gauss_edge::GaussEdge;
use super::gaussian::{Gaussian, LEAST_SIGMA};
use super::shape::{SHAPE_PARAMETERS, Shape};
use super::sharp::{self, SharpCircle};
use super::stamps::{Kernel, Outline, Room};
use super::uneven::resweep;
use super::window::Grid;
use nalgebra::Vector2;

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
    dense: Dense,
    disc: Disc,
    room: Room,
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
        self.clear(grid, base, contrasts.is_some());
        let (psf, kernel_size) = kernel_of(blur, grid);
        for (circle, radius) in [1.0, ratio].into_iter().enumerate() {
            let contrast = contrasts.map(|both| both[circle] as f32);
            if self.fill_closely(grid, shape, (circle, radius), (psf, kernel_size), contrast)? {
                continue;
            }
            let nodes = &mut self.nodes;
            trace(nodes, grid, shape, radius, spacing(psf, kernel_size))?;
            if psf == Psf::Gaussian && self.nodes.len() <= dense::MOST_NODES {
                let planes = (&mut self.circles[circle], &mut self.changes);
                let nodes = (self.nodes.as_slice(), kernel_size.max(LEAST_SIGMA));
                self.dense.cover((grid, shape), nodes, planes, contrast);
            } else {
                self.lay(grid, (psf, kernel_size), circle, contrast);
            }
        }
        if psf != blur.psf && contrasts.is_some() {
            // a disc that is taken for a Gaussian of half its size
            let by_blur = self.changes[SHAPE_PARAMETERS].iter_mut();
            by_blur.for_each(|change| *change *= 0.5);
        }
        Some(())
    }

    /// Fills in one circle in closed form; false where there is none for this blur, `None` where the circle is no ellipse.
    #[inline(always)]
    fn fill_closely(
        &mut self,
        grid: &Grid,
        shape: &Shape,
        (number, radius): (usize, f64),
        (psf, size): (Psf, f64),
        contrast: Option<f32>,
    ) -> Option<bool> {
        let circle = Circle::new(grid, shape, radius)?;
        let planes = (&mut self.circles[number], &mut self.changes);
        let drawn = match psf {
            Psf::Disc => {
                DiscEdge::new(&circle, size).map(|edge| draw(&edge, grid, planes, contrast))
            }
            Psf::Gaussian if size < sharp::MOST_SIGMA => {
                SharpCircle::new(&circle, size.max(sharp::LEAST_SIGMA))
                    .map(|edge| draw(&edge, grid, planes, contrast))
            }
            Psf::Gaussian => {
                GaussEdge::new(&circle, size).map(|edge| draw(&edge, grid, planes, contrast))
            }
        };
        Some(drawn.is_some())
    }

    /// The three pictures that blur which changes by `slope` (px per px) is made of, as the first of the changes (`uneven`); `None` where
    /// the circles are no ellipses, or as good as sharp.
    #[inline(always)]
    pub(super) fn fill_uneven(
        &mut self,
        grid: &Grid,
        (shape, blur): (&Shape, &Blur),
        (ratio, contrasts): (f64, Contrasts),
        slope: Vector2<f64>,
    ) -> Option<()> {
        let (psf, kernel_size) = kernel_of(blur, grid);
        if psf == Psf::Gaussian && kernel_size < sharp::MOST_SIGMA {
            return None;
        }
        self.fill_displaced(
            grid,
            blur,
            (ratio, contrasts),
            #[inline(always)]
            |radius, spacing, nodes| {
                trace(nodes, grid, shape, radius, spacing)?;
                resweep(nodes, grid, shape.centre, slope);
                Some(())
            },
        )
    }

    /// What outlines change where they are displaced: `nodes_of` traces the circle of a radius (outer radii), its nodes at most so far apart,
    /// each with displacements in its sweeps; what the first of them changes is the first of the changes, and so on. The blur must not be sharp.
    #[inline(always)]
    pub(super) fn fill_displaced(
        &mut self,
        grid: &Grid,
        blur: &Blur,
        (ratio, contrasts): (f64, Contrasts),
        nodes_of: impl Fn(f64, f64, &mut Vec<Node>) -> Option<()>,
    ) -> Option<()> {
        let (psf, kernel_size) = kernel_of(blur, grid);
        self.clear(grid, None, true);
        for (circle, radius) in [1.0, ratio].into_iter().enumerate() {
            nodes_of(radius, spacing(psf, kernel_size), &mut self.nodes)?;
            let contrast = Some(contrasts[circle] as f32);
            self.lay(grid, (psf, kernel_size), circle, contrast);
        }
        Some(())
    }

    /// Coverages of two outlines that are no ellipses: `nodes_of` traces the circle of a radius (outer radii), its nodes at most so far apart.
    /// The blur must not be sharp.
    #[inline(always)]
    pub(super) fn fill_traced(
        &mut self,
        grid: &Grid,
        blur: &Blur,
        ratio: f64,
        nodes_of: impl Fn(f64, f64, &mut Vec<Node>) -> Option<()>,
    ) -> Option<()> {
        let (psf, kernel_size) = kernel_of(blur, grid);
        self.clear(grid, None, false);
        for (circle, radius) in [1.0, ratio].into_iter().enumerate() {
            nodes_of(radius, spacing(psf, kernel_size), &mut self.nodes)?;
            self.lay(grid, (psf, kernel_size), circle, None);
        }
        Some(())
    }

    /// Empties the planes, but for what `base` holds.
    #[inline(always)]
    fn clear(&mut self, grid: &Grid, base: Option<&[Plane; 2]>, changes: bool) {
        let size = grid.stride() * grid.height;
        for (circle, plane) in self.circles.iter_mut().enumerate() {
            plane.clear();
            match base {
                Some(base) => plane.extend_from_slice(&base[circle]),
                None => plane.resize(size, 0.0),
            }
        }
        if changes {
            for plane in &mut self.changes {
                plane.clear();
                plane.resize(size, 0.0);
            }
        }
    }

    /// Lays the stamps of the nodes, which are those of one of the circles.
    #[inline(always)]
    fn lay(
        &mut self,
        grid: &Grid,
        (psf, kernel_size): (Psf, f64),
        circle: usize,
        contrast: Option<f32>,
    ) {
        let planes = (&mut self.circles[circle], &mut self.changes);
        match psf {
            Psf::Gaussian => {
                let outline = Outline {
                    nodes: &self.nodes,
                    room: &mut self.room,
                    grid,
                };
                outline.cover(&mut self.gaussian, kernel_size, planes, contrast);
            }
            Psf::Disc => {
                let disc = (grid, self.nodes.as_slice(), kernel_size);
                self.disc.cover(disc, planes, contrast);
            }
        }
    }
}

/// The kernel that stands for a blur, and its size in pixels of the grid.
fn kernel_of(blur: &Blur, grid: &Grid) -> (Psf, f64) {
    let size = blur.size_px / grid.pixel_px;
    match blur.psf {
        Psf::Disc if size < SMALL_DISC => (Psf::Gaussian, 0.5 * size),
        psf => (psf, size),
    }
}

/// How close its nodes must be, pixels of the grid.
fn spacing(psf: Psf, size: f64) -> f64 {
    match psf {
        Psf::Gaussian => Gaussian::spacing(size),
        Psf::Disc => Disc::spacing(size),
    }
}
