//! SVG written by hand: the two pictures of a calibration, in the frame's own pixel coordinates.

use crate::formats::CalibrationJson;

/// Hues for views, as far apart as the golden angle makes them.
fn colour(at: usize) -> String {
    format!("hsl({:.0} 65% 45%)", (at as f64 * 137.508) % 360.0)
}

/// Opens a picture of the frame, and draws its border.
fn frame(file: &CalibrationJson) -> (String, f64) {
    let (width, height) = (f64::from(file.width), f64::from(file.height));
    let text = format!(
        "<svg viewBox=\"-0.5 -0.5 {width} {height}\" role=\"img\">\
         <rect class=\"frame\" x=\"-0.5\" y=\"-0.5\" width=\"{width}\" height=\"{height}\"/>\n"
    );
    (text, width.max(height) / 640.0)
}

/// The rings of all views that are used over the frame, one colour a view.
pub(super) fn coverage(file: &CalibrationJson) -> String {
    let (mut text, dot) = frame(file);
    for (at, view) in file.views.iter().filter(|view| view.used).enumerate() {
        text += &format!("<g fill=\"{}\">", colour(at));
        for ring in &view.rings {
            text += &format!(
                "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{:.2}\"/>",
                ring.x,
                ring.y,
                2.5 * dot
            );
        }
        text += "</g>\n";
    }
    text + "</svg>"
}

/// The residual of every ring as a line from its centre, and by how much they are magnified.
pub(super) fn residuals(file: &CalibrationJson) -> (String, f64) {
    let (mut text, dot) = frame(file);
    let scale = magnification(file.rms_px, 12.0 * dot);
    for (at, view) in file.views.iter().filter(|view| view.used).enumerate() {
        text += &format!(
            "<g stroke=\"{}\" stroke-width=\"{:.2}\">",
            colour(at),
            1.4 * dot
        );
        for ring in view.rings.iter().filter(|ring| ring.used) {
            let [dx, dy] = ring.residual.unwrap_or_default();
            text += &format!(
                "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\"/>",
                ring.x,
                ring.y,
                ring.x + scale * dx,
                ring.y + scale * dy
            );
        }
        text += "</g>\n";
    }
    (text + "</svg>", scale)
}

/// 1, 2 or 5 times a power of ten that makes a typical residual about `wanted` long.
fn magnification(rms_px: f64, wanted: f64) -> f64 {
    let exact = (wanted / rms_px.max(1e-9)).max(1.0);
    let decade = 10.0_f64.powf(exact.log10().floor());
    let step = [5.0, 2.0].into_iter().find(|s| s * decade <= exact);
    step.unwrap_or(1.0) * decade
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn residuals_are_magnified_by_round_numbers() {
        assert_eq!(magnification(0.1, 12.0), 100.0);
        assert_eq!(magnification(0.05, 12.0), 200.0);
        assert_eq!(magnification(0.02, 12.0), 500.0);
        assert_eq!(magnification(50.0, 12.0), 1.0);
        assert!(magnification(0.0, 12.0).is_finite());
    }
}
