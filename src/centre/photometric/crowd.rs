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

use super::alone::{Alone, Coupling, Ends, SHOWN, Shown, alone};
use super::fitted::ShapeCovariance;
use super::gmres::gmres;
use super::model::{Matrix, RingModel, Vector};
use super::problem::Workspace;
use super::shape::SHAPE_PARAMETERS;
use super::under::Under;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

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
    /// How much less its sum of squares would be if it stood at its best among the others as they are, in variances of its noise.
    wants: f64,
    /// B_ij L_j, H_ij, and j.
    by_others: Vec<(usize, Coupling, Shown)>,
}

impl Part {
    /// A ring's part, where the spreads of all are known.
    fn of(alone: Alone, spreads: &[Shown]) -> Self {
        let shown = alone.inverse.fixed_rows::<SHOWN>(0);
        let coupled = alone.couplings.into_iter().map(|(j, coupling)| {
            let coupling = coupling * spreads[j];
            let by_other = alone.spread.solve_lower_triangular(&(shown * coupling));
            (j, coupling, by_other.unwrap_or_else(Shown::zeros))
        });
        Self {
            inverse: alone.inverse,
            gradient: alone.gradient,
            spread: alone.spread,
            wants: alone.wants,
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
        let parts = alone.into_par_iter().map(|ring| Part::of(ring, &spreads));
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
