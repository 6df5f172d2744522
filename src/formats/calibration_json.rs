//! calibration.json: the whole result of a calibration for programs.

use crate::calibrate::{Calibration, Range};
use crate::session::View;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The file; keys as written. Lengths in m, angles in rad, pixels with (0, 0) at the centre of the top-left one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CalibrationJson {
    /// Lens model, by its ROS name.
    pub model: String,
    /// Name of the camera.
    pub camera_name: String,
    /// Width of the frames, px.
    pub width: u32,
    /// Height of the frames, px.
    pub height: u32,
    /// Values by name: fx, fy, cx, cy in px, the others without unit.
    pub parameters: BTreeMap<String, f64>,
    /// Standard deviations by the same names; 0 for a fixed parameter.
    pub std: BTreeMap<String, f64>,
    /// Order of the rows and columns of `covariance`.
    pub names: Vec<String>,
    /// Covariance of the parameters, by rows.
    pub covariance: Vec<Vec<f64>>,
    /// Parameters that were not estimated.
    pub fixed: Vec<String>,
    /// Root mean square distance between measured and projected centres, px.
    pub rms_px: f64,
    /// Sum of the squared weighted residuals over the degrees of freedom.
    pub variance_factor: f64,
    /// Which construction gave the centres.
    pub estimator: String,
    /// Standard deviation of where things are seen, over the frame.
    pub projection_std_px: ProjectionStd,
    /// Every input in the order given, those that were not used as well.
    pub views: Vec<ViewJson>,
}

/// Standard deviation, in the worst direction, of the pixel at which something would appear to the camera of another calibration
/// from such views; in the middles of the cells of the frame, by rows; null where the camera has no ray.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ProjectionStd {
    /// Cells across the frame.
    pub columns: usize,
    /// Cells down the frame.
    pub rows: usize,
    /// Of things infinitely far away, px.
    pub infinity: Vec<Option<f64>>,
    /// The mean distance of the boards, m.
    pub distance_m: f64,
    /// Of things at that distance, px.
    pub at_distance: Vec<Option<f64>>,
}

/// One input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ViewJson {
    /// Path of the file, or frame id and stamp.
    pub source: String,
    /// Whether it is part of the calibration.
    pub used: bool,
    /// Why it is not used, or what is suspicious about it; one plain sentence.
    pub reason: Option<String>,
    /// As `rms_px` of the file, of this view alone; null where it is not used.
    pub rms_px: Option<f64>,
    /// Rotation from the board to the camera: axis times angle, rad; null where it has none, like the next.
    pub rotation_vector: Option<[f64; 3]>,
    /// The board's ring (0, 0) in the camera frame, m.
    pub translation_m: Option<[f64; 3]>,
    /// Covariance of (rotation vector, translation), by rows: the rotation vector turns the board about the camera's axes, rad; m. Null
    /// where it is not used.
    pub pose_covariance: Option<Vec<Vec<f64>>>,
    /// The rings; empty where no board was found.
    pub rings: Vec<RingJson>,
}

/// One ring of a view.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RingJson {
    /// Row on the board.
    pub row: u16,
    /// Column on the board.
    pub col: u16,
    /// Measured projected centre, px.
    pub x: f64,
    /// Measured projected centre, px.
    pub y: f64,
    /// Measured less projected with the calibrated camera: (x, y), px; null where the view has no pose.
    pub residual: Option<[f64; 2]>,
    /// Whether it took part; a ring that does not was left out as an outlier, or with its view.
    pub used: bool,
    /// Covariance of (x, y): xx, xy, yy, px^2; null where the estimator has none.
    pub cov: Option<[f64; 3]>,
}

/// What became of one input, in the order given.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// It is the view at this place of the calibration's.
    Used(usize),
    /// It is not used.
    NotUsed {
        /// Path of the file, or frame id and stamp.
        source: String,
        /// Why, one plain sentence.
        reason: String,
    },
}

impl CalibrationJson {
    /// The file of a calibration of `views`, with what became of every input.
    pub fn new(
        camera_name: &str,
        estimator: &str,
        calibration: &Calibration,
        views: &[View],
        outcomes: &[Outcome],
    ) -> Self {
        let owned = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect();
        let names: Vec<String> = owned(&calibration.names);
        let by_name = |values: Vec<f64>| names.iter().cloned().zip(values).collect();
        let camera = &calibration.camera;
        Self {
            model: camera.model().to_string(),
            camera_name: camera_name.to_owned(),
            width: camera.width,
            height: camera.height,
            parameters: by_name(calibration.values()),
            std: by_name(calibration.stds()),
            covariance: rows(&calibration.covariance),
            fixed: owned(&calibration.fixed),
            rms_px: calibration.rms_px,
            variance_factor: calibration.variance_factor,
            estimator: estimator.to_owned(),
            projection_std_px: ProjectionStd::of(calibration),
            views: view_entries(calibration, views, outcomes),
            names,
        }
    }

    /// Reads the text of a file, every number to the last bit.
    ///
    /// # Errors
    /// Where the text stops being a calibration.json.
    pub fn from_json(text: &str) -> serde_json::Result<Self> {
        serde_json::from_str(text)
    }

    /// The text of the file.
    ///
    /// # Errors
    /// Never for what [`CalibrationJson::new`] makes.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self).map(|text| text + "\n")
    }
}

impl ProjectionStd {
    const COLUMNS: usize = 10;
    const ROWS: usize = 10;

