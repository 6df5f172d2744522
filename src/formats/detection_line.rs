//! One line of `ringcal detect`: JSON for programs, text for people.

use crate::detect::{Detection, Ring};
use serde::Serialize;
use std::fmt::Write;

/// The result of one image, in the order and with the names of the JSON line.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DetectionLine {
    /// The path as it was given.
    pub image: String,
    /// Whether the board was found.
    pub found: bool,
    /// Width, px; `None` where the file could not be read.
    pub width: Option<usize>,
    /// Height, px; `None` where the file could not be read.
    pub height: Option<usize>,
    /// `absolute` or `relative`; `None` where no board was found.
    pub indices: Option<&'static str>,
    /// Median blur of the rings, px; `None` where no board was found.
    pub blur_sigma: Option<f64>,
    /// From decoded pixels to points, ms; `None` where the file could not be read.
    pub elapsed_ms: Option<f64>,
    /// The rings by row, then column; empty where no board was found.
    pub points: Vec<PointLine>,
    /// Why no board was found, one plain sentence.
    pub reason: Option<String>,
    /// For people: what the photometric estimator found of blur and response, and which rings it could not measure and why. Not in
    /// the JSON line.
    #[serde(skip)]
    pub notes: Vec<String>,
}

/// One ring of a [`DetectionLine`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PointLine {
    /// Row on the board.
    pub row: u16,
    /// Column on the board.
    pub col: u16,
    /// Projected centre, px of the raw image.
    pub x: f64,
    /// Projected centre, px of the raw image.
    pub y: f64,
    /// Covariance xx, xy, yy, px^2, where the estimator has one.
    pub cov: Option<[f64; 3]>,
    /// Blur of the ring's edges, px.
    pub blur_sigma: f64,
}

impl From<&Ring> for PointLine {
    fn from(ring: &Ring) -> Self {
        Self {
            row: ring.row,
            col: ring.column,
            x: ring.centre.point.x,
            y: ring.centre.point.y,
            cov: ring
                .centre
                .covariance
                .map(|c| [c[(0, 0)], c[(0, 1)], c[(1, 1)]]),
            blur_sigma: ring.blur_sigma_px,
        }
    }
}

impl DetectionLine {
    /// A board that was found.
    pub fn found(image: String, detection: &Detection, elapsed_ms: f64) -> Self {
        Self {
            image,
            found: true,
            width: Some(detection.width),
            height: Some(detection.height),
            indices: Some(detection.indices.word()),
            blur_sigma: Some(detection.blur_sigma_px()),
            elapsed_ms: Some(elapsed_ms),
            points: detection.rings.iter().map(PointLine::from).collect(),
            reason: None,
            notes: detection.notes(),
        }
    }

    /// An image without the board.
    pub fn missed(image: String, size: (usize, usize), reason: String, elapsed_ms: f64) -> Self {
        Self {
            width: Some(size.0),
            height: Some(size.1),
            elapsed_ms: Some(elapsed_ms),
            ..Self::unreadable(image, reason)
        }
    }

    /// A file that is no image.
    pub fn unreadable(image: String, reason: String) -> Self {
        Self {
            image,
            found: false,
            width: None,
            height: None,
            indices: None,
            blur_sigma: None,
            elapsed_ms: None,
            points: Vec::new(),
            reason: Some(reason),
            notes: Vec::new(),
        }
    }

    /// The JSON of one line, without its end.
    ///
    /// # Errors
    /// Those of the JSON writer; none for numbers and strings.
    pub fn json(&self) -> serde_json::Result<String> {
        serde_json::to_string(self)
    }

    /// The same for people: a line on the image, then one for each ring.
    pub fn text(&self) -> String {
        let mut text = match (&self.reason, self.blur_sigma, self.elapsed_ms) {
            (None, Some(blur), Some(ms)) => format!(
                "{}: {} rings, blur sigma {blur:.1} px, {ms:.1} ms",
                self.image,
                self.points.len()
            ),
            (reason, ..) => format!(
                "{}: {}",
                self.image,
                reason.as_deref().unwrap_or("no board")
            ),
        };
        for note in &self.notes {
            // writing to a String does not fail
            let _ = write!(text, "\n  {note}");
        }
        for p in &self.points {
            let _ = write!(
                text,
                "\n  row {:2} column {:2}  x {:9.3}  y {:9.3}",
                p.row, p.col, p.x, p.y
            );
            if let Some([xx, _, yy]) = p.cov {
                let _ = write!(text, "  +- {:.3} {:.3}", xx.sqrt(), yy.sqrt());
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unreadable_file_is_a_line_with_nulls_and_the_reason() {
        let line = DetectionLine::unreadable("a.png".into(), "not an image".into());
        let value: serde_json::Value = serde_json::from_str(&line.json().unwrap()).unwrap();
        assert_eq!(value["found"], false);
        assert_eq!(value["points"], serde_json::json!([]));
        assert_eq!(value["reason"], "not an image");
        assert!(value["width"].is_null());
        assert_eq!(line.text(), "a.png: not an image");
    }
}
