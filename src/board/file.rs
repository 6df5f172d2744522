//! The text of a board file, read and written.

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

    /// The text of a board file that [`Board::from_yaml`] reads back as this very board: a line for each key.
    pub fn to_yaml(&self) -> String {
        let line = |(key, value)| format!("{key}: {value}\n");
        self.entries().into_iter().map(line).collect()
    }

    /// The same in one line, `{rows: 5, columns: 7, ...}`; it may be broken at any space and stays the same YAML.
    pub fn to_yaml_line(&self) -> String {
        let entries = self.entries();
        let entries = entries.iter().map(|(key, value)| format!("{key}: {value}"));
        format!("{{{}}}", entries.collect::<Vec<_>>().join(", "))
    }

    /// Keys and values, in the order of the documentation.
    fn entries(&self) -> Vec<(&'static str, String)> {
        // the shortest decimal number that reads back as the same one
        let mut entries = vec![
            ("rows", self.rows.to_string()),
            ("columns", self.columns.to_string()),
        ];
        if !self.is_single() {
            entries.push(("pitch", self.pitch_m.to_string()));
        }
        entries.push(("inner_radius", self.inner_radius_m.to_string()));
        entries.push(("outer_radius", self.outer_radius_m.to_string()));
        entries.push(("polarity", self.polarity.name().to_owned()));
        if !self.marks.is_empty() {
            entries.push(("marks", marks_text(&self.marks)));
        }
        entries
    }
}

fn marks_text(marks: &[(u16, u16)]) -> String {
    let marks = marks
        .iter()
        .map(|(row, column)| format!("[{row}, {column}]"));
    format!("[{}]", marks.collect::<Vec<_>>().join(", "))
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
    fn what_is_written_reads_back_as_the_same_board() {
        let single = "rows: 1\ncolumns: 1\ninner_radius: 0.05\nouter_radius: 1\npolarity: auto\n";
        let marked = format!("{C4}marks: [[0, 0], [0, 1], [1, 0]]\n");
        for text in [C4, single, &marked] {
            let board = Board::from_yaml(text).unwrap();
            assert_eq!(board.to_yaml(), text);
            let line = board.to_yaml_line();
            assert_eq!(Board::from_yaml(&line).unwrap(), board);
            assert_eq!(Board::from_yaml(&line.replace(' ', "\n  ")).unwrap(), board);
        }
        let odd = Board::new(2, 3, 0.1 + 0.2, 1e-7, 1.0 / 7.0, Polarity::LightOnDark).unwrap();
        assert_eq!(Board::from_yaml(&odd.to_yaml()).unwrap(), odd);
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
        let error = Board::from_yaml(&format!("{C4}marks: [[0, 0]]\n")).unwrap_err();
        assert_eq!(error, BoardError::OneMark);
        assert!(error.to_string().contains("at least two must be in view"));
        assert!(Board::from_yaml("rows: seven").is_err());
        assert!(Board::from_yaml(&format!("{C4}colour: red\n")).is_err());
    }
}
