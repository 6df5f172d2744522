//! What a calibration collects: the views of one board by one camera.
//!
//! A [`Session`] is offered every frame in which the board was found and keeps those that are still and new; the node
//! and the command line both fill one. It says how much of the frame the rings have covered and what to show next.
//!
//! As long as the views do not tell the camera, being new is what counts: other places, other tilts. Once they do, a
//! view is kept for the information that it adds, after it was seen to agree with the others ([`Estimate`]), and the views are
//! enough when they predict everywhere in the frame where a thing would be seen ([`SessionRules::target_px`]). [`choose`] does the
//! same for a recording, all of whose views are there already.
//!
//! Tilt is needed before the lens is known. It is taken from a view's homography with the focal length that the
//! homographies of the views kept agree on, and as long as they do not (fewer than three views, or none tilted) with
//! a nominal one of 1.2 times the longer side of the frame, which is a field of view of 45 degrees. With a lens of
//! 4 sides a tilt then looks about a third of what it is.

mod choice;
mod choose;
mod coverage;
mod guidance;
mod measures;
mod motion;
mod repeats;
mod rules;
mod variety;
mod view;

pub use choose::choose;
pub use coverage::Coverage;
pub use guidance::{Guidance, LeastCertain};
pub use measures::{Measures, Progress};
pub use motion::{Motion, motion};
pub use repeats::Repeats;
pub use rules::{Change, Offer, OnChange, SessionRules, Verdict};
pub use view::View;

use crate::board::Board;
use crate::calibrate::{CalibrateError, CalibrateOptions, Estimate, NEEDED_RINGS, Told};
use crate::calibrate::{focal_length_px, plane_normal};
use crate::detect::Detection;
use crate::frame::Stamp;
use choice::{Choice, Decision};
use nalgebra::Vector3;

/// Nominal focal length over the longer side of the frame.
const NOMINAL_FOCAL: f64 = 1.2;

/// The views of one board by one camera, collected frame by frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Session {
    board: Board,
    rules: SessionRules,
    views: Vec<View>,
    coverage: Coverage,
    choice: Choice,
    /// Views that were ever kept, those that were replaced since as well.
    ever_kept: usize,
    /// The frame before, where the board was found in it.
    before: Option<View>,
}

impl Session {
    /// A session without views.
    pub fn new(board: Board, rules: SessionRules) -> Self {
        Self {
            board,
            rules,
            views: Vec::new(),
            coverage: Coverage::default(),
            choice: Choice::default(),
            ever_kept: 0,
            before: None,
        }
    }

    /// The board it is about.
    pub fn board(&self) -> &Board {
        &self.board
    }

    /// When a frame becomes a view.
    pub fn rules(&self) -> &SessionRules {
        &self.rules
    }

    /// The views kept, in the order they came.
    pub fn views(&self) -> &[View] {
        &self.views
    }

    /// Whether there are as many views as a calibration should have.
    pub fn is_ready(&self) -> bool {
        self.views.len() >= self.rules.min_views
    }

    /// Whether a calibration need not wait for more views: the target is met, or no more may be kept. Without a target
    /// as [`Session::is_ready`].
    pub fn is_enough(&self) -> bool {
        let ends = || {
            let guidance = self.guidance();
            matches!(guidance, Guidance::Enough { .. } | Guidance::Full { .. })
        };
        self.is_ready() && (self.rules.target_px.is_none() || ends())
    }

    /// Forgets all views.
    pub fn reset(&mut self) {
        self.views.clear();
        self.coverage = Coverage::default();
        self.choice.forget();
        self.ever_kept = 0;
        self.before = None;
    }

    /// Changes the board; starts anew and answers `true` where it is another one.
    pub fn set_board(&mut self, board: Board) -> bool {
        let changed = board != self.board;
        if changed {
            self.board = board;
            self.reset();
        }
        changed
    }

    /// Changes the rules; views kept stay.
    pub fn set_rules(&mut self, rules: SessionRules) {
        self.rules = rules;
    }

    /// Changes how the camera is estimated from the views while they are collected.
    pub fn set_options(&mut self, options: CalibrateOptions) {
        if options != *self.choice.options() {
            self.choice.set_options(options, &self.board, &self.views);
        }
    }

    /// Says that a frame showed no board: the next one with a board has nothing to be still against.
    pub fn missed(&mut self) {
        self.before = None;
    }

    /// Takes in a frame of a stream, with the board or without: what the node does with every message of its topic, and the
    /// command line with every message of a bag.
    ///
    /// # Errors
    /// Why there is no board, as it was handed in.
    pub fn observe<E>(
        &mut self,
        frame_id: &str,
        stamp: Stamp,
        found: Result<&Detection, E>,
    ) -> Result<Offer, E> {
        match found {
            Ok(detection) => Ok(self.offer(View::of_message(frame_id, stamp, detection))),
            Err(reason) => {
                self.missed();
                Err(reason)
            }
        }
    }

    /// Offers a frame in which the board was found; it is kept where it is of the same camera, still and new, and tells
    /// something.
    pub fn offer(&mut self, view: View) -> Offer {
        let change = self.change(&view);
        if let (Some(change), OnChange::Refuse) = (&change, self.rules.on_change) {
            return Offer {
                restart: None,
                verdict: Verdict::Stray(change.clone()),
            };
        }
        // where only a passing frame came before, nothing is lost and nothing needs to be said
        let restart = change.filter(|_| !self.views.is_empty());
        if restart.is_some() {
            self.reset();
        }
        let before = self.before.take();
        let verdict = self
            .not_still(before.as_ref(), &view)
            .or_else(|| self.not_wanted(&view))
            .unwrap_or_else(|| self.decide(&view));
        self.before = Some(view);
        Offer { restart, verdict }
    }

