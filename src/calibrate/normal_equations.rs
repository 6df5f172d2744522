//! The normal equations of the adjustment and their solution with the poses eliminated.
//!
//! Unknowns are the free numbers c that the views share and six numbers p_v a view (a rotation vector applied on the left,
//! then a shift). A residual depends on c and the p of its own view alone, so that J^T J is
//!
//! ```text
//!     | A    B_1  B_2 ... |
//!     | B_1' C_1          |     A = sum over views,  C_v is 6 x 6
//!     | B_2'      C_2     |
//! ```
//!
//! and the Schur complement S = A - sum B_v C_v^-1 B_v' leaves a system in c alone. All columns are scaled to unit
//! length first, because a focal length of 20000 px and a k3 differ by ten orders of magnitude. Sums run in the order of
//! the views, so that the result does not depend on the number of threads.

use super::adjust::Solution;
use super::linearise::{POSE, ViewBlock, view_block};
use super::observations::Observation;
use super::shared::Free;
use nalgebra::{
    Cholesky, Const, DMatrix, DVector, Matrix6, OMatrix, Rotation3, U6, Vector3, Vector6,
};
use rayon::prelude::*;

/// Least over largest eigenvalue of the scaled Schur complement that counts as singular.
const SINGULAR: f64 = 1e-15;

/// The normal equations at one camera and set of poses.
#[derive(Debug, Clone)]
pub(super) struct NormalEquations {
    blocks: Vec<ViewBlock>,
    free: usize,
    /// What the free numbers themselves are charged: cost, gradient and its derivative.
    charged: (f64, DVector<f64>, DVector<f64>),
}

/// A step of the adjustment.
#[derive(Debug, Clone)]
pub(super) struct Step {
    shared: DVector<f64>,
    poses: Vec<Vector6<f64>>,
    /// By how much the cost should fall, were the residuals linear.
    pub predicted: f64,
}

/// The system in the shared numbers alone, columns scaled.
struct Reduced {
    system: DMatrix<f64>,
    right: DVector<f64>,
    scale: DVector<f64>,
    views: Vec<ReducedView>,
}

/// What it takes to find a view's pose step once that of the camera is known, columns scaled.
struct ReducedView {
    scale: Vector6<f64>,
    /// B_v.
    mixed: OMatrix<f64, nalgebra::Dyn, U6>,
    pose: Cholesky<f64, Const<6>>,
    gradient: Vector6<f64>,
}

/// The inverse of J^T J in blocks: what the covariance of anything is made of, for residuals of unit variance.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Inverse {
    /// S^-1: the covariance of the free numbers.
    pub shared: DMatrix<f64>,
    /// Of each view.
    pub views: Vec<InverseView>,
}

/// A view's part of [`Inverse`].
#[derive(Debug, Clone, PartialEq)]
pub(super) struct InverseView {
    /// C_v^-1.
    pub own: Matrix6<f64>,
    /// B_v C_v^-1.
    pub mixed: OMatrix<f64, nalgebra::Dyn, U6>,
}

impl NormalEquations {
    /// Linearises at a solution; `None` where a ring has no image.
    pub fn at(solution: &Solution, rings: &[Vec<Observation>], free: &Free) -> Option<Self> {
        let blocks: Vec<Option<ViewBlock>> = solution
            .poses
            .par_iter()
            .zip(rings)
            .with_min_len(4)
            .map(|(pose, rings)| view_block(&solution.shared, pose, rings, free))
            .collect();
        let blocks = blocks.into_iter().collect::<Option<_>>()?;
        let (cost, slopes) = free.charged(&solution.shared);
        let charges = free.columns.iter().map(|column| column.charge);
        Some(Self {
            blocks,
            free: free.len(),
            charged: (
                cost,
                DVector::from_vec(slopes),
                DVector::from_iterator(free.len(), charges),
            ),
        })
    }

    /// What is minimised: the squared whitened residuals and what the free numbers are charged.
    pub fn cost(&self) -> f64 {
        self.charged.0 + self.squares()
    }

    /// Sum of the squared whitened residuals.
    pub fn squares(&self) -> f64 {
        self.blocks.iter().map(|block| block.cost).sum()
    }

    /// The part of each view in [`NormalEquations::squares`].
    pub fn view_squares(&self) -> Vec<f64> {
        self.blocks.iter().map(|block| block.cost).collect()
    }

    /// What the free numbers themselves are charged, as a part of the equations.
    pub fn charges(&self) -> DMatrix<f64> {
        DMatrix::from_diagonal(&self.charged.2)
    }

    /// The Levenberg-Marquardt step with damping `lambda` relative to the scaled diagonal; `None` where the equations
    /// are singular.
    pub fn step(&self, lambda: f64) -> Option<Step> {
        let reduced = self.reduce(lambda)?;
        let shared = if self.free == 0 {
            DVector::zeros(0)
        } else {
            -reduced.system.clone().cholesky()?.solve(&reduced.right)
        };
        let gradient = self.gradient().component_mul(&reduced.scale);
        let mut predicted = lambda * shared.norm_squared() - shared.dot(&gradient);
        let mut poses = Vec::with_capacity(reduced.views.len());
        for view in &reduced.views {
            let back = view.mixed.tr_mul(&shared);
            let pose = -view.pose.solve(&(view.gradient + back));
            predicted += lambda * pose.norm_squared() - pose.dot(&view.gradient);
            poses.push(pose.component_mul(&view.scale));
        }
        predicted.is_finite().then(|| Step {
            shared: shared.component_mul(&reduced.scale),
            poses,
            predicted,
        })
    }

