//! The sheet of an arrangement: rings, rulers, texts.

use super::layout::{Arrangement, GAP_MM, LEGEND_GAP_MM, Plan, RULER_MM, Side};
use super::legend::Line;
use super::ruler::{Ruler, overhang_mm, ruler_scale};
use super::sheet::{Area, Shape, Sheet, Text, Tone, Turn};
use crate::board::Polarity;

impl Plan<'_> {
    /// Everything in its place.
    pub(super) fn sheet(&self, arrangement: &Arrangement, paper: &str) -> Sheet {
        let field = Area::at(arrangement.field_mm, self.field_mm[0], self.field_mm[1]);
        let rulers = self.rulers(arrangement);
        let mut shapes = self.rings(&field);
        let band = self.band_mm();
        let tip = field.low_mm.map(|v| v - GAP_MM);
        let size = 0.9 * (band - GAP_MM);
        shapes.push(Shape::Triangle {
            corners_mm: [tip, [tip[0] - size, tip[1]], [tip[0], tip[1] - size]],
        });
        let mut texts = self.top_texts(arrangement, &rulers);
        for ruler in rulers.iter().filter(|ruler| ruler.length_mm >= 10.0) {
            shapes.extend(ruler.ticks());
            texts.extend(ruler.numbers());
        }
        texts.extend(legend_texts(arrangement, &field));
        Sheet {
            width_mm: arrangement.page_mm[0],
            height_mm: arrangement.page_mm[1],
            paper: paper.to_owned(),
            name: self.options.name.clone(),
            yaml: self.board.to_yaml(),
            field,
            shapes,
            texts,
        }
    }

    /// The ground, where it is dark, and the rings on it, row by row.
    fn rings(&self, field: &Area) -> Vec<Shape> {
        let (tone, ground) = match self.board.polarity() {
            Polarity::LightOnDark => (Tone::Light, Some(Tone::Dark)),
            Polarity::DarkOnLight | Polarity::Auto => (Tone::Dark, None),
        };
        let first = self.first_mm(field.low_mm);
        let ground = ground.map(|tone| Shape::Rectangle { area: *field, tone });
        let ring = |(row, column)| {
            let [x, y] = self.board.centre_m(row, column);
            let whole = !self.board.is_mark(row, column);
            Shape::Ring {
                centre_mm: [first[0] + 1e3 * x, first[1] + 1e3 * y],
                outer_mm: 1e3 * self.board.outer_radius_m(),
                inner_mm: whole.then_some(1e3 * self.board.inner_radius_m()),
                tone,
            }
        };
        ground
            .into_iter()
            .chain(self.board.indices().map(ring))
            .collect()
    }

    /// Centre of ring (0, 0) in a field that begins here.
    pub(super) fn first_mm(&self, low_mm: [f64; 2]) -> [f64; 2] {
        low_mm.map(|v| v + self.quiet_mm + 1e3 * self.board.outer_radius_m())
    }

    /// Rulers above the field and left of it: from ring (0, 0) to the last one, and over 100 mm where the page has them.
    fn rulers(&self, arrangement: &Arrangement) -> [Ruler; 2] {
        let low = arrangement.field_mm;
        let first = self.first_mm(low);
        let tens = |length: f64| ((length + 1e-6) / 10.0).floor() * 10.0;
        let ruler = |axis: usize, turn| {
            let end = arrangement.page_mm[axis] - self.options.margin_mm - overhang_mm(self.scale);
            let wanted = tens(2e3 * self.board.middle_m()[axis] + 9.999).max(RULER_MM);
            let zero = first[axis].min((end - RULER_MM).max(low[axis] + 1.0));
            let mut zero_mm = low.map(|v| v - GAP_MM);
            zero_mm[axis] = zero;
            Ruler {
                zero_mm,
                length_mm: tens(wanted.min(end - zero)).max(0.0),
                turn,
                scale: ruler_scale(self.scale),
            }
        };
        [ruler(0, Turn::Level), ruler(1, Turn::Down)]
    }

    fn top_texts(&self, arrangement: &Arrangement, rulers: &[Ruler; 2]) -> Vec<Text> {
        let band = self.band_mm();
        let [left, upper] = arrangement.field_mm;
        let left = left - band;
        let length = arrangement.page_mm[0] - self.options.margin_mm - left;
        let ruler_mm = rulers.iter().map(|r| r.length_mm).fold(RULER_MM, f64::min);
        let (mut lines, one_line) = self.top(ruler_mm, length);
        if ruler_mm < 10.0 {
            // there is no ruler to speak of
            lines.retain(|line| line.bold);
        }
        let mut below = upper - band;
        let mut texts = Vec::new();
        // from the corner's name upwards
        while let Some(line) = lines.pop() {
            let beside = one_line && !line.bold;
            let x = match beside {
                true => left + Line::corner(self.scale).length_mm() + line.em_mm,
                false => left,
            };
            if !beside {
                below -= line.height_mm();
            }
            texts.push(line.placed([x, below], Turn::Level));
        }
        texts
    }
}

fn legend_texts(arrangement: &Arrangement, field: &Area) -> Vec<Text> {
    let below = arrangement.side == Side::Below;
    let mut at = match below {
        true => [field.low_mm[0], field.high_mm[1] + LEGEND_GAP_MM],
        false => [
            field.high_mm[0] + LEGEND_GAP_MM + arrangement.legend_mm,
            field.low_mm[1],
        ],
    };
    let place = |line: &Line| {
        let height = line.height_mm();
        let turn = if below { Turn::Level } else { Turn::Down };
        let text = line.clone().placed(at, turn);
        match below {
            true => at[1] += height,
            false => at[0] -= height,
        }
        text
    };
    arrangement.legend.iter().map(place).collect()
}
