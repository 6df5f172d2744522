//! The equations of the rings of a crowded board: how each one's best answer depends on its neighbours.
//!
//! With A_i the normal matrix of ring i, g_i its gradient and B_ij the products of its derivatives with those by shape and blur of ring j
//! in its window, the steps d at which no ring would want to move any more solve
//!
//! ```text
//! A_i d_i + sum over j of B_ij s_j = g_i,   s_j = S d_j its part of shape and blur
//! ```
//!
//! Only s couples them. With V_i = S A_i^-1 S^T = L_i L_i^T (the covariance of s_i where the neighbours are known, in variances of the
//! noise) and s_i = L_i w_i that leaves
//!
//! ```text
//! w_i + sum over j of H_ij w_j = L_i^-1 S A_i^-1 g_i,   H_ij = L_i^-1 S A_i^-1 B_ij L_j
//! ```
//!
//! which GMRES solves in a few dozen products of small matrices. As far as the windows hold what the rings show, 1 + H is symmetric, and the
//! whole covariance of s_i is L_i X_ii L_i^T with X = (1 + H)^-1: a ring whose neighbours are not known either is less certain than
//! its own pixels make it look.

use super::around::{around, reaches};
use super::coverage::LANES;
use super::descent::BLUR_PRIOR;
use super::equations::{diagonal_scales, scaled_by};
use super::fitted::ShapeCovariance;
use super::gmres::gmres;
use super::model::{BLUR, Matrix, PARAMETERS, RingModel, Vector};
use super::problem::{Normal, Problem, Workspace};
use super::rows::shades;
use super::shape::SHAPE_PARAMETERS;
use super::under::Under;
use super::wall::Wall;
use nalgebra::{DMatrix, DVector, SMatrix};
use rayon::prelude::*;

/// Parameters by which a ring shows in its neighbours' windows: shape and blur.
const SHOWN: usize = SHAPE_PARAMETERS + 1;
/// Derivatives of one ring times those by another's parameters.
type Coupling = SMatrix<f64, PARAMETERS, SHOWN>;
type Shown = SMatrix<f64, SHOWN, SHOWN>;

/// The neighbours' own uncertainty is told where it adds more than this to a ring's.
const WORTH_TELLING: f64 = 0.02;

/// The equations of all rings of a board.
pub(super) struct Crowd(Vec<Part>);

/// One ring's part of them.
struct Part {
    /// A_i^-1.
    inverse: Matrix,
    gradient: Vector,
    /// L_i.
    spread: Shown,
    /// B_ij L_j, H_ij, and j.
    by_others: Vec<(usize, Coupling, Shown)>,
}

/// A_i^-1, L_i, the gradient, and the couplings with their rings' numbers.
type Alone = (Matrix, Shown, Vector, Vec<(usize, Coupling)>);

impl Crowd {
    /// Where the rings stand; `None` where no ring has another in reach.
    pub(super) fn of(ratio: f64, rings: &[Under]) -> Option<Self> {
        let models: Vec<RingModel> = rings.iter().map(|ring| ring.model).collect();
        let alone: Vec<Alone> = rings
            .par_iter()
            .enumerate()
            .map_init(Workspace::default, |room, (i, ring)| {
                let own = part(ratio, ring, (i, &models, rings), room);
                own.unwrap_or_else(|| (Matrix::zeros(), Shown::identity(), Vector::zeros(), vec![]))
            })
            .collect();
        if alone.iter().all(|(_, _, _, others)| others.is_empty()) {
            return None;
        }
        let spreads: Vec<Shown> = alone.iter().map(|(_, spread, _, _)| *spread).collect();
        let part = |(inverse, spread, gradient, others): Alone| {
            let shown = inverse.fixed_rows::<SHOWN>(0);
            let coupled = others.into_iter().map(|(j, coupling)| {
                let coupling = coupling * spreads[j];
                let by_other = spread.solve_lower_triangular(&(shown * coupling));
                (j, coupling, by_other.unwrap_or_else(Shown::zeros))
            });
            let by_others = coupled.collect();
            Part {
                inverse,
                gradient,
                spread,
                by_others,
            }
        };
        Some(Self(alone.into_par_iter().map(part).collect()))
    }

