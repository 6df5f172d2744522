//! Whether one camera took all views: a focus that was touched, a zoom, an autofocus change the focal length between views.
//!
//! A board nearer or farther makes up for most of another focal length, so that hardly a residual shows it; what is left are the
//! angles of tilted boards. Each view says by its own part of the normal equations (S_v, g_v, its pose eliminated) how much
//! longer it wants the focal length. Let the focal length of view v be 1 + w_v e times that of all. With u the direction in
//! which both focal lengths grow by their own size, the score test of e is
//!
//! ```text
//!     e = - sum w_v u'g_v / I,   I = sum w_v^2 u'S_v u - b' S^-1 b,   b = sum w_v S_v u,   S = sum S_v
//! ```
//!
//! with variance 1 / I: the second term is what all free numbers together explain as well. Two kinds of change are tried: at one
//! moment (w is 0 before and 1 from some view on, every moment in turn), and with nearness (w grows with 1 / distance). Views may
//! disagree for other reasons, a bent board for one. So what they disagree by beside the change counts as noise.

use super::normal_equations::{Inverse, NormalEquations};
use super::shared::{Free, Shared};
use crate::camera::Pose;
use nalgebra::{DMatrix, DVector};

/// Standard deviations from which on a change is none by chance, at whichever of a thousand moments.
const SURE: f64 = 5.0;
/// Views on either side of a moment, at least.
const LEAST_VIEWS: usize = 3;

/// When the focal length changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum When {
    /// At the view of this place in the list, and it stayed.
    At(usize),
    /// With the distance of the board: this is between the farthest and the nearest view.
    WithNearness,
}

/// A change of the focal length between the views, beyond chance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// When.
    pub when: When,
    /// By how much, of the focal length.
    pub relative: f64,
    /// Standard deviation of `relative`.
    pub std: f64,
}

/// What each view says of the focal length.
struct Views {
    /// u'g_v and u'S_v u.
    scores: Vec<(f64, f64)>,
    /// S_v u.
    mixed: Vec<DVector<f64>>,
}

/// The surest change of the focal length over the views that took part (`places` in the list, `poses`), for residuals of this variance;
/// `None` where there is none beyond chance, or the focal length is not free.
pub(super) fn change(
    equations: &NormalEquations,
    inverse: &Inverse,
    (shared, free): (&Shared, &Free),
    (places, poses): (&[usize], &[Pose]),
    variance: f64,
) -> Option<Change> {
    let views = Views::of(equations, &growth(shared, free)?)?;
    let count = poses.len();
    let last = count.checked_sub(LEAST_VIEWS)?;
    let moments = (LEAST_VIEWS..=last).map(|moment| {
        let weights = (0..count).map(|v| f64::from(u8::from(v >= moment)));
        (When::At(places[moment]), weights.collect::<Vec<f64>>())
    });
    let nearness: Vec<f64> = poses
        .iter()
        .map(|p| p.translation_m.norm().recip())
        .collect();
    let least = nearness.iter().copied().fold(f64::INFINITY, f64::min);
    let most = nearness.iter().copied().fold(0.0, f64::max);
    let weights = nearness.iter().map(|near| (near - least) / (most - least));
    let by_nearness = std::iter::once((When::WithNearness, weights.collect()));
    let tried = moments.chain(by_nearness).filter_map(|(when, weights)| {
        let (relative, std) = views.tested(&weights, &inverse.shared, variance)?;
        Some(Change {
            when,
            relative,
            std,
        })
    });
    let sureness = |change: &Change| change.relative.abs() / change.std;
    let surest = tried.max_by(|a, b| sureness(a).total_cmp(&sureness(b)))?;
    (sureness(&surest) > SURE).then_some(surest)
}

/// u: how the free numbers change where both focal lengths grow by their own size.
fn growth(shared: &Shared, free: &Free) -> Option<DVector<f64>> {
    let names = shared.camera.parameter_names();
    let values = shared.camera.parameters();
    let mut growth = DVector::zeros(free.len());
    for (place, column) in free.columns.iter().enumerate() {
        if names
            .get(column.at)
            .is_some_and(|name| matches!(*name, "fx" | "fy"))
        {
            growth[place] = values[column.at];
        }
    }
    growth.iter().any(|value| *value > 0.0).then_some(growth)
}

impl Views {
    fn of(equations: &NormalEquations, growth: &DVector<f64>) -> Option<Self> {
        let (information, pulls) = (equations.information()?, equations.pulls()?);
        let mixed: Vec<DVector<f64>> = information.iter().map(|own| own * growth).collect();
        let scores = pulls.iter().zip(&mixed);
        Some(Self {
            scores: scores
                .map(|(pull, own)| (growth.dot(pull), growth.dot(own)))
                .collect(),
            mixed,
        })
    }

