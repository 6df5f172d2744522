//! Papers and rolls.

use super::error::PrintError;
use std::str::FromStr;

/// Papers by name: portrait width and height, mm. The A series from the smallest on, then what North America prints on.
const NAMED: [(&str, f64, f64); 10] = [
    ("a6", 105.0, 148.0),
    ("a5", 148.0, 210.0),
    ("a4", 210.0, 297.0),
    ("a3", 297.0, 420.0),
    ("a2", 420.0, 594.0),
    ("a1", 594.0, 841.0),
    ("a0", 841.0, 1189.0),
    ("letter", 215.9, 279.4),
    ("legal", 215.9, 355.6),
    ("tabloid", 279.4, 431.8),
];
/// The papers tried where none is named. A smaller one than A4 would be enlarged by many a print dialogue.
const TRIED: [usize; 5] = [2, 3, 4, 5, 6];

/// The shortest and longest side of a page, mm. A PDF page is at most 14400 points, 5080 mm, long.
pub(super) const LEAST_MM: f64 = 20.0;
pub(super) const MOST_MM: f64 = 5000.0;

/// A paper, either way up.
#[derive(Debug, Clone, PartialEq)]
pub struct Paper {
    name: String,
    sides_mm: [f64; 2],
}

impl Paper {
    /// What it is called.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Width and height as given, mm; a sheet may lie on it turned.
    pub fn sides_mm(&self) -> [f64; 2] {
        self.sides_mm
    }

    /// The papers tried where none is named, the smallest first.
    pub(super) fn usual() -> [Self; TRIED.len()] {
        TRIED.map(|at| {
            let (name, width, height) = NAMED[at];
            Self {
                name: name.to_owned(),
                sides_mm: [width, height],
            }
        })
    }
}

impl FromStr for Paper {
    type Err = PrintError;

    fn from_str(text: &str) -> Result<Self, PrintError> {
        let name = text.trim().to_ascii_lowercase();
        if let Some(&(name, width, height)) = NAMED.iter().find(|(known, ..)| *known == name) {
            return Ok(Self {
                name: name.to_owned(),
                sides_mm: [width, height],
            });
        }
        let side = |text: &str| {
            let side: f64 = text.trim().parse().ok()?;
            (LEAST_MM..=MOST_MM).contains(&side).then_some(side)
        };
        let sides = name
            .split_once('x')
            .and_then(|(width, height)| Some([side(width)?, side(height)?]));
        match sides {
            Some(sides_mm) => Ok(Self { name, sides_mm }),
            None => Err(PrintError::Paper {
                text: text.to_owned(),
                names: NAMED.map(|(name, ..)| name).join(", "),
            }),
        }
    }
}

/// What is printed on.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Stock {
    /// The smallest of A4, A3, A2, A1 and A0 that holds the board.
    #[default]
    Smallest,
    /// This paper, upright or lying.
    Sheet(Paper),
    /// A roll; the page takes as much of its length as it needs.
    Roll {
        /// Width of the roll, mm.
        width_mm: f64,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn papers_have_names_or_sizes() {
        let paper: Paper = "A4".parse().unwrap();
        assert_eq!((paper.name(), paper.sides_mm()), ("a4", [210.0, 297.0]));
        let paper: Paper = " 600 x 400.5".parse().unwrap();
        assert_eq!(paper.sides_mm(), [600.0, 400.5]);
        for wrong in [
            "", "a7", "10x400", "600x6000", "600", "nanx300", "infx300", "-5x3",
        ] {
            let error = wrong.parse::<Paper>().unwrap_err().to_string();
            assert!(
                error.contains("letter") && error.contains("600x400"),
                "{error}"
            );
        }
    }

    #[test]
    fn the_usual_papers_grow() {
        let names = Paper::usual().map(|paper| paper.name);
        assert_eq!(names, ["a4", "a3", "a2", "a1", "a0"]);
    }
}
