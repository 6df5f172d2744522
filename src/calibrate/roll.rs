//! Which views and rings take part: the roll is called before the adjustment and after it.
//!
//! Before: views that repeat another one, and views without a pose, are left out. After: see [`Roll::judge`].

use super::adjust::Solution;
use super::observations::Observation;
use super::repeats::repeats;
use super::shared::Shared;
use super::{NEEDED_RINGS, start_homography};
use crate::camera::{Camera, Pose};
use crate::session::View;
use nalgebra::Vector2;
use std::fmt;

/// Chance that any ring of a faultless set is left out.
const CHANCE: f64 = 0.01;
/// Mean squared residual of a view over that of the median view beyond which it is left out: four times in the residual.
const WORSE: f64 = super::leverage::WORSE;
/// The squared length of two standard normal numbers has this median.
const MEDIAN: f64 = 1.386_294_361_119_890_6;
/// Poses that a view may be given before it is left out: the camera gets better in between.
const MORE_POSES: usize = 3;
/// Residuals below this are of no consequence, px: a set without noise must not lose rings to rounding.
const NEGLIGIBLE_PX: f64 = 1e-3;

/// Why a view does not take part; displays as one plain sentence.
#[derive(Debug, Clone, PartialEq)]
pub enum LeftOut {
    /// It shows what another view shows.
    Repeat {
        /// `source` of the other view.
        of: String,
    },
    /// Too few rings for a pose.
    TooFewRings {
        /// Rings in it.
        found: usize,
    },
    /// Its rings stand in a line or in one place.
    Degenerate,
    /// No position of the board puts its rings where they are: they are mirrored, or not this board's.
    NoPose,
    /// Most of its rings lie elsewhere than camera and board allow.
    MostRings {
        /// How many do.
        out: usize,
        /// Of how many.
        of: usize,
    },
    /// Its residuals are much larger than those of the other views.
    Noisy {
        /// How many times as large.
        times: f64,
    },
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Repeat { of } => write!(f, "repeats the view {of}"),
            Self::TooFewRings { found } => {
                write!(f, "shows {found} rings, at least {NEEDED_RINGS} are needed")
            }
            Self::Degenerate => write!(f, "its rings stand in one line or in one place"),
            Self::NoPose => write!(
                f,
                "no position of the board puts its rings where they are: mirrored, or another board"
            ),
            Self::MostRings { out, of } => write!(
                f,
                "{out} of its {of} rings are not where the others say: another board, or numbered wrongly"
            ),
            Self::Noisy { times } => write!(
                f,
                "its residuals are {times:.0} times as large as those of the other views: the board or the camera \
                 moved, or it is another board"
            ),
        }
    }
}

/// The views, their rings, and which of them count.
#[derive(Debug, Clone)]
pub(super) struct Roll {
    /// All rings of all views, in their order.
    pub rings: Vec<Vec<Observation>>,
    /// Why a view is left out.
    pub left_out: Vec<Option<LeftOut>>,
    /// Where each view's board stands, as far as it is known.
    pub poses: Vec<Option<Pose>>,
    /// How often each view has been given another pose because most of its rings contradicted the one it had.
    tried_again: Vec<usize>,
}

impl Roll {
    /// Leaves out what can be seen to be of no use before anything is adjusted; marks rings that cannot be on the same plane as the
    /// others of their view.
    pub fn new(views: &[View], rings: Vec<Vec<Observation>>) -> Self {
        let mut left_out: Vec<Option<LeftOut>> = repeats(views)
            .into_iter()
            .map(|of| of.map(|of| LeftOut::Repeat { of }))
            .collect();
        let mut rings = rings;
        for (left_out, rings) in left_out.iter_mut().zip(&mut rings) {
            if left_out.is_some() {
                continue;
            }
            if rings.len() < NEEDED_RINGS {
                *left_out = Some(LeftOut::TooFewRings { found: rings.len() });
            } else if start_homography::mark(rings).is_none() {
                *left_out = Some(LeftOut::Degenerate);
            }
        }
        Self {
            poses: vec![None; rings.len()],
            tried_again: vec![0; rings.len()],
            rings,
            left_out,
        }
    }

    /// Places of the views that take part.
    pub fn active(&self) -> Vec<usize> {
        (0..self.rings.len())
            .filter(|at| self.left_out[*at].is_none())
            .collect()
    }

    /// Rings of the views that take part.
    pub fn active_rings(&self) -> Vec<Vec<Observation>> {
        let active = self.active().into_iter();
        active.map(|at| self.rings[at].clone()).collect()
    }

    /// How many rings of a view count.
    pub fn counted(&self, at: usize) -> usize {
        let rings = self.rings[at].iter();
        rings.filter(|ring| ring.share > 0.0).count()
    }

    /// Gives the views that take part their poses.
    pub fn stand(&mut self, poses: &[Pose]) {
        for (at, pose) in self.active().into_iter().zip(poses) {
            self.poses[at] = Some(*pose);
        }
    }

    /// The solution as the views that take part have it.
    pub fn solution(&self, shared: Shared) -> Solution {
        let active = self.active().into_iter();
        Solution {
            shared,
            poses: active.filter_map(|at| self.poses[at]).collect(),
        }
    }

