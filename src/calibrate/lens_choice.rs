//! Which lens model describes the camera best, by what each predicts of views left out.
//!
//! Views that leave a camera open leave it open under every lens model; one with fewer coefficients may pass all the same, with
//! numbers that are another lens's. So where `plumb_bob` is refused for what the views lack, another model counts only where it
//! explains the views much better.

use super::cross_validation::validate;
use super::{CalibrateError, CalibrateOptions, Calibration, CrossValidation, conclude, solve};
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

/// Standard deviations by which the chosen lens model has to be better than another for that one to be out of the question.
const SURELY: f64 = 3.0;
/// The same for squared residuals in units of their variance, whatever the views.
const SURELY_SQUARED: f64 = SURELY * SURELY;
/// Standard deviations by which further coefficients have to take away more of the squared residuals than noise lets them.
const NEEDED: f64 = 4.0;

/// What became of a lens model in [`choose_model`].
#[derive(Debug, Clone, PartialEq)]
pub struct ModelScore {
    /// The lens model.
    pub model: LensModel,
    /// Root mean square of its residuals on views left out, px, or why it has none.
    pub rms_px: Result<f64, CalibrateError>,
    /// Whether it is not the one chosen and explains the views as well as that: see [`super::with_rivals`].
    pub rival: bool,
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

/// A lens model that was tried.
struct Tried {
    model: LensModel,
    /// How well its solution explains the views, where there is one.
    explained: Option<Explained>,
    /// Its calibration, whether or not the views determine it, and how it predicts views left out.
    solved: Option<(Calibration, CrossValidation)>,
    /// Why it is refused.
    refused: Option<CalibrateError>,
    /// Why a part of the views gave no prediction.
    unpredicted: Option<CalibrateError>,
}

/// The lens model that predicts left-out views best, and what became of each. `plumb_bob` is the one to beat: another is chosen only
/// where it explains more of the views, or where its error on a typical view is smaller by 2 % and by two standard deviations of the
/// difference over the views. A model that all views determine is not out of it where some of them would not.
///
/// # Errors
/// That of the best lens model, where the views do not determine it: the worse ones may have fewer coefficients, and no better numbers. That of
/// the first, where none can be.
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
    let all: Vec<Tried> = candidates
        .into_iter()
        .map(|model| Tried::of(board, views, options, model))
        .collect();
    let best = all
        .iter()
        .filter(|tried| tried.stands())
        .reduce(|best, next| if next.beats(best) { next } else { best });
    let Some(best) = best else {
        let error = all.into_iter().find_map(|tried| tried.refused);
        return Err(error.unwrap_or(CalibrateError::TooFewViews { found: views.len() }));
    };
    if let Some(error) = &best.refused {
        return Err(error.clone());
    }
    let scores = all.iter().map(|tried| ModelScore {
        model: tried.model,
        rms_px: tried.score(),
        rival: tried.model != best.model && tried.stands() && tried.rivals(best),
    });
    Ok((best.model, scores.collect()))
}

impl Tried {
    fn of(board: &Board, views: &[View], options: &CalibrateOptions, model: LensModel) -> Self {
        let options = CalibrateOptions {
            model,
            ..options.clone()
        };
        let mut tried = Self {
            model,
            explained: None,
            solved: None,
            refused: None,
            unpredicted: None,
        };
        tried.refused = tried.solve(board, views, &options).err();
        tried
    }

    fn solve(
        &mut self,
        board: &Board,
        views: &[View],
        options: &CalibrateOptions,
    ) -> Result<(), CalibrateError> {
        let (solved, roll) = solve::solved(board, views, options)?;
        self.explained = Some(Explained {
            views: roll.active().len(),
            variance: solve::variance(&solved, &roll),
        });
        let (rings, converged) = (roll.active_rings(), solved.adjusted.converged);
        let calibration = conclude::unjudged(solved, roll, options)?;
        let judged = conclude::judged(&calibration, &rings, converged);
        // what no camera can be is not asked for predictions
        if judged
            .as_ref()
            .err()
            .is_none_or(CalibrateError::is_of_the_views)
        {
            let (validated, unpredicted) = validate(board, views, options, &calibration);
            self.solved = Some((calibration, validated));
            self.unpredicted = unpredicted;
        }
        judged
    }

