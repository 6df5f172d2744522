//! The board: a grid of rings printed on a plane.
//!
//! Board frame: the origin is the centre of ring (row 0, column 0), x grows with the column, y with the
//! row, z = x cross y points away from a camera that looks at the print. Lengths are metres.

mod file;
mod marks;

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

impl Polarity {
    /// The name in a board file.
    pub fn name(self) -> &'static str {
        match self {
            Self::DarkOnLight => "dark_on_light",
            Self::LightOnDark => "light_on_dark",
            Self::Auto => "auto",
        }
    }
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
    marks: Vec<(u16, u16)>,
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
    /// A mark that is no ring of the board.
    #[error("marks: there is no ring in row {row}, column {column}")]
    MarkOffBoard {
        /// Row given.
        row: u16,
        /// Column given.
        column: u16,
    },
    /// The same mark again.
    #[error("marks: row {row}, column {column} is there twice")]
    MarkTwice {
        /// Row given.
        row: u16,
        /// Column given.
        column: u16,
    },
    /// A single mark, which a ring that is badly seen may look like.
    #[error(
        "marks: one is not enough, at least two must be in view to tell which way the board is turned"
    )]
    OneMark,
    /// Too many marks leave too few rings.
    #[error("marks: {count} are too many, at most {most} rings of this board can be marks")]
    Marks {
        /// Marks given.
        count: usize,
        /// A quarter of the rings.
        most: usize,
    },
    /// Marks that do not tell which way the board is turned.
    #[error("marks: they look the same when the board is turned by 180 degrees")]
    MarksSymmetric,
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
            marks: Vec::new(),
        })
    }

    /// The same board of this polarity.
    pub fn with_polarity(self, polarity: Polarity) -> Self {
        Self { polarity, ..self }
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

    /// The rings (row, column) that are printed without their inner circle: they tell row 0, column 0 however the board is turned.
    pub fn marks(&self) -> &[(u16, u16)] {
        &self.marks
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

fn positive(name: &'static str, value: f64) -> Result<(), BoardError> {
    if value > 0.0 && value <= MOST_M {
        Ok(())
    } else {
        Err(BoardError::Length { name, value })
    }
}
