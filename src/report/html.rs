//! report.html: a calibration on one page that needs nothing but itself.

use super::svg;
use crate::formats::{CalibrationJson, ViewJson};

const STYLE: &str = "\
body{font:15px/1.5 system-ui,sans-serif;color:#222;max-width:60rem;margin:2rem auto;padding:0 1rem}\
h1{font-size:1.5rem;margin-bottom:0}h2{font-size:1.1rem;margin-top:2rem}\
table{border-collapse:collapse;width:100%}\
th,td{text-align:left;padding:.25rem .75rem .25rem 0;border-bottom:1px solid #e4e4e4;vertical-align:top}\
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums}\
table.narrow{width:auto}table.narrow td,table.narrow th{padding-right:2rem}figure{margin:0}svg{width:100%;height:auto;max-height:34rem;overflow:visible}\
.frame{fill:#fafafa;stroke:#999;stroke-width:1;vector-effect:non-scaling-stroke}\
.pair{display:grid;grid-template-columns:1fr 1fr;gap:1.5rem}\
.unused{color:#888}.warn{color:#a04000}\
@media(max-width:50rem){.pair{grid-template-columns:1fr}}";

/// The page. All text that comes from outside is escaped.
pub fn report_html(file: &CalibrationJson) -> String {
    let used = file.views.iter().filter(|view| view.used).count();
    let (residuals, scale) = svg::residuals(file);
    let title = format!("Calibration of {}", escaped(&file.camera_name));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width\">\
         <title>{title}</title><style>{STYLE}</style></head>\n<body>\n<h1>{title}</h1>\n\
         <p>{} x {} px, {}, centres by {}. {used} of {} inputs used. \
         Reprojection error <strong>{:.4} px</strong> rms.</p>\n\
         <p>A small reprojection error alone does not prove a calibration: look at the standard deviations, at how \
         much of the frame is covered, and check on focused views at another distance.</p>\n\
         <h2>Parameters</h2>\n{}\n<h2>Rings</h2>\n<div class=\"pair\">\
         <figure>{}<figcaption>Where the rings were, one colour a view</figcaption></figure>\
         <figure>{residuals}<figcaption>Residuals, measured less projected, {scale} times as long</figcaption>\
         </figure></div>\n<h2>Views</h2>\n{}\n</body></html>\n",
        file.width,
        file.height,
        escaped(&file.model),
        escaped(&file.estimator),
        file.views.len(),
        file.rms_px,
        parameters(file),
        svg::coverage(file),
        views(&file.views),
    )
}

fn parameters(file: &CalibrationJson) -> String {
    let mut text = String::from(
        "<table class=\"narrow\"><tr><th>Name</th><th class=\"n\">Value</th><th class=\"n\">Standard deviation</th></tr>\n",
    );
    for name in &file.names {
        let (Some(value), Some(std)) = (file.parameters.get(name), file.std.get(name)) else {
            continue;
        };
        // pixels to a ten-thousandth, what has no unit to as many digits as anyone uses
        let digits = if "fx fy cx cy".contains(name.as_str()) {
            4
        } else {
            8
        };
        let std = if file.fixed.contains(name) {
            "fixed".to_owned()
        } else {
            format!("{std:.digits$}")
        };
        text += &format!(
            "<tr><td>{name}</td><td class=\"n\">{value:.digits$}</td><td class=\"n\">{std}</td></tr>\n"
        );
    }
    text + "</table>"
}

fn views(views: &[ViewJson]) -> String {
    let mut text = String::from(
        "<table><tr><th>Source</th><th class=\"n\">Rings</th><th class=\"n\">rms, px</th><th></th></tr>\n",
    );
    for view in views {
        let class = if view.used { "used" } else { "unused" };
        let rms = view.rms_px.map_or(String::new(), |rms| format!("{rms:.4}"));
        let rings = if view.used {
            view.rings.len().to_string()
        } else {
            String::new()
        };
        let reason = view.reason.as_deref().map_or(String::new(), escaped);
        let said = if view.used {
            format!("<span class=\"warn\">{reason}</span>")
        } else {
            format!("not used: {reason}")
        };
        text += &format!(
            "<tr class=\"{class}\"><td>{}</td><td class=\"n\">{rings}</td><td class=\"n\">{rms}</td>\
             <td>{said}</td></tr>\n",
            escaped(&view.source)
        );
    }
    text + "</table>"
}

/// Text as it may stand in an element or a quoted attribute.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\'' => out += "&#39;",
            _ => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::{CalibrateOptions, Fixed, calibrate, synthetic};
    use crate::formats::Outcome;

    #[test]
    fn the_page_shows_everything_and_escapes_what_comes_from_outside() {
        let (camera, board) = (synthetic::ordinary(), synthetic::board());
        let poses = synthetic::poses(&camera, &board);
        let views = synthetic::views(&camera, &board, &poses, 0.1, 1);
        let options = CalibrateOptions {
            fixed: Fixed::from_entries(["k3"]).unwrap(),
            ..CalibrateOptions::default()
        };
        let calibration = calibrate(&board, &views, &options).unwrap();
        let mut outcomes: Vec<Outcome> = (0..views.len()).map(Outcome::Used).collect();
        outcomes.push(Outcome::NotUsed {
            source: "<script>.png".into(),
            reason: "\"a\" & 'b'".into(),
        });
        let file = CalibrationJson::new("<b>", "cross", &calibration, &views, &outcomes);
        let page = report_html(&file);
        assert!(!page.contains("<script") && !page.contains("<b>"));
        assert!(page.contains("&lt;script&gt;.png"));
        assert!(page.contains("&quot;a&quot; &amp; &#39;b&#39;"));
        assert!(page.contains("12 of 13 inputs used"));
        assert!(
            page.contains("<td>k3</td><td class=\"n\">0.00000000</td><td class=\"n\">fixed</td>")
        );
        assert_eq!(page.matches("<circle").count(), 12 * 49);
        assert_eq!(page.matches("<line").count(), 12 * 49);
        for tag in ["svg", "table", "figure", "g", "tr", "td"] {
            let opened = page.matches(&format!("<{tag} ")).count()
                + page.matches(&format!("<{tag}>")).count();
            assert_eq!(opened, page.matches(&format!("</{tag}>")).count(), "{tag}");
        }
        assert!(!page.contains("http"), "it needs nothing from elsewhere");
    }
}
