//! A sheet as PNG: grey values are the exact part of each pixel that is ink, whatever the resolution.
//!
//! The file says how many pixels a metre has, which is a whole number; the picture is drawn at exactly that many, not at the dpi that
//! were asked for. Where the paper does not end with a pixel, the last one reaches beyond it.

use super::coverage::{disc, span, triangle};
use super::error::PrintError;
use super::glyphs::Glyphs;
use super::sheet::{Shape, Sheet, Tone};
use png::{BitDepth, ColorType, Compression, Encoder, PixelDimensions, Unit};
use std::io::Write;
use std::ops::Range;

/// The most pixels of a picture.
const MOST_PIXELS: u64 = 400_000_000;
/// Rows that are looked at together for what is in them.
const BAND: u32 = 64;

/// The bytes of a PNG file of about so many pixels an inch, 8-bit grey; the board file stands in its `Description`.
///
/// # Errors
/// [`PrintError`] where it would be too large, or too coarse to show the rings.
pub fn png(sheet: &Sheet, dpi: f64) -> Result<Vec<u8>, PrintError> {
    let per_metre = (dpi / 0.0254).round();
    let scale = 1e-3 * per_metre;
    let size = [sheet.width_mm, sheet.height_mm].map(|side| (side * scale - 1e-6).ceil());
    let [width, height] = size.map(|pixels| pixels as u64);
    if width.saturating_mul(height) > MOST_PIXELS {
        return Err(PrintError::Pixels {
            dpi,
            sheet_mm: [sheet.width_mm, sheet.height_mm],
            width,
            height,
            most: MOST_PIXELS,
        });
    }
    refuse_coarse(sheet, dpi)?;
    // 400 million pixels are at most 8 million in a row: a page is 20 mm at least
    let (width, height) = (width as u32, height as u32);
    encode(sheet, scale, per_metre as u32, width, height)
        .map_err(|e| PrintError::Encoding(e.to_string()))
}

/// A pixel as wide as a ring shows none.
fn refuse_coarse(sheet: &Sheet, dpi: f64) -> Result<(), PrintError> {
    let narrowest = sheet.shapes.iter().filter_map(|shape| match *shape {
        Shape::Ring {
            outer_mm, inner_mm, ..
        } => Some(inner_mm.map_or(outer_mm, |inner| (outer_mm - inner).min(2.0 * inner))),
        _ => None,
    });
    let width_mm = narrowest.fold(f64::INFINITY, f64::min);
    if dpi * width_mm >= 25.4 {
        Ok(())
    } else {
        Err(PrintError::TooCoarse { dpi, width_mm })
    }
}

fn encode(
    sheet: &Sheet,
    scale: f64,
    per_metre: u32,
    width: u32,
    height: u32,
) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height);
    encoder.set_color(ColorType::Grayscale);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Fast);
    encoder.set_pixel_dims(Some(PixelDimensions {
        xppu: per_metre,
        yppu: per_metre,
        unit: Unit::Meter,
    }));
    encoder.add_itxt_chunk("Title".to_owned(), sheet.name.clone())?;
    encoder.add_itxt_chunk("Description".to_owned(), sheet.yaml.clone())?;
    let mut writer = encoder.write_header()?;
    let mut stream = writer.stream_writer()?;
    let items = items(sheet, scale);
    let mut light = vec![1.0; width as usize];
    let mut row = vec![0; width as usize];
    for top in (0..height).step_by(BAND as usize) {
        let band = top..height.min(top + BAND);
        let here: Vec<_> = items.iter().filter(|item| item.meets(&band)).collect();
        for y in band {
            light.fill(1.0);
            here.iter()
                .for_each(|item| item.paint(y, scale, &mut light));
            for (grey, light) in row.iter_mut().zip(&light) {
                *grey = (255.0 * light).round() as u8;
            }
            stream.write_all(&row)?;
        }
    }
    stream.finish()?;
    writer.finish()?;
    Ok(bytes)
}

/// Something on the sheet, and the pixels it may touch.
struct Item<'a> {
    columns: Range<usize>,
    rows: Range<u32>,
    /// 0 for ink, 1 for paper.
    light: f64,
    kind: Kind<'a>,
}

/// Shapes in pixels.
enum Kind<'a> {
    Rectangle {
        low: [f64; 2],
        high: [f64; 2],
    },
    Triangle([[f64; 2]; 3]),
    Ring {
        centre: [f64; 2],
        outer: f64,
        inner: Option<f64>,
    },
    Letters(Glyphs<'a>),
}

/// Everything in the order in which it is drawn.
fn items(sheet: &Sheet, scale: f64) -> Vec<Item<'_>> {
    let px = |mm: [f64; 2]| mm.map(|v| v * scale);
    let item = |area: super::sheet::Area, light, kind| {
        let (low, high) = (px(area.low_mm), px(area.high_mm));
        // negative and huge numbers end at the limits of the type
        Item {
            columns: low[0].floor() as usize..high[0].ceil() as usize,
            rows: low[1].floor() as u32..high[1].ceil() as u32,
            light,
            kind,
        }
    };
    let shape = |shape: &Shape| {
        let (tone, kind) = match *shape {
            Shape::Rectangle { area, tone } => (
                tone,
                Kind::Rectangle {
                    low: px(area.low_mm),
                    high: px(area.high_mm),
                },
            ),
            Shape::Triangle { corners_mm } => (Tone::Dark, Kind::Triangle(corners_mm.map(px))),
            Shape::Ring {
                centre_mm,
                outer_mm,
                inner_mm,
                tone,
            } => (
                tone,
                Kind::Ring {
                    centre: px(centre_mm),
                    outer: outer_mm * scale,
                    inner: inner_mm.map(|inner| inner * scale),
                },
            ),
        };
        let light = if tone == Tone::Light { 1.0 } else { 0.0 };
        item(shape.area(), light, kind)
    };
    let letters = sheet
        .texts
        .iter()
        .map(|text| item(text.area(), 0.0, Kind::Letters(Glyphs::new(text))));
    sheet.shapes.iter().map(shape).chain(letters).collect()
}

impl Item<'_> {
    fn meets(&self, rows: &Range<u32>) -> bool {
        self.rows.start < rows.end && rows.start < self.rows.end
    }

    /// Puts it over what is in row `y` so far.
    fn paint(&self, y: u32, scale: f64, row: &mut [f64]) {
        if !self.rows.contains(&y) {
            return;
        }
        let columns = self.columns.start.min(row.len())..self.columns.end.min(row.len());
        for x in columns {
            let covered = self.covered(x as f64, f64::from(y), scale);
            row[x] += covered * (self.light - row[x]);
        }
    }

    fn covered(&self, x: f64, y: f64, scale: f64) -> f64 {
        match &self.kind {
            Kind::Rectangle { low, high } => span(x, low[0], high[0]) * span(y, low[1], high[1]),
            Kind::Triangle(corners) => triangle(x, y, corners),
            Kind::Ring {
                centre,
                outer,
                inner,
            } => {
                let within = |radius| disc(x - centre[0], y - centre[1], radius);
                within(*outer) - inner.map_or(0.0, within)
            }
            Kind::Letters(glyphs) => {
                let middle = [(x + 0.5) / scale, (y + 0.5) / scale];
                glyphs.ink(middle, 1.0 / scale)
            }
        }
    }
}
