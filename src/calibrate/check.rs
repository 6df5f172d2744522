//! How well a calibration explains views that it was not made from.
//!
//! Each view's pose is found with the camera as it is; what is left over is noise where the camera is right, and a field over the frame
//! where it is not. The pose takes up a part of any error, so that views should fill the frame and differ in distance.

use super::resect::{Known, Resection, resect};
use super::{CalibrateError, LeftOut, SheetShape};
use crate::board::Board;
use crate::camera::Camera;
use crate::centre::Estimator;
use crate::session::View;
use nalgebra::Vector2;
use std::fmt;

/// Cells of the bias field, across and down.
pub const FIELD: (usize, usize) = (8, 6);
/// Rings below which a cell says nothing.
const CELL_RINGS: usize = 5;
/// Bias of a cell over its standard deviation beyond which it is no accident; one cell in 400 exceeds it by chance.
const SURE: f64 = 3.5;
/// A bias that does not matter to anybody, px.
const NO_MATTER_PX: f64 = 0.02;
/// A bias that spoils a measurement, px.
const SPOILS_PX: f64 = 0.5;
/// Part of the cells that must have been seen for a verdict.
const SEEN: f64 = 0.5;

/// A cell of the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// Rings in it.
    pub rings: usize,
    /// Mean of measured less predicted, px.
    pub bias_px: Vector2<f64>,
    /// Standard deviation of each coordinate of that mean, px, as the residuals scatter.
    pub std_px: f64,
}

impl Cell {
    /// Whether it has seen enough rings to say anything.
    pub fn tells(&self) -> bool {
        self.rings >= CELL_RINGS
    }
}

/// What a check says; displays as one plain sentence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// No bias beyond what the scatter explains, or none that matters.
    Holds {
        /// The largest bias that a cell shows, px.
        worst_px: f64,
    },
    /// There is a bias, and it is small.
    Drifted {
        /// The largest bias that is no accident, px.
        worst_px: f64,
    },
    /// The camera is another one.
    Fails {
        /// The largest bias that is no accident, px.
        worst_px: f64,
    },
    /// The camera sees no view as it is, wherever the board is placed.
    ExplainsNone,
    /// Too little of the frame was seen.
    NotEnough {
        /// Part of the cells with enough rings, %.
        percent: f64,
    },
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Holds { worst_px } => write!(
                f,
                "the calibration holds: no part of the frame is off by more than its scatter explains or than matters \
                 ({worst_px:.3} px at most)"
            ),
            Self::Drifted { worst_px } => write!(
                f,
                "the calibration is a little off, by {worst_px:.3} px where it is worst: calibrate anew where that matters"
            ),
            Self::Fails { worst_px } => write!(
                f,
                "the calibration does not fit these views, it is off by {worst_px:.2} px where it is worst: calibrate anew"
            ),
            Self::ExplainsNone => f.write_str(
                "the calibration does not fit these views: no position of the board explains any of them; calibrate anew",
            ),
            Self::NotEnough { percent } => write!(
                f,
                "no verdict: the rings of these views reach only {percent:.0} % of the frame; show the board all over it"
            ),
        }
    }
}

/// The result of a check.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// Every view, in the order given.
    pub views: Vec<Resection>,
    /// Root mean square distance between measured and predicted centres, px, over the views that have a pose; `None` where none has.
    pub rms_px: Option<f64>,
    /// The cells of the frame, by rows.
    pub field: Vec<Cell>,
    /// What to make of it.
    pub verdict: Verdict,
}

/// Holds views against a camera.
///
/// # Errors
/// [`CalibrateError`] for views that are not of this board, or of another frame size than the camera's.
pub fn check(
    board: &Board,
    views: &[View],
    camera: &Camera,
    estimator: Estimator,
) -> Result<Check, CalibrateError> {
    let wanted = (camera.width as usize, camera.height as usize);
    if let Some(view) = views.iter().find(|v| (v.width, v.height) != wanted) {
        return Err(CalibrateError::CameraSize {
            source_name: view.source.clone(),
            size: (view.width, view.height),
            camera: wanted,
        });
    }
    let known = Known {
        camera: *camera,
        sheet: SheetShape::default(),
        estimator,
    };
    let resections = resect(board, views, &known)?;
    let field = field(camera, views, &resections);
    Ok(Check {
        rms_px: rms(&resections),
        verdict: if explains_none(&resections) {
            Verdict::ExplainsNone
        } else {
            verdict(&field)
        },
        views: resections,
        field,
    })
}

/// Whether no view has a pose, and the camera is to blame for one of them at least.
fn explains_none(resections: &[Resection]) -> bool {
    let mut reasons = resections.iter().map(|r| &r.fit.left_out);
    resections.iter().all(|r| !r.fit.used()) && reasons.any(|r| *r == Some(LeftOut::NoPose))
}

fn rms(resections: &[Resection]) -> Option<f64> {
    let used = || resections.iter().filter(|r| r.fit.used());
    let residuals = used().flat_map(|r| &r.fit.residuals).flatten();
    used()
        .next()
        .map(|_| super::calibration::rms(residuals.copied()))
}

