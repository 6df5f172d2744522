//! Small text on a picture, in the Noto Sans Mono that the font crate brings as bitmaps.

use super::canvas::Canvas;
use image::Rgb;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// Height of a line of text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Size {
    /// 16 px.
    Small,
    /// 24 px.
    Large,
}

impl Size {
    fn raster(self) -> RasterHeight {
        match self {
            Self::Small => RasterHeight::Size16,
            Self::Large => RasterHeight::Size24,
        }
    }

    /// Height of a line, px.
    pub fn line_px(self) -> i64 {
        self.raster().val() as i64
    }

    /// Width of every character, px.
    pub fn character_px(self) -> i64 {
        get_raster_width(FontWeight::Regular, self.raster()) as i64
    }
}

/// Draws one line of text with its top-left corner at (x, y), outlined in black so that it can be read on anything.
/// Characters outside ASCII are shown as `?`.
pub(super) fn draw(canvas: &mut Canvas, x: i64, y: i64, text: &str, size: Size, colour: Rgb<u8>) {
    let starts = (0..).map(|k| x + k * size.character_px());
    for (character, x) in text.chars().zip(starts) {
        draw_character(canvas, x, y, character, size, colour);
    }
}

fn draw_character(
    canvas: &mut Canvas,
    x: i64,
    y: i64,
    character: char,
    size: Size,
    colour: Rgb<u8>,
) {
    let glyph = |character| get_raster(character, FontWeight::Regular, size.raster());
    let Some(glyph) = glyph(character).or_else(|| glyph('?')) else {
        return;
    };
    let ink = |column: i64, row: i64| -> f64 {
        let (Ok(column), Ok(row)) = (usize::try_from(column), usize::try_from(row)) else {
            return 0.0;
        };
        let ink = glyph.pixel(column, row).unwrap_or(0);
        f64::from(ink) / 255.0
    };
    for row in -1..=size.line_px() {
        for column in -1..=size.character_px() {
            let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
            let outline = around
                .map(|(dx, dy)| ink(column + dx, row + dy))
                .fold(0.0, f64::max);
            if outline > 0.0 {
                canvas.blend(x + column, y + row, Rgb([0, 0, 0]), 0.7 * outline);
                canvas.blend(x + column, y + row, colour, ink(column, row));
            }
        }
    }
}

/// Breaks text into lines of at most `columns` characters, between words where it can.
pub(crate) fn wrap(text: &str, columns: usize) -> Vec<String> {
    let columns = columns.max(1);
    let mut lines = vec![String::new()];
    let mut used = 0;
    for word in text.split_whitespace() {
        let length = word.chars().count();
        if used > 0 && used + 1 + length > columns {
            lines.push(String::new());
            used = 0;
        } else if used > 0 {
            push(&mut lines, ' ');
            used += 1;
        }
        for character in word.chars() {
            if used == columns {
                lines.push(String::new());
                used = 0;
            }
            push(&mut lines, character);
            used += 1;
        }
    }
    lines
}

fn push(lines: &mut [String], character: char) {
    if let Some(line) = lines.last_mut() {
        line.push(character);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::RgbImage;

    fn lit(text: &str) -> usize {
        let mut canvas = Canvas::new(RgbImage::new(80, 20));
        draw(&mut canvas, 2, 2, text, Size::Small, Rgb([255, 255, 255]));
        canvas
            .into_picture()
            .pixels()
            .filter(|p| p.0[0] > 128)
            .count()
    }

    #[test]
    fn characters_leave_ink_and_spaces_do_not() {
        assert_eq!(lit("   "), 0);
        assert!(lit("8") > lit("1") && lit("1") > 5);
        assert_eq!(lit("\u{4e2d}"), lit("?"));
        assert_eq!(lit("0,0"), 2 * lit("0") + lit(","));
    }

    #[test]
    fn text_is_broken_between_words_and_within_long_ones() {
        assert_eq!(
            wrap("too few rings: 3 of 49", 9),
            ["too few", "rings: 3", "of 49"]
        );
        assert_eq!(wrap("abcdefg", 3), ["abc", "def", "g"]);
        assert_eq!(wrap("exact fit", 9), ["exact fit"]);
        assert_eq!(wrap("", 0), [""]);
    }
}
