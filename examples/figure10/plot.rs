//! The figure: error over k on a logarithmic scale, one panel for each ring size.

use crate::table::{KS, PAPER, Table};
use ringcal::centre::Estimator;
use std::fmt::Write;

const PANEL: (f64, f64) = (430.0, 380.0);
const LEFT: f64 = 62.0;
const TOP: f64 = 44.0;
const PITCH: f64 = 600.0;
/// Bounds of the error, powers of ten.
const DECADES: (f64, f64) = (-3.0, 1.0);

fn colour(estimator: Estimator) -> &'static str {
    match estimator {
        Estimator::BigEllipse => "#8c564b",
        Estimator::SmallEllipse => "#9467bd",
        Estimator::OneSided => "#e68a00",
        Estimator::Cross => "#1f77b4",
        Estimator::PolePolar => "#17a2b8",
        Estimator::Photometric => "#c00000",
    }
}

fn x(k: f64) -> f64 {
    LEFT + PANEL.0 * (k - 3.0) / 39.0
}

fn y(error_px: f64) -> f64 {
    let (low, high) = DECADES;
    let part = (error_px.log10().clamp(low, high) - low) / (high - low);
    TOP + PANEL.1 * (1.0 - part)
}

/// The figure as SVG, on white so that it reads on any page.
pub fn draw(panels: &[(String, Table)]) -> String {
    let width = PITCH * panels.len() as f64;
    let height = TOP + PANEL.1 + 58.0;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    for (i, (title, table)) in panels.iter().enumerate() {
        let _ = writeln!(out, "<g transform=\"translate({} 0)\">", PITCH * i as f64);
        panel(&mut out, title, table);
        out.push_str("</g>\n");
    }
    out.push_str("</svg>\n");
    out
}

fn panel(out: &mut String, title: &str, table: &Table) {
    let (bottom, right) = (TOP + PANEL.1, LEFT + PANEL.0);
    let _ = writeln!(
        out,
        "<text x=\"{LEFT}\" y=\"24\" font-size=\"15\">{title}</text>"
    );
    for decade in DECADES.0 as i32..=DECADES.1 as i32 {
        let at = y(10f64.powi(decade));
        let _ = writeln!(
            out,
            "<path d=\"M{LEFT} {at:.1}H{right}\" stroke=\"#ddd\"/><text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            LEFT - 6.0,
            at + 4.0,
            10f64.powi(decade)
        );
    }
    for k in KS {
        let _ = writeln!(
            out,
            "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{k}</text>",
            x(k),
            bottom + 18.0
        );
    }
    let _ = writeln!(
        out,
        "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">blur k = sigma, px</text>\
         <text transform=\"translate(16 {:.1}) rotate(-90)\" text-anchor=\"middle\">error of the centre, px (rms)</text>\
         <rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#888\"/>",
        LEFT + 0.5 * PANEL.0,
        bottom + 42.0,
        TOP + 0.5 * PANEL.1,
        PANEL.0,
        PANEL.1
    );
    let bounds: Vec<(f64, f64)> = table
        .rows
        .iter()
        .filter_map(|row| Some((row.k, row.bound_px?)))
        .collect();
    line(out, &bounds, "#444", "stroke-dasharray=\"5 4\"");
    let mut labels = vec![(bounds.last().copied(), "bound".to_owned(), "#444")];
    for (i, estimator) in Estimator::ALL.into_iter().enumerate() {
        let points: Vec<(f64, f64)> = table
            .rows
            .iter()
            .filter_map(|row| Some((row.k, row.plain[i].rmse_px()?)))
            .collect();
        line(out, &points, colour(estimator), "");
        labels.push((
            points.last().copied(),
            estimator.name().to_owned(),
            colour(estimator),
        ));
    }
    for (estimator, k, error_px) in PAPER {
        let (cx, cy) = (x(k), y(error_px));
        let _ = writeln!(
            out,
            "<path d=\"M{:.1} {cy:.1}l5 -5l5 5l-5 5z\" fill=\"white\" stroke=\"{}\" stroke-width=\"1.6\"/>",
            cx - 5.0,
            colour(estimator)
        );
    }
    label(out, labels);
    let _ = writeln!(
        out,
        "<text x=\"{}\" y=\"{}\" fill=\"#444\">diamonds: the paper's own figures</text>",
        LEFT + 10.0,
        TOP + 18.0
    );
}

fn line(out: &mut String, points: &[(f64, f64)], colour: &str, style: &str) {
    let path: Vec<String> = points
        .iter()
        .map(|&(k, e)| format!("{:.1},{:.1}", x(k), y(e)))
        .collect();
    let _ = writeln!(
        out,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\" {style}/>",
        path.join(" ")
    );
}

/// A line's last point (k and error, px), its name and its colour.
type LineEnd<'a> = (Option<(f64, f64)>, String, &'a str);

/// Names at the right of the lines' ends, pushed apart where they would overlap.
fn label(out: &mut String, labels: Vec<LineEnd>) {
    let mut placed: Vec<(f64, f64, String, &str)> = labels
        .into_iter()
        .filter_map(|(end, name, colour)| {
            let (k, error_px) = end?;
            let name = if k < 40.0 {
                format!("{name} (to k = {k})")
            } else {
                name
            };
            Some((y(error_px), y(error_px), name, colour))
        })
        .collect();
    placed.sort_by(|a, b| a.0.total_cmp(&b.0));
    for i in 1..placed.len() {
        placed[i].0 = placed[i].0.max(placed[i - 1].0 + 16.0);
    }
    for (at, _, name, colour) in placed {
        let _ = writeln!(
            out,
            "<text x=\"{}\" y=\"{:.1}\" fill=\"{colour}\">{name}</text>",
            LEFT + PANEL.0 + 8.0,
            at + 4.0
        );
    }
}
