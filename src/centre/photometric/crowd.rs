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

use super::around::reaches;
use super::coverage::{COVERAGE_PARAMETERS, LANES, Plane};
use super::descent::add_priors;
use super::equations::{diagonal_scales, freeze, scaled_by};
use super::fitted::ShapeCovariance;
use super::gmres::gmres;
use super::model::{BLUR, Matrix, PARAMETERS, RingModel, SHEET, Vector};
use super::problem::{Normal, Problem, Workspace};
use super::rows::shades;
use super::shape::SHAPE_PARAMETERS;
use super::under::Under;
use super::wall::Wall;
use super::window::Grid;
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

/// Whether the ends of the sheet beside rings are to be found too. They show in no other ring's window, and in their tails what they add is so
/// far from linear that a step would be worth nothing: a fit of the ring finds them better.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ends {
    Free,
    Held,
}

/// One ring's part of them.
struct Part {
    /// A_i^-1.
    inverse: Matrix,
    gradient: Vector,
    /// L_i.
    spread: Shown,
    /// How much less its sum of squares would be if it stood at its best among the others as they are, in variances of its noise.
    wants: f64,
    /// B_ij L_j, H_ij, and j.
    by_others: Vec<(usize, Coupling, Shown)>,
}

/// One ring's part as far as it is known from its own window: the B_ij are not yet in the others' units.
struct Alone {
    inverse: Matrix,
    gradient: Vector,
    spread: Shown,
    wants: f64,
    couplings: Vec<(usize, Coupling)>,
}

impl Alone {
    /// Of a ring without a fit, which has no say.
    fn mute() -> Self {
        Self {
            inverse: Matrix::zeros(),
            gradient: Vector::zeros(),
            spread: Shown::identity(),
            wants: 0.0,
            couplings: Vec::new(),
        }
    }

    fn among(self, spreads: &[Shown]) -> Part {
        let shown = self.inverse.fixed_rows::<SHOWN>(0);
        let coupled = self.couplings.into_iter().map(|(j, coupling)| {
            let coupling = coupling * spreads[j];
            let by_other = self.spread.solve_lower_triangular(&(shown * coupling));
            (j, coupling, by_other.unwrap_or_else(Shown::zeros))
        });
        Part {
            inverse: self.inverse,
            gradient: self.gradient,
            spread: self.spread,
            wants: self.wants,
            by_others: coupled.collect(),
        }
    }
}

impl Crowd {
    /// Where rings are at these models; `None` where no ring has another in reach.
    pub(super) fn of(
        ratio: f64,
        (rings, models): (&[Under], &[RingModel]),
        ends: Ends,
    ) -> Option<Self> {
        let alone: Vec<Alone> = rings
            .par_iter()
            .enumerate()
            .map_init(Workspace::default, |room, (i, ring)| {
                alone(ratio, ring, (i, models, rings), ends, room).unwrap_or_else(Alone::mute)
            })
            .collect();
        if alone.iter().all(|ring| ring.couplings.is_empty()) {
            return None;
        }
        let spreads: Vec<Shown> = alone.iter().map(|ring| ring.spread).collect();
        let parts = alone.into_par_iter().map(|ring| ring.among(&spreads));
        Some(Self(parts.collect()))
    }

