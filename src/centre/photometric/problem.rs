//! Residuals of a window under a model, and their normal equations.

use super::censored::Censored;
use super::coverage::{Contrasts, Coverage};
use super::fit::Known;
use super::gram::{Gradient, Gram};
use super::model::{Matrix, RingModel, Vector};
use super::pull::pull;
use super::rows::{Rows, light};
use super::window::Window;
use pulp::Arch;

/// What is fitted to what.
#[derive(Debug, Clone, Copy)]
pub(super) struct Problem<'a> {
    /// The pixels.
    pub(super) window: &'a Window,
    /// Inner over outer radius on the board.
    pub(super) ratio: f64,
    /// Coverages of the rings around this one by their outer and inner circles, in the window's padded rows.
    pub(super) around: Option<&'a [Vec<f32>; 2]>,
    /// Standard deviation of a pixel's noise, which says how far beyond the end of the range a clipped pixel may be.
    pub(super) noise: f64,
}

impl<'a> Problem<'a> {
    /// What is known of a ring, and the noise of its pixels.
    pub(super) fn of(known: &Known<'a>, noise: f64) -> Self {
        Self {
            window: known.window,
            ratio: known.ratio,
            around: known.around,
            noise,
        }
    }
}

/// Room for fits, to be used again and again by one thread.
#[derive(Debug, Clone)]
pub struct Workspace {
    pub(super) coverage: Coverage,
    rows: Rows,
    /// Residuals of the last evaluation, in padded rows; zero where a pixel does not count.
    pub(super) residuals: Vec<f32>,
    arch: Arch,
}

impl Default for Workspace {
    fn default() -> Self {
        Self {
            coverage: Coverage::default(),
            rows: Rows::default(),
            residuals: Vec::new(),
            arch: Arch::new(),
        }
    }
}

/// Sum of squares, gradient and normal matrix at one point.
#[derive(Debug, Clone)]
pub(super) struct Normal {
    pub(super) squares: f64,
    pub(super) gradient: Vector,
    pub(super) matrix: Matrix,
}

impl Workspace {
    /// Runs `work` compiled for the widest vectors this machine has.
    pub(super) fn dispatch<R>(&mut self, work: impl FnOnce(&mut Self) -> R) -> R {
        let arch = self.arch;
        arch.dispatch(Job(self, work))
    }

    /// Everything at a model: coverages with their changes and the normal equations; `None` where the shape is no ring.
    pub(super) fn normal(&mut self, problem: &Problem, model: &RingModel) -> Option<Normal> {
        self.normal_and(problem, model, |_| ())
    }

    /// The same, and what else is made of the derivatives.
    pub(super) fn normal_and(
        &mut self,
        problem: &Problem,
        model: &RingModel,
        mut visit: impl FnMut(&Rows),
    ) -> Option<Normal> {
        self.dispatch(
            #[inline(always)]
            |room| {
                let mut gram = Gram::new();
                let contrasts = Some(model.contrasts());
                let beyond = room.for_each_row(problem, model, contrasts, |rows| {
                    gram.add(rows);
                    visit(rows);
                })?;
                let (matrix, gradient, squares) = gram.finish();
                let squares = squares + beyond;
                let finite = squares.is_finite() && matrix.iter().all(|v| v.is_finite());
                finite.then_some(Normal {
                    squares,
                    gradient,
                    matrix,
                })
            },
        )
    }

    /// Sum of squares at a model, and the gradient with the changes of an earlier one; `None` where the shape is no ring.
    pub(super) fn gradient(
        &mut self,
        problem: &Problem,
        model: &RingModel,
    ) -> Option<(Vector, f64)> {
        if model.sheet.is_none() && problem.window.censored.is_empty() {
            return self.plain_gradient(problem, model);
        }
        self.dispatch(
            #[inline(always)]
            |room| {
                let mut sums = Gradient::new();
                let beyond = room.for_each_row(problem, model, None, |rows| sums.add(rows))?;
                let (gradient, squares) = sums.finish();
                let squares = squares + beyond;
                squares.is_finite().then_some((gradient, squares))
            },
        )
    }

