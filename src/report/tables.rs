//! The tables of the page: what was calibrated, the parameters, the views, and what was left out.

use super::Report;
use super::escape::escaped;
use crate::calibrate::ViewFit;
use crate::formats::Outcome;
use crate::plural::counted;
use crate::session::View;

/// Lines of a list of what was left out, at most; more are counted.
const MOST_LINES: usize = 100;

/// What this is about, in a few lines.
pub(super) fn facts(report: &Report) -> String {
    let board = report.board;
    let mut facts = Vec::new();
    if let Some(solved) = &report.solved {
        let camera = &solved.calibration.camera;
        let text = format!(
            "{} x {} px, lens model {}",
            camera.width,
            camera.height,
            camera.model()
        );
        facts.push(("Camera", text));
    }
    facts.push((
        "Board",
        format!(
            "{} x {} rings, pitch {} mm, radii {} and {} mm",
            board.rows(),
            board.columns(),
            mm(board.pitch_m()),
            mm(board.inner_radius_m()),
            mm(board.outer_radius_m())
        ),
    ));
    let rings: usize = report.views.iter().map(|view| view.rings.len()).sum();
    let views = match &report.solved {
        Some(solved) => format!("{} used", solved.calibration.views_used()),
        None => format!("{} kept", report.views.len()),
    };
    let (inputs, estimator) = (report.inputs, report.estimator);
    facts.push((
        "Views",
        format!(
            "{views} of {}; {} measured ({estimator})",
            counted(inputs, "input"),
            counted(rings, "ring")
        ),
    ));
    if let Some(solved) = &report.solved {
        let on_others = solved.validated.map_or(String::new(), |validated| {
            format!(
                "; {:.4} px on views left out, in {} parts",
                validated.rms_px, validated.folds
            )
        });
        let error = format!(
            "{:.4} px rms between measured and computed centres{on_others}. Small alone proves nothing.",
            solved.calibration.rms_px
        );
        facts.push(("Error", error));
    }
    let lines: String = facts
        .iter()
        .map(|(name, text)| format!("<dt>{name}</dt><dd>{}</dd>\n", escaped(text)))
        .collect();
    format!("<dl class=\"facts\">\n{lines}</dl>\n")
}

fn mm(length_m: f64) -> f64 {
    (length_m * 1e6).round() / 1e3
}

/// The parameters with their standard deviations.
pub(super) fn parameters(report: &Report) -> String {
    let Some(solved) = &report.solved else {
        return String::new();
    };
    let calibration = solved.calibration;
    let numbers = calibration.values().into_iter().zip(calibration.stds());
    let rows: String = calibration
        .names
        .iter()
        .zip(numbers)
        .map(|(name, (value, std))| {
            // pixels to a ten-thousandth, what has no unit to as many digits as anyone uses
            let digits = if matches!(*name, "fx" | "fy" | "cx" | "cy") {
                4
            } else {
                8
            };
            let std = if calibration.fixed.contains(name) {
                "fixed".to_owned()
            } else {
                format!("{std:.digits$}")
            };
            format!(
                "<tr><td>{name}</td><td class=\"n\">{value:.digits$}</td><td class=\"n\">{std}</td>\
                 <td class=\"soft\">{}</td></tr>\n",
                meaning(name)
            )
        })
        .collect();
    format!(
        "<h2>Parameters</h2>\n<div class=\"scroll\"><table id=\"parameters\">\n<tr><th>Name</th><th class=\"n\">Value</th>\
         <th class=\"n\">Standard deviation</th><th></th></tr>\n{rows}</table></div>\n\
         <p class=\"soft\">The standard deviations count the noise of the centres, not an error that all views share. \
         Parameters move together: a large one in k2 and k3 may well mean little in the picture. \
         What it comes to there is in the figures.</p>\n"
    )
}

fn meaning(name: &str) -> &'static str {
    match name {
        "fx" => "focal length along x, px",
        "fy" => "focal length along y, px",
        "cx" => "principal point, px from the left",
        "cy" => "principal point, px from the top",
        "p1" | "p2" => "tangential distortion",
        "bow_x" => "bend of the sheet along its rows, 1/m",
        "bow_y" => "bend of the sheet along its columns, 1/m",
        "pitch_ratio" => "pitch along columns over pitch along rows",
        _ => "radial distortion",
    }
}

