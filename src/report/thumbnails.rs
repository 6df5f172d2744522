//! Small pictures of the views with what was found in them, the worst first, and of some files that showed no board.
//!
//! At most [`MOST`] and [`MISSED_PICTURES`] of them, so that the page stays small whatever the number of views.

use super::escape::escaped;
use super::figures::magnification;
use super::svg::Svg;
use super::tables::median_blur_px;
use super::{Picture, Report};
use crate::calibrate::ViewFit;
use crate::formats::Outcome;
use crate::plural::counted;
use crate::session::View;
use nalgebra::Point2;

/// Views in the page, at most.
const MOST: usize = 12;
/// Files that were not used, at most: enough to see what is wrong with all of them.
pub(crate) const MISSED_PICTURES: usize = 6;
/// Width of a picture, units.
const WIDTH: f64 = 320.0;

/// The pictures of the page; nothing where there are none.
pub(super) fn section(report: &Report) -> String {
    let fit = |at: usize| {
        report
            .solved
            .and_then(|solved| solved.calibration.views.get(at))
    };
    let mut order: Vec<usize> = (0..report.views.len()).collect();
    let badness = |at: usize| {
        fit(at).map_or(0.0, |fit| {
            if fit.used() {
                fit.rms_px
            } else {
                f64::INFINITY
            }
        })
    };
    // stable: views that are as bad as one another stay in their order
    order.sort_by(|a, b| badness(*b).total_cmp(&badness(*a)));
    let views: String = order
        .iter()
        .take(MOST)
        .filter_map(|at| {
            let view = &report.views[*at];
            let picture = report.pictures.get(&view.source)?;
            Some(of_view(report, *at, (view, picture, fit(*at))))
        })
        .collect();
    let missed: String = report
        .outcomes
        .iter()
        .filter_map(|outcome| match outcome {
            Outcome::NotUsed { source, reason } => {
                Some((source, reason, report.pictures.get(source)?))
            }
            Outcome::Used(_) => None,
        })
        .take(MISSED_PICTURES)
        .map(|(source, reason, picture)| of_missed(source, reason, picture))
        .collect();
    let shown = if order.len() > MOST {
        format!("{MOST} of the {} views, ", order.len())
    } else {
        "The views, ".to_owned()
    };
    let mut text = String::new();
    if !views.is_empty() {
        let lead = match &report.solved {
            Some(solved) => {
                let camera = &solved.calibration.camera;
                let times =
                    magnification(solved.calibration.rms_px, scale(f64::from(camera.width)));
                format!(
                    "{shown}worst first. Blue: the outer circle of each ring as it was found. Orange: measured less computed \
                     centre, {times} times as long as it is. Red: left out."
                )
            }
            None => format!(
                "{shown}in their order. Blue: the outer circle of each ring as it was found."
            ),
        };
        text += &format!(
            "<h2>Pictures of the views</h2>\n<p>{lead}</p>\n<div class=\"thumbs\">\n{views}</div>\n"
        );
    }
    if !missed.is_empty() {
        text += &format!(
            "<h2>Pictures of files that were not used</h2>\n<p>At most {MISSED_PICTURES} of them.</p>\n\
             <div class=\"thumbs\">\n{missed}</div>\n"
        );
    }
    text
}

fn scale(width_px: f64) -> f64 {
    WIDTH / width_px.max(1.0)
}

/// The ground of a picture: the frame, WIDTH units wide.
fn ground(picture: &Picture, label: String) -> Svg {
    let (width, height) = picture.frame_px();
    let scale = scale(width);
    let mut svg = Svg::new(WIDTH, height * scale, label);
    let (shown_width, shown_height) = picture.shows_px();
    svg.image(
        &picture.data_uri(),
        [0.0, 0.0],
        [shown_width * scale, shown_height * scale],
    );
    svg
}

fn of_view(
    report: &Report,
    at: usize,
    (view, picture, fit): (&View, &Picture, Option<&ViewFit>),
) -> String {
    let mut svg = ground(picture, format!("View {} with its rings", at + 1));
    let scale = scale(view.width as f64);
    let rms_px = report
        .solved
        .map_or(0.0, |solved| solved.calibration.rms_px);
    let times = magnification(rms_px, scale);
    let place = |p: Point2<f64>| [(p.x + 0.5) * scale, (p.y + 0.5) * scale];
    let mut errors = Vec::new();
    for (number, ring) in view.rings.iter().enumerate() {
        let used = fit.is_none_or(|fit| fit.used() && fit.rings_used.get(number) == Some(&true));
        let ellipse = &ring.ellipses.outer;
        let axes = [ellipse.major * scale, ellipse.minor * scale];
        let class = if used { "found" } else { "refused" };
        svg.ellipse(
            class,
            place(ellipse.centre),
            axes,
            ellipse.angle.to_degrees(),
        );
        let residual = fit
            .filter(|fit| fit.used())
            .and_then(|fit| *fit.residuals.get(number)?);
        if let (Some(residual), true) = (residual, used) {
            let from = place(ring.centre.point);
            let drawn = (residual * (times * scale)).cap_magnitude(0.25 * WIDTH);
            errors.push([from, [from[0] + drawn.x, from[1] + drawn.y]]);
        }
    }
    svg.strokes("error", errors);
    let (numbers, source) = (numbers(view, fit), escaped(&view.source));
    format!(
        "<figure>{}<figcaption><b>View {}</b> {numbers}<br>{source}</figcaption></figure>\n",
        svg.finish(),
        at + 1
    )
}

fn numbers(view: &View, fit: Option<&ViewFit>) -> String {
    let blur = format!(
        "{} rings, blur {:.1} px",
        view.rings.len(),
        median_blur_px(view)
    );
    match fit.map(|fit| (&fit.left_out, fit.rings_left_out(), fit.rms_px)) {
        None => blur,
        Some((Some(reason), _, _)) => {
            format!(
                "{blur}<br><span class=\"alarm\">left out: {}</span>",
                escaped(&reason.to_string())
            )
        }
        Some((None, 0, rms_px)) => format!("{rms_px:.4} px, {blur}"),
        Some((None, out, rms_px)) => {
            let out = counted(out, "ring");
            format!("{rms_px:.4} px, {blur}<br><span class=\"alarm\">{out} left out</span>")
        }
    }
}

fn of_missed(source: &str, reason: &str, picture: &Picture) -> String {
    let svg = ground(picture, "A frame that was not used".to_owned());
    format!(
        "<figure>{}<figcaption><span class=\"alarm\">{}</span><br>{}</figcaption></figure>\n",
        svg.finish(),
        escaped(reason),
        escaped(source)
    )
}
