//! Which views to choose: the design of an experiment whose measurements are views.
//!
//! What a view says of the numbers that all views share is a matrix, S_v = A_v - B_v C_v^-1 B_v' (`normal_equations`): what it
//! measures less what its own pose takes. The matrices add up, and the inverse of the sum S is the covariance of the
//! shared numbers in units of the variance of the residuals. What is gained by a view is how much less is unknown
//! afterwards, Shannon's entropy before less after (Lindley 1956): 1/2 ln det(I + S^-1 S_v), in nats. Choosing by it is called D-optimal. It
//! needs neither a unit for a focal length beside a distortion coefficient nor the variance. And it never grows when
//! other views are added first, so that taking the best view again and again comes within 1 - 1/e of the best set (Nemhauser,
//! Wolsey and Fisher 1978).

use nalgebra::{Cholesky, DMatrix, Dyn};

/// What is known before the first view of a greedy choice, as a part of what all candidates say together.
const PRIOR: f64 = 1e-6;

/// What information matrices add up to, in a form that answers questions.
pub(super) struct Total {
    matrix: DMatrix<f64>,
    log_det: f64,
}

impl Total {
    /// `None` where the information leaves something open.
    pub fn new(matrix: DMatrix<f64>) -> Option<Self> {
        let log_det = log_det(&matrix)?;
        Some(Self { matrix, log_det })
    }

    /// What a view adds, nats; 0 where that cannot be said.
    pub fn gain_nats(&self, view: &DMatrix<f64>) -> f64 {
        let after = log_det(&(&self.matrix + view));
        after.map_or(0.0, |after| 0.5 * (after - self.log_det))
    }

    /// What would be lost without a view that is part of it, nats; infinite where something would be left open.
    pub fn loss_nats(&self, view: &DMatrix<f64>) -> f64 {
        let after = log_det(&(&self.matrix - view));
        after.map_or(f64::INFINITY, |after| 0.5 * (self.log_det - after))
    }

    /// With another view.
    pub fn with(&self, view: &DMatrix<f64>) -> Option<Self> {
        Self::new(&self.matrix + view)
    }

    /// Standard deviation of one of the shared numbers, for residuals of unit variance.
    pub fn std(&self, place: usize) -> Option<f64> {
        let (scale, factor) = scaled(&self.matrix)?;
        let mut unit = nalgebra::DVector::zeros(self.matrix.nrows());
        *unit.get_mut(place)? = scale[place];
        let column = factor.solve(&unit);
        Some((column[place] * scale[place]).max(0.0).sqrt())
    }
}

/// The best candidates, at most `count`, each in addition to those before it; in the order of the choice, and of equally good ones
/// the first. `None` is no candidate. A candidate that `repeats` a chosen one (chosen, candidate) is passed over.
pub(super) fn greedy(
    candidates: &[Option<&DMatrix<f64>>],
    count: usize,
    mut repeats: impl FnMut(usize, usize) -> bool,
) -> Vec<usize> {
    let Some(first) = candidates.iter().flatten().next() else {
        return Vec::new();
    };
    let nothing = DMatrix::zeros(first.nrows(), first.ncols());
    let all = candidates.iter().flatten().fold(nothing, |sum, s| sum + *s);
    let mut total = Total::new(all * PRIOR);
    // a gain only falls as others are chosen, so that an old one is a bound and most need not be computed again (Minoux 1978)
    let mut bounds: Vec<f64> = candidates
        .iter()
        .map(|c| c.map_or(f64::NEG_INFINITY, |_| f64::INFINITY))
        .collect();
    let mut fresh = vec![false; candidates.len()];
    let mut chosen = Vec::new();
    while let (true, Some(now)) = (chosen.len() < count, &total) {
        let Some(best) = first_largest(&bounds) else {
            break;
        };
        let Some(information) = candidates[best] else {
            break;
        };
        if !fresh[best] {
            bounds[best] = now.gain_nats(information);
            fresh[best] = true;
            continue;
        }
        total = now.with(information);
        chosen.push(best);
        bounds[best] = f64::NEG_INFINITY;
        for at in 0..bounds.len() {
            fresh[at] = false;
            if bounds[at] > f64::NEG_INFINITY && repeats(best, at) {
                bounds[at] = f64::NEG_INFINITY;
            }
        }
    }
    chosen
}

