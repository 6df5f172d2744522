//! A sheet as PDF, written by hand: one page of vectors, the fonts that every reader has, nothing compressed, no date.
//!
//! The page's coordinates are millimetres from its lower left corner (PDF's y points up). A ring is drawn once, as a form of
//! its own, and placed at each centre, so that the numbers in the file are those of the centres. Circles are Bezier arcs; of
//! `n` arcs to a circle, each with ends on it and the usual handles of 4/3 tan(pi / 2n) radii, the curve is outside the circle by at
//! most 2/27 sin^6(pi / 2n) / cos^2(pi / 2n) radii: 2.7e-4 for the usual four, 4e-6 for eight.

use super::numbers::{decimal, mm};
use super::sheet::{Shape, Sheet, Text, Tone, Turn};
use std::f64::consts::{PI, TAU};
use std::fmt::Write;

/// Points of 1/72 inch in a millimetre.
const POINTS_PER_MM: f64 = 72.0 / 25.4;
/// How far a curve may be from its circle, mm.
const MOST_ERROR_MM: f64 = 1e-4;

/// The bytes of a PDF file. Its document information has the board's name as title and the board file as subject.
pub fn pdf(sheet: &Sheet) -> Vec<u8> {
    let content = content(sheet);
    let size = [sheet.width_mm, sheet.height_mm].map(|side| decimal(side * POINTS_PER_MM, 4));
    let mut objects = vec![
        // print dialogues of this preference start at 100 %
        "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>".to_owned(),
        "<< /Type /Pages /Kids [3 0 R] /Count 1 >>".to_owned(),
        format!(
            "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {} {}] /Contents 4 0 R /Resources << \
             /Font << /Regular 5 0 R /Bold 6 0 R >> /XObject << /Ring 7 0 R /Mark 8 0 R >> >> >>",
            size[0], size[1]
        ),
        stream("", &content),
        font("Courier"),
        font("Courier-Bold"),
    ];
    objects.extend(forms(sheet));
    objects.push(format!(
        "<< /Title {} /Subject {} /Creator (ringcal) >>",
        string(&sheet.name),
        string(&sheet.yaml)
    ));
    file(&objects)
}

fn font(name: &str) -> String {
    format!("<< /Type /Font /Subtype /Type1 /BaseFont /{name} /Encoding /WinAnsiEncoding >>")
}

fn stream(entries: &str, content: &str) -> String {
    let length = content.len();
    format!("<< {entries}/Length {length} >>\nstream\n{content}\nendstream")
}

/// The objects, numbered from 1, with the table of where each begins. The last one is the document information.
fn file(objects: &[String]) -> Vec<u8> {
    // the second line tells programs that move files that this one is not text
    let mut out = b"%PDF-1.7\n%\xe2\xe3\xcf\xd3\n".to_vec();
    let mut table = format!("xref\n0 {}\n0000000000 65535 f \n", objects.len() + 1);
    for (at, object) in objects.iter().enumerate() {
        // a table's line is 20 bytes long
        table += &format!("{:010} 00000 n \n", out.len());
        out.extend_from_slice(format!("{} 0 obj\n{object}\nendobj\n", at + 1).as_bytes());
    }
    let start = out.len();
    let (size, info) = (objects.len() + 1, objects.len());
    let trailer = format!(
        "{table}trailer\n<< /Size {size} /Root 1 0 R /Info {info} 0 R >>\nstartxref\n{start}\n%%EOF\n"
    );
    out.extend_from_slice(trailer.as_bytes());
    out
}

/// A ring and a mark about the origin.
fn forms(sheet: &Sheet) -> [String; 2] {
    let radii = sheet.shapes.iter().find_map(|shape| match *shape {
        Shape::Ring {
            outer_mm,
            inner_mm: Some(inner_mm),
            ..
        } => Some((outer_mm, inner_mm)),
        _ => None,
    });
    let (outer_mm, inner_mm) = radii.unwrap_or_default();
    let form = |path: String| {
        let side = mm(outer_mm + 2.0 * MOST_ERROR_MM);
        let entries =
            format!("/Type /XObject /Subtype /Form /BBox [-{side} -{side} {side} {side}] ");
        // even-odd: what is inside both circles is outside
        stream(&entries, &format!("{path}f*"))
    };
    [
        form(circle(outer_mm) + &circle(inner_mm)),
        form(circle(outer_mm)),
    ]
}

/// How many arcs keep a circle within the error.
fn arcs(radius_mm: f64) -> u32 {
    let error = |n: u32| {
        let (sin, cos) = (0.5 * PI / f64::from(n)).sin_cos();
        2.0 / 27.0 * sin.powi(6) / (cos * cos) * radius_mm
    };
    [8, 16, 32]
        .into_iter()
        .find(|&n| error(n) <= MOST_ERROR_MM)
        .unwrap_or(64)
}

