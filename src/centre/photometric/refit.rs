//! Rings of a view fitted again, their shapes known from elsewhere.

use super::around::around;
use super::fit::{Given, Known, RingFitted};
use super::kept::KeptRing;
use super::law::{CentreAndCovariance, given_perspective};
use super::model::RingModel;
use super::problem::Workspace;
use super::shape::Shape;
use nalgebra::Matrix2;
use rayon::prelude::*;

/// The known shape may put the ring so many standard deviations from where it was; else it is not believed.
const FARTHEST: f64 = 6.0;

/// A ring as a view keeps it, and its shape as a camera and a pose say it is.
#[derive(Debug, Clone, Copy)]
pub struct KnownRing<'a> {
    /// What was kept.
    pub kept: &'a KeptRing,
    /// The shape; its centre is where the ring is expected, which the fit does not use.
    pub shape: Shape,
}

/// The centres of one view's rings with these shapes, in their order; `None` for a ring whose pixels contradict its shape.
pub fn refit(rings: &[KnownRing], ratio: f64) -> Vec<Option<CentreAndCovariance>> {
    let models: Vec<RingModel> = rings.iter().map(|ring| ring.kept.fitted.model).collect();
    rings
        .par_iter()
        .enumerate()
        .map_init(Workspace::default, |room, (i, ring)| {
            refit_one(ring, ratio, (i, &models), room)
        })
        .collect()
}

fn refit_one(
    ring: &KnownRing,
    ratio: f64,
    (own, models): (usize, &[RingModel]),
    room: &mut Workspace,
) -> Option<CentreAndCovariance> {
    let fitted = &ring.kept.fitted;
    let linear = given_perspective(fitted, &(ring.shape.perspective, Matrix2::zeros()))?;
    let Some(kept) = &ring.kept.window else {
        return Some(linear);
    };
    let window = kept.restore();
    let around = around(&window.grid, ratio, (own, models), room);
    let known = Known {
        window: &window,
        ratio,
        around: around.as_ref(),
        given: Given::Shape,
    };
    let start = RingModel {
        shape: Shape {
            centre: linear.0,
            affine: fitted.model.shape.affine,
            perspective: ring.shape.perspective,
        },
        ..fitted.model
    };
    let again = known.fit_with(&start, start.blur.psf, room).ok()?;
    agrees(&again, &linear).then(|| (again.model.shape.centre, again.centre_covariance()))
}

fn agrees(again: &RingFitted, linear: &CentreAndCovariance) -> bool {
    let off = again.model.shape.centre - linear.0;
    let variance = linear.1 + again.centre_covariance();
    variance
        .try_inverse()
        .is_some_and(|inverse| off.dot(&(inverse * off)) < FARTHEST * FARTHEST)
}