    /// The change e with these weights and its standard deviation; `None` where the views cannot tell.
    fn tested(&self, weights: &[f64], inverse: &DMatrix<f64>, variance: f64) -> Option<(f64, f64)> {
        let (mut score, mut information) = (0.0, 0.0);
        let mut mixed = DVector::zeros(inverse.nrows());
        for ((weight, (pull, own)), by) in weights.iter().zip(&self.scores).zip(&self.mixed) {
            score += weight * pull;
            information += weight * weight * own;
            mixed.axpy(*weight, by, 1.0);
        }
        let explained = mixed.dot(&(inverse * &mixed));
        let left = information - explained;
        let told = left.is_finite() && left > f64::EPSILON * information;
        if !told {
            return None;
        }
        let change = -score / left;
        let others = inverse * mixed * -change;
        // what the views still disagree by once the change, and what it moves, is paid for
        let disagree = self.scores.iter().zip(&self.mixed).zip(weights);
        let squares: f64 = disagree
            .filter(|(((_, own), _), _)| *own > 0.0)
            .map(|(((pull, own), by), weight)| {
                (pull + own * weight * change + by.dot(&others)).powi(2) / own
            })
            .sum();
        let scatter = squares / (weights.len() as f64 - 2.0).max(1.0);
        Some((change, (scatter.max(variance) / left).sqrt()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::synthetic::{board, ordinary, pose_at, views, wide, with_covariance};
    use crate::calibrate::{
        CalibrateOptions, assess::Facts, assess::Grade, assess::assess, calibrate,
    };
    use crate::camera::Camera;
    use crate::session::View;
    use nalgebra::Matrix2;

    const NOISE_PX: f64 = 0.02;

    /// Twenty poses near and far, tilted to all sides, as the frames come.
    fn poses(camera: &Camera) -> Vec<Pose> {
        let (w, h) = (f64::from(camera.width), f64::from(camera.height));
        let pose = |i: i32| {
            let angle = f64::from(i) * 2.4;
            let part = |of: i32| f64::from(i * of % 7) / 6.0;
            let pixel = [w * (0.35 + 0.3 * part(3)), h * (0.4 + 0.2 * part(5))];
            let turn = [0.55 * angle.cos(), 0.55 * angle.sin(), 0.2 * part(2)];
            pose_at(camera, &board(), pixel, 0.35 + 0.25 * part(4), turn)
        };
        (0..20).map(pose).collect()
    }

    /// The views of a camera whose focal length is this many times its own in each of them.
    fn seen(camera: &Camera, times: impl Fn(usize, &Pose) -> f64, seed: u64) -> Vec<View> {
        let poses = poses(camera);
        let taken = poses.iter().enumerate().map(|(at, pose)| {
            let mut changed = *camera;
            changed.intrinsics.fx *= times(at, pose);
            changed.intrinsics.fy *= times(at, pose);
            let one = views(
                &changed,
                &board(),
                &[*pose],
                NOISE_PX,
                100 * seed + at as u64,
            );
            one.into_iter().map(move |mut view| {
                view.source = format!("view {at}");
                view
            })
        });
        let mut all: Vec<View> = taken.flatten().collect();
        with_covariance(&mut all, Matrix2::identity() * NOISE_PX * NOISE_PX);
        all
    }

    #[test]
    fn a_focus_that_was_touched_half_way_is_told_with_its_moment_and_size() {
        for camera in [ordinary(), wide()] {
            let views = seen(&camera, |at, _| if at < 10 { 1.0 } else { 1.005 }, 1);
            let calibration = calibrate(&board(), &views, &CalibrateOptions::default()).unwrap();
            let change = calibration.change.unwrap();
            assert_eq!(change.when, When::At(10));
            let off = change.relative - 0.005;
            assert!(off.abs() < 1e-3, "{change:?}");
            let unchecked = Err(&crate::calibrate::CalibrateError::TooFewViews { found: 0 });
            let verdict = assess(&Facts::of(&calibration, &views, unchecked));
            assert_eq!(verdict.grade, Grade::NotEnough);
            let said = verdict.to_string();
            assert!(
                said.contains("from view 11 on the focal length is 0."),
                "{said}"
            );
            assert!(
                verdict
                    .advice
                    .iter()
                    .any(|advice| advice.contains("Hold focus"))
            );
        }
    }

    #[test]
    fn a_camera_that_focuses_by_itself_is_told() {
        let breathing = |_: usize, pose: &Pose| 1.0 + 0.002 / pose.translation_m.norm();
        let views = seen(&ordinary(), breathing, 2);
        let calibration = calibrate(&board(), &views, &CalibrateOptions::default()).unwrap();
        let change = calibration.change.unwrap();
        assert!(
            change.when == When::WithNearness && change.relative > 0.0,
            "{change:?}"
        );
    }

    #[test]
    fn noise_alone_is_no_change() {
        for camera in [ordinary(), wide()] {
            for seed in 0..60 {
                let views = seen(&camera, |_, _| 1.0, seed);
                let calibration = calibrate(&board(), &views, &CalibrateOptions::default());
                assert_eq!(calibration.unwrap().change, None, "seed {seed}");
            }
        }
    }

    #[test]
    fn a_board_that_is_bent_is_no_change_of_focus() {
        let camera = ordinary();
        let mut views = seen(&camera, |_, _| 1.0, 5);
        // each view's sheet is bent in a way of its own, and makes the most of it for the focal length
        for (at, view) in views.iter_mut().enumerate() {
            let bow_px = 0.3 * (at as f64 * 2.4).sin();
            for ring in &mut view.rings {
                let [x, y] = [ring.column, ring.row].map(|i| (f64::from(i) - 3.0) / 3.0);
                ring.centre.point.x += bow_px * x * x;
                ring.centre.point.y += bow_px * y * y * y;
            }
        }
        let calibration = calibrate(&board(), &views, &CalibrateOptions::default()).unwrap();
        assert!(
            calibration.variance_factor > 2.0,
            "{}",
            calibration.variance_factor
        );
        assert_eq!(calibration.change, None);
    }
}
