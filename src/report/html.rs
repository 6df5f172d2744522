//! report.html: a calibration, or why there is none, on one page that needs nothing but itself.
//!
//! The verdict comes first, then what it rests on. There is no script, no link and no clock: the page works from a disk, prints,
//! follows the reader's choice of light or dark, and is the same for the same calibration.

use super::escape::escaped;
use super::figures::{self, Figure};
use super::{Pictures, tables, thumbnails, verdict};
use crate::board::Board;
use crate::calibrate::{Assessment, Calibration, CrossValidation, Range};
use crate::formats::Outcome;
use crate::session::View;

const STYLE: &str = include_str!("style.css");
/// Keeps a browser from fetching anything, whatever finds its way into the page.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:";
/// The hatching of what was not seen; one for all figures, because an id must be unique.
const HATCH: &str = "<svg class=\"defs\" aria-hidden=\"true\"><defs><pattern id=\"hatch\" width=\"8\" height=\"8\" \
     patternUnits=\"userSpaceOnUse\" patternTransform=\"rotate(45)\"><line class=\"hatching\" x1=\"0\" y1=\"0\" x2=\"0\" \
     y2=\"8\"/></pattern></defs></svg>\n";

/// What the page is made of.
#[derive(Debug)]
pub struct Report<'a> {
    /// Name of the camera.
    pub camera_name: &'a str,
    /// What measured the centres.
    pub estimator: &'a str,
    /// The board that was looked for.
    pub board: &'a Board,
    /// Frames that were read.
    pub inputs: u64,
    /// The views that the calibration was tried from.
    pub views: &'a [View],
    /// Every image file and every view of the bags.
    pub outcomes: &'a [Outcome],
    /// Frames of bags that became no views: how many, and why.
    pub passed_over: &'a [(u64, String)],
    /// Small pictures of frames, by their source; of views, and of some files that are none.
    pub pictures: &'a Pictures,
    /// What the calibration is worth, or why there is none.
    pub assessment: &'a Assessment,
    /// The calibration, where there is one.
    pub solved: Option<Solved<'a>>,
}

/// A calibration and its cross-validation, if it has one.
#[derive(Debug, Clone, Copy)]
pub struct Solved<'a> {
    /// The calibration of the views.
    pub calibration: &'a Calibration,
    /// How it does on views left out.
    pub validated: Option<&'a CrossValidation>,
}

/// The page. All text that comes from outside is escaped.
pub fn report_html(report: &Report) -> String {
    let title = format!("Calibration of {}", escaped(report.camera_name));
    let version = env!("CARGO_PKG_VERSION");
    let sections = [
        verdict::section(report),
        tables::facts(report),
        verdict::criteria(report.assessment),
        tables::parameters(report),
        figure_section(report),
        thumbnails::section(report),
        tables::left_out(report),
        tables::views(report),
    ];
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>\n{STYLE}</style></head>\n<body>\n{HATCH}<h1>{title}</h1>\n{}\
         <footer>Made by ringcal {version}; docs/report.md there says how to read this page. Pixel (0, 0) is the centre of the \
         upper left one.</footer>\n</body></html>\n",
        sections.concat(),
    )
}

fn figure_section(report: &Report) -> String {
    let figures = match &report.solved {
        Some(solved) => of_calibration(report.views, solved.calibration),
        None => of_views(report.views),
    };
    if figures.is_empty() {
        return String::new();
    }
    let figures: String = figures.into_iter().map(Figure::html).collect();
    format!("<h2>Figures</h2>\n<div class=\"figures\">\n{figures}</div>\n")
}

fn of_calibration(views: &[View], calibration: &Calibration) -> Vec<Figure> {
    let pairs = views.iter().zip(&calibration.views);
    let used: Vec<&View> = pairs
        .filter(|(_, fit)| fit.used())
        .map(|(view, _)| view)
        .collect();
    let camera = &calibration.camera;
    let distance = Range::At(calibration.typical_distance_m());
    vec![
        figures::uncertainty(calibration, Range::Infinity),
        figures::uncertainty(calibration, distance),
        figures::coverage(&used, (f64::from(camera.width), f64::from(camera.height))),
        figures::residuals(views, calibration),
        figures::by_view(calibration),
        figures::by_radius(views, calibration),
        figures::blur(views),
        figures::distortion(camera),
    ]
}

/// What can be drawn without a camera.
fn of_views(views: &[View]) -> Vec<Figure> {
    let Some(first) = views.first() else {
        return Vec::new();
    };
    let all: Vec<&View> = views.iter().collect();
    vec![
        figures::coverage(&all, (first.width as f64, first.height as f64)),
        figures::blur(views),
    ]
}

#[cfg(test)]
mod tests;
