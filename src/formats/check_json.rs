//! What `ringcal check --format json` prints.

use crate::calibrate::{Check, Difference, FIELD};
use crate::session::View;
use serde::Serialize;

/// The object; keys as written. Pixels with (0, 0) at the centre of the top-left one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CheckJson {
    /// holds, drifted, fails or not_enough; null without views.
    pub verdict: Option<&'static str>,
    /// The verdict as a sentence.
    pub reason: Option<String>,
    /// Root mean square distance between measured and predicted centres, px; null where no view has a position of the board.
    pub rms_px: Option<f64>,
    /// Every view in which the board was found.
    pub views: Vec<CheckedView>,
    /// The bias over the frame.
    pub field: Option<Field>,
    /// The other calibration.
    pub difference: Option<DifferenceJson>,
}

/// A view.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CheckedView {
    /// Path of the file, or frame id and stamp.
    pub source: String,
    /// Rings found.
    pub rings: usize,
    /// Root mean square distance, px; null where no position of the board explains the view.
    pub rms_px: Option<f64>,
    /// Why there is none.
    pub reason: Option<String>,
}

/// Means over the cells of the frame, by rows; null where fewer than five rings were seen.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Field {
    /// Cells across the frame.
    pub columns: usize,
    /// Cells down the frame.
    pub rows: usize,
    /// Mean of measured less predicted, (x, y), px.
    pub bias_px: Vec<Option<[f64; 2]>>,
    /// Standard deviation of each coordinate of it, px.
    pub std_px: Vec<Option<f64>>,
}

/// Where the second camera sees what the first one sees, less where the first one does.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DifferenceJson {
    /// Cells across the frame.
    pub columns: usize,
    /// Cells down the frame.
    pub rows: usize,
    /// (x, y) in the middles of the cells, by rows, px; null where either camera has no ray.
    pub offsets_px: Vec<Option<[f64; 2]>>,
    /// The rotation that was taken off: axis times angle, rad.
    pub rotation_vector: [f64; 3],
    /// Root mean square length, px.
    pub rms_px: f64,
    /// The longest, px.
    pub worst_px: f64,
}

impl CheckJson {
    /// Of a check of views, and of a comparison.
    pub fn new(checked: Option<(&[View], &Check)>, difference: Option<&Difference>) -> Self {
        let check = checked.map(|(_, check)| check);
        Self {
            verdict: check.map(|check| check.verdict.word()),
            reason: check.map(|check| check.verdict.to_string()),
            rms_px: check.and_then(|check| check.rms_px),
            views: checked.map_or_else(Vec::new, |(views, check)| checked_views(views, check)),
            field: check.map(Field::of),
            difference: difference.map(DifferenceJson::of),
        }
    }

    /// The text.
    ///
    /// # Errors
    /// Never for what [`CheckJson::new`] makes.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self).map(|text| text + "\n")
    }
}

fn checked_views(views: &[View], check: &Check) -> Vec<CheckedView> {
    let pairs = views.iter().zip(&check.views);
    pairs
        .map(|(view, resection)| CheckedView {
            source: view.source.clone(),
            rings: view.rings.len(),
            rms_px: resection.fit.used().then_some(resection.fit.rms_px),
            reason: resection.fit.left_out.as_ref().map(ToString::to_string),
        })
        .collect()
}

impl Field {
    fn of(check: &Check) -> Self {
        let told = || {
            let cells = check.field.iter();
            cells.map(|cell| cell.tells().then_some(cell))
        };
        Self {
            columns: FIELD.0,
            rows: FIELD.1,
            bias_px: told()
                .map(|cell| cell.map(|c| [c.bias_px.x, c.bias_px.y]))
                .collect(),
            std_px: told().map(|cell| cell.map(|c| c.std_px)).collect(),
        }
    }
}

impl DifferenceJson {
    fn of(difference: &Difference) -> Self {
        let offsets = difference.offsets_px.iter();
        Self {
            columns: difference.cells.0,
            rows: difference.cells.1,
            offsets_px: offsets.map(|o| o.map(|o| [o.x, o.y])).collect(),
            rotation_vector: difference.rotation_rad.into(),
            rms_px: difference.rms_px,
            worst_px: difference.worst_px,
        }
    }
}
