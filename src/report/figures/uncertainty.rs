//! How certain it is where things are seen, over the frame.

use super::Figure;
use super::frame_plot::{FramePlot, LINE, WIDTH};
use crate::calibrate::{Calibration, MAP_CELLS, Range, Rule};
use crate::report::svg::Anchor;

/// Upper ends of the classes, px; the last class has none. The same in every report, so that reports can be compared.
pub(super) const CLASSES_PX: [f64; 8] = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0];

/// The standard deviation of the projection of something at this range, in cells over the frame.
pub(in crate::report) fn uncertainty(calibration: &Calibration, range: Range) -> Figure {
    let camera = &calibration.camera;
    let frame_px = (f64::from(camera.width), f64::from(camera.height));
    let map = calibration.projection_std_map(MAP_CELLS, range);
    let (place, why) = match range {
        Range::Infinity => ("far away".to_owned(), ""),
        Range::At(distance_m) => (
            format!("at {distance_m:.2} m"),
            ", the mean distance of the boards,",
        ),
    };
    let label = format!("Projection uncertainty over the frame, of things {place}");
    let mut plot = FramePlot::new(frame_px, 3.4, label);
    for (cell, std_px) in map.iter().enumerate() {
        let (column, row) = (cell % MAP_CELLS.0, cell / MAP_CELLS.0);
        let [at, size] = plot.cell((column, row), MAP_CELLS);
        match std_px {
            Some(px) => {
                let class = class(*px);
                plot.svg.rect(&format!("s{class}"), at, size);
                let middle = [at[0] + 0.5 * size[0], at[1] + 0.5 * size[1] + 4.0];
                let ink = format!("on{class}");
                plot.svg.text(&ink, middle, Anchor::Middle, &short(*px));
            }
            None => plot.svg.rect("unseen", at, size),
        }
    }
    let told = map
        .iter()
        .enumerate()
        .filter_map(|(cell, std)| Some((cell, (*std)?)));
    let worst = told.max_by(|a, b| a.1.total_cmp(&b.1));
    if let Some((cell, _)) = worst {
        let [at, size] = plot.cell((cell % MAP_CELLS.0, cell / MAP_CELLS.0), MAP_CELLS);
        plot.svg.rect(
            "worst",
            [at[0] + 2.0, at[1] + 2.0],
            [size[0] - 4.0, size[1] - 4.0],
        );
    }
    plot.outline();
    legend(&mut plot);
    let worst_px = worst.map_or(f64::NAN, |worst| worst.1);
    Figure {
        title: format!("Projection uncertainty {place}"),
        svg: plot.svg,
        reading: format!(
            "By how many px (one standard deviation, in the worst direction) a thing {place}{why} would be seen elsewhere if \
             you calibrated again from as many such views. At worst {worst_px:.3} px, in the framed cell."
        ),
    }
}

/// A number that fits into a cell, px.
fn short(std_px: f64) -> String {
    match std_px {
        px if px < 1.0 => format!("{px:.3}"),
        px if px < 10.0 => format!("{px:.1}"),
        px => format!("{px:.0}"),
    }
}

/// The class of a standard deviation.
pub(super) fn class(std_px: f64) -> usize {
    CLASSES_PX
        .iter()
        .position(|end| std_px <= *end)
        .unwrap_or(CLASSES_PX.len())
}

/// The classes with their ends, and what they are worth.
fn legend(plot: &mut FramePlot) {
    let [x, y] = plot.legend(0.0);
    let count = CLASSES_PX.len() + 1;
    let width = (WIDTH - 2.0 * x) / count as f64;
    let top = y - LINE + 6.0;
    let end = |class: usize| x + class as f64 * width;
    for class in 0..count {
        plot.svg
            .rect(&format!("s{class} edge"), [end(class), top], [width, 14.0]);
    }
    for (class, px) in CLASSES_PX.iter().enumerate() {
        let at = [end(class + 1), top + 31.0];
        plot.svg.text("muted", at, Anchor::Middle, &format!("{px}"));
    }
    plot.svg
        .text("muted", [WIDTH - x, top + 31.0], Anchor::End, "px");
    let [good, usable] = Rule::Certainty.limits().map(|limit| end(class(limit) + 1));
    let (level, words) = (top + 38.0, top + 53.0);
    let parts = [
        (x, good, "good"),
        (good, usable, "usable"),
        (usable, WIDTH - x, "not enough"),
    ];
    for (from, to, word) in parts {
        plot.svg
            .line("bracket", [from + 2.0, level], [to - 2.0, level]);
        plot.svg
            .text("label", [0.5 * (from + to), words], Anchor::Middle, word);
    }
}
