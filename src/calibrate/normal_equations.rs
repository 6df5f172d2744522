//! The normal equations of the adjustment and their solution with the poses eliminated.
//!
//! Unknowns are the free parameters c of the camera and six numbers p_v a view (a rotation vector applied on the left,
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

use super::observations::Observation;
use crate::camera::{Camera, Pose};
use nalgebra::{
    Cholesky, Const, DMatrix, DVector, Matrix2, Matrix6, Rotation3, SMatrix, SVector, Vector2,
    Vector3, Vector6,
};
use rayon::prelude::*;

const COUNT: usize = Camera::PARAMETER_COUNT;

/// What one view adds to the normal equations; all parameters of the camera, free or not.
#[derive(Debug, Clone)]
pub(super) struct ViewBlock {
    camera: SMatrix<f64, COUNT, COUNT>,
    mixed: SMatrix<f64, COUNT, 6>,
    pose: Matrix6<f64>,
    camera_gradient: SVector<f64, COUNT>,
    pose_gradient: Vector6<f64>,
    /// Sum of the squared whitened residuals.
    cost: f64,
}

/// The normal equations at one camera and set of poses.
#[derive(Debug, Clone)]
pub(super) struct NormalEquations {
    blocks: Vec<ViewBlock>,
}

/// A step of the adjustment.
#[derive(Debug, Clone)]
pub(super) struct Step {
    camera: [f64; COUNT],
    poses: Vec<Vector6<f64>>,
    /// By how much the cost should fall, were the residuals linear.
    pub predicted: f64,
}

/// The system in the camera's free parameters alone, columns scaled.
struct Reduced {
    system: DMatrix<f64>,
    right: DVector<f64>,
    scale: DVector<f64>,
    views: Vec<ReducedView>,
}

/// What it takes to find a view's pose step once that of the camera is known, columns scaled.
struct ReducedView {
    scale: Vector6<f64>,
    mixed: DMatrix<f64>,
    pose: Cholesky<f64, Const<6>>,
    gradient: Vector6<f64>,
}

impl NormalEquations {
    /// Linearises at a camera and poses; `None` where a ring falls behind the camera.
    pub fn at(camera: &Camera, poses: &[Pose], rings: &[Vec<Observation>]) -> Option<Self> {
        let blocks: Vec<Option<ViewBlock>> = poses
            .par_iter()
            .zip(rings)
            .map(|(pose, rings)| view_block(camera, pose, rings))
            .collect();
        let blocks = blocks.into_iter().collect::<Option<_>>()?;
        Some(Self { blocks })
    }

    /// Sum of the squared whitened residuals.
    pub fn cost(&self) -> f64 {
        self.blocks.iter().map(|block| block.cost).sum()
    }

    /// The Levenberg-Marquardt step with damping `lambda` relative to the scaled diagonal; `None` where the equations
    /// are singular.
    pub fn step(&self, free: &[usize], lambda: f64) -> Option<Step> {
        let reduced = self.reduce(free, lambda)?;
        let camera = if free.is_empty() {
            DVector::zeros(0)
        } else {
            -reduced.system.clone().cholesky()?.solve(&reduced.right)
        };
        let gradient = self.camera_gradient(free).component_mul(&reduced.scale);
        let mut predicted = lambda * camera.norm_squared() - camera.dot(&gradient);
        let mut poses = Vec::with_capacity(reduced.views.len());
        for view in &reduced.views {
            let back = view.mixed.transpose() * &camera;
            let pose = -view
                .pose
                .solve(&(view.gradient + Vector6::from_iterator(back.iter().copied())));
            predicted += lambda * pose.norm_squared() - pose.dot(&view.gradient);
            poses.push(pose.component_mul(&view.scale));
        }
        let mut whole = [0.0; COUNT];
        for (i, at) in free.iter().enumerate() {
            whole[*at] = camera[i] * reduced.scale[i];
        }
        predicted.is_finite().then_some(Step {
            camera: whole,
            poses,
            predicted,
        })
    }

    /// Inverse of the Schur complement: the covariance of the free parameters for residuals of unit variance. `Err`
    /// holds the place in `free` that takes the largest part in what the views leave open.
    pub fn covariance(&self, free: &[usize]) -> Result<DMatrix<f64>, usize> {
        if free.is_empty() {
            return Ok(DMatrix::zeros(0, 0));
        }
        let reduced = self.reduce(free, 0.0).ok_or(0_usize)?;
        let eigen = reduced.system.clone().symmetric_eigen();
        let least = eigen.eigenvalues.imin();
        if eigen.eigenvalues[least] <= SINGULAR * eigen.eigenvalues.max() {
            return Err(eigen.eigenvectors.column(least).iamax());
        }
        let inverse = eigen.eigenvectors.clone()
            * DMatrix::from_diagonal(&eigen.eigenvalues.map(|value| 1.0 / value))
            * eigen.eigenvectors.transpose();
        let scale = DMatrix::from_diagonal(&reduced.scale);
        let covariance = &scale * inverse * &scale;
        Ok(0.5 * (&covariance + covariance.transpose()))
    }

