//! How far out of focus each view is.

use super::Figure;
use super::chart::Chart;
use crate::session::View;

/// The blur of the rings of each view: its range as a line, its median as a dot.
pub(in crate::report) fn blur(views: &[View]) -> Figure {
    let all: Vec<Vec<f64>> = views.iter().map(sorted).collect();
    let most = all.iter().flatten().copied().fold(0.0, f64::max);
    let mut chart = Chart::new(
        (0.0, most),
        views.len(),
        ("blur sigma, px", "view"),
        "Blur of each view",
    );
    for (at, blur) in all.iter().enumerate() {
        let (Some(least), Some(most)) = (blur.first(), blur.last()) else {
            continue;
        };
        let x = chart.x(at);
        let ends = [[x, chart.y(*least)], [x, chart.y(*most)]];
        chart.svg.line("range", ends[0], ends[1]);
        let middle = [x, chart.y(blur[blur.len() / 2])];
        chart.svg.circle("dot", middle, 3.5);
    }
    chart.names(|place| (place + 1).to_string());
    Figure {
        title: "Blur by view".to_owned(),
        svg: chart.svg,
        reading: "How far out of focus the rings are: the standard deviation of the blur, the median of a view as a dot, its \
                  smallest and largest as a line. Blur does no harm; blur that differs between views of the same \
                  distance does: the focus was changed, or something moved."
            .to_owned(),
    }
}

fn sorted(view: &View) -> Vec<f64> {
    let mut blur: Vec<f64> = view
        .rings
        .iter()
        .map(|ring| ring.blur_sigma_px)
        .filter(|blur| blur.is_finite())
        .collect();
    blur.sort_by(f64::total_cmp);
    blur
}