    /// The step of each ring; `None` where none is found.
    pub(super) fn steps(&self) -> Option<Vec<Vector>> {
        let alone: Vec<Vector> = self.0.iter().map(|p| p.inverse * p.gradient).collect();
        let mut right = DVector::zeros(SHOWN * self.0.len());
        for (i, (part, step)) in self.0.iter().zip(&alone).enumerate() {
            let own = step.fixed_rows::<SHOWN>(0);
            let own = part.spread.solve_lower_triangular(&own)?;
            right.fixed_rows_mut::<SHOWN>(SHOWN * i).copy_from(&own);
        }
        let product = |w: &DVector<f64>| {
            let mut out = w.clone();
            for (i, part) in self.0.iter().enumerate() {
                let mut own = out.fixed_rows_mut::<SHOWN>(SHOWN * i);
                for (j, _, by_other) in &part.by_others {
                    own += by_other * w.fixed_rows::<SHOWN>(SHOWN * j);
                }
            }
            out
        };
        let solution = gmres(&right, product)?;
        let parts = self.0.iter().zip(alone);
        let steps = parts.map(|(part, alone)| {
            let of_others = part
                .by_others
                .iter()
                .map(|(j, coupling, _)| coupling * solution.fixed_rows::<SHOWN>(SHOWN * j));
            alone - part.inverse * of_others.sum::<Vector>()
        });
        Some(steps.collect())
    }

    /// Makes the rings as uncertain as they are with neighbours that are not known either.
    pub(super) fn widen(&self, rings: &mut [Under]) {
        let work = rings.par_iter_mut().enumerate();
        work.for_each(|(i, ring)| {
            if let (Ok(fitted), Some(added)) = (&mut ring.fitted, self.added(i)) {
                fitted.covariance += added * fitted.noise.powi(2);
            }
        });
    }

    /// What its neighbours' uncertainty adds to the covariance of a ring's shape, in variances of the noise: L_i (X_ii - 1) L_i^T, with the
    /// rings beyond its neighbours as if they were known.
    fn added(&self, i: usize) -> Option<ShapeCovariance> {
        let part = self.0.get(i)?;
        let near: Vec<usize> = part.by_others.iter().map(|(j, _, _)| *j).collect();
        let back: Vec<Option<&Shown>> = near.iter().map(|&j| self.by(j, i)).collect();
        let most: f64 = part
            .by_others
            .iter()
            .zip(&back)
            .map(|((_, _, there), back)| back.map_or(0.0, |back| there.norm() * back.norm()))
            .sum();
        if most < WORTH_TELLING {
            return None;
        }
        let size = SHOWN * near.len();
        let mut among = DMatrix::<f64>::identity(size, size);
        let mut of_ring = DMatrix::<f64>::zeros(size, SHOWN);
        for (a, back) in back.iter().enumerate() {
            if let Some(back) = back {
                of_ring
                    .view_mut((SHOWN * a, 0), (SHOWN, SHOWN))
                    .copy_from(back);
            }
            for (b, &other) in near.iter().enumerate() {
                if let Some(coupled) = self.by(near[a], other) {
                    let place = (SHOWN * a, SHOWN * b);
                    among.view_mut(place, (SHOWN, SHOWN)).copy_from(coupled);
                }
            }
        }
        let answers = among.lu().solve(&of_ring)?;
        let mut schur = Shown::identity();
        for (a, (_, _, there)) in part.by_others.iter().enumerate() {
            schur -= there * answers.fixed_view::<SHOWN, SHOWN>(SHOWN * a, 0);
        }
        let more = schur.try_inverse()? - Shown::identity();
        let more = part.spread * (0.5 * (more + more.transpose())) * part.spread.transpose();
        let shape = more.fixed_view::<SHAPE_PARAMETERS, SHAPE_PARAMETERS>(0, 0);
        Some(shape.into_owned())
    }

    /// H of two rings, where one reaches the other.
    fn by(&self, ring: usize, other: usize) -> Option<&Shown> {
        let by_others = &self.0.get(ring)?.by_others;
        let found = by_others.iter().find(|(j, _, _)| *j == other);
        found.map(|(_, _, by_other)| by_other)
    }
}

/// A^-1, L, the gradient and the couplings of one ring; `None` where it has no fit, and so no say.
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
    let inverse = back * back.transpose();
    let shown = inverse.fixed_view::<SHOWN, SHOWN>(0, 0).into_owned();
    let scales = shown.diagonal().map(|v| v.max(f64::MIN_POSITIVE).sqrt());
    let unit = Shown::from_fn(|i, j| shown[(i, j)] / (scales[i] * scales[j]));
    let spread = Shown::from_diagonal(&scales) * unit.cholesky()?.l();
    let couplings = others.iter().map(|(j, _)| *j).zip(couplings).collect();
    Some((inverse, spread, gradient, couplings))
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
