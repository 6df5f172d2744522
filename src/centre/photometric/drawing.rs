//! Pictures of rings over a window: coverages, and what blur that changes adds.

use super::blur::Blur;
use super::boundary::Node;
use super::coverage::Plane;
use super::model::RingModel;
use super::problem::Workspace;
use super::shape::Shape;
use super::window::Grid;
use nalgebra::Vector2;

impl Workspace {
    /// Coverages of a window by both circles of a ring, in padded rows; `None` where they are no ellipses.
    pub(super) fn circles(
        &mut self,
        grid: &Grid,
        shape: &Shape,
        blur: &Blur,
        ratio: f64,
    ) -> Option<&[Vec<f32>; 2]> {
        self.circles_among(grid, (shape, blur), ratio, None)
    }

    /// The same with those of the rings around (`around`).
    pub(super) fn circles_among(
        &mut self,
        grid: &Grid,
        ring: (&Shape, &Blur),
        ratio: f64,
        around: Option<&[Vec<f32>; 2]>,
    ) -> Option<&[Vec<f32>; 2]> {
        self.dispatch(
            #[inline(always)]
            |room| room.coverage.fill(grid, ring, ratio, None, around),
        )?;
        Some(&self.coverage.circles)
    }

    /// Coverages of both circles of a ring over a window, added to `planes`.
    pub(super) fn add_coverage(
        &mut self,
        planes: &mut [Vec<f32>; 2],
        grid: &Grid,
        model: &RingModel,
        ratio: f64,
    ) -> Option<()> {
        let circles = self.circles(grid, &model.shape, &model.blur, ratio)?;
        for (sum, own) in planes.iter_mut().zip(circles) {
            for (sum, own) in sum.iter_mut().zip(own) {
                *sum += own;
            }
        }
        Some(())
    }

    /// What blur that grows by `slope` (px per px) over a ring adds to its unshaded light, in padded rows (`uneven` has the equation); `None`
    /// where it is no ring, or as good as sharp.
    pub(super) fn uneven(
        &mut self,
        grid: &Grid,
        model: &RingModel,
        ratio: f64,
        slope: Vector2<f64>,
    ) -> Option<&[f32]> {
        let (shape, blur) = (&model.shape, &model.blur);
        self.dispatch(
            #[inline(always)]
            |room| {
                let known = (ratio, model.contrasts());
                let coverage = &mut room.coverage;
                coverage.fill_uneven(grid, (shape, blur), known, slope)?;
                let [whole, by_x, by_y, ..] = &coverage.changes;
                let scale = (1.0 / blur.size_px) as f32;
                room.residuals.clear();
                for i in 0..grid.stride() * grid.height {
                    let (column, row) = (i % grid.stride(), i / grid.stride());
                    let x = (grid.x(column) - shape.centre.x) as f32;
                    let y = (grid.y(row) - shape.centre.y) as f32;
                    // contrasts are inside less outside, the step is the other way round
                    let added = scale * (x * by_x[i] + y * by_y[i] - whole[i]);
                    room.residuals.push(added);
                }
                Some(())
            },
        )?;
        Some(&self.residuals)
    }

    /// Coverages by two outlines that are no ellipses, in padded rows ([`Coverage::fill_traced`]).
    pub(super) fn traced(
        &mut self,
        grid: &Grid,
        blur: &Blur,
        ratio: f64,
        nodes_of: impl Fn(f64, f64, &mut Vec<Node>) -> Option<()>,
    ) -> Option<&[Plane; 2]> {
        self.dispatch(
            #[inline(always)]
            |room| room.coverage.fill_traced(grid, blur, ratio, nodes_of),
        )?;
        Some(&self.coverage.circles)
    }
}