    /// The inverse of J^T J. `Err` holds the place among the free numbers that takes the largest part in what the views leave
    /// open.
    pub fn inverse(&self) -> Result<Inverse, usize> {
        let reduced = self.reduce(0.0).ok_or(0_usize)?;
        let shared = if self.free == 0 {
            DMatrix::zeros(0, 0)
        } else {
            let inverse = definite_inverse(&reduced.system)?;
            let scale = DMatrix::from_diagonal(&reduced.scale);
            &scale * inverse * &scale
        };
        let unscaled = DMatrix::from_diagonal(&reduced.scale.map(|s| 1.0 / s));
        let views = reduced.views.iter().map(|view| {
            let scale = Matrix6::from_diagonal(&view.scale);
            let inverse = view.pose.inverse();
            InverseView {
                own: scale * inverse * scale,
                mixed: &unscaled * &view.mixed * inverse * scale,
            }
        });
        Ok(Inverse {
            views: views.collect(),
            shared,
        })
    }

    /// What each view says of the shared numbers once its own pose is paid for: A_v - B_v C_v^-1 B_v', which add up to S.
    pub fn information(&self) -> Option<Vec<DMatrix<f64>>> {
        self.blocks
            .iter()
            .map(|block| {
                let factor = block.pose().cholesky()?;
                let mixed = block.mixed(self.free);
                let eliminated = factor.solve(&mixed.transpose());
                Some(block.shared(self.free) - mixed * eliminated)
            })
            .collect()
    }

    /// Half the derivatives of each view's squared residuals by the shared numbers, its pose following: its part of the
    /// right hand side once the poses are eliminated.
    pub fn pulls(&self) -> Option<Vec<DVector<f64>>> {
        self.blocks
            .iter()
            .map(|block| {
                let own = block.gradient.fixed_rows::<POSE>(0).into_owned();
                let through = block.mixed(self.free) * block.pose().cholesky()?.solve(&own);
                Some(block.gradient.rows(POSE, self.free).into_owned() - through)
            })
            .collect()
    }

    fn gradient(&self) -> DVector<f64> {
        let mut sum = self.charged.1.clone();
        for block in &self.blocks {
            sum += block.gradient.rows(POSE, self.free);
        }
        sum
    }

    fn reduce(&self, lambda: f64) -> Option<Reduced> {
        let count = self.free;
        let mut system = DMatrix::from_diagonal(&self.charged.2);
        for block in &self.blocks {
            system += block.shared(count);
        }
        let scale = system.diagonal().map(unit);
        for (i, j) in (0..count).flat_map(|i| (0..count).map(move |j| (i, j))) {
            system[(i, j)] *= scale[i] * scale[j];
        }
        for i in 0..count {
            system[(i, i)] += lambda;
        }
        let mut right = self.gradient().component_mul(&scale);
        let mut views = Vec::with_capacity(self.blocks.len());
        for block in &self.blocks {
            let view = ReducedView::of(block, &scale, lambda)?;
            let eliminated = view.pose.solve(&view.mixed.transpose());
            system.gemm(-1.0, &view.mixed, &eliminated, 1.0);
            right.gemv(-1.0, &view.mixed, &view.pose.solve(&view.gradient), 1.0);
            views.push(view);
        }
        Some(Reduced {
            system,
            right,
            scale,
            views,
        })
    }
}

/// The inverse of a symmetric matrix with a unit diagonal, or the place of its weakest direction's largest part.
fn definite_inverse(system: &DMatrix<f64>) -> Result<DMatrix<f64>, usize> {
    let eigen = system.clone().symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    // not a number counts as singular
    let regular = eigen.eigenvalues[least] > SINGULAR * eigen.eigenvalues.max();
    if !regular {
        return Err(eigen.eigenvectors.column(least).iamax());
    }
    let inverse = &eigen.eigenvectors
        * DMatrix::from_diagonal(&eigen.eigenvalues.map(|value| 1.0 / value))
        * eigen.eigenvectors.transpose();
    Ok(0.5 * (&inverse + inverse.transpose()))
}

impl ReducedView {
    fn of(block: &ViewBlock, scale: &DVector<f64>, lambda: f64) -> Option<Self> {
        let own = block.pose().diagonal().map(unit);
        let mut pose = block.pose();
        let mut mixed = block.mixed(scale.len());
        for j in 0..POSE {
            for i in 0..POSE {
                pose[(i, j)] *= own[i] * own[j];
            }
            pose[(j, j)] += lambda;
            for i in 0..scale.len() {
                mixed[(i, j)] *= scale[i] * own[j];
            }
        }
        Some(Self {
            scale: own,
            mixed,
            pose: pose.cholesky()?,
            gradient: block.gradient.fixed_rows::<POSE>(0).component_mul(&own),
        })
    }
}

/// What makes a column of this squared length one of length 1.
fn unit(squared_length: f64) -> f64 {
    if squared_length > 0.0 {
        1.0 / squared_length.sqrt()
    } else {
        1.0
    }
}

impl Step {
    /// The solution after the step.
    pub fn apply(&self, solution: &Solution, free: &Free) -> Solution {
        let moved = solution.poses.iter().zip(&self.poses).map(|(pose, step)| {
            let turn = Rotation3::new(Vector3::new(step[0], step[1], step[2]));
            // by way of the rotation vector, so that rounding never bends the matrix over many steps
            crate::camera::Pose::from_rotation_vector(
                (turn * pose.rotation).scaled_axis(),
                pose.translation_m + Vector3::new(step[3], step[4], step[5]),
            )
        });
        Solution {
            shared: solution.shared.moved(free, &self.shared),
            poses: moved.collect(),
        }
    }
}
