//! A ring of a board under measurement: its window, its fit, and what of its surroundings is believed.

use super::around::around;
use super::board::{BoardPlace, BoardStart};
use super::fit::{Given, Known, fit_roughly};
use super::fitted::{FitError, RingFitted};
use super::flatten::Bends;
use super::jury::Verdict;
use super::model::RingModel;
use super::plane::PlaneView;
use super::problem::Workspace;
use super::ring::{RingError, Seen, gate};
use super::sheet_start::{shows, with_sheet};
use super::start::{Cut, cut};
use super::trust::Surroundings;
use super::window::Window;
use crate::frame::Frame;

/// A ring has settled when it moved by less than this many of its standard deviations.
const SETTLED: f64 = 0.1;

/// A ring under measurement.
#[derive(Debug, Clone)]
pub(super) struct Under {
    /// As it was seen.
    pub(super) seen: Seen,
    /// Its pixels; `None` outside the frame.
    pub(super) window: Option<Window>,
    /// The fit, or where it starts.
    pub(super) model: RingModel,
    pub(super) fitted: Result<RingFitted, RingError>,
    /// Other rings were in reach when it was last fitted.
    pub(super) crowded: bool,
    /// Something in its window was left out.
    pub(super) masked: bool,
    /// Its window before that: what was strange beside neighbours that had not settled may be no more.
    pub(super) whole: Option<Window>,
    /// Its shape is not its own but the map's.
    pub(super) given: bool,
    /// What was taken out of its window because the lens bends it.
    pub(super) bends: Option<Bends>,
}

/// A ring's place on its board, and the board's plane in the frame where that is known.
pub(super) type Standing<'a> = (&'a BoardStart<'a>, &'a BoardPlace, Option<&'a PlaneView>);

impl Under {
    /// As the jury's verdict says.
    pub(super) fn begin(frame: &Frame, standing: Standing, verdict: &Verdict) -> Self {
        let (board, place, view) = standing;
        let model = verdict.start(board, place, view);
        Self::at(frame, board, (board.seen(place), Cut::OF_BOARD), model)
    }

    /// From a start, in a window cut for it.
    pub(super) fn at(
        frame: &Frame,
        board: &BoardStart,
        (seen, how): (Seen, Cut),
        model: RingModel,
    ) -> Self {
        let outer = model.shape.ellipse(1.0).unwrap_or(seen.outline);
        let sigma_px = model.blur.sigma_px();
        Self {
            seen,
            window: cut(frame, &outer, sigma_px, how, board.linear),
            model,
            fitted: Err(RingError::Outside),
            crowded: false,
            masked: false,
            whole: None,
            given: false,
            bends: None,
        }
    }

    /// Fits it among the others (`models`, of which it is the one at `own`).
    pub(super) fn fit(
        &mut self,
        standing: Standing,
        (own, models): (usize, &[RingModel]),
        room: &mut Workspace,
    ) {
        let Some(mut window) = self.whole.take().or(self.window.take()) else {
            return;
        };
        self.masked = false;
        let around = around(&window.grid, self.seen.ratio, (own, models), room);
        self.crowded = around.is_some();
        let fitted = self.fit_window(standing, &mut window, around.as_ref(), room);
        self.window = Some(window);
        self.fitted = fitted
            .map_err(RingError::from)
            .and_then(|fitted| gate(&self.seen, fitted));
        if let Ok(fitted) = &self.fitted {
            self.model = fitted.model;
        }
    }

    fn fit_window(
        &mut self,
        (board, place, view): Standing,
        window: &mut Window,
        around: Option<&[Vec<f32>; 2]>,
        room: &mut Workspace,
    ) -> Result<RingFitted, FitError> {
        let known = Known {
            window,
            ratio: self.seen.ratio,
            around,
            given: Given::NearStart,
        };
        let first = self.fit_known(&known, room)?;
        let Some(surroundings) = Surroundings::of(&first, &window.grid) else {
            return Ok(first);
        };
        let judgement = surroundings.judge(window, &room.residuals, &first);
        let clean = if judgement.is_clean() {
            first
        } else {
            // whatever stands there may have spoilt the fit: ask again without it
            let mut alone = window.clone();
            surroundings.mask(&mut alone, &judgement.without_suspects());
            let on_own = Known {
                window: &alone,
                ..known
            };
            fit_roughly(&on_own, &first.model, first.noise, room).unwrap_or(first)
        };
        let end = view
            .filter(|_| first.model.sheet.is_none())
            .and_then(|view| with_sheet(&known, (board, place, view), (&clean, &first), room));
        if end.is_none() && judgement.is_clean() {
            return Ok(first);
        }
        let believed = end.unwrap_or(clean);
        let residuals = room.residuals(&known, &believed.model);
        let again = surroundings.judge(window, residuals, &believed);
        if again.is_clean() {
            return Ok(end.unwrap_or(first));
        }
        self.masked = true;
        self.whole = around.is_some().then(|| window.clone());
        surroundings.mask(window, &again.verdict());
        let rest = Known {
            window,
            ratio: self.seen.ratio,
            around,
            given: Given::NearStart,
        };
        let fitted = rest.fit_with(&believed.model, believed.model.blur.psf, room)?;
        Ok(fitted.widened_by(&believed))
    }

    /// From where it stands, with the end of the sheet as long as that shows.
    fn fit_known(&self, known: &Known, room: &mut Workspace) -> Result<RingFitted, FitError> {
        let psf = self.model.blur.psf;
        // where a start is not near after all, from it with care
        let mut fit = |model: &RingModel| {
            let carefully = Known {
                given: Given::Nothing,
                ..*known
            };
            let near = known.fit_with(model, psf, room);
            near.or_else(|_| carefully.fit_with(model, psf, room))
        };
        let bare = RingModel {
            sheet: None,
            ..self.model
        };
        let noise = self.fitted.map_or(0.0, |fitted| fitted.noise);
        let has_end = self.model.sheet.is_some();
        if has_end && !shows(known.window, &self.model, noise) {
            return fit(&bare);
        }
        let fitted = fit(&self.model)?;
        if has_end && !shows(known.window, &fitted.model, fitted.noise) {
            return fit(&bare);
        }
        Ok(fitted)
    }

    /// Whether its last fit moved it away from a model.
    pub(super) fn has_moved(&self, before: &RingModel) -> bool {
        self.fitted.as_ref().is_ok_and(|fitted| {
            let moved = (fitted.model.shape.centre - before.shape.centre).norm();
            let size = |model: &RingModel| model.shape.affine[0] + model.shape.affine[2];
            let grown = 0.5 * (size(&fitted.model) / size(before) - 1.0).abs();
            let std = fitted.centre_covariance().trace().sqrt();
            let radius = size(before).max(f64::MIN_POSITIVE).sqrt().recip();
            moved + grown * radius > SETTLED * std
        })
    }
}