    /// Whether it may be the lens: refused, if at all, for what the views lack.
    fn stands(&self) -> bool {
        self.refused
            .as_ref()
            .is_none_or(CalibrateError::is_of_the_views)
    }

    fn score(&self) -> Result<f64, CalibrateError> {
        let error = self.refused.as_ref().or(self.unpredicted.as_ref());
        match (error, &self.solved) {
            (Some(error), _) => Err(error.clone()),
            (None, Some((_, validated))) => Ok(validated.rms_px),
            (None, None) => Err(CalibrateError::TooFewViews { found: 0 }),
        }
    }

    /// Whether it is chosen rather than one of those before it.
    fn beats(&self, best: &Self) -> bool {
        let (Some(own), Some(other)) = (self.explained, best.explained) else {
            return best.explained.is_none();
        };
        if best.refused.is_some() {
            return own.much_better(&other);
        }
        let (Some((_, own_views)), Some((_, other_views))) = (&self.solved, &best.solved) else {
            return false;
        };
        own.views > other.views
            || (own.views == other.views && clearly_better(own_views, other_views))
    }

    /// Whether it explains the views as well as the one chosen, within the scatter of what they say.
    fn rivals(&self, best: &Self) -> bool {
        let (Some(own), Some(other)) = (self.explained, best.explained) else {
            return false;
        };
        let (Some((calibration, own_views)), Some((chosen, other_views))) =
            (&self.solved, &best.solved)
        else {
            return false;
        };
        if own.views < other.views {
            return false;
        }
        let more = (own.variance / other.variance - 1.0) * chosen.degrees();
        let names = calibration.camera.parameter_names();
        let further = names.len() as f64 - chosen.camera.parameter_names().len() as f64;
        let contains = chosen
            .camera
            .parameter_names()
            .iter()
            .all(|n| names.contains(n));
        if contains && self.model != LensModel::Equidistant {
            // the same lens and further numbers: they count where noise alone would not have used them
            return more < -(further + NEEDED * (2.0 * further).sqrt());
        }
        let worse = gains(other_views, own_views);
        more <= SURELY_SQUARED || worse.is_none_or(|(mean, std)| mean <= SURELY * std)
    }
}

/// Whether `a` predicts the views better than `b` beyond chance and by what is worth it.
fn clearly_better(a: &CrossValidation, b: &CrossValidation) -> bool {
    // of squares
    let noticeable = -2.0 * (1.0 - NOTICEABLY).ln();
    gains(a, b).is_some_and(|(mean, std)| mean > noticeable.max(CLEARLY * std))
}

/// Mean over the views of how much better `a` predicts them than `b`, in logarithms of the squares, so that one bad view decides nothing,
/// and its standard deviation. Only those count that both predict; `None` where these are too few.
fn gains(a: &CrossValidation, b: &CrossValidation) -> Option<(f64, f64)> {
    let pairs = || a.view_factors.iter().zip(&b.view_factors);
    let told = pairs().filter(|(a, b)| a.is_some() || b.is_some()).count();
    let gains: Vec<f64> = pairs()
        .filter_map(|(a, b)| Some(((*b)? / (*a)?).ln()))
        .filter(|gain| gain.is_finite())
        .collect();
    let n = gains.len() as f64;
    if n < 2.0 || n < COMPARED * told as f64 {
        return None;
    }
    let mean = gains.iter().sum::<f64>() / n;
    let variance = gains.iter().map(|g| (g - mean).powi(2)).sum::<f64>() / (n - 1.0);
    Some((mean, (variance / n).sqrt()))
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