    fn of(calibration: &Calibration) -> Self {
        let distance_m = calibration.typical_distance_m();
        let map = |range| calibration.projection_std_map((Self::COLUMNS, Self::ROWS), range);
        Self {
            columns: Self::COLUMNS,
            rows: Self::ROWS,
            infinity: map(Range::Infinity),
            distance_m,
            at_distance: map(Range::At(distance_m)),
        }
    }
}

fn rows<R: nalgebra::Dim, C: nalgebra::Dim, S: nalgebra::RawStorage<f64, R, C>>(
    matrix: &nalgebra::Matrix<f64, R, C, S>,
) -> Vec<Vec<f64>> {
    let rows = matrix.row_iter();
    rows.map(|row| row.iter().copied().collect()).collect()
}

fn view_entries(calibration: &Calibration, views: &[View], outcomes: &[Outcome]) -> Vec<ViewJson> {
    outcomes
        .iter()
        .filter_map(|outcome| match outcome {
            Outcome::NotUsed { source, reason } => Some(not_used(source, reason)),
            Outcome::Used(at) => entry(calibration, *at, views.get(*at)?),
        })
        .collect()
}

fn not_used(source: &str, reason: &str) -> ViewJson {
    ViewJson {
        source: source.to_owned(),
        used: false,
        reason: Some(reason.to_owned()),
        rms_px: None,
        rotation_vector: None,
        translation_m: None,
        pose_covariance: None,
        rings: Vec::new(),
    }
}

/// A view that was offered to the calibration, which may have left it out.
fn entry(calibration: &Calibration, at: usize, view: &View) -> Option<ViewJson> {
    let fit = calibration.views.get(at)?;
    let rings = view
        .rings
        .iter()
        .zip(fit.residuals.iter().zip(&fit.rings_used))
        .map(|(ring, (residual, used))| RingJson {
            row: ring.row,
            col: ring.column,
            x: ring.centre.point.x,
            y: ring.centre.point.y,
            residual: residual.map(|r| [r.x, r.y]),
            used: *used && fit.used(),
            cov: ring
                .centre
                .covariance
                .map(|c| [c[(0, 0)], c[(0, 1)], c[(1, 1)]]),
        });
    let out = fit.rings_left_out();
    let reason = match &fit.left_out {
        Some(left_out) => Some(left_out.to_string()),
        None if out > 0 => Some(format!(
            "{out} of its {} rings are left out: they lie elsewhere than the others say",
            view.rings.len()
        )),
        None => None,
    };
    Some(ViewJson {
        source: view.source.clone(),
        used: fit.used(),
        reason,
        rms_px: fit.used().then_some(fit.rms_px),
        rotation_vector: fit.pose.map(|pose| pose.rotation_vector().into()),
        translation_m: fit.pose.map(|pose| pose.translation_m.into()),
        pose_covariance: calibration.pose_covariance(at).map(|c| rows(&c)),
        rings: rings.collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::{calibrate, synthetic};
    use crate::formats::{CameraInfo, read_camera};

    #[test]
    fn every_input_is_there_in_its_order_with_what_became_of_it() {
        let (camera, board) = (synthetic::ordinary(), synthetic::board());
        let poses = synthetic::poses(&camera, &board);
        let mut views = synthetic::views(&camera, &board, &poses[..4], 0.1, 1);
        synthetic::with_covariance(
            &mut views[..1],
            nalgebra::Matrix2::new(0.01, 0.001, 0.001, 0.02),
        );
        let calibration = calibrate(&board, &views, &Default::default()).unwrap();
        let lost = Outcome::NotUsed {
            source: "b.png".into(),
            reason: "no ring seen".into(),
        };
        let mut outcomes: Vec<Outcome> = (0..4).map(Outcome::Used).collect();
        outcomes.insert(1, lost);
        let file = CalibrationJson::new("front", "cross", &calibration, &views, &outcomes);
        let text = file.to_json().unwrap();
        let json: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(CalibrationJson::from_json(&text).unwrap(), file);
        let info = CameraInfo::new("front", calibration.camera);
        assert_eq!(read_camera(&text, None), Ok(info));
        let same = |value: &serde_json::Value, wanted: f64| {
            (value.as_f64().unwrap() - wanted).abs() <= 1e-14 * wanted.abs()
        };
        assert_eq!(json["model"], "plumb_bob");
        assert!(same(&json["std"]["k3"], calibration.std(8)));
        assert_eq!(json["names"][4], "k1");
        assert!(same(
            &json["covariance"][4][0],
            calibration.covariance[(0, 4)]
        ));
        assert_eq!(json["views"].as_array().unwrap().len(), 5);
        assert_eq!(json["views"][1]["used"], false);
        assert_eq!(json["views"][1]["reason"], "no ring seen");
        assert!(json["views"][1]["rms_px"].is_null());
        let ring = &json["views"][2]["rings"][8];
        assert_eq!((&ring["row"], &ring["col"]), (&1.into(), &1.into()));
        assert!(same(
            &ring["residual"][1],
            calibration.views[1].residuals[8].unwrap().y
        ));
        assert!(ring["cov"].is_null());
        assert_eq!(json["views"][0]["rings"][0]["cov"][1], 0.001);
        let depth = calibration.views[1].pose.unwrap().translation_m.z;
        assert!(same(&json["views"][2]["translation_m"][2], depth));
    }
}
