//! Whether a still and new view is kept: as long as the views do not tell the camera, because it is new; from then on, for what
//! it adds.
//!
//! The camera is estimated from the views kept, every few new ones. A candidate is held against that estimate and refused where it
//! contradicts it. Of the others each adds so much information ([`Estimate::gain_nats`]), which is compared with what the views
//! kept tell on average. When no more may be kept, it is compared with the view that would be missed least.

use super::variety;
use super::{SessionRules, Verdict, View};
use crate::board::Board;
use crate::calibrate::{CalibrateError, CalibrateOptions, Estimate, NEEDED_VIEWS, Told};

/// Views that an estimate is first tried from.
const FIRST: usize = NEEDED_VIEWS + 1;
/// New views after which the camera is estimated again, ...
const EVERY: usize = 3;
/// ... or, where they are many, this part of them: a large set changes slowly and takes long.
const EVERY_PART: usize = 10;
/// By how much more than the view it replaces a candidate must tell, as a part of what that one tells: or two views that
/// tell the same would replace one another for ever.
const CLEARLY_MORE: f64 = 0.1;

/// What is known of the camera while views are collected.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Choice {
    options: CalibrateOptions,
    estimate: Option<Estimate>,
    /// Why there is no estimate, where one was tried.
    refused: Option<CalibrateError>,
    /// Views kept since an estimate was tried.
    since: usize,
}

/// What becomes of a candidate.
pub(super) enum Decision {
    Keep(Option<Told>),
    /// It takes the place of the view at this place.
    Exchange(usize, Option<Told>),
    Refuse(Verdict),
}

impl Choice {
    pub fn estimate(&self) -> Option<&Estimate> {
        self.estimate.as_ref()
    }

    pub fn refused(&self) -> Option<&CalibrateError> {
        self.refused.as_ref()
    }

    pub fn options(&self) -> &CalibrateOptions {
        &self.options
    }

    pub fn forget(&mut self) {
        *self = Self {
            options: std::mem::take(&mut self.options),
            ..Self::default()
        };
    }

    /// Estimates the camera with other options.
    pub fn set_options(&mut self, options: CalibrateOptions, board: &Board, views: &[View]) {
        self.options = options;
        if self.estimate.is_some() || self.refused.is_some() {
            self.solve(board, views);
        }
    }

    /// Whether to keep a view that is still and new, and in place of which one.
    pub fn decide(
        &self,
        board: &Board,
        rules: &SessionRules,
        (views, focal_px): (&[View], f64),
        view: &View,
    ) -> Decision {
        let full = views.len() >= rules.max_views;
        match (rules.least_gain, &self.estimate) {
            (Some(least), Some(estimate)) => {
                by_information(board, rules, (estimate, least), views.len(), view)
            }
            (_, _) if !full => Decision::Keep(None),
            (Some(_), None) => {
                let place = |view| variety::place(board, view, focal_px);
                let kept: Vec<_> = views.iter().map(place).collect();
                variety::exchange(&kept, &place(view))
                    .map_or_else(|| refuse_full(rules), |at| Decision::Exchange(at, None))
            }
            (None, _) => refuse_full(rules),
        }
    }

    /// Takes in a view that was kept; `views` are those with it, the last of them; it stands in for the one that was at
    /// `instead_of`.
    pub fn kept(
        &mut self,
        board: &Board,
        rules: &SessionRules,
        views: &[View],
        (told, instead_of): (Option<Told>, Option<usize>),
    ) {
        if rules.least_gain.is_none() && rules.target_px.is_none() {
            return;
        }
        self.since += 1;
        match (told, instead_of, &mut self.estimate) {
            (Some(told), None, Some(estimate)) => estimate.add(told),
            (Some(told), Some(at), Some(estimate)) => estimate.exchange(at, told),
            // a view that was not held against the estimate
            (_, _, estimate) => *estimate = None,
        }
        let due = self.since >= EVERY.max(views.len() / EVERY_PART);
        if due && views.len() >= FIRST {
            self.solve(board, views);
        }
    }

    fn solve(&mut self, board: &Board, views: &[View]) {
        self.since = 0;
        match Estimate::solve(board, views, &self.options) {
            Ok(estimate) => (self.estimate, self.refused) = (Some(estimate), None),
            Err(error) => (self.estimate, self.refused) = (None, Some(error)),
        }
    }
}

fn refuse_full(rules: &SessionRules) -> Decision {
    let max_views = rules.max_views;
    Decision::Refuse(Verdict::Full { max_views })
}

fn by_information(
    board: &Board,
    rules: &SessionRules,
    (estimate, least): (&Estimate, f64),
    views: usize,
    view: &View,
) -> Decision {
    let told = match estimate.judge(board, view) {
        Ok(told) => told,
        Err(unfit) => {
            let reason = unfit.to_string();
            return Decision::Refuse(Verdict::Contradicts { reason });
        }
    };
    let adds_little = |full| {
        let (before, after) = (estimate.fx_std_px(), estimate.fx_std_with_px(&told));
        let certain = (before > 0.0).then(|| 100.0 * (1.0 - after / before));
        let fx_percent = certain.filter(|percent| percent.is_finite());
        Decision::Refuse(Verdict::AddsLittle { fx_percent, full })
    };
    if views >= rules.max_views {
        return match estimate.least_useful(&told) {
            Some((at, won)) if won > CLEARLY_MORE => Decision::Exchange(at, Some(told)),
            _ => adds_little(Some(rules.max_views)),
        };
    }
    let average = estimate.average_gain_nats();
    if views >= rules.min_views && estimate.gain_nats(&told) < least * average {
        return adds_little(None);
    }
    Decision::Keep(Some(told))
}

#[cfg(test)]
mod tests;