    /// The same, where every pixel that counts shows the ring and its paper alone.
    fn plain_gradient(&mut self, problem: &Problem, model: &RingModel) -> Option<(Vector, f64)> {
        let grid = &problem.window.grid;
        let ring = (&model.shape, &model.blur);
        self.circles_among(grid, ring, problem.ratio, problem.around)?;
        self.residuals.resize(grid.stride() * grid.height, 0.0);
        let (gradient, squares) = pull(model, problem.window, &self.coverage, &mut self.residuals);
        squares.is_finite().then_some((gradient, squares))
    }

    /// Computes the coverages, with their changes for these contrasts, and calls `visit` with the derivatives and residuals of all rows, a few at a time.
    /// Returns what censored pixels add to the sum of squares; `None` where the shape is no ring.
    #[inline(always)]
    fn for_each_row(
        &mut self,
        problem: &Problem,
        model: &RingModel,
        contrasts: Option<Contrasts>,
        mut visit: impl FnMut(&Rows),
    ) -> Option<f64> {
        let grid = &problem.window.grid;
        let (shape, blur) = (&model.shape, &model.blur);
        let (ratio, around) = (problem.ratio, problem.around);
        self.coverage
            .fill(grid, (shape, blur), ratio, contrasts, around)?;
        self.residuals.resize(grid.stride() * grid.height, 0.0);
        let mut beyond = 0.0;
        self.rows.clear();
        for row in 0..grid.height {
            beyond += self.fill_row(problem, model, row);
            if self.rows.is_full() || row + 1 == grid.height {
                visit(&self.rows);
                self.rows.clear();
            }
        }
        Some(beyond)
    }

    /// Residuals of all pixels of a window under a model, in padded rows; zero where a pixel does not count.
    pub(super) fn residuals(&mut self, known: &Known, model: &RingModel) -> &[f32] {
        self.residuals_and(known, model, None)
    }

    /// The same, and with contrasts the coverage's changes.
    pub(super) fn residuals_and(
        &mut self,
        known: &Known,
        model: &RingModel,
        contrasts: Option<Contrasts>,
    ) -> &[f32] {
        let grid = &known.window.grid;
        let stride = grid.stride();
        self.dispatch(
            #[inline(always)]
            |room| {
                room.residuals.clear();
                room.residuals.resize(stride * grid.height, 0.0);
                let (shape, blur) = (&model.shape, &model.blur);
                let filled =
                    room.coverage
                        .fill(grid, (shape, blur), known.ratio, contrasts, known.around);
                if filled.is_none() {
                    return;
                }
                let (circles, sheet) = (&room.coverage.circles, &mut room.rows.sheet);
                for (row, out) in room.residuals.chunks_exact_mut(stride).enumerate() {
                    light(
                        (model, grid),
                        row,
                        circles,
                        Some(known.window),
                        (sheet, out),
                    );
                }
            },
        );
        &self.residuals
    }

    /// Derivatives and residuals of one row. Returns what censored pixels add to the sum of squares beyond their residuals.
    #[inline(always)]
    fn fill_row(&mut self, problem: &Problem, model: &RingModel, row: usize) -> f64 {
        let Self {
            coverage,
            rows: out,
            ..
        } = self;
        let window = problem.window;
        let stride = window.grid.stride();
        let span = row * stride..(row + 1) * stride;
        out.fill(model, window, row, coverage);
        self.residuals[span.clone()].copy_from_slice(out.residuals());
        if window.censored.is_empty() {
            return 0.0;
        }
        Censored::new(problem, model, coverage).patch(span, out)
    }
}

/// Work with its room, as the dispatcher takes it.
struct Job<'a, F>(&'a mut Workspace, F);

impl<R, F: FnOnce(&mut Workspace) -> R> pulp::NullaryFnOnce for Job<'_, F> {
    type Output = R;

    #[inline(always)]
    fn call(self) -> R {
        self.1(self.0)
    }
}