    fn camera_gradient(&self, free: &[usize]) -> DVector<f64> {
        let mut sum = SVector::<f64, COUNT>::zeros();
        for block in &self.blocks {
            sum += block.camera_gradient;
        }
        DVector::from_iterator(free.len(), free.iter().map(|at| sum[*at]))
    }

    fn reduce(&self, free: &[usize], lambda: f64) -> Option<Reduced> {
        let count = free.len();
        let mut whole = SMatrix::<f64, COUNT, COUNT>::zeros();
        for block in &self.blocks {
            whole += block.camera;
        }
        let scale = DVector::from_iterator(count, free.iter().map(|at| unit(whole[(*at, *at)])));
        let mut system = DMatrix::from_fn(count, count, |i, j| {
            let damping = if i == j { lambda } else { 0.0 };
            whole[(free[i], free[j])] * scale[i] * scale[j] + damping
        });
        let mut right = self.camera_gradient(free).component_mul(&scale);
        let mut views = Vec::with_capacity(self.blocks.len());
        for block in &self.blocks {
            let view = ReducedView::of(block, free, &scale, lambda)?;
            let eliminated = view.pose.solve(&view.mixed.transpose());
            system -= &view.mixed * eliminated;
            right -= &view.mixed * view.pose.solve(&view.gradient);
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

/// Least over largest eigenvalue of the scaled Schur complement that counts as singular.
const SINGULAR: f64 = 1e-15;

impl ReducedView {
    fn of(block: &ViewBlock, free: &[usize], scale: &DVector<f64>, lambda: f64) -> Option<Self> {
        let own = block.pose.diagonal().map(unit);
        let mut pose = Matrix6::from_fn(|i, j| block.pose[(i, j)] * own[i] * own[j]);
        for i in 0..6 {
            pose[(i, i)] += lambda;
        }
        Some(Self {
            scale: own,
            mixed: DMatrix::from_fn(free.len(), 6, |i, j| {
                block.mixed[(free[i], j)] * scale[i] * own[j]
            }),
            pose: pose.cholesky()?,
            gradient: block.pose_gradient.component_mul(&own),
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
    /// The camera and the poses after the step.
    pub fn apply(&self, camera: &Camera, poses: &[Pose]) -> (Camera, Vec<Pose>) {
        let mut values = camera.parameters();
        for (value, step) in values.iter_mut().zip(&self.camera) {
            *value += step;
        }
        let moved = poses.iter().zip(&self.poses).map(|(pose, step)| {
            let turn = Rotation3::new(Vector3::new(step[0], step[1], step[2]));
            // by way of the rotation vector, so that rounding never bends the matrix over many steps
            Pose::from_rotation_vector(
                (turn * pose.rotation).scaled_axis(),
                pose.translation_m + Vector3::new(step[3], step[4], step[5]),
            )
        });
        (camera.with_parameters(&values), moved.collect())
    }
}

fn view_block(camera: &Camera, pose: &Pose, rings: &[Observation]) -> Option<ViewBlock> {
    let mut block = ViewBlock {
        camera: SMatrix::zeros(),
        mixed: SMatrix::zeros(),
        pose: Matrix6::zeros(),
        camera_gradient: SVector::zeros(),
        pose_gradient: Vector6::zeros(),
        cost: 0.0,
    };
    for ring in rings {
        let Linearised {
            residual,
            wrt_camera,
            wrt_pose,
        } = linearised(camera, pose, ring)?;
        block.camera += wrt_camera.transpose() * wrt_camera;
        block.mixed += wrt_camera.transpose() * wrt_pose;
        block.pose += wrt_pose.transpose() * wrt_pose;
        block.camera_gradient += wrt_camera.transpose() * residual;
        block.pose_gradient += wrt_pose.transpose() * residual;
        block.cost += residual.norm_squared();
    }
    block.cost.is_finite().then_some(block)
}

/// Whitened residual (projected less measured) and its derivatives.
struct Linearised {
    residual: Vector2<f64>,
    wrt_camera: SMatrix<f64, 2, COUNT>,
    wrt_pose: SMatrix<f64, 2, 6>,
}

/// `None` where the ring falls behind the camera.
fn linearised(camera: &Camera, pose: &Pose, ring: &Observation) -> Option<Linearised> {
    let point = pose.board_to_camera(ring.board_m);
    let projection = camera.project_with_derivatives(&point)?;
    let w: &Matrix2<f64> = &ring.whitening;
    let lever = point.coords - pose.translation_m;
    // the rotation vector turns the lever: d(exp(w) q)/dw = -[q]x
    let wrt_shift = w * projection.wrt_point;
    let wrt_turn = -wrt_shift * lever.cross_matrix();
    let mut wrt_pose = SMatrix::<f64, 2, 6>::zeros();
    wrt_pose.fixed_columns_mut::<3>(0).copy_from(&wrt_turn);
    wrt_pose.fixed_columns_mut::<3>(3).copy_from(&wrt_shift);
    let raw = SMatrix::<f64, 2, COUNT>::from_fn(|i, j| projection.wrt_parameters[j][i]);
    Some(Linearised {
        residual: w * (projection.pixel - ring.pixel),
        wrt_camera: w * raw,
        wrt_pose,
    })
}
