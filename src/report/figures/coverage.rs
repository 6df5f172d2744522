//! Which parts of the frame the rings have been in.

use super::Figure;
use super::frame_plot::FramePlot;
use crate::calibrate::MAP_CELLS;
use crate::report::svg::Anchor;
use crate::session::{Coverage, View};

/// Centres of rings in the figure, at most.
const MOST: usize = 6000;

/// The cells of the frame that rings of these views touched, and the centres of the rings.
pub(in crate::report) fn coverage(views: &[&View], frame_px: (f64, f64)) -> Figure {
    let mut touched = Coverage::default();
    for view in views {
        touched.add(view);
    }
    let percent = 100.0 * touched.fraction();
    let label = format!("Coverage of the frame, {percent:.0} %");
    let mut plot = FramePlot::new(frame_px, 1.0, label);
    for row in 0..MAP_CELLS.1 {
        for column in 0..MAP_CELLS.0 {
            let [at, size] = plot.cell((column, row), MAP_CELLS);
            let class = if touched.cell(row, column) {
                "seen"
            } else {
                "unseen"
            };
            plot.svg.rect(class, at, size);
        }
    }
    let centres = || views.iter().flat_map(|view| &view.rings);
    let every = centres().count().div_ceil(MOST).max(1);
    let dots: Vec<[[f64; 2]; 2]> = centres()
        .step_by(every)
        .map(|ring| plot.at(ring.centre.point))
        .map(|at| [at, at])
        .collect();
    // a line without length and with round ends is a dot
    plot.svg.strokes("dots", dots);
    plot.outline();
    legend(&mut plot);
    plot.say_size(frame_px);
    let reading = if touched.fraction() < 1.0 {
        "Dots are the centres of all rings. Where no ring was, the lens is not measured but continued from its \
         neighbourhood: show the board in the hatched cells."
    } else {
        "Dots are the centres of all rings. No part of the frame was left bare."
    };
    Figure {
        title: format!("Coverage: {percent:.0} % of the frame"),
        svg: plot.svg,
        reading: reading.to_owned(),
    }
}

fn legend(plot: &mut FramePlot) {
    let [x, y] = plot.legend(0.0);
    let swatch = [16.0, 12.0];
    plot.svg.rect("seen edge", [x, y - 11.0], swatch);
    plot.svg
        .text("label", [x + 22.0, y], Anchor::Start, "a ring was here");
    plot.svg.rect("unseen edge", [x + 150.0, y - 11.0], swatch);
    plot.svg
        .text("label", [x + 172.0, y], Anchor::Start, "no ring");
}
