//! A sheet as SVG: a millimetre is a unit, and the page is as large as the paper.

use super::numbers::mm;
use super::sheet::{Area, Shape, Sheet, Text, Tone, Turn};
use std::fmt::Write;

/// The text of an SVG file. Every ring is a `<circle>` whose stroke is the ring; the board file stands in `<metadata>`.
pub fn svg(sheet: &Sheet) -> String {
    let (width, height) = (mm(sheet.width_mm), mm(sheet.height_mm));
    let mut out = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}mm\" height=\"{height}mm\" viewBox=\"0 0 {width} {height}\">\n\
         <title>{}</title>\n\
         <metadata id=\"ringcal-board\">\n{}</metadata>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n",
        escaped(&sheet.name),
        escaped(&sheet.yaml),
    );
    for shape in &sheet.shapes {
        draw_shape(&mut out, shape);
    }
    out += "<g font-family=\"'Noto Sans Mono','DejaVu Sans Mono','Liberation Mono','Courier New',monospace\">\n";
    for text in &sheet.texts {
        draw_text(&mut out, text);
    }
    out + "</g>\n</svg>\n"
}

fn colour(tone: Tone) -> &'static str {
    match tone {
        Tone::Dark => "black",
        Tone::Light => "white",
    }
}

fn draw_shape(out: &mut String, shape: &Shape) {
    let line = match *shape {
        Shape::Rectangle { area, tone } => rectangle(&area, tone),
        Shape::Triangle { corners_mm } => {
            let corners = corners_mm.map(|[x, y]| format!("{},{}", mm(x), mm(y)));
            format!("<polygon points=\"{}\"/>", corners.join(" "))
        }
        Shape::Ring {
            centre_mm: [x, y],
            outer_mm,
            inner_mm,
            tone,
        } => ring(x, y, outer_mm, inner_mm, colour(tone)),
    };
    out.push_str(&line);
    out.push('\n');
}

fn rectangle(area: &Area, tone: Tone) -> String {
    let [x, y] = area.low_mm.map(mm);
    let (width, height) = (mm(area.width_mm()), mm(area.height_mm()));
    let colour = colour(tone);
    format!("<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" fill=\"{colour}\"/>")
}

/// A ring is the stroke of the circle in its middle: both of its edges are true circles.
fn ring(x: f64, y: f64, outer_mm: f64, inner_mm: Option<f64>, colour: &str) -> String {
    let centre = format!("cx=\"{}\" cy=\"{}\"", mm(x), mm(y));
    match inner_mm {
        Some(inner_mm) => {
            let (radius, width) = (mm(0.5 * (inner_mm + outer_mm)), mm(outer_mm - inner_mm));
            format!(
                "<circle {centre} r=\"{radius}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"/>"
            )
        }
        None => format!(
            "<circle {centre} r=\"{}\" fill=\"{colour}\"/>",
            mm(outer_mm)
        ),
    }
}

/// Whatever font is there, the text keeps its length.
fn draw_text(out: &mut String, text: &Text) {
    let [x, y] = text.at_mm.map(mm);
    let weight = if text.bold {
        " font-weight=\"bold\""
    } else {
        ""
    };
    let turn = match text.turn {
        Turn::Level => String::new(),
        Turn::Down => format!(" transform=\"rotate(90 {x} {y})\""),
    };
    let (em, length) = (mm(text.em_mm), mm(text.length_mm()));
    let words = escaped(&text.text);
    // writing to a String cannot fail
    let _ = writeln!(
        out,
        "<text x=\"{x}\" y=\"{y}\" font-size=\"{em}\" textLength=\"{length}\" \
         lengthAdjust=\"spacingAndGlyphs\"{weight}{turn}>{words}</text>"
    );
}

/// Text for XML, without the control characters that XML does not allow.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\n' => out.push('\n'),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('?'),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn xml_has_its_own_way_with_some_characters() {
        assert_eq!(escaped("a<b & \"c\"\u{7}"), "a&lt;b &amp; &quot;c&quot;?");
    }
}
