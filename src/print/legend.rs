//! What the sheet says to whoever holds it.

use super::numbers::mm;
use super::sheet::{ADVANCE, ASCENT, Text, Turn};
use crate::board::{Board, Polarity};
use crate::report::wrap;

/// Sizes of the fonts on an A4 sheet, mm: 2.3 mm are 6.5 points.
const SMALL_MM: f64 = 2.2;
const BODY_MM: f64 = 2.3;
const TITLE_MM: f64 = 3.0;
/// From one line to the next, over the size of the font.
const LEADING: f64 = 1.3;
/// A name is cut after so many characters on the sheet.
const LONGEST_NAME: usize = 60;
/// The fewest characters in a line.
const LEAST_COLUMNS: usize = 12;

/// What stands beside the corner of ring (0, 0).
pub(super) const CORNER: &str = "row 0, column 0";

/// What the rulers are for, where they are so long.
pub(super) fn scale_sentence(length_mm: f64) -> String {
    let length = mm(length_mm);
    format!(
        "{length} mm here must measure {length} mm, on both rulers. Print at 100 %, not fitted to the page."
    )
}

/// A line of text that is not placed yet.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Line {
    pub(super) text: String,
    pub(super) em_mm: f64,
    pub(super) bold: bool,
}

impl Line {
    pub(super) fn body(text: String, scale: f64) -> Self {
        Self {
            text,
            em_mm: BODY_MM * scale,
            bold: false,
        }
    }

    pub(super) fn corner(scale: f64) -> Self {
        Self {
            text: CORNER.to_owned(),
            em_mm: BODY_MM * scale,
            bold: true,
        }
    }

    pub(super) fn length_mm(&self) -> f64 {
        self.text.chars().count() as f64 * ADVANCE * self.em_mm
    }

    pub(super) fn height_mm(&self) -> f64 {
        LEADING * self.em_mm
    }

    /// The line with the upper left corner of its room here (as it is read).
    pub(super) fn placed(self, corner_mm: [f64; 2], turn: Turn) -> Text {
        let up = (ASCENT + 0.5 * (LEADING - ASCENT - super::sheet::DESCENT)) * self.em_mm;
        let [x, y] = corner_mm;
        Text {
            at_mm: match turn {
                Turn::Level => [x, y + up],
                Turn::Down => [x - up, y],
            },
            em_mm: self.em_mm,
            bold: self.bold,
            turn,
            text: self.text,
        }
    }

    /// The line broken into lines of at most this length.
    pub(super) fn wrapped(&self, length_mm: f64) -> Vec<Self> {
        let columns = (length_mm / (ADVANCE * self.em_mm) + 1e-9) as usize;
        let with = |text| Self {
            text,
            ..self.clone()
        };
        let lines = wrap(&self.text, columns.max(LEAST_COLUMNS));
        lines.into_iter().map(with).collect()
    }
}

/// The shortest line that can hold every text without breaking short words, mm.
pub(super) fn least_length_mm(scale: f64) -> f64 {
    Line::corner(scale)
        .length_mm()
        .max(30.0 * ADVANCE * BODY_MM * scale)
}

/// The legend: name, sizes, the board file.
pub(super) fn legend(board: &Board, name: &str, scale: f64) -> Vec<Line> {
    let title = Line {
        text: ascii(name).chars().take(LONGEST_NAME).collect(),
        em_mm: TITLE_MM * scale,
        bold: true,
    };
    let file = Line {
        text: format!("Board file: {}", board.to_yaml_line()),
        em_mm: SMALL_MM * scale,
        bold: false,
    };
    vec![title, Line::body(sizes(board), scale), file]
}

/// The board in words.
fn sizes(board: &Board) -> String {
    let length = |metres: f64| mm(1e3 * metres);
    let grid = if board.is_single() {
        "A single ring".to_owned()
    } else {
        let (rows, columns) = (board.rows(), board.columns());
        let pitch = length(board.pitch_m());
        format!("{rows} rows x {columns} columns of rings, {pitch} mm from centre to centre")
    };
    let (inner, outer) = (
        length(board.inner_radius_m()),
        length(board.outer_radius_m()),
    );
    let polarity = match board.polarity() {
        Polarity::LightOnDark => "light on dark",
        Polarity::DarkOnLight | Polarity::Auto => "dark on light",
    };
    let marks = match board.marks().len() {
        0 => String::new(),
        count => format!(", {count} of them marks without an inner circle"),
    };
    format!("{grid}, radii {inner} and {outer} mm, {polarity}{marks}.")
}

/// Printable ASCII, with `?` for everything else: what every font of a printer has.
fn ascii(text: &str) -> String {
    text.chars()
        .map(|c| match c {
            ' '..='~' => c,
            _ => '?',
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_legend_describes_the_board() {
        let board = Board::new(5, 7, 0.038, 0.006, 0.012, Polarity::DarkOnLight).unwrap();
        let lines = legend(&board, "caf\u{e9} 5", 1.0);
        assert_eq!(lines[0].text, "caf? 5");
        assert_eq!(
            lines[1].text,
            "5 rows x 7 columns of rings, 38 mm from centre to centre, radii 6 and 12 mm, dark on light."
        );
        let broken: Vec<_> = lines[2].wrapped(50.0);
        assert!(broken.len() > 2 && broken.iter().all(|line| line.length_mm() <= 50.0));
        let text: Vec<_> = broken.iter().map(|line| line.text.as_str()).collect();
        let text = text.join("\n");
        let yaml = text.strip_prefix("Board file: ").unwrap();
        assert_eq!(Board::from_yaml(yaml).unwrap(), board);
    }
}