fn circle(radius_mm: f64) -> String {
    let n = arcs(radius_mm);
    let step = TAU / f64::from(n);
    let handle = 4.0 / 3.0 * (0.25 * step).tan();
    let at = |angle: f64, along: f64| {
        let (sin, cos) = angle.sin_cos();
        let (x, y) = (cos - along * sin, sin + along * cos);
        format!("{} {}", mm(radius_mm * x), mm(radius_mm * y))
    };
    let mut out = format!("{} m\n", at(0.0, 0.0));
    for arc in 0..n {
        let (from, to) = (f64::from(arc) * step, f64::from(arc + 1) * step);
        let (a, b, end) = (at(from, handle), at(to, -handle), at(to, 0.0));
        // writing to a String cannot fail
        let _ = writeln!(out, "{a} {b} {end} c");
    }
    out + "h\n"
}

fn content(sheet: &Sheet) -> String {
    let scale = decimal(POINTS_PER_MM, 10);
    let up = |y: f64| mm(sheet.height_mm - y);
    let mut out = format!("{scale} 0 0 {scale} 0 0 cm\n");
    for shape in &sheet.shapes {
        out += &match *shape {
            Shape::Rectangle { area, tone } => format!(
                "{} g {} {} {} {} re f\n",
                grey(tone),
                mm(area.low_mm[0]),
                up(area.high_mm[1]),
                mm(area.width_mm()),
                mm(area.height_mm())
            ),
            Shape::Triangle { corners_mm } => {
                let [a, b, c] = corners_mm.map(|[x, y]| format!("{} {}", mm(x), up(y)));
                format!("0 g {a} m {b} l {c} l h f\n")
            }
            Shape::Ring {
                centre_mm: [x, y],
                inner_mm,
                tone,
                ..
            } => {
                let form = inner_mm.map_or("Mark", |_| "Ring");
                format!(
                    "q {} g 1 0 0 1 {} {} cm /{form} Do Q\n",
                    grey(tone),
                    mm(x),
                    up(y)
                )
            }
        };
    }
    out += "0 g BT\n";
    for text in &sheet.texts {
        out += &words(text, up(text.at_mm[1]));
    }
    out + "ET"
}

fn grey(tone: Tone) -> u8 {
    match tone {
        Tone::Dark => 0,
        Tone::Light => 1,
    }
}

fn words(text: &Text, y: String) -> String {
    let font = if text.bold { "Bold" } else { "Regular" };
    let turn = match text.turn {
        Turn::Level => "1 0 0 1",
        Turn::Down => "0 -1 1 0",
    };
    let (em, x, words) = (mm(text.em_mm), mm(text.at_mm[0]), string(&text.text));
    format!("/{font} {em} Tf {turn} {x} {y} Tm {words} Tj\n")
}

/// A string of PDF: in brackets where it is ASCII, else UTF-16 in hexadecimal digits, as titles may be.
fn string(text: &str) -> String {
    let plain = |c: char| matches!(c, ' '..='~' | '\n');
    if text.chars().all(plain) {
        let mut out = String::from("(");
        for c in text.chars() {
            match c {
                '(' | ')' | '\\' => out.extend(['\\', c]),
                '\n' => out += "\\n",
                c => out.push(c),
            }
        }
        return out + ")";
    }
    let units = text.encode_utf16().map(|unit| format!("{unit:04X}"));
    format!("<FEFF{}>", units.collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_keep_to_their_circles() {
        for radius_mm in [0.5, 6.0, 23.0, 100.0, 2000.0] {
            let path = circle(radius_mm);
            let numbers = |line: &str| -> Vec<f64> {
                let words = line.split(' ').filter_map(|word| word.parse().ok());
                words.collect()
            };
            let mut from = numbers(path.lines().next().unwrap());
            for line in path.lines().filter(|line| line.ends_with('c')) {
                let p = numbers(line);
                for k in 0..=20 {
                    let t = f64::from(k) / 20.0;
                    let u = 1.0 - t;
                    let at = |i: usize| {
                        u * u * u * from[i]
                            + 3.0 * u * u * t * p[i]
                            + 3.0 * u * t * t * p[2 + i]
                            + t * t * t * p[4 + i]
                    };
                    let off = at(0).hypot(at(1)) - radius_mm;
                    assert!(off.abs() < 2.0 * MOST_ERROR_MM, "{radius_mm} mm: {off}");
                }
                from = p[4..].to_vec();
            }
        }
    }

    #[test]
    fn strings_are_escaped() {
        assert_eq!(string("a (b) \\\n"), "(a \\(b\\) \\\\\\n)");
        assert_eq!(string("\u{e9}"), "<FEFF00E9>");
    }
}
