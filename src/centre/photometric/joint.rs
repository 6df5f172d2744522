//! A step that all rings of a crowded board take together.
//!
//! Where blurred skirts reach far into the neighbours' windows, rings that are fitted one after the other, each with its neighbours
//! as they were, need dozens of rounds: blur that is too large in one looks like light that is missing in the next. But
//! the first derivatives say how each ring's best answer depends on its neighbours' parameters. With A_i the normal matrix of ring
//! i, g_i its gradient and B_ij the products of its derivatives with those by the parameters of ring j in its window,
//! the step d at which no ring would want to move any more solves
//!
//! ```text
//! A_i d_i + sum over j of B_ij d_j = g_i
//! ```
//!
//! With A_i = L_i L_i^T and z_i = L_i^T d_i that is (1 + C) z = b, which GMRES (Saad & Schultz 1986) solves in a few dozen products of
//! small matrices.

use super::around::{around, reaches};
use super::coverage::LANES;
use super::descent::BLUR_PRIOR;
use super::equations::{diagonal_scales, scaled_by};
use super::fit::{Given, Known};
use super::gmres::gmres;
use super::model::{BLUR, INSIDE, Matrix, PAPER, PARAMETERS, RING, RingModel, Vector};
use super::problem::{Normal, Problem, Workspace};
use super::rows::shades;
use super::shape::SHAPE_PARAMETERS;
use super::under::Under;
use super::wall::Wall;
use nalgebra::{DVector, SMatrix};
use rayon::prelude::*;

/// Parameters by which a ring shows in its neighbours' windows: shape and blur.
const SHOWN: usize = SHAPE_PARAMETERS + 1;
/// Derivatives of one ring times those by another's parameters.
type Coupling = SMatrix<f64, PARAMETERS, SHOWN>;

/// Steps at most: rings that began with twice their contrast and half their size come back in a dozen.
const STEPS: usize = 16;
/// Another step is worth its while where the last one has lowered the sum of squares by this many variances for each ring: what is left
/// of a centre's error then is a few per cent of the noise's.
const WORTH_ANOTHER: f64 = 0.03;
/// A step moves no outline by more than this (blur sigmas) and changes no contrast by more than this part of it: what is farther off is
/// no longer linear.
const LONGEST: f64 = 0.7;
const MOST_CONTRAST: f64 = 0.2;
/// Shares of the step that are tried until one lowers the sum of squares.
const SHARES: [f64; 3] = [1.0, 0.4, 0.15];

/// Inverse of L_i^T, the gradient, and the couplings with their rings' numbers.
type Alone = (Matrix, Vector, Vec<(usize, Coupling)>);

/// One ring's part of the equations.
struct Part {
    /// Inverse of L_i^T.
    back: Matrix,
    right: Vector,
    /// C_ij, and j.
    by_others: Vec<(usize, Matrix)>,
}

/// Moves all rings that are fitted to where none of them would want to move any more.
pub(super) fn settle_together(ratio: f64, rings: &mut [Under]) {
    let mut known = None;
    for _ in 0..STEPS {
        let Some((before, after)) = step_together(ratio, rings, known) else {
            return;
        };
        if before - after < WORTH_ANOTHER * rings.len() as f64 {
            return;
        }
        known = Some(after);
    }
}

