//! The rules, one number each.

use super::{Facts, Grade, px};
use crate::calibrate::{Change, When};
use nalgebra::Point2;

/// Projection uncertainty that the node, too, asks for before it calls the views enough (its parameter `target_px`), px.
const CERTAIN_PX: f64 = 0.1;
/// A whole pixel: whoever can live with more hardly needs a calibration.
const UNCERTAIN_PX: f64 = 1.0;
/// Residuals beyond the noise that hardly anybody notices, px, ...
const MISFIT_PX: f64 = 0.1;
/// ... and such as spoil a measurement; `check` says "fails" there.
const SPOILS_PX: f64 = 0.5;
/// Differences between views that were used and views that were left out that nobody notices, px.
const NO_MATTER_PX: f64 = 0.02;

/// Changes of the focal length between views, of itself, that move nothing in a frame by more than a few tenths of a pixel ...
const STEADY: f64 = 2e-4;
/// ... and such as no view agrees with the result.
const REFOCUSED: f64 = 2e-3;

/// One rule, in order of weight.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// How certain it is where things are seen, in the worst part of the frame.
    Certainty,
    /// How well views that were left out are predicted, against those that were used.
    Prediction,
    /// Whether one focal length served all views.
    Steadiness,
    /// Residuals that the noise of the centres does not explain.
    Misfit,
    /// How much of the frame the rings covered.
    Coverage,
    /// How many views took part.
    Views,
    /// How many rings contradict the others.
    Contradicting,
}

/// A rule applied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Criterion {
    /// The rule.
    pub rule: Rule,
    /// Its number: px, a factor, a fraction or a count; not finite where it could not be told.
    pub value: f64,
    /// What it is worth.
    pub grade: Grade,
    /// Where in the frame the number is from, px.
    at: Option<Point2<f64>>,
    /// How the focal length changed between the views.
    change: Option<Change>,
}

impl Rule {
    /// All of them, the weightiest first.
    pub const ALL: [Self; 7] = [
        Self::Certainty,
        Self::Prediction,
        Self::Steadiness,
        Self::Misfit,
        Self::Coverage,
        Self::Views,
        Self::Contradicting,
    ];

    /// What is asked, a few words.
    pub fn question(self) -> &'static str {
        match self {
            Self::Certainty => "Uncertainty in the worst part of the frame",
            Self::Prediction => "Error on views left out, over that on views used",
            Self::Steadiness => "Change of the focal length between the views",
            Self::Misfit => "Error that noise does not explain",
            Self::Coverage => "Part of the frame that rings covered",
            Self::Views => "Views that took part",
            Self::Contradicting => "Rings that contradict the others, left out",
        }
    }

    /// The limits of good and of usable.
    pub fn limits(self) -> [f64; 2] {
        match self {
            Self::Certainty => [CERTAIN_PX, UNCERTAIN_PX],
            Self::Prediction => [1.5, 3.0],
            Self::Steadiness => [STEADY, REFOCUSED],
            Self::Misfit => [MISFIT_PX, SPOILS_PX],
            Self::Coverage => [0.7, 0.4],
            Self::Views => [10.0, 5.0],
            Self::Contradicting => [0.1, 0.33],
        }
    }

    /// Whether larger numbers are better.
    pub fn rises(self) -> bool {
        matches!(self, Self::Coverage | Self::Views)
    }

    /// A number of this rule with its unit.
    pub fn text(self, value: f64) -> String {
        match self {
            _ if !value.is_finite() => "not told".to_owned(),
            Self::Certainty | Self::Misfit => px(value),
            Self::Prediction => format!("{value:.2} times"),
            Self::Steadiness => format!("{:.2} %", 100.0 * value),
            Self::Coverage | Self::Contradicting => format!("{:.0} %", 100.0 * value),
            Self::Views => format!("{value:.0}"),
        }
    }

    /// A limit with its unit, as a phrase.
    pub fn limit_text(self, limit: f64) -> String {
        let phrase = if self.rises() { "at least" } else { "at most" };
        format!("{phrase} {}", self.round(limit))
    }

    /// The same for a table.
    pub fn limit_short(self, limit: f64) -> String {
        let sign = if self.rises() { '\u{2265}' } else { '\u{2264}' };
        format!("{sign} {}", self.round(limit))
    }

    /// A limit with its unit, without digits that say nothing.
    fn round(self, limit: f64) -> String {
        match self {
            Self::Certainty | Self::Misfit => format!("{limit} px"),
            Self::Prediction => format!("{limit} times"),
            _ => self.text(limit),
        }
    }

    /// What to do where the number is not good, a sentence or two.
    pub fn advice(self) -> &'static str {
        match self {
            Self::Certainty => {
                "Add views with the board large in the frame, tilted by 20 to 45 degrees to all sides, most of them where \
                 the camera is least certain."
            }
            Self::Prediction => {
                "Add views at other places and tilts: some parameters rest on one or two views. Or estimate fewer of \
                 them (--fix)."
            }
            Self::Steadiness => {
                "Hold focus and zoom, autofocus off, and calibrate each setting from views of its own: no camera in \
                 between is right for either."
            }
            Self::Misfit => {
                "Something is not as assumed. Is the board flat, and its pitch measured on the print? Did board and \
                 camera hold still? Try --model auto, or --bow for a sheet that is bent."
            }
            Self::Coverage => {
                "Show the board where no ring was seen: there the lens is only guessed from its neighbourhood. Corners \
                 and edges first."
            }
            Self::Views => "Add views: 15 or more, each at another place and tilt.",
            Self::Contradicting => {
                "Look at the views and rings that were left out: another board, a hand before it, or a board that moved?"
            }
        }
    }
}