    /// Leaves out what the solution contradicts, and takes back what it does not; whether anything changed.
    ///
    /// The scale of the residuals is that of their median, so that up to half of them may be wrong. A ring is left out where its squared
    /// residual exceeds what one in a hundred faultless sets would show anywhere (chi-square with two degrees of freedom,
    /// Bonferroni); a view where that befalls more than half of its rings, or where the mean square of the others is 16
    /// times that of the median view. A view is first given another pose, through most of its rings: the one it started from may
    /// have been spoilt by a few. Views are judged only when no ring changes its part any more.
    pub fn judge(&mut self, shared: &Shared) -> bool {
        let squares: Vec<Vec<f64>> = (0..self.rings.len())
            .map(|at| self.squares(at, shared))
            .collect();
        let active = self.active();
        let mut all: Vec<f64> = Vec::new();
        for at in &active {
            all.extend(&squares[*at]);
        }
        let (scale, limit) = self.scale_and_limit(&mut all);
        let mut changed = false;
        let mut means = Vec::new();
        for at in active {
            let (out, mean) = judge_rings(&mut self.rings[at], &squares[at], limit, &mut changed);
            if self.contradicted(at, out) {
                changed = true;
                self.try_again(at, out, &shared.camera);
            } else {
                means.push((at, mean));
            }
        }
        if changed {
            return true;
        }
        let typical = median(&mut means.iter().map(|m| m.1).collect::<Vec<_>>()).max(scale);
        for (at, mean) in means.into_iter().filter(|m| m.1 > WORSE * typical) {
            let times = (mean / typical).sqrt();
            self.left_out[at] = Some(LeftOut::Noisy { times });
            changed = true;
        }
        changed
    }

    /// What is usual of a ring's squares, and what they exceed by mistake alone, if these are those of all rings.
    fn scale_and_limit(&self, all: &mut [f64]) -> (f64, f64) {
        let scale = (median(all) / MEDIAN).max(self.negligible());
        let limit = -2.0 * (CHANCE / all.len().max(1) as f64).ln() * scale;
        (scale, limit)
    }

    /// Takes back views that were left out while the solution was bent by others and that it does not contradict any more; whether
    /// there are any.
    pub fn take_back(&mut self, shared: &Shared) -> bool {
        let mut all: Vec<f64> = Vec::new();
        for at in self.active() {
            all.extend(self.squares(at, shared));
        }
        let (_, limit) = self.scale_and_limit(&mut all);
        let mut any = false;
        for at in 0..self.rings.len() {
            let contradicted = matches!(self.left_out[at], Some(LeftOut::MostRings { .. }));
            let mut rings = self.rings[at].clone();
            let pose = start_homography::pose_through_most(&shared.camera, &mut rings);
            let Some(pose) = pose.filter(|_| contradicted) else {
                continue;
            };
            let before = std::mem::replace(&mut self.rings[at], rings);
            let pose = self.poses[at].replace(pose);
            let squares = self.squares(at, shared);
            let (out, _) = judge_rings(&mut self.rings[at], &squares, limit, &mut false);
            if self.contradicted(at, out) {
                (self.rings[at], self.poses[at]) = (before, pose);
            } else {
                (self.left_out[at], self.tried_again[at]) = (None, 0);
                any = true;
            }
        }
        any
    }

    /// Whether most rings of a view are out, or too many for a pose.
    fn contradicted(&self, at: usize, out: usize) -> bool {
        let of = self.rings[at].len();
        2 * out > of || of - out < NEEDED_RINGS
    }

    /// Gives a view another pose, or leaves it out where it has had one already.
    fn try_again(&mut self, at: usize, out: usize, camera: &Camera) {
        self.tried_again[at] += 1;
        let again = if self.tried_again[at] > MORE_POSES {
            None
        } else {
            start_homography::pose_through_most(camera, &mut self.rings[at])
        };
        match again {
            Some(pose) => self.poses[at] = Some(pose),
            None => {
                let of = self.rings[at].len();
                self.left_out[at] = Some(LeftOut::MostRings { out, of });
            }
        }
    }

    /// Squared whitened residuals of a view's rings; infinite where a ring has no image.
    fn squares(&self, at: usize, shared: &Shared) -> Vec<f64> {
        let Some(pose) = self.poses[at] else {
            return Vec::new();
        };
        let rings = self.rings[at].iter();
        rings
            .map(|ring| {
                residual_px(shared, &pose, ring)
                    .map_or(f64::INFINITY, |r| (ring.whitening * r).norm_squared())
            })
            .collect()
    }

    /// A variance of whitened residuals, at least that of negligible ones.
    pub fn variance(&self, found: f64) -> f64 {
        found.max(self.negligible())
    }

    /// What [`NEGLIGIBLE_PX`] is in whitened units, squared.
    fn negligible(&self) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for ring in self.rings.iter().flatten() {
            sum += 0.5 * ring.whitening.norm_squared();
            count += 1.0;
        }
        NEGLIGIBLE_PX * NEGLIGIBLE_PX * sum / f64::max(count, 1.0)
    }
}

/// How many rings of a view are out, and the mean square of the others.
fn judge_rings(
    rings: &mut [Observation],
    squares: &[f64],
    limit: f64,
    changed: &mut bool,
) -> (usize, f64) {
    let (mut out, mut sum) = (0, 0.0);
    for (ring, square) in rings.iter_mut().zip(squares) {
        // not a number is out
        let share = if *square <= limit { 1.0 } else { 0.0 };
        *changed |= share != ring.share;
        ring.share = share;
        if share > 0.0 {
            sum += square;
        } else {
            out += 1;
        }
    }
    (out, sum / (rings.len() - out).max(1) as f64)
}

/// Measured less predicted, px; `None` where the ring has no image.
pub(super) fn residual_px(
    shared: &Shared,
    pose: &Pose,
    ring: &Observation,
) -> Option<Vector2<f64>> {
    let place = shared.sheet.place_m(ring.board_m, shared.middle_m);
    let predicted = shared
        .camera
        .project(&(pose.rotation * place + pose.translation_m))?;
    Some(ring.pixel - predicted - ring.bias_px)
}

/// The middle one; 0 for none.
fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