/// One such step, to first order, from the sum of squares where the rings stand (if that is known). Returns the sums before and after it, in
/// variances of the rings' noise; `None` where no step was taken.
fn step_together(ratio: f64, rings: &mut [Under], known: Option<f64>) -> Option<(f64, f64)> {
    let parts = parts(ratio, rings)?;
    let size = PARAMETERS * parts.len();
    let mut right = DVector::zeros(size);
    for (i, part) in parts.iter().enumerate() {
        right
            .fixed_rows_mut::<PARAMETERS>(PARAMETERS * i)
            .copy_from(&part.right);
    }
    let product = |z: &DVector<f64>| {
        let mut out = z.clone();
        for (i, part) in parts.iter().enumerate() {
            let mut own = out.fixed_rows_mut::<PARAMETERS>(PARAMETERS * i);
            for (j, coupling) in &part.by_others {
                own += coupling * z.fixed_rows::<PARAMETERS>(PARAMETERS * j);
            }
        }
        out
    };
    let solution = gmres(&right, product)?;
    let steps: Vec<Vector> = parts
        .iter()
        .enumerate()
        .map(|(i, part)| part.back * solution.fixed_rows::<PARAMETERS>(PARAMETERS * i))
        .collect();
    let before: Vec<RingModel> = rings.iter().map(|ring| ring.model).collect();
    let squares = known.unwrap_or_else(|| squares_of_all(ratio, rings, &before));
    for share in SHARES {
        let models: Vec<RingModel> = before
            .iter()
            .zip(&steps)
            .map(|(model, step)| moved(model, &(step * share)).unwrap_or(*model))
            .collect();
        let after = squares_of_all(ratio, rings, &models);
        if after < squares {
            for (ring, model) in rings.iter_mut().zip(models) {
                if let Ok(fitted) = &mut ring.fitted {
                    ring.model = model;
                    fitted.model = model;
                }
            }
            return Some((squares, after));
        }
    }
    None
}

/// What all rings leave in their windows, in variances of their noise.
fn squares_of_all(ratio: f64, rings: &[Under], models: &[RingModel]) -> f64 {
    let left = rings.par_iter().enumerate();
    let left = left.map_init(Workspace::default, |room, (i, ring)| {
        let (Ok(fitted), Some(window)) = (ring.fitted, ring.window.as_ref()) else {
            return 0.0;
        };
        let around = around(&window.grid, ratio, (i, models), room);
        let known = Known {
            window,
            ratio,
            around: around.as_ref(),
            given: Given::NearStart,
        };
        let residuals = room.residuals(&known, &models[i]).iter();
        residuals.map(|&r| f64::from(r * r)).sum::<f64>() / (fitted.noise * fitted.noise)
    });
    // in their order, so that it is the same on any number of threads
    left.collect::<Vec<f64>>().into_iter().sum()
}

/// The equations of all rings, each in its own units; `None` where no ring has another in reach.
fn parts(ratio: f64, rings: &[Under]) -> Option<Vec<Part>> {
    let models: Vec<RingModel> = rings.iter().map(|ring| ring.model).collect();
    let alone: Vec<Alone> = rings
        .par_iter()
        .enumerate()
        .map_init(Workspace::default, |room, (i, ring)| {
            let own = part(ratio, ring, (i, &models, rings), room);
            own.unwrap_or_else(|| (Matrix::zeros(), Vector::zeros(), Vec::new()))
        })
        .collect();
    if alone.iter().all(|(_, _, others)| others.is_empty()) {
        return None;
    }
    let backs: Vec<Matrix> = alone.iter().map(|(back, _, _)| *back).collect();
    let part = |(back, gradient, others): Alone| Part {
        back,
        right: back.tr_mul(&gradient),
        by_others: others
            .into_iter()
            .map(|(j, coupling)| {
                let shown = backs[j].fixed_rows::<SHOWN>(0);
                (j, back.tr_mul(&(coupling * shown)))
            })
            .collect(),
    };
    Some(alone.into_iter().map(part).collect())
}

/// L^-T, the gradient and the couplings of one ring; `None` where it has no fit, and so no say.
fn part(
    ratio: f64,
    ring: &Under,
    (own, models, rings): (usize, &[RingModel], &[Under]),
    room: &mut Workspace,
) -> Option<Alone> {
    let fitted = ring.fitted.ok()?;
    let window = ring.window.as_ref()?;
    let around = around(&window.grid, ratio, (own, models), room);
    let problem = Problem {
        window,
        ratio,
        around: around.as_ref(),
        noise: fitted.noise,
    };
    let others: Vec<(usize, &RingModel)> = (0..rings.len())
        .filter(|&j| j != own && rings[j].fitted.is_ok() && reaches(&models[j], &window.grid))
        .map(|j| (j, &models[j]))
        .collect();
    let (normal, couplings) = room.couplings(&problem, &ring.model, &others)?;
    let (mut matrix, mut gradient) = (normal.matrix, normal.gradient);
    let (parameters, wall) = (ring.model.parameters(), Wall::of(&matrix));
    wall.push(&parameters, &mut gradient);
    wall.stiffen(&parameters, &mut matrix);
    matrix[(BLUR, BLUR)] += BLUR_PRIOR;
    let scales = diagonal_scales::<PARAMETERS>(&matrix);
    let inverse = scaled_by(&matrix, &scales).cholesky()?.l().try_inverse()?;
    let back = Matrix::from_fn(|i, j| scales[i] * inverse[(j, i)]);
    let couplings = others.iter().map(|(j, _)| *j).zip(couplings).collect();
    Some((back, gradient, couplings))
}

