//! Which lens model describes the camera best, by what each predicts of views left out.
//!
//! Views that leave a camera open leave it open under every lens model; one with fewer coefficients may pass all the same, with
//! numbers that are another lens's. So where `plumb_bob` is refused for what the views lack, another model counts only where it
//! explains the views much better.

use super::cross_validation::validate;
use super::{CalibrateError, CalibrateOptions, Calibration, CrossValidation, solve};
use crate::board::Board;
use crate::camera::LensModel;
use crate::session::View;

/// Standard deviations by which a lens model with more coefficients has to be better to be chosen.
const CLEARLY: f64 = 2.0;
/// Part of the error that such a lens model has to take away, on the typical view: what is less is worth no coefficient and no other kind
/// of lens.
const NOTICEABLY: f64 = 0.02;
/// The part of the variance that another lens model leaves at most where `plumb_bob` was refused for what the views lack.
const MUCH: f64 = 0.5;
/// The part of the views that both models have to predict.
const COMPARED: f64 = 0.5;

/// What became of a lens model in [`choose_model`].
#[derive(Debug, Clone, PartialEq)]
pub struct ModelScore {
    /// The lens model.
    pub model: LensModel,
    /// Root mean square of its residuals on views left out, px, or why it has none.
    pub rms_px: Result<f64, CalibrateError>,
}

/// How well a solution explains the views, whether or not they determine it.
#[derive(Debug, Clone, Copy)]
struct Explained {
    views: usize,
    variance: f64,
}

impl Explained {
    /// Whether it explains more of the views, or leaves much less of them.
    fn much_better(&self, other: &Self) -> bool {
        self.views > other.views || self.variance < MUCH * other.variance
    }
}

/// A calibration, and how well its solution explains the views, where there is one.
type Tried = (Result<Calibration, CalibrateError>, Option<Explained>);

/// The lens model that predicts left-out views best, and what became of each. `plumb_bob` is the one to beat: another is chosen only
/// where it explains more of the views, or where its error on a typical view is smaller by 2 % and by two standard deviations of the
/// difference over the views. A model that all views determine is not out of it where some of them would not.
///
/// # Errors
/// That of the first lens model, where none gives a calibration, or where the views lack what every model needs.
pub fn choose_model(
    board: &Board,
    views: &[View],
    options: &CalibrateOptions,
) -> Result<(LensModel, Vec<ModelScore>), CalibrateError> {
    let candidates = [
        LensModel::PlumbBob,
        LensModel::Equidistant,
        LensModel::RationalPolynomial,
    ];
    let mut scores = Vec::new();
    let mut best: Option<(LensModel, usize, CrossValidation)> = None;
    let mut refused = None;
    // how well a refused plumb_bob explains the views, where they are what is lacking
    let mut lacking: Option<Explained> = None;
    for model in candidates {
        let options = CalibrateOptions {
            model,
            ..options.clone()
        };
        let (calibration, explained) = tried(board, views, &options);
        let calibration = match (calibration, explained, lacking) {
            (Ok(_), Some(own), Some(first)) if !own.much_better(&first) => Err(refused
                .clone()
                .unwrap_or(CalibrateError::TooFewViews { found: views.len() })),
            (calibration, _, _) => calibration,
        };
        let calibration = match calibration {
            Ok(calibration) => calibration,
            Err(error) => {
                if model == LensModel::PlumbBob && error.is_of_the_views() {
                    lacking = explained;
                }
                scores.push(ModelScore {
                    model,
                    rms_px: Err(error.clone()),
                });
                refused = refused.or(Some(error));
                continue;
            }
        };
        let (validated, unpredicted) = validate(board, views, &options, &calibration);
        scores.push(ModelScore {
            model,
            rms_px: unpredicted.map_or(Ok(validated.rms_px), Err),
        });
        let used = calibration.views_used();
        let better = best.as_ref().is_none_or(|(_, views, best)| {
            used > *views || (used == *views && clearly_better(&validated, best))
        });
        if better {
            best = Some((model, used, validated));
        }
    }
    match (best, refused) {
        (Some((model, ..)), _) => Ok((model, scores)),
        (None, Some(error)) => Err(error),
        (None, None) => Err(CalibrateError::TooFewViews { found: views.len() }),
    }
}

/// [`super::calibrate`], and how well the solution explains the views even where it is refused.
fn tried(board: &Board, views: &[View], options: &CalibrateOptions) -> Tried {
    match solve::solved(board, views, options) {
        Ok((solved, roll)) => {
            let explained = Explained {
                views: roll.active().len(),
                variance: solve::variance(&solved, &roll),
            };
            (solve::conclude(solved, roll, options), Some(explained))
        }
        Err(error) => (Err(error), None),
    }
}

/// Whether `a` predicts the views better than `b` beyond chance; only those count that both predict.
fn clearly_better(a: &CrossValidation, b: &CrossValidation) -> bool {
    let pairs = || a.view_factors.iter().zip(&b.view_factors);
    let told = pairs().filter(|(a, b)| a.is_some() || b.is_some()).count();
    // in logarithms, so that one bad view decides nothing
    let gains: Vec<f64> = pairs()
        .filter_map(|(a, b)| Some(((*b)? / (*a)?).ln()))
        .filter(|gain| gain.is_finite())
        .collect();
    let n = gains.len() as f64;
    if n < 2.0 || n < COMPARED * told as f64 {
        return false;
    }
    let mean = gains.iter().sum::<f64>() / n;
    let variance = gains.iter().map(|g| (g - mean).powi(2)).sum::<f64>() / (n - 1.0);
    // of squares
    let noticeable = -2.0 * (1.0 - NOTICEABLY).ln();
    mean > noticeable.max(CLEARLY * (variance / n).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::FOLDS;

    fn of(view_factors: Vec<Option<f64>>) -> CrossValidation {
        CrossValidation {
            folds: FOLDS,
            rms_px: 0.0054,
            view_factors,
        }
    }

    #[test]
    fn a_gain_that_nobody_notices_is_a_tie_however_certain_it_is() {
        let scaled = |by: f64| of((0..10).map(|i| Some(by * (1.0 + f64::from(i)))).collect());
        let one = scaled(1.0);
        assert!(!clearly_better(&one, &one));
        assert!(!clearly_better(&scaled(0.97), &one));
        assert!(clearly_better(&scaled(0.95), &one));
        let scattered =
            |i: u32| Some((1.0 + f64::from(i)) * if i.is_multiple_of(2) { 0.5 } else { 1.7 });
        assert!(!clearly_better(&of((0..10).map(scattered).collect()), &one));
    }

    #[test]
    fn views_that_one_model_alone_predicts_decide_nothing() {
        let one = of((0..10).map(|i| Some(1.0 + f64::from(i))).collect());
        let mut parts = one.clone();
        parts.view_factors[3] = None;
        parts.view_factors[8] = None;
        assert!(!clearly_better(&one, &parts) && !clearly_better(&parts, &one));
        assert!(!clearly_better(&one, &of(vec![None; 10])));
        let much = of((0..10).map(|i| Some(0.5 + 0.5 * f64::from(i))).collect());
        assert!(clearly_better(&much, &parts));
    }

    #[test]
    fn another_model_has_to_explain_more_than_one_refused_for_its_views() {
        let of = |views, variance| Explained { views, variance };
        assert!(!of(10, 0.9).much_better(&of(10, 1.0)));
        assert!(of(10, 0.4).much_better(&of(10, 1.0)));
        assert!(of(10, 1.0).much_better(&of(6, 1.0)));
    }
}