    /// How much less the rings' sums of squares would be if each stood at its best among the others as they are, in variances of their noise.
    pub(super) fn wants(&self) -> f64 {
        self.0.iter().map(|part| part.wants).sum()
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

/// What one ring's own window says; `None` where it has no fit.
fn alone(
    ratio: f64,
    ring: &Under,
    (own, models, rings): (usize, &[RingModel], &[Under]),
    ends: Ends,
    room: &mut Workspace,
) -> Option<Alone> {
    let (fitted, model) = (ring.fitted.ok()?, models[own]);
    let window = ring.window.as_ref()?;
    let near: Vec<usize> = (0..rings.len())
        .filter(|&j| j != own && reaches(&models[j], &window.grid))
        .filter(|&j| models[j].shape.ellipse(ratio).is_some())
        .collect();
    let (around, shown) = room.neighbours(&window.grid, (&model, ratio), &near, models)?;
    let problem = Problem {
        window,
        ratio,
        around: Some(&around),
        noise: fitted.noise,
    };
    let (normal, mut couplings) = room.couplings(&problem, &model, &shown)?;
    let (mut matrix, mut gradient) = (normal.matrix, normal.gradient);
    let (parameters, wall) = (model.parameters(), Wall::of(&matrix));
    wall.push(&parameters, &mut gradient);
    wall.stiffen(&parameters, &mut matrix);
    add_priors(&mut matrix, model.count());
    if ends == Ends::Held {
        for k in SHEET..model.count() {
            freeze(&mut matrix, k);
            gradient[k] = 0.0;
            couplings
                .iter_mut()
                .for_each(|coupling| coupling.row_mut(k).fill(0.0));
        }
    }
    let inverse = inverse(&matrix)?;
    let shown = inverse.fixed_view::<SHOWN, SHOWN>(0, 0).into_owned();
    let scales = shown.diagonal().map(|v| v.max(f64::MIN_POSITIVE).sqrt());
    let unit = Shown::from_fn(|i, j| shown[(i, j)] / (scales[i] * scales[j]));
    let couplings = near.into_iter().zip(couplings);
    Some(Alone {
        inverse,
        gradient,
        spread: Shown::from_diagonal(&scales) * unit.cholesky()?.l(),
        wants: gradient.dot(&(inverse * gradient)) / (fitted.noise * fitted.noise),
        couplings: couplings
            .filter(|(j, _)| rings[*j].fitted.is_ok())
            .collect(),
    })
}

/// Of a normal matrix, whose units differ by many orders of magnitude.
fn inverse(matrix: &Matrix) -> Option<Matrix> {
    let scales = diagonal_scales::<PARAMETERS>(matrix);
    let inverse = scaled_by(matrix, &scales).cholesky()?.l().try_inverse()?;
    let back = Matrix::from_fn(|i, j| scales[i] * inverse[(j, i)]);
    Some(back * back.transpose())
}

/// What a neighbour shows in a ring's window changes so by its shape and blur (its square, px^2), were it lit like the ring.
struct ShownChanges {
    planes: [Plane; COVERAGE_PARAMETERS],
    by_blur: f64,
}

impl Workspace {
    /// The coverages of a ring's window by its neighbours together, and how what each shows there changes; `None` where one of the shapes is no
    /// ring.
    fn neighbours(
        &mut self,
        grid: &Grid,
        (model, ratio): (&RingModel, f64),
        near: &[usize],
        models: &[RingModel],
    ) -> Option<([Plane; 2], Vec<ShownChanges>)> {
        let size = grid.stride() * grid.height;
        let mut around = [vec![0.0; size], vec![0.0; size]];
        let contrasts = Some(model.contrasts());
        let shown = near.iter().map(|&j| {
            let other = &models[j];
            self.dispatch(
                #[inline(always)]
                |room| {
                    let shape = (&other.shape, &other.blur);
                    room.coverage.fill(grid, shape, ratio, contrasts, None)?;
                    for (sum, circle) in around.iter_mut().zip(&room.coverage.circles) {
                        let pairs = sum.iter_mut().zip(circle);
                        pairs.for_each(|(sum, circle)| *sum += circle);
                    }
                    Some(ShownChanges {
                        planes: std::mem::take(&mut room.coverage.changes),
                        by_blur: other.by_blur(grid),
                    })
                },
            )
        });
        let shown = shown.collect::<Option<Vec<_>>>()?;
        Some((around, shown))
    }

    /// The normal equations at a model, and the products of its derivatives with those by shape and blur of others; `None` where its shape is no
    /// ring.
    fn couplings(
        &mut self,
        problem: &Problem,
        model: &RingModel,
        others: &[ShownChanges],
    ) -> Option<(Normal, Vec<Coupling>)> {
        let grid = &problem.window.grid;
        let mut derivatives = vec![Vec::new(); model.count()];
        let normal = self.normal_and(problem, model, |rows| {
            for (k, all) in derivatives.iter_mut().enumerate() {
                all.extend_from_slice(rows.column(k));
            }
        })?;
        // what is seen of another is shaded like the ring
        let shades: Vec<f32> = (0..grid.height)
            .flat_map(|row| shades(model, grid, row))
            .collect();
        self.dispatch(
            #[inline(always)]
            |_| {
                for derivative in &mut derivatives {
                    let pairs = derivative.iter_mut().zip(&shades);
                    pairs.for_each(|(derivative, shade)| *derivative *= shade);
                }
                let couplings = others.iter().map(|other| {
                    Coupling::from_fn(|a, k| match derivatives.get(a) {
                        Some(own) => {
                            let scale = if k == BLUR { other.by_blur } else { 1.0 };
                            scale * sum_of_products(own, &other.planes[k])
                        }
                        None => 0.0,
                    })
                });
                Some((normal, couplings.collect()))
            },
        )
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
