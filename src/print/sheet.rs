//! What is on a sheet, in millimetres.

/// A rectangle along the edges of the sheet, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    /// Upper left corner, x and y.
    pub low_mm: [f64; 2],
    /// Lower right corner, x and y.
    pub high_mm: [f64; 2],
}

impl Area {
    /// From its upper left corner and its size.
    pub fn at(low_mm: [f64; 2], width_mm: f64, height_mm: f64) -> Self {
        Self {
            low_mm,
            high_mm: [low_mm[0] + width_mm, low_mm[1] + height_mm],
        }
    }

    /// From left to right.
    pub fn width_mm(&self) -> f64 {
        self.high_mm[0] - self.low_mm[0]
    }

    /// From top to bottom.
    pub fn height_mm(&self) -> f64 {
        self.high_mm[1] - self.low_mm[1]
    }

    /// Whether the other one lies inside, up to a nanometre of rounding.
    pub fn contains(&self, other: &Self) -> bool {
        (0..2).all(|axis| {
            self.low_mm[axis] <= other.low_mm[axis] + 1e-6
                && other.high_mm[axis] <= self.high_mm[axis] + 1e-6
        })
    }

    /// Whether they share more than an edge.
    pub fn overlaps(&self, other: &Self) -> bool {
        (0..2).all(|axis| {
            self.low_mm[axis] < other.high_mm[axis] - 1e-6
                && other.low_mm[axis] < self.high_mm[axis] - 1e-6
        })
    }
}

/// Ink or paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// Black ink.
    Dark,
    /// The white of the paper.
    Light,
}

/// A filled shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// A rectangle along the edges of the sheet.
    Rectangle {
        /// Where.
        area: Area,
        /// How it is filled.
        tone: Tone,
    },
    /// A dark triangle.
    Triangle {
        /// Its corners, mm.
        corners_mm: [[f64; 2]; 3],
    },
    /// What lies between two concentric circles.
    Ring {
        /// Common centre, mm.
        centre_mm: [f64; 2],
        /// Radius of the outer circle, mm.
        outer_mm: f64,
        /// Radius of the inner circle, mm; `None` for a mark, which is a full disc.
        inner_mm: Option<f64>,
        /// How it is filled.
        tone: Tone,
    },
}

impl Shape {
    /// The smallest area that holds it.
    pub fn area(&self) -> Area {
        match *self {
            Self::Rectangle { area, .. } => area,
            Self::Triangle { corners_mm } => {
                let pick = |axis: usize, of: fn(f64, f64) -> f64| {
                    corners_mm[1..]
                        .iter()
                        .fold(corners_mm[0][axis], |found, corner| of(found, corner[axis]))
                };
                Area {
                    low_mm: [pick(0, f64::min), pick(1, f64::min)],
                    high_mm: [pick(0, f64::max), pick(1, f64::max)],
                }
            }
            Self::Ring {
                centre_mm,
                outer_mm,
                ..
            } => Area {
                low_mm: centre_mm.map(|c| c - outer_mm),
                high_mm: centre_mm.map(|c| c + outer_mm),
            },
        }
    }
}

/// The direction in which a text is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Turn {
    /// From left to right.
    Level,
    /// From top to bottom: turned clockwise by a right angle.
    Down,
}

/// Advance of a character over the size of the font: every font here has characters of one width.
pub(super) const ADVANCE: f64 = 0.6;
/// How far characters reach above and below the line they stand on, over the size of the font.
pub(super) const ASCENT: f64 = 0.8;
pub(super) const DESCENT: f64 = 0.25;

/// One line of text in a font whose characters all have one width.
#[derive(Debug, Clone, PartialEq)]
pub struct Text {
    /// Where the line that the characters stand on begins, mm.
    pub at_mm: [f64; 2],
    /// Size of the font, mm.
    pub em_mm: f64,
    /// Whether it is bold.
    pub bold: bool,
    /// Which way it is read.
    pub turn: Turn,
    /// Printable ASCII.
    pub text: String,
}

impl Text {
    /// Length of the line, mm.
    pub fn length_mm(&self) -> f64 {
        self.text.chars().count() as f64 * ADVANCE * self.em_mm
    }

    /// What it may cover.
    pub fn area(&self) -> Area {
        let [x, y] = self.at_mm;
        let (up, down) = (ASCENT * self.em_mm, DESCENT * self.em_mm);
        match self.turn {
            Turn::Level => Area {
                low_mm: [x, y - up],
                high_mm: [x + self.length_mm(), y + down],
            },
            Turn::Down => Area {
                low_mm: [x - down, y],
                high_mm: [x + up, y + self.length_mm()],
            },
        }
    }
}

/// A printable page.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    /// Width of the paper, mm.
    pub width_mm: f64,
    /// Height of the paper, mm.
    pub height_mm: f64,
    /// What the paper is called, `a4` or the like.
    pub paper: String,
    /// Name of the board, for titles.
    pub name: String,
    /// The board file that describes the print.
    pub yaml: String,
    /// The rings and the quiet zone around them; nothing else is in it.
    pub field: Area,
    /// Shapes, each drawn over those before it.
    pub shapes: Vec<Shape>,
    /// Dark texts; they cover no shape.
    pub texts: Vec<Text>,
}