/// The place of the first of the largest; `None` where all are minus infinity.
fn first_largest(values: &[f64]) -> Option<usize> {
    let mut best = None;
    for (at, value) in values.iter().enumerate() {
        let larger = best.is_none_or(|(_, most)| *value > most);
        if larger && *value > f64::NEG_INFINITY {
            best = Some((at, *value));
        }
    }
    best.map(|(at, _)| at)
}

/// Logarithm of the determinant; `None` where the matrix is not positive definite.
fn log_det(matrix: &DMatrix<f64>) -> Option<f64> {
    let (scale, factor) = scaled(matrix)?;
    let of_factor: f64 = factor.l_dirty().diagonal().iter().map(|l| l.ln()).sum();
    let of_scale: f64 = scale.iter().map(|s| s.ln()).sum();
    Some(2.0 * (of_factor - of_scale))
}

/// The factor of D M D with a diagonal of ones, and the diagonal of D: a focal length and a k3 differ by ten orders of magnitude.
fn scaled(matrix: &DMatrix<f64>) -> Option<(Vec<f64>, Cholesky<f64, Dyn>)> {
    let diagonal = matrix.diagonal();
    // not a number is not positive
    if !diagonal.iter().all(|d| *d > 0.0 && d.is_finite()) {
        return None;
    }
    let scale: Vec<f64> = diagonal.iter().map(|d| 1.0 / d.sqrt()).collect();
    let (rows, columns) = matrix.shape();
    let scaled = DMatrix::from_fn(rows, columns, |i, j| matrix[(i, j)] * scale[i] * scale[j]);
    Some((scale, scaled.cholesky()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn diagonal(values: [f64; 2]) -> DMatrix<f64> {
        DMatrix::from_diagonal(&nalgebra::DVector::from_row_slice(&values))
    }

    #[test]
    fn gain_and_loss_are_those_of_the_determinant() {
        let total = Total::new(diagonal([1e8, 1e-8])).unwrap();
        let gain = total.gain_nats(&diagonal([1e8, 0.0]));
        assert!((gain - 0.5 * 2.0_f64.ln()).abs() < 1e-12);
        let loss = total.loss_nats(&diagonal([0.5e8, 0.0]));
        assert!((loss - 0.5 * 2.0_f64.ln()).abs() < 1e-12);
        assert_eq!(total.loss_nats(&diagonal([0.0, 1e-8])), f64::INFINITY);
        assert!((total.std(1).unwrap() - 1e4).abs() < 1e-6);
        assert!(Total::new(diagonal([1.0, 0.0])).is_none());
        assert!(Total::new(diagonal([1.0, f64::NAN])).is_none());
    }

    #[test]
    fn the_greedy_choice_takes_what_is_missing_and_the_first_of_equals() {
        let [a, b, both] = [[4.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(diagonal);
        let candidates = [Some(&a), None, Some(&a), Some(&b), Some(&both), Some(&both)];
        let chosen = greedy(&candidates, 3, |_, _| false);
        assert_eq!(chosen, greedy(&candidates, 3, |_, _| false));
        assert_eq!(chosen[0], 4);
        assert_eq!(greedy(&candidates, 9, |_, _| false).len(), 5);
        // of two that are the same only the first is taken where the second repeats it
        let without = greedy(&candidates, 9, |a, b| candidates[a] == candidates[b]);
        assert!(!without.contains(&2) && !without.contains(&5) && without.len() == 3);
        assert!(greedy(&[None, None], 2, |_, _| false).is_empty());
    }
}
