//! What a calibration is worth: good, usable or not enough, by written rules, and the sentence that says why.
//!
//! Each [`Criterion`] is one number with two limits, and the calibration is worth as much as the worst of them. A small
//! residual alone proves nothing, so it is one number of seven. docs/report.md explains the limits to those who use them.

mod criterion;
mod refusal;

pub use criterion::{Criterion, Rule};
pub use refusal::{FramesRead, refused};

use super::observability::DARK;
use super::{CalibrateError, Calibration, Change, CrossValidation, LeftOut, MAP_CELLS, Range};
use crate::camera::LensModel;
use crate::session::{Coverage, View};
use nalgebra::Point2;
use std::fmt;

/// What a calibration is worth, the best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Grade {
    /// Nothing speaks against it.
    Good,
    /// It serves where little is asked; what would make it better is known.
    Usable,
    /// It is not to be relied upon, or there is none.
    NotEnough,
}

impl Grade {
    /// The word for people.
    pub fn word(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Usable => "usable",
            Self::NotEnough => "not enough",
        }
    }
}

impl fmt::Display for Grade {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

/// The numbers that a calibration is judged by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facts {
    /// Views that took part.
    pub views: usize,
    /// Part of the frame that their rings touched, of the part that the camera has rays for; 0 to 1.
    pub coverage: f64,
    /// Largest standard deviation of where something infinitely far away is seen, anywhere in the frame, px.
    pub worst_std_px: f64,
    /// Where that is, px.
    pub worst_at: Point2<f64>,
    /// As [`Calibration::rms_px`].
    pub rms_px: f64,
    /// The part of it that the noise of the centres explains, px; 0 where their covariances are not known.
    pub noise_px: f64,
    /// The same error on views that were left out; `None` where none could be.
    pub left_out_rms_px: Option<f64>,
    /// Part of the measured rings that contradict the others, 0 to 1.
    pub contradicting: f64,
    /// A change of the focal length between the views, beyond chance.
    pub change: Option<Change>,
}

impl Facts {
    /// Of a calibration of `views`.
    pub fn of(
        calibration: &Calibration,
        views: &[View],
        validated: Result<&CrossValidation, &CalibrateError>,
    ) -> Self {
        let map = calibration.projection_std_map(MAP_CELLS, Range::Infinity);
        let told = map
            .iter()
            .enumerate()
            .filter_map(|(at, std)| Some((at, (*std)?)));
        let worst = told.max_by(|a, b| a.1.total_cmp(&b.1));
        let (worst_at, worst_std_px) = worst.unwrap_or((0, f64::INFINITY));
        let with_covariance = views
            .iter()
            .flat_map(|view| &view.rings)
            .any(|ring| ring.centre.covariance.is_some());
        let factor = calibration.variance_factor;
        let noise_px = if with_covariance && factor > 0.0 {
            calibration.rms_px / factor.sqrt().max(1.0)
        } else {
            0.0
        };
        Self {
            views: calibration.views_used(),
            coverage: coverage(calibration, views, &map),
            worst_std_px,
            worst_at: middle(calibration, worst_at),
            rms_px: calibration.rms_px,
            noise_px,
            left_out_rms_px: validated.ok().map(|v| v.rms_px),
            contradicting: contradicting(calibration),
            change: calibration.change,
        }
    }
}

/// The part of the cells with a ray that a ring of a view that took part has touched. A fisheye's circle may be as small as it likes; of any
/// other lens that has no rays for much of the frame, who knows whether the camera has none: there all cells count.
fn coverage(calibration: &Calibration, views: &[View], map: &[Option<f64>]) -> f64 {
    let mut covered = Coverage::default();
    for (view, fit) in views.iter().zip(&calibration.views) {
        if fit.used() {
            covered.add(view);
        }
    }
    let dark = map.iter().filter(|std| std.is_none()).count();
    let folds = calibration.camera.model() != LensModel::Equidistant
        && dark as f64 > DARK * map.len() as f64;
    let lit = || (0..map.len()).filter(|cell| folds || map[*cell].is_some());
    let touched = lit().filter(|cell| covered.cell(cell / MAP_CELLS.0, cell % MAP_CELLS.0));
    touched.count() as f64 / lit().count().max(1) as f64
}

/// The middle of a cell of the map, px.
fn middle(calibration: &Calibration, cell: usize) -> Point2<f64> {
    let camera = &calibration.camera;
    let along = |at: usize, cells: usize, side: u32| {
        (at as f64 + 0.5) * f64::from(side) / cells as f64 - 0.5
    };
    Point2::new(
        along(cell % MAP_CELLS.0, MAP_CELLS.0, camera.width),
        along(cell / MAP_CELLS.0, MAP_CELLS.1, camera.height),
    )
}

/// The part of the rings that were left out although nothing but their place is wrong. A repeat contradicts nothing.
fn contradicting(calibration: &Calibration) -> f64 {
    let (mut out, mut all) = (0, 0);
    for fit in &calibration.views {
        let rings = fit.rings_used.len();
        out += match &fit.left_out {
            Some(LeftOut::Repeat { .. }) => continue,
            Some(_) => rings,
            None => fit.rings_left_out(),
        };
        all += rings;
    }
    f64::from(out as u32) / f64::from(all.max(1) as u32)
}

/// What a calibration is worth and why.
#[derive(Debug, Clone, PartialEq)]
pub struct Assessment {
    /// The worst of the criteria; [`Grade::NotEnough`] for a refusal.
    pub grade: Grade,
    /// Why, without the grade's word: clauses that follow a colon.
    pub reason: String,
    /// What to do, a sentence each, what helps most first; empty where nothing is to be done.
    pub advice: Vec<String>,
    /// Every number with its limits; none of a refusal.
    pub criteria: Vec<Criterion>,
}

impl fmt::Display for Assessment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.grade, self.reason)
    }
}

/// Clauses that a sentence has at most; the others are in [`Assessment::criteria`].
const CLAUSES: usize = 2;

/// Judges a calibration by its numbers.
pub fn assess(facts: &Facts) -> Assessment {
    let criteria: Vec<Criterion> = Rule::ALL
        .iter()
        .map(|rule| Criterion::of(*rule, facts))
        .collect();
    let grade = criteria.iter().map(|c| c.grade).max();
    let mut wanting: Vec<&Criterion> = criteria.iter().filter(|c| c.grade > Grade::Good).collect();
    // stable: of equally bad ones the more important rule comes first
    wanting.sort_by_key(|c| std::cmp::Reverse(c.grade));
    let clauses: Vec<String> = wanting.iter().take(CLAUSES).map(|c| c.clause()).collect();
    let reason = if clauses.is_empty() {
        format!(
            "directions are known to {} (one standard deviation) everywhere in the frame; the rings of {} views cover {:.0} % \
             of it",
            px(facts.worst_std_px),
            facts.views,
            100.0 * facts.coverage
        )
    } else {
        clauses.join("; ")
    };
    Assessment {
        grade: grade.unwrap_or(Grade::NotEnough),
        reason,
        advice: wanting.iter().map(|c| c.rule.advice().to_owned()).collect(),
        criteria,
    }
}

/// A number of pixels with as many digits as anyone reads.
fn px(value: f64) -> String {
    match value {
        v if v < 1.0 => format!("{v:.3} px"),
        v if v < 10.0 => format!("{v:.1} px"),
        v => format!("{v:.0} px"),
    }
}

#[cfg(test)]
mod tests;
