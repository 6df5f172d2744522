//! The Cramer-Rao bound: how well a ring's centre can be known at all.

use super::fit::{BLUR_PRIOR, freeze, inverse_of};
use super::model::{BLUR, RingModel};
use super::problem::{Problem, Workspace};
use super::shape::SHAPE_PARAMETERS;
use super::window::Window;
use nalgebra::Matrix2;

/// The least covariance (px^2) any unbiased estimator of a ring's centre can have on a window of this grid, for pixel noise of
/// this standard deviation: the Cramer-Rao bound with every parameter of the model unknown. With `perspective_known` the
/// perspective is given, as a board gives it. `None` where the shape is no ring or the pixels determine none.
pub fn cramer_rao_bound(
    window: &Window,
    model: &RingModel,
    ratio: f64,
    noise: f64,
    perspective_known: bool,
) -> Option<Matrix2<f64>> {
    let problem = Problem {
        window,
        ratio,
        around: None,
        noise,
    };
    let mut matrix = Workspace::default().normal(&problem, model)?.matrix;
    matrix[(BLUR, BLUR)] += BLUR_PRIOR;
    if perspective_known {
        (SHAPE_PARAMETERS - 2..SHAPE_PARAMETERS).for_each(|k| freeze(&mut matrix, k));
    }
    let inverse = inverse_of(&matrix)?;
    Some(Matrix2::from_fn(|i, j| inverse[(i, j)] * noise * noise))
}
