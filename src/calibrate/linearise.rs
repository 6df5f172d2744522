//! The residuals of one view and their derivatives, summed into its block of the normal equations.

use super::observations::Observation;
use super::shared::{Free, MOST_SHARED, SHEET_NAMES, Shared, SheetShape};
use crate::camera::Pose;
use nalgebra::{DMatrix, Matrix2, Matrix2x3, Matrix6, OMatrix, SMatrix, SVector, U6, Vector2};

/// Numbers of a pose: rotation vector, then shift.
pub(super) const POSE: usize = 6;

const MOST: usize = POSE + MOST_SHARED;

/// What one view adds to the normal equations: its pose first, then the free shared numbers.
#[derive(Debug, Clone)]
pub(super) struct ViewBlock {
    /// J^T J, the upper triangle.
    upper: SMatrix<f64, MOST, MOST>,
    /// J^T r.
    pub gradient: SVector<f64, MOST>,
    /// Sum of the squared whitened residuals.
    pub cost: f64,
}

impl ViewBlock {
    fn at(&self, i: usize, j: usize) -> f64 {
        self.upper[(i.min(j), i.max(j))]
    }

    /// C_v.
    pub fn pose(&self) -> Matrix6<f64> {
        Matrix6::from_fn(|i, j| self.at(i, j))
    }

    /// B_v.
    pub fn mixed(&self, free: usize) -> OMatrix<f64, nalgebra::Dyn, U6> {
        OMatrix::<f64, nalgebra::Dyn, U6>::from_fn(free, |i, j| self.upper[(j, POSE + i)])
    }

    /// A_v.
    pub fn shared(&self, free: usize) -> DMatrix<f64> {
        DMatrix::from_fn(free, free, |i, j| self.at(POSE + i, POSE + j))
    }
}

/// The block of a view; `None` where a ring that counts has no image.
pub(super) fn view_block(
    shared: &Shared,
    pose: &Pose,
    rings: &[Observation],
    free: &Free,
) -> Option<ViewBlock> {
    let mut block = ViewBlock {
        upper: SMatrix::zeros(),
        gradient: SVector::zeros(),
        cost: 0.0,
    };
    let width = POSE + free.len();
    for ring in rings.iter().filter(|ring| ring.share > 0.0) {
        let (residual, rows) = linearised(shared, pose, ring, free)?;
        for (r, row) in [(residual.x, &rows[0]), (residual.y, &rows[1])] {
            for j in 0..width {
                let by = row[j];
                block.gradient[j] += by * r;
                for i in 0..=j {
                    block.upper[(i, j)] += row[i] * by;
                }
            }
            block.cost += r * r;
        }
    }
    block.cost.is_finite().then_some(block)
}

/// Whitened residual (predicted less measured) and its derivatives by pose and free numbers; `None` where the ring has no image.
fn linearised(
    shared: &Shared,
    pose: &Pose,
    ring: &Observation,
    free: &Free,
) -> Option<(Vector2<f64>, [[f64; MOST]; 2])> {
    let place = shared.sheet.place_m(ring.board_m, shared.middle_m);
    let lever = pose.rotation * place.coords;
    let projection = shared
        .camera
        .project_with_derivatives(&(lever + pose.translation_m).into())?;
    let w: Matrix2<f64> = ring.whitening * ring.share.sqrt();
    let wrt_shift: Matrix2x3<f64> = w * projection.wrt_point;
    // the rotation vector turns the lever: d(exp(w) q)/dw = -[q]x
    let wrt_turn = -wrt_shift * lever.cross_matrix();
    let names = shared.camera.parameter_names().len();
    let mut all = [Vector2::zeros(); MOST_SHARED];
    for (to, by) in all.iter_mut().zip(&projection.wrt_parameters[..names]) {
        *to = w * Vector2::new(by[0], by[1]);
    }
    if free.columns.iter().any(|column| column.at >= names) {
        let places = SheetShape::place_by(ring.board_m, shared.middle_m);
        for (to, by) in all[names..names + SHEET_NAMES.len()].iter_mut().zip(places) {
            *to = wrt_shift * (pose.rotation * by);
        }
    }
    let mut rows = [[0.0; MOST]; 2];
    for (i, row) in rows.iter_mut().enumerate() {
        for k in 0..3 {
            row[k] = wrt_turn[(i, k)];
            row[3 + k] = wrt_shift[(i, k)];
        }
        for (to, column) in row[POSE..].iter_mut().zip(&free.columns) {
            let tied = column
                .tied
                .map_or(0.0, |(other, factor)| factor * all[other][i]);
            *to = all[column.at][i] + tied;
        }
    }
    let residual = w * (projection.pixel + ring.bias_px - ring.pixel);
    Some((residual, rows))
}