impl Criterion {
    /// Applies a rule.
    pub(super) fn of(rule: Rule, facts: &Facts) -> Self {
        let value = value(rule, facts);
        let [good, usable] = rule.limits();
        let keeps = |limit: f64| {
            if rule.rises() {
                value >= limit
            } else {
                value <= limit
            }
        };
        let close = facts
            .left_out_rms_px
            .is_some_and(|rms| rms - facts.rms_px <= NO_MATTER_PX);
        let grade = if keeps(good) || (rule == Rule::Prediction && close) {
            Grade::Good
        } else if keeps(usable) || (rule == Rule::Prediction && !value.is_finite()) {
            // what could not be tried speaks neither for a calibration nor against it
            Grade::Usable
        } else {
            Grade::NotEnough
        };
        Self {
            rule,
            value,
            grade,
            at: (rule == Rule::Certainty).then_some(facts.worst_at),
            change: facts.change,
        }
    }

    /// Its number with its unit.
    pub fn text(&self) -> String {
        self.rule.text(self.value)
    }

    /// What is wrong with it, for the sentence.
    pub(super) fn clause(&self) -> String {
        let [good, usable] = self.rule.limits();
        let (limit, word) = match self.grade {
            Grade::NotEnough => (usable, "usable"),
            _ => (good, "good"),
        };
        let (value, limit) = (self.text(), self.rule.limit_text(limit));
        let said = match self.rule {
            Rule::Certainty => {
                let at = self.at.unwrap_or_default();
                format!(
                    "near pixel ({:.0}, {:.0}) directions are known to {value} only",
                    at.x, at.y
                )
            }
            Rule::Prediction if !self.value.is_finite() => {
                return "no view could be left out to check the others".to_owned();
            }
            Rule::Prediction => {
                format!("on views that were left out the error is {value} that on views used")
            }
            Rule::Steadiness => changed(self.change, &value),
            Rule::Misfit => {
                format!("{value} of the error is more than the noise of the ring centres")
            }
            Rule::Coverage => format!("the rings cover {value} of the frame"),
            Rule::Views if self.value == 1.0 => "1 view took part".to_owned(),
            Rule::Views => format!("{value} views took part"),
            Rule::Contradicting => {
                format!("{value} of the rings contradict the others and were left out")
            }
        };
        format!("{said} ({word}: {limit})")
    }
}

fn value(rule: Rule, facts: &Facts) -> f64 {
    match rule {
        Rule::Certainty => facts.worst_std_px,
        Rule::Prediction => facts
            .left_out_rms_px
            .map_or(f64::INFINITY, |rms| rms / facts.rms_px.max(f64::EPSILON)),
        Rule::Steadiness => facts.change.map_or(0.0, |change| change.relative.abs()),
        Rule::Misfit => {
            let squares = facts.rms_px.powi(2) - facts.noise_px.powi(2);
            squares.max(0.0).sqrt()
        }
        Rule::Coverage => facts.coverage,
        Rule::Views => facts.views as f64,
        Rule::Contradicting => facts.contradicting,
    }
}

/// How the focal length changed, in words.
fn changed(change: Option<Change>, value: &str) -> String {
    let Some(Change { when, relative, .. }) = change else {
        return format!("the focal length changes by {value} between the views");
    };
    let longer = if relative > 0.0 { "longer" } else { "shorter" };
    match when {
        When::At(view) => format!(
            "from view {} on the focal length is {value} {longer} than before: focus or zoom was changed",
            view + 1
        ),
        When::WithNearness => format!(
            "the nearest views want a focal length {value} {longer} than the farthest: does the camera focus by itself?"
        ),
    }
}
