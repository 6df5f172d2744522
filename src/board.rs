//! The board: a grid of rings printed on a plane.
//!
//! Board frame: the origin is the centre of ring (row 0, column 0), x grows with the column, y with the
//! row, z = x cross y points away from a camera that looks at the print. Lengths are metres.

use serde::{Deserialize, Serialize};

/// Whether the rings are darker or lighter than the board they are printed on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Polarity {
    /// Dark rings on light paper (the usual print).
    #[default]
    DarkOnLight,
    /// Light rings on a dark board.
    LightOnDark,
    /// Unknown: the detector tries both and keeps the one that shows the board.
    Auto,
}

/// A board of `rows` x `columns` rings, each two concentric circles; valid by construction.
#[derive(Debug, Clone, PartialEq)]
pub struct Board {
    rows: u16,
    columns: u16,
    pitch_m: f64,
    inner_radius_m: f64,
    outer_radius_m: f64,
    polarity: Polarity,
}

/// The longest length of a board, m: a larger number was meant in millimetres.
const MOST_M: f64 = 10.0;

/// What is wrong with a board description.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BoardError {
    /// The text is not the YAML of a board.
    #[error("not a board file: {0}")]
    Syntax(String),
    /// A number of rings that is not whole or out of range.
    #[error("{name} must be a whole number from 1 to 100, not {value}")]
    Count {
        /// The key of the board file.
        name: &'static str,
        /// The value found.
        value: f64,
    },
    /// A key that the board needs is not there.
    #[error("{name} is missing")]
    Missing {
        /// The key of the board file.
        name: &'static str,
    },
    /// No board has this many rings in a row or column.
    #[error("a board has 1 x 1 ring or 2 to 100 rows and columns, not {rows} x {columns}")]
    Size {
        /// Rows asked for.
        rows: u16,
        /// Columns asked for.
        columns: u16,
    },
    /// A length is missing, not finite or not positive.
    #[error("{name} must be a length in metres, more than 0 and at most {MOST_M}, not {value}")]
    Length {
        /// The key of the board file.
        name: &'static str,
        /// The value found.
        value: f64,
    },
    /// The inner circle must lie inside the outer one.
    #[error("inner_radius {inner_m} m must be smaller than outer_radius {outer_m} m")]
    Radii {
        /// Inner radius, m.
        inner_m: f64,
        /// Outer radius, m.
        outer_m: f64,
    },
    /// Neighbouring rings would touch or overlap.
    #[error("pitch {pitch_m} m must be larger than the outer diameter {diameter_m} m")]
    Pitch {
        /// Centre to centre, m.
        pitch_m: f64,
        /// Diameter of a ring, m.
        diameter_m: f64,
    },
}

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
}

impl Board {
    /// A board of `rows` x `columns` rings; `pitch_m` is ignored for a single ring (1 x 1).
    ///
    /// # Errors
    /// [`BoardError`] where the sizes do not describe a board that can be printed.
    pub fn new(
        rows: u16,
        columns: u16,
        pitch_m: f64,
        inner_radius_m: f64,
        outer_radius_m: f64,
        polarity: Polarity,
    ) -> Result<Self, BoardError> {
        let single = rows == 1 && columns == 1;
        let grid = (2..=100).contains(&rows) && (2..=100).contains(&columns);
        if !(single || grid) {
            return Err(BoardError::Size { rows, columns });
        }
        positive("inner_radius", inner_radius_m)?;
        positive("outer_radius", outer_radius_m)?;
        if inner_radius_m >= outer_radius_m {
            return Err(BoardError::Radii {
                inner_m: inner_radius_m,
                outer_m: outer_radius_m,
            });
        }
        if !single {
            positive("pitch", pitch_m)?;
            if pitch_m <= 2.0 * outer_radius_m {
                return Err(BoardError::Pitch {
                    pitch_m,
                    diameter_m: 2.0 * outer_radius_m,
                });
            }
        }
        Ok(Self {
            rows,
            columns,
            pitch_m: if single { 0.0 } else { pitch_m },
            inner_radius_m,
            outer_radius_m,
            polarity,
        })
    }

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
        )
    }

    /// Rings per column.
    pub fn rows(&self) -> u16 {
        self.rows
    }

    /// Rings per row.
    pub fn columns(&self) -> u16 {
        self.columns
    }

    /// All rings of the board.
    pub fn ring_count(&self) -> usize {
        usize::from(self.rows) * usize::from(self.columns)
    }

    /// Whether the board is one ring alone.
    pub fn is_single(&self) -> bool {
        self.ring_count() == 1
    }

    /// Distance between neighbouring ring centres, m; 0 for a single ring.
    pub fn pitch_m(&self) -> f64 {
        self.pitch_m
    }

    /// Radius of the inner circle, m.
    pub fn inner_radius_m(&self) -> f64 {
        self.inner_radius_m
    }

    /// Radius of the outer circle, m.
    pub fn outer_radius_m(&self) -> f64 {
        self.outer_radius_m
    }

    /// Inner radius over outer radius, in (0, 1).
    pub fn radius_ratio(&self) -> f64 {
        self.inner_radius_m / self.outer_radius_m
    }

    /// Dark rings on light, light rings on dark, or unknown.
    pub fn polarity(&self) -> Polarity {
        self.polarity
    }

    /// Centre of the ring in the board frame, m (z is 0).
    pub fn centre_m(&self, row: u16, column: u16) -> [f64; 2] {
        [
            f64::from(column) * self.pitch_m,
            f64::from(row) * self.pitch_m,
        ]
    }

    /// Middle of the grid of centres in the board frame, m.
    pub fn middle_m(&self) -> [f64; 2] {
        [
            0.5 * f64::from(self.columns - 1) * self.pitch_m,
            0.5 * f64::from(self.rows - 1) * self.pitch_m,
        ]
    }

    /// (row, column) of every ring, row by row.
    pub fn indices(&self) -> impl Iterator<Item = (u16, u16)> + use<> {
        let columns = self.columns;
        (0..self.rows).flat_map(move |row| (0..columns).map(move |column| (row, column)))
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

fn positive(name: &'static str, value: f64) -> Result<(), BoardError> {
    if value > 0.0 && value <= MOST_M {
        Ok(())
    } else {
        Err(BoardError::Length { name, value })
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
        assert!(Board::from_yaml("rows: seven").is_err());
        assert!(Board::from_yaml(&format!("{C4}colour: red\n")).is_err());
    }
}