/// The model after a step, which is cut where it is too long; `None` where nothing is left of the ring.
fn moved(model: &RingModel, step: &Vector) -> Option<RingModel> {
    let outer = model.shape.ellipse(1.0)?;
    let radius_px = outer.mean_radius();
    let (sigma_px, size_px) = (model.blur.sigma_px(), model.blur.size_px);
    let affine = step[2].abs().max(step[3].abs()).max(step[4].abs());
    let outline = step[0].hypot(step[1])
        + 0.5 * affine * radius_px.powi(3)
        + step[5].hypot(step[6]) * radius_px * radius_px
        + 0.5 * step[BLUR].abs() / size_px.max(f64::MIN_POSITIVE);
    let contrast = (model.paper - model.ring)
        .abs()
        .min((model.inside - model.ring).abs());
    let light = (step[PAPER] - step[RING])
        .abs()
        .max((step[INSIDE] - step[RING]).abs());
    let short = (LONGEST * sigma_px / outline.max(f64::MIN_POSITIVE))
        .min(MOST_CONTRAST * contrast / light.max(f64::MIN_POSITIVE))
        .min(1.0);
    let next = model.with_parameters(&(model.parameters() + step * short));
    next.shape.ellipse(1.0).map(|_| next)
}

impl Workspace {
    /// The normal equations at a model, and the products of its derivatives with those by shape and blur of other rings, which are lit
    /// like this one; `None` where one of the shapes is no ring.
    fn couplings(
        &mut self,
        problem: &Problem,
        model: &RingModel,
        others: &[(usize, &RingModel)],
    ) -> Option<(Normal, Vec<Coupling>)> {
        let grid = &problem.window.grid;
        let mut derivatives = vec![Vec::new(); model.count()];
        let normal = self.normal_and(problem, model, |rows| {
            for (k, all) in derivatives.iter_mut().enumerate() {
                all.extend_from_slice(rows.column(k));
            }
        })?;
        let shades: Vec<f32> = (0..grid.height)
            .flat_map(|row| shades(model, grid, row))
            .collect();
        let couplings = others.iter().map(|(_, other)| {
            self.dispatch(
                #[inline(always)]
                |room| {
                    let known = (problem.ratio, Some(model.contrasts()));
                    let shown = (&other.shape, &other.blur);
                    room.coverage.fill(grid, shown, known.0, known.1, None)?;
                    let mut out = Coupling::zeros();
                    for (k, change) in room.coverage.changes.iter_mut().enumerate() {
                        let scale = if k == BLUR { other.by_blur(grid) } else { 1.0 };
                        let pairs = change.iter_mut().zip(&shades);
                        pairs.for_each(|(change, shade)| *change *= shade);
                        for (a, own) in derivatives.iter().enumerate() {
                            out[(a, k)] = scale * sum_of_products(own, change);
                        }
                    }
                    Some(out)
                },
            )
        });
        let couplings = couplings.collect::<Option<Vec<_>>>()?;
        Some((normal, couplings))
    }
}

/// Over pixels of padded rows; as many at once as there are lanes.
#[inline(always)]
fn sum_of_products(left: &[f32], right: &[f32]) -> f64 {
    let mut sums = [0.0_f32; LANES];
    let pairs = left.chunks_exact(LANES).zip(right.chunks_exact(LANES));
    for (left, right) in pairs {
        for l in 0..LANES {
            sums[l] += left[l] * right[l];
        }
    }
    f64::from(sums.iter().sum::<f32>())
}
