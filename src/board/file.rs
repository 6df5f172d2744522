//! The text of a board file.

use super::{Board, BoardError, Polarity};
use serde::Deserialize;

/// The keys of a board file, as written there.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct BoardFile {
    rows: Option<f64>,
    columns: Option<f64>,
    pitch: Option<f64>,
    inner_radius: Option<f64>,
    outer_radius: Option<f64>,
    #[serde(default)]
    polarity: Polarity,
    #[serde(default)]
    marks: Vec<(u16, u16)>,
}

impl Board {
    /// Reads the text of a board file (see docs/formats.md).
    ///
    /// # Errors
    /// [`BoardError::Syntax`] with the place in the text, or what [`Board::new`] refuses.
    pub fn from_yaml(text: &str) -> Result<Self, BoardError> {
        let file: BoardFile =
            serde_saphyr::from_str(text).map_err(|e| BoardError::Syntax(e.to_string()))?;
        let (rows, columns) = (count("rows", file.rows)?, count("columns", file.columns)?);
        let single = rows == 1 && columns == 1;
        let pitch_m = if single {
            0.0
        } else {
            present("pitch", file.pitch)?
        };
        Self::new(
            rows,
            columns,
            pitch_m,
            present("inner_radius", file.inner_radius)?,
            present("outer_radius", file.outer_radius)?,
            file.polarity,
        )?
        .with_marks(file.marks)
    }
}

fn present(name: &'static str, value: Option<f64>) -> Result<f64, BoardError> {
    value.ok_or(BoardError::Missing { name })
}

fn count(name: &'static str, value: Option<f64>) -> Result<u16, BoardError> {
    let value = present(name, value)?;
    if (1.0..=100.0).contains(&value) && value.fract() == 0.0 {
        Ok(value as u16)
    } else {
        Err(BoardError::Count { name, value })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const C4: &str = "rows: 7\ncolumns: 7\npitch: 0.0269\ninner_radius: 0.003\nouter_radius: 0.006\npolarity: dark_on_light\n";

    #[test]
    fn reads_the_design_s_example() {
        let board = Board::from_yaml(C4).unwrap();
        assert_eq!((board.rows(), board.columns()), (7, 7));
        assert_eq!(board.centre_m(1, 2), [2.0 * 0.0269, 0.0269]);
        assert_eq!(board.radius_ratio(), 0.5);
    }

    #[test]
    fn a_single_ring_needs_no_pitch() {
        let text = "rows: 1\ncolumns: 1\ninner_radius: 0.05\nouter_radius: 0.1\n";
        assert!(Board::from_yaml(text).unwrap().is_single());
    }

    #[test]
    fn marks_are_rows_and_columns() {
        let board = Board::from_yaml(&format!("{C4}marks: [[0, 0], [0, 1], [1, 0]]\n")).unwrap();
        assert_eq!(board.marks(), [(0, 0), (0, 1), (1, 0)]);
    }

    #[test]
    fn refusals_name_the_key_and_the_value() {
        let negative = C4.replace("0.0269", "-1");
        let error = Board::from_yaml(&negative).unwrap_err().to_string();
        assert!(error.contains("pitch") && error.contains("-1"), "{error}");
        let line = C4.replace("rows: 7", "rows: 1");
        assert!(matches!(
            Board::from_yaml(&line),
            Err(BoardError::Size { rows: 1, .. })
        ));
        let touching = C4.replace("0.0269", "0.011");
        assert!(matches!(
            Board::from_yaml(&touching),
            Err(BoardError::Pitch { .. })
        ));
        let swapped = C4.replace("0.003", "0.03");
        assert!(matches!(
            Board::from_yaml(&swapped),
            Err(BoardError::Radii { .. })
        ));
        let say = |from: &str, to: &str| {
            Board::from_yaml(&C4.replace(from, to))
                .unwrap_err()
                .to_string()
        };
        assert!(say("rows: 7", "rows: -7").contains("rows must be a whole number"));
        assert!(say("rows: 7", "rows: 7.5").contains("not 7.5"));
        assert_eq!(say("pitch: 0.0269\n", ""), "pitch is missing");
        assert!(say("pitch: 0.0269", "pitch: 26.9").contains("in metres"));
        let symmetric = format!("{C4}marks: [[0, 0], [6, 6]]\n");
        let error = Board::from_yaml(&symmetric).unwrap_err();
        assert_eq!(error, BoardError::MarksSymmetric);
        assert!(Board::from_yaml("rows: seven").is_err());
        assert!(Board::from_yaml(&format!("{C4}colour: red\n")).is_err());
    }
}
