//! One line of `ringcal detect`: JSON for programs, text for people.

use crate::detect::{Detection, Ring};
use crate::frame::Stamp;
use serde::Serialize;
use std::fmt::Write;

/// The result of one image, in the order and with the names of the JSON line.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DetectionLine {
    /// The path as it was given.
    pub image: String,
    /// For a frame of a bag its number on the topic, from 0; an image file has no such key.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<u64>,
    /// For a frame of a bag the time in its header; an image file has no such key.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stamp: Option<StampLine>,
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

/// A time, as builtin_interfaces/msg/Time has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct StampLine {
    /// Whole seconds.
    pub sec: i32,
    /// Nanoseconds within the second.
    pub nanosec: u32,
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
            frame: None,
            stamp: None,
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
            frame: None,
            stamp: None,
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

    /// The same of a message of a bag: its number on the topic and the time in its header, where that could be read.
    #[must_use]
    pub fn of_message(self, number: u64, stamp: Option<Stamp>) -> Self {
        let line = |stamp: Stamp| StampLine {
            sec: stamp.sec,
            nanosec: stamp.nanosec,
        };
        Self {
            frame: Some(number),
            stamp: stamp.map(line),
            ..self
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
        let mut text = self.image.clone();
        // writing to a String does not fail
        let _ = match (self.frame, self.stamp) {
            (Some(number), Some(at)) => {
                write!(text, ": frame {number} at {}.{:09}", at.sec, at.nanosec)
            }
            (Some(number), None) => write!(text, ": frame {number}"),
            (None, _) => Ok(()),
        };
        let _ = match (&self.reason, self.blur_sigma, self.elapsed_ms) {
            (None, Some(blur), Some(ms)) => {
                let rings = self.points.len();
                write!(text, ": {rings} rings, blur sigma {blur:.1} px, {ms:.1} ms")
            }
            (reason, ..) => write!(text, ": {}", reason.as_deref().unwrap_or("no board")),
        };
        for note in &self.notes {
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
        assert!(value.get("frame").is_none() && value.get("stamp").is_none());
    }

    #[test]
    fn a_frame_of_a_bag_has_its_number_and_its_time() {
        let (sec, nanosec) = (12, 500_000_000);
        let line = DetectionLine::unreadable("drive".into(), "too dark".into())
            .of_message(7, Some(Stamp { sec, nanosec }));
        let value: serde_json::Value = serde_json::from_str(&line.json().unwrap()).unwrap();
        assert_eq!(
            (&value["image"], &value["frame"]),
            (&"drive".into(), &7.into())
        );
        assert_eq!(
            value["stamp"],
            serde_json::json!({"sec": 12, "nanosec": 500_000_000})
        );
        assert_eq!(line.text(), "drive: frame 7 at 12.500000000: too dark");
    }
}
