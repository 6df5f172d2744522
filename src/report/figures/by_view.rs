//! The error of each view.

use super::Figure;
use super::chart::Chart;
use crate::calibrate::Calibration;

/// The error of each view that took part, by its number.
pub(in crate::report) fn by_view(calibration: &Calibration) -> Figure {
    let used = || {
        calibration
            .views
            .iter()
            .enumerate()
            .filter(|(_, fit)| fit.used())
    };
    let most = used().map(|(_, fit)| fit.rms_px).fold(0.0, f64::max);
    let mut chart = Chart::new(
        (0.0, most),
        calibration.views.len(),
        ("error, px (rms)", "view"),
        "Error of each view",
    );
    for (at, fit) in used() {
        let says = format!("view {}: {:.4} px", at + 1, fit.rms_px);
        chart.bar("bar", at, fit.rms_px, &says);
    }
    chart.level("level", calibration.rms_px);
    chart.names(|place| (place + 1).to_string());
    Figure {
        title: "Error by view".to_owned(),
        svg: chart.svg,
        reading: format!(
            "The distance between measured and computed centres in each view; the dashed line is that of all, {:.4} px. A \
             view that stands out deserves a look below. A view without a bar was left out.",
            calibration.rms_px
        ),
    }
}
