//! The Cramer-Rao bound: how well a ring's centre can be known at all.

use super::descent::BLUR_PRIOR;
use super::equations::{freeze, shape_of_inverse};
use super::model::{BLUR, PARAMETERS, RingModel};
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
    let inverse = shape_of_inverse::<PARAMETERS>(&matrix)?;
    Some(inverse.fixed_view::<2, 2>(0, 0) * noise * noise)
}