    /// Fraction of the frame's area that the rings of the views kept have covered, 0 to 1, in 10 x 10 cells.
    pub fn coverage(&self) -> f64 {
        self.coverage.fraction()
    }

    /// The cells of the frame that the rings of the views kept have covered.
    pub fn coverage_map(&self) -> &Coverage {
        &self.coverage
    }

    /// How far the ranges of X, Y, size and skew reach, as camera_calibration shows them.
    pub fn progress(&self) -> Progress {
        let views = self.views.iter();
        Progress::of(views.map(|view| Measures::of(&self.board, view)))
    }

    /// The camera as the views kept tell it so far; `None` while they do not, and where the rules do not ask for it.
    pub fn estimate(&self) -> Option<&Estimate> {
        self.choice.estimate()
    }

    /// Why there is no estimate, where one was tried.
    pub fn not_told(&self) -> Option<&CalibrateError> {
        self.choice.refused()
    }

    /// Views that were ever kept since the session began, those that were replaced as well.
    pub fn ever_kept(&self) -> usize {
        self.ever_kept
    }

    /// What to show the camera next.
    pub fn guidance(&self) -> Guidance {
        guidance::guidance(self)
    }

    /// Normals of the board in the views kept, in the camera frame, pointing away from the camera.
    pub fn normals(&self) -> Vec<Vector3<f64>> {
        let focal = self.focal_px();
        self.views
            .iter()
            .filter_map(|view| normal(view, focal))
            .collect()
    }

    fn change(&self, view: &View) -> Option<Change> {
        let known = self.views.first().or(self.before.as_ref())?;
        let (before, now) = ((known.width, known.height), (view.width, view.height));
        if before != now {
            return Some(Change::Size { before, now });
        }
        (known.frame_id != view.frame_id).then(|| Change::FrameId {
            before: known.frame_id.clone(),
            now: view.frame_id.clone(),
        })
    }

    fn not_still(&self, before: Option<&View>, view: &View) -> Option<Verdict> {
        let limit_px = self.rules.max_motion_px?;
        let same_camera = |b: &&View| {
            (b.width, b.height, &b.frame_id) == (view.width, view.height, &view.frame_id)
        };
        let Some(before) = before.filter(same_camera) else {
            return Some(Verdict::FirstSight);
        };
        let motion_px = motion(before, view).map(|m| m.max_px);
        let still = motion_px.is_some_and(|px| px <= limit_px);
        (!still).then_some(Verdict::Moving {
            motion_px,
            limit_px,
        })
    }

    fn not_wanted(&self, view: &View) -> Option<Verdict> {
        let found = view.rings.len();
        if found < NEEDED_RINGS {
            return Some(Verdict::TooFewRings { found });
        }
        let focal = self.focal_px();
        let normal_now = normal(view, focal);
        self.views.iter().find_map(|kept| {
            let shift_px = motion(kept, view)?.mean_px;
            let tilt_rad = match (normal(kept, focal), normal_now) {
                (Some(a), Some(b)) => a.angle(&b),
                _ => 0.0,
            };
            let new = shift_px > self.rules.new_shift * view.width as f64
                || tilt_rad > self.rules.new_tilt_rad;
            (!new).then(|| Verdict::NotNew {
                like: kept.source.clone(),
                shift_px,
                tilt_rad,
            })
        })
    }

    fn decide(&mut self, view: &View) -> Verdict {
        let kept = (self.views.as_slice(), self.focal_px());
        let decision = self.choice.decide(&self.board, &self.rules, kept, view);
        match decision {
            Decision::Refuse(verdict) => verdict,
            Decision::Keep(told) => {
                self.keep(view.clone(), told, None);
                let views = self.views.len();
                Verdict::Kept { views }
            }
            Decision::Exchange(at, told) => {
                let replaced = self.views.remove(at).source;
                self.coverage = Coverage::default();
                for kept in &self.views {
                    self.coverage.add(kept);
                }
                self.keep(view.clone(), told, Some(at));
                let views = self.views.len();
                Verdict::Replaced { views, replaced }
            }
        }
    }

    fn keep(&mut self, view: View, told: Option<Told>, instead_of: Option<usize>) {
        self.coverage.add(&view);
        self.views.push(view);
        self.ever_kept += 1;
        let (board, rules, views) = (&self.board, &self.rules, &self.views);
        self.choice.kept(board, rules, views, (told, instead_of));
    }

    /// The focal length the views agree on, or the nominal one; 0 without views.
    fn focal_px(&self) -> f64 {
        let Some(view) = self.views.first() else {
            return 0.0;
        };
        let size = (view.width as f64, view.height as f64);
        let homographies: Vec<_> = self.views.iter().map(|v| v.homography).collect();
        let agreed = (homographies.len() >= 3)
            .then(|| focal_length_px(&homographies, size))
            .flatten();
        agreed.unwrap_or(NOMINAL_FOCAL * size.0.max(size.1))
    }
}

fn normal(view: &View, focal_px: f64) -> Option<Vector3<f64>> {
    plane_normal(
        &view.homography,
        focal_px,
        (view.width as f64, view.height as f64),
    )
}

#[cfg(test)]
mod stream;
#[cfg(test)]
mod tests;