/// What was left out and why: files, frames of bags, views, and rings of views.
pub(super) fn left_out(report: &Report) -> String {
    let mut lines: Vec<(String, String)> = Vec::new();
    let fits = || {
        report
            .solved
            .iter()
            .flat_map(|solved| &solved.calibration.views)
    };
    for (at, (view, fit)) in report.views.iter().zip(fits()).enumerate() {
        let what = format!("view {}, {}", at + 1, view.source);
        match (&fit.left_out, fit.rings_left_out()) {
            (Some(reason), _) => lines.push((what, reason.to_string())),
            (None, 0) => {}
            (None, out) => {
                let of = view.rings.len();
                let why = format!(
                    "{out} of its {of} rings lie elsewhere than the others say; the rest was used"
                );
                lines.push((what, why));
            }
        }
    }
    for outcome in report.outcomes {
        if let Outcome::NotUsed { source, reason } = outcome {
            lines.push((source.clone(), reason.clone()));
        }
    }
    let frames = |(count, why): &(u64, String)| (format!("{count} frames of bags"), why.clone());
    lines.extend(report.passed_over.iter().map(frames));
    if lines.is_empty() {
        return "<h2>What was left out</h2>\n<p id=\"left-out\">Nothing.</p>\n".to_owned();
    }
    let rows: String = lines
        .iter()
        .take(MOST_LINES)
        .map(|(what, why)| {
            format!(
                "<tr><td class=\"source\">{}</td><td>{}</td></tr>\n",
                escaped(what),
                escaped(why)
            )
        })
        .collect();
    let more = match lines.len().saturating_sub(MOST_LINES) {
        0 => String::new(),
        more => format!("<p>And {more} more; calibration.json has them all.</p>\n"),
    };
    format!(
        "<h2>What was left out</h2>\n<div class=\"scroll\"><table id=\"left-out\">\n<tr><th>What</th>\
         <th>Why</th></tr>\n{rows}</table></div>\n{more}"
    )
}

/// Every view with its numbers.
pub(super) fn views(report: &Report) -> String {
    if report.views.is_empty() {
        return String::new();
    }
    let fit = |at: usize| {
        report
            .solved
            .and_then(|solved| solved.calibration.views.get(at))
    };
    let rows: String = report
        .views
        .iter()
        .enumerate()
        .map(|(at, view)| view_row(at, view, fit(at)))
        .collect();
    let of_fit = if report.solved.is_some() {
        "<th class=\"n\">Error, px</th><th class=\"n\">Distance, m</th><th class=\"n\">Tilt, degrees</th>"
    } else {
        ""
    };
    format!(
        "<h2>All views</h2>\n<div class=\"scroll\"><table id=\"views\">\n<tr><th class=\"n\">View</th><th class=\"n\">Rings</th>\
         <th class=\"n\">Blur, px</th>{of_fit}<th>Source</th></tr>\n{rows}</table></div>\n"
    )
}

fn view_row(at: usize, view: &View, fit: Option<&ViewFit>) -> String {
    format!(
        "<tr><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{:.1}</td>{}<td class=\"source\">{}</td></tr>\n",
        at + 1,
        view.rings.len(),
        median_blur_px(view),
        fit.map_or(String::new(), fit_cells),
        escaped(&view.source),
    )
}

/// Error, distance and tilt.
fn fit_cells(fit: &ViewFit) -> String {
    let error = if fit.used() {
        format!("{:.4}", fit.rms_px)
    } else {
        "left out".to_owned()
    };
    let (distance, tilt) = fit.pose.map_or((String::new(), String::new()), |pose| {
        let tilt_deg = pose.tilt_rad().to_degrees();
        (
            format!("{:.3}", pose.translation_m.norm()),
            format!("{tilt_deg:.0}"),
        )
    });
    format!(
        "<td class=\"n\">{error}</td><td class=\"n\">{distance}</td><td class=\"n\">{tilt}</td>"
    )
}

/// Median of the rings' blur, px; 0 without rings.
pub(super) fn median_blur_px(view: &View) -> f64 {
    let mut blur: Vec<f64> = view.rings.iter().map(|ring| ring.blur_sigma_px).collect();
    blur.sort_by(f64::total_cmp);
    blur.get(blur.len() / 2).copied().unwrap_or(0.0)
}
