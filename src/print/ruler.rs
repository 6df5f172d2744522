//! A ruler, to see with another one whether the print has kept its scale.

use super::numbers::mm;
use super::sheet::{ADVANCE, Area, DESCENT, Shape, Text, Tone, Turn};

/// Lengths of the marks on an A4 sheet, mm: every millimetre, every fifth, every tenth.
const TICKS_MM: [f64; 3] = [1.1, 1.6, 4.0];
const TICK_WIDTH_MM: f64 = 0.2;
/// Size of the digits, and how far above the ruler's foot they stand.
const EM_MM: f64 = 2.2;
const FOOT_MM: f64 = 1.65 + DESCENT * EM_MM;
/// Between a mark and the number beside it.
const GAP_MM: f64 = 0.4;
/// Numbers of four digits still stand between two marks at this size.
const MOST_SCALE: f64 = 1.4;

/// A ruler along one side of the field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ruler {
    /// Its 0, on the side of the field, mm.
    pub(super) zero_mm: [f64; 2],
    /// How far it counts, in whole centimetres, mm.
    pub(super) length_mm: f64,
    /// Level: above the field, counting to the right. Down: left of it, counting downwards.
    pub(super) turn: Turn,
    /// Size of marks and digits.
    pub(super) scale: f64,
}

/// The size of a ruler's parts on a sheet whose texts are so much larger than on A4.
pub(super) fn ruler_scale(scale: f64) -> f64 {
    scale.min(MOST_SCALE)
}

/// Depth of a ruler from the field outwards, mm.
pub(super) fn depth_mm(scale: f64) -> f64 {
    TICKS_MM[2] * ruler_scale(scale)
}

/// How far a ruler reaches beyond its last number, mm.
pub(super) fn overhang_mm(scale: f64) -> f64 {
    ruler_scale(scale) * (GAP_MM + TICK_WIDTH_MM + 4.0 * ADVANCE * EM_MM)
}

impl Ruler {
    /// The marks.
    pub(super) fn ticks(&self) -> impl Iterator<Item = Shape> {
        let ruler = *self;
        // a whole number of millimetres, at most a page long
        (0..=self.length_mm.round() as u32).map(move |at_mm| {
            let kind = match at_mm {
                at if at % 10 == 0 => 2,
                at if at % 5 == 0 => 1,
                _ => 0,
            };
            let half = 0.5 * TICK_WIDTH_MM * ruler.scale;
            let along = f64::from(at_mm);
            ruler.bar([along - half, along + half], TICKS_MM[kind] * ruler.scale)
        })
    }

    fn bar(&self, along: [f64; 2], depth: f64) -> Shape {
        let [x, y] = self.zero_mm;
        let area = match self.turn {
            Turn::Level => Area {
                low_mm: [x + along[0], y - depth],
                high_mm: [x + along[1], y],
            },
            Turn::Down => Area {
                low_mm: [x - depth, y + along[0]],
                high_mm: [x, y + along[1]],
            },
        };
        Shape::Rectangle {
            area,
            tone: Tone::Dark,
        }
    }

    /// The numbers, one beside every tenth mark.
    pub(super) fn numbers(&self) -> impl Iterator<Item = Text> {
        let ruler = *self;
        (0..=self.length_mm.round() as u32)
            .step_by(10)
            .map(move |at_mm| {
                let s = ruler.scale;
                let along = f64::from(at_mm) + (0.5 * TICK_WIDTH_MM + GAP_MM) * s;
                let [x, y] = ruler.zero_mm;
                let start = match ruler.turn {
                    Turn::Level => [x + along, y - FOOT_MM * s],
                    // digits stand on the far side of the short marks, their heads towards the field
                    Turn::Down => [x - (TICKS_MM[2] - DESCENT * EM_MM) * s, y + along],
                };
                Text {
                    at_mm: start,
                    em_mm: EM_MM * s,
                    bold: false,
                    turn: ruler.turn,
                    text: mm(f64::from(at_mm)),
                }
            })
    }
}
