//! How certain a calibration is: of its parameters, of the poses, and of where it says that things are seen.
//!
//! The noise of the centres makes another calibration with every set of views: another camera, and other poses. A point that the first one
//! sees at a pixel is carried by the poses to the boards, and by the other poses to the other camera, which sees it
//! somewhere else: that is the error which matters, for parameters may move together and change nothing. Its covariance is
//! G M^-1 G' with M = J^T J and G the derivative of the pixel, averaged over the boards (mrcal's projection uncertainty,
//! "mean-pcam", Kogan 2021).

use super::calibration::Calibration;
use super::normal_equations::Inverse;
use super::rivals;
use super::shared::Free;
use nalgebra::{DMatrix, Matrix2, Matrix2x3, Matrix6, OMatrix, Point2, Point3, U2, Vector3};

/// How far away the thing is that is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Range {
    /// Beyond all parallax.
    Infinity,
    /// At this distance from the camera, m.
    At(f64),
}

/// The covariance of everything that was estimated.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Covariance {
    /// For residuals of unit variance.
    pub inverse: Inverse,
    /// Places of the camera's parameters among the free numbers, with what follows them: (place, parameter, factor).
    pub camera: Vec<(usize, usize, f64)>,
    /// For each view its place in `inverse`, where it takes part.
    pub place: Vec<Option<usize>>,
    /// What was free, with what it was charged.
    pub free: Free,
}

impl Calibration {
    /// Covariance of the pose of a view: rotation vector applied on the left of the rotation (rad), then translation (m); `None`
    /// for a view that was left out.
    pub fn pose_covariance(&self, view: usize) -> Option<Matrix6<f64>> {
        let place = (*self.uncertain.place.get(view)?)?;
        let inverse = &self.uncertain.inverse;
        let own = inverse.views.get(place)?;
        let through = own.mixed.tr_mul(&inverse.shared) * &own.mixed;
        Some((own.own + Matrix6::from_fn(|i, j| through[(i, j)])) * self.variance_factor)
    }

    /// Covariance of the pixel at which something seen at `pixel` would appear to the camera of another calibration from such views, px^2;
    /// `None` where the camera has no ray. It covers what [`Calibration::rivals`] disagree by.
    pub fn projection_covariance(&self, pixel: &Point2<f64>, range: Range) -> Option<Matrix2<f64>> {
        let own = self.own_projection_covariance(pixel, range)?;
        let rivals = self.rivals.iter();
        let more = rivals.map(|rival| rivals::projection_beyond(self, rival, (pixel, range), &own));
        Some(more.fold(own, |sum, more| sum + more))
    }

    /// What the noise of the centres and the lens model itself leave open.
    pub(super) fn own_projection_covariance(
        &self,
        pixel: &Point2<f64>,
        range: Range,
    ) -> Option<Matrix2<f64>> {
        let ray = self.camera.ray(pixel)?;
        let (point, shifts) = match range {
            Range::Infinity => (ray, 0.0),
            Range::At(distance_m) => (ray * distance_m, 1.0),
        };
        let projection = self.camera.project_with_derivatives(&Point3::from(point))?;
        let inverse = &self.uncertain.inverse;
        let free = inverse.shared.nrows();
        let mut by_shared = OMatrix::<f64, nalgebra::Dyn, U2>::zeros(free);
        for (place, parameter, factor) in &self.uncertain.camera {
            let by = projection.wrt_parameters[*parameter];
            by_shared[(*place, 0)] += factor * by[0];
            by_shared[(*place, 1)] += factor * by[1];
        }
        let used = inverse.views.len() as f64;
        let by_point: Matrix2x3<f64> = projection.wrt_point / used;
        let mut covariance = Matrix2::zeros();
        for (view, place) in self.views.iter().zip(&self.uncertain.place) {
            let (Some(pose), Some(place)) = (view.pose, place) else {
                continue;
            };
            let own = &inverse.views[*place];
            let lever: Vector3<f64> = point - pose.translation_m * shifts;
            let by_turn = -by_point * lever.cross_matrix();
            let mut by_pose = OMatrix::<f64, U2, nalgebra::U6>::zeros();
            by_pose.fixed_columns_mut::<3>(0).copy_from(&by_turn);
            by_pose
                .fixed_columns_mut::<3>(3)
                .copy_from(&(by_point * shifts));
            covariance += by_pose * own.own * by_pose.transpose();
            by_shared -= &own.mixed * by_pose.transpose();
        }
        covariance += by_shared.tr_mul(&inverse.shared) * &by_shared;
        Some(covariance * self.variance_factor)
    }

    /// Standard deviation in the worst direction of [`Calibration::projection_covariance`], px.
    pub fn projection_std_px(&self, pixel: &Point2<f64>, range: Range) -> Option<f64> {
        let covariance = self.projection_covariance(pixel, range)?;
        let worst = covariance.symmetric_eigenvalues().max();
        Some(worst.max(0.0).sqrt())
    }

    /// [`Calibration::projection_std_px`] in the middles of `columns` x `rows` cells of the frame, by rows.
    pub fn projection_std_map(
        &self,
        (columns, rows): (usize, usize),
        range: Range,
    ) -> Vec<Option<f64>> {
        let (width, height) = (f64::from(self.camera.width), f64::from(self.camera.height));
        (0..rows * columns)
            .map(|cell| {
                let x = ((cell % columns) as f64 + 0.5) * width / columns as f64 - 0.5;
                let y = ((cell / columns) as f64 + 0.5) * height / rows as f64 - 0.5;
                self.projection_std_px(&Point2::new(x, y), range)
            })
            .collect()
    }

    /// The mean distance of the boards' origins from the camera, m.
    pub fn typical_distance_m(&self) -> f64 {
        let distances = self.views.iter().filter_map(|view| view.pose);
        let (sum, count) = distances.fold((0.0, 0_usize), |(sum, count), pose| {
            (sum + pose.translation_m.norm(), count + 1)
        });
        sum / count.max(1) as f64
    }
}

/// Standard deviations of a covariance.
pub(super) fn deviations(covariance: &DMatrix<f64>) -> Vec<f64> {
    covariance
        .diagonal()
        .iter()
        .map(|variance| variance.max(0.0).sqrt())
        .collect()
}