fn field(camera: &Camera, views: &[View], resections: &[Resection]) -> Vec<Cell> {
    let mut inside: Vec<Vec<Vector2<f64>>> = vec![Vec::new(); FIELD.0 * FIELD.1];
    let (width, height) = (f64::from(camera.width), f64::from(camera.height));
    for (view, resection) in views.iter().zip(resections) {
        for (ring, residual) in view.rings.iter().zip(&resection.fit.residuals) {
            let at = ring.centre.point;
            let column = ((at.x + 0.5) / width * FIELD.0 as f64).floor();
            let row = ((at.y + 0.5) / height * FIELD.1 as f64).floor();
            let in_frame =
                (0.0..FIELD.0 as f64).contains(&column) && (0.0..FIELD.1 as f64).contains(&row);
            if let (true, Some(residual)) = (in_frame, residual) {
                inside[row as usize * FIELD.0 + column as usize].push(*residual);
            }
        }
    }
    inside.iter().map(|residuals| cell(residuals)).collect()
}

fn cell(residuals: &[Vector2<f64>]) -> Cell {
    let n = residuals.len() as f64;
    let mean = residuals.iter().sum::<Vector2<f64>>() / n.max(1.0);
    let scatter: f64 = residuals.iter().map(|r| (r - mean).norm_squared()).sum();
    Cell {
        rings: residuals.len(),
        bias_px: mean,
        std_px: (scatter / (2.0 * (n - 1.0).max(1.0)) / n.max(1.0)).sqrt(),
    }
}

fn verdict(field: &[Cell]) -> Verdict {
    let told: Vec<&Cell> = field.iter().filter(|c| c.tells()).collect();
    let part = told.len() as f64 / field.len() as f64;
    let sure = told
        .iter()
        .filter(|c| c.bias_px.norm() > SURE * c.std_px)
        .map(|c| c.bias_px.norm())
        .fold(0.0, f64::max);
    if sure > SPOILS_PX {
        return Verdict::Fails { worst_px: sure };
    }
    if part < SEEN {
        return Verdict::NotEnough {
            percent: 100.0 * part,
        };
    }
    if sure > NO_MATTER_PX {
        return Verdict::Drifted { worst_px: sure };
    }
    let worst_px = told.iter().map(|c| c.bias_px.norm()).fold(0.0, f64::max);
    Verdict::Holds { worst_px }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::synthetic::{board, ordinary, pose_at, views};

    fn all_over(camera: &Camera, sigma_px: f64) -> Vec<View> {
        let (w, h) = (f64::from(camera.width), f64::from(camera.height));
        let poses: Vec<_> = (0..16)
            .map(|i| {
                let (x, y) = (f64::from(i % 4), f64::from(i / 4));
                let pixel = [w * (0.2 + 0.2 * x), h * (0.22 + 0.187 * y)];
                let a = f64::from(i) * 2.4;
                let turn = [0.3 * a.cos(), 0.3 * a.sin(), 0.0];
                pose_at(camera, &board(), pixel, 0.42, turn)
            })
            .collect();
        views(camera, &board(), &poses, sigma_px, 2)
    }

    fn verdict_of(change: impl Fn(&mut Camera)) -> Verdict {
        let camera = ordinary();
        let mut believed = camera;
        change(&mut believed);
        let views = all_over(&camera, 0.03);
        check(&board(), &views, &believed, Estimator::Photometric)
            .unwrap()
            .verdict
    }

    #[test]
    fn the_true_camera_holds_and_others_do_not() {
        let holds = verdict_of(|_| {});
        assert!(
            matches!(holds, Verdict::Holds { worst_px } if worst_px < 0.03),
            "{holds}"
        );
        let drifted = verdict_of(|camera| camera.intrinsics.cx += 10.0);
        assert!(matches!(drifted, Verdict::Drifted { .. }), "{drifted}");
        let fails = verdict_of(|camera| {
            let mut values = camera.parameters();
            values[4] += 0.1;
            *camera = camera.with_parameters(&values);
        });
        assert!(matches!(fails, Verdict::Fails { .. }), "{fails}");
    }

    #[test]
    fn a_camera_that_explains_no_view_fails() {
        let camera = ordinary();
        let mut believed = camera;
        let mut values = camera.parameters();
        values[4..].fill(0.0);
        values[4] = -5.0;
        believed = believed.with_parameters(&values);
        let views = all_over(&camera, 0.03);
        let checked = check(&board(), &views, &believed, Estimator::Photometric).unwrap();
        assert_eq!(checked.verdict, Verdict::ExplainsNone, "{checked:?}");
        assert_eq!(checked.rms_px, None);
        let said = checked.verdict.to_string();
        assert!(
            said.contains("no position of the board explains any"),
            "{said}"
        );
        let json = crate::formats::CheckJson::new(Some((&views, &checked)), None);
        assert_eq!((json.verdict, json.rms_px), (Some("fails"), None));
    }

    #[test]
    fn little_of_the_frame_gives_no_verdict_and_another_size_no_check() {
        let camera = ordinary();
        let views = &all_over(&camera, 0.03)[..2];
        let checked = check(&board(), views, &camera, Estimator::Photometric).unwrap();
        assert!(matches!(checked.verdict, Verdict::NotEnough { .. }));
        let mut other = camera;
        other.width = 640;
        let refused = check(&board(), views, &other, Estimator::Photometric).unwrap_err();
        assert_eq!(
            refused.to_string(),
            "view 0 is 1280 x 960 px, the camera's frames are 640 x 960 px"
        );
    }
}
