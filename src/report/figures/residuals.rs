//! Where in the frame the rings lie off, and which way.

use super::Figure;
use super::chart::round_step;
use super::frame_plot::FramePlot;
use crate::calibrate::Calibration;
use crate::report::svg::Anchor;
use crate::session::View;
use nalgebra::{Point2, Vector2};

/// Length that a typical residual is drawn at, units.
const TYPICAL: f64 = 11.0;
/// Length that none is drawn beyond, units: an outlier must not cross the picture.
const LONGEST: f64 = 80.0;
/// Vectors in the figure, at most: more would be a grey area, and a large page.
const MOST: usize = 6000;

/// The residual of every ring that took part, as a line from the ring; those left out as crosses.
pub(in crate::report) fn residuals(views: &[View], calibration: &Calibration) -> Figure {
    let camera = &calibration.camera;
    let frame_px = (f64::from(camera.width), f64::from(camera.height));
    let mut plot = FramePlot::new(frame_px, 1.0, "Residuals of the rings over the frame");
    let times = magnification(calibration.rms_px, plot.scale);
    let rings = || {
        let pairs = views
            .iter()
            .zip(&calibration.views)
            .filter(|(_, fit)| fit.used());
        pairs.flat_map(|(view, fit)| {
            let residuals = fit.residuals.iter().zip(&fit.rings_used);
            view.rings
                .iter()
                .zip(residuals)
                .filter_map(|(ring, (residual, used))| {
                    Some((ring.centre.point, (*residual)?, *used))
                })
        })
    };
    let count = rings().filter(|ring| ring.2).count();
    let every = count.div_ceil(MOST).max(1);
    let vectors: Vec<[[f64; 2]; 2]> = rings()
        .filter(|ring| ring.2)
        .step_by(every)
        .map(|(at, residual, _)| vector(&plot, at, residual * (times * plot.scale)))
        .collect();
    let rings_at = vectors.iter().map(|[from, _]| [*from, *from]);
    plot.svg.strokes("dots small", rings_at);
    plot.svg.strokes("vector", vectors);
    let out: Vec<[f64; 2]> = rings()
        .filter(|ring| !ring.2)
        .map(|ring| plot.at(ring.0))
        .collect();
    for [x, y] in &out {
        let arms = [
            [[x - 4.0, y - 4.0], [x + 4.0, y + 4.0]],
            [[x - 4.0, y + 4.0], [x + 4.0, y - 4.0]],
        ];
        plot.svg.strokes("cross", arms);
    }
    plot.outline();
    legend(&mut plot, times);
    plot.say_size(frame_px);
    let thinned = if every > 1 {
        format!(" One ring of {every} is drawn.")
    } else {
        String::new()
    };
    let crosses = match out.len() {
        0 => String::new(),
        1 => " The cross is a ring that was left out.".to_owned(),
        n => format!(" The {n} crosses are rings that were left out."),
    };
    Figure {
        title: "Residuals over the frame".to_owned(),
        svg: plot.svg,
        reading: format!(
            "From the dot of each ring a line leads in the direction of measured less computed centre, drawn {times} times \
             as long as it is. Good are lines that point at random; where neighbours agree, the lens or the \
             board is not as the model has it.{thinned}{crosses}"
        ),
    }
}

fn vector(plot: &FramePlot, at: Point2<f64>, drawn: Vector2<f64>) -> [[f64; 2]; 2] {
    let [x, y] = plot.at(at);
    let drawn = drawn.cap_magnitude(LONGEST);
    [[x, y], [x + drawn.x, y + drawn.y]]
}

/// A line of a round length in px.
fn legend(plot: &mut FramePlot, times: f64) {
    let units = |px: f64| px * times * plot.scale;
    let px = round_step(30.0 / units(1.0));
    let [x, y] = plot.legend(0.0);
    let length = units(px);
    plot.svg
        .strokes("vector", [[[x, y - 5.0], [x + length, y - 5.0]]]);
    let text = format!("{px} px");
    plot.svg
        .text("label", [x + length + 8.0, y], Anchor::Start, &text);
}

/// 1, 2 or 5 times a power of ten by which residuals are drawn longer than they are, so that a typical one can be seen.
pub(in crate::report) fn magnification(rms_px: f64, units_per_px: f64) -> f64 {
    let exact = (TYPICAL / (units_per_px * rms_px.max(1e-9))).max(1.0);
    let decade = 10.0_f64.powf(exact.log10().floor());
    let step = [5.0, 2.0].into_iter().find(|s| s * decade <= exact);
    step.unwrap_or(1.0) * decade
}
