//! SVG written by hand: elements with classes, whose colours are the page's (style.css), so that dark pages and prints work.

use super::escape::escaped;
use std::fmt::Write;

/// A picture being written. Coordinates are those of its view box, with (0, 0) at the upper left.
pub(super) struct Svg {
    body: String,
    size: (f64, f64),
    label: String,
}

/// Where a text begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

impl Svg {
    /// An empty picture; `label` is what a screen reader says of it.
    pub fn new(width: f64, height: f64, label: impl Into<String>) -> Self {
        Self {
            body: String::new(),
            size: (width, height),
            label: label.into(),
        }
    }

    /// A rectangle.
    pub fn rect(&mut self, class: &str, [x, y]: [f64; 2], [width, height]: [f64; 2]) {
        let [x, y, width, height] = [x, y, width, height].map(number);
        self.add(format_args!(
            "<rect class=\"{class}\" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"/>"
        ));
    }

    /// A rectangle that says something when it is pointed at.
    pub fn rect_saying(&mut self, class: &str, at: [f64; 2], size: [f64; 2], says: &str) {
        let [x, y, width, height] = [at[0], at[1], size[0], size[1]].map(number);
        let says = escaped(says);
        self.add(format_args!(
            "<rect class=\"{class}\" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"><title>{says}</title></rect>"
        ));
    }

    /// A straight line.
    pub fn line(&mut self, class: &str, from: [f64; 2], to: [f64; 2]) {
        let [x1, y1, x2, y2] = [from[0], from[1], to[0], to[1]].map(number);
        self.add(format_args!(
            "<line class=\"{class}\" x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\"/>"
        ));
    }

    /// A disc.
    pub fn circle(&mut self, class: &str, at: [f64; 2], radius: f64) {
        let [x, y, radius] = [at[0], at[1], radius].map(number);
        self.add(format_args!(
            "<circle class=\"{class}\" cx=\"{x}\" cy=\"{y}\" r=\"{radius}\"/>"
        ));
    }

    /// Many short lines as one element: an element each would make reports of many views ten times as large.
    pub fn strokes(&mut self, class: &str, lines: impl IntoIterator<Item = [[f64; 2]; 2]>) {
        let mut d = String::new();
        for [from, to] in lines {
            let [x, y] = from.map(number);
            let [dx, dy] = [to[0] - from[0], to[1] - from[1]].map(number);
            // writing to a String does not fail
            let _ = write!(d, "M{x} {y}l{dx} {dy}");
        }
        if !d.is_empty() {
            self.add(format_args!("<path class=\"{class}\" d=\"{d}\"/>\n"));
        }
    }

    /// An ellipse about `at`, its first axis turned by `degrees`.
    pub fn ellipse(&mut self, class: &str, at: [f64; 2], axes: [f64; 2], degrees: f64) {
        let [x, y, rx, ry] = [at[0], at[1], axes[0], axes[1]].map(number);
        let turn = number(degrees);
        self.add(format_args!(
            "<ellipse class=\"{class}\" cx=\"{x}\" cy=\"{y}\" rx=\"{rx}\" ry=\"{ry}\" transform=\"rotate({turn} {x} {y})\"/>"
        ));
    }

    /// A text on its base line.
    pub fn text(&mut self, class: &str, [x, y]: [f64; 2], anchor: Anchor, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let ([x, y], text) = ([x, y].map(number), escaped(text));
        self.add(format_args!(
            "<text class=\"{class}\" x=\"{x}\" y=\"{y}\"{anchor}>{text}</text>"
        ));
    }

    /// A picture by its data URI.
    pub fn image(&mut self, data: &str, [x, y]: [f64; 2], [width, height]: [f64; 2]) {
        let [x, y, width, height] = [x, y, width, height].map(number);
        self.add(format_args!(
            "<image href=\"{data}\" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" preserveAspectRatio=\"none\"/>\n"
        ));
    }

    /// The element, for the middle of an HTML page.
    pub fn finish(self) -> String {
        let (width, height) = (number(self.size.0), number(self.size.1));
        let (label, body) = (escaped(&self.label), self.body);
        format!(
            "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{label}\">\n{body}\n</svg>"
        )
    }

    fn add(&mut self, element: std::fmt::Arguments) {
        // writing to a String does not fail
        let _ = self.body.write_fmt(element);
    }
}

/// A coordinate to a tenth of a unit, which is finer than a screen; 0 for one that is not finite.
fn number(value: f64) -> String {
    let tenths = (10.0 * value).round() / 10.0;
    if tenths.is_finite() && tenths != 0.0 {
        format!("{tenths}")
    } else {
        "0".to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_always_numbers() {
        let told = [12.0, 0.04, -0.04, 1.26, -3.449, f64::NAN, f64::INFINITY].map(number);
        assert_eq!(told, ["12", "0", "0", "1.3", "-3.4", "0", "0"]);
    }

    #[test]
    fn elements_stand_where_they_were_put_and_text_is_escaped() {
        let mut svg = Svg::new(100.0, 50.0, "a < b");
        svg.strokes(
            "vectors",
            [[[1.0, 2.0], [4.0, 1.5]], [[7.0, 7.0], [7.0, 8.0]]],
        );
        svg.text("t", [3.0, 4.0], Anchor::End, "<&>");
        let text = svg.finish();
        assert!(text.contains("d=\"M1 2l3 -0.5M7 7l0 1\""), "{text}");
        assert!(
            text.contains("text-anchor=\"end\">&lt;&amp;&gt;</text>"),
            "{text}"
        );
        assert!(text.contains("aria-label=\"a &lt; b\""), "{text}");
        assert!(text.starts_with("<svg viewBox=\"0 0 100 50\"") && text.ends_with("</svg>"));
    }

    #[test]
    fn no_strokes_are_no_element() {
        let mut svg = Svg::new(1.0, 1.0, "");
        svg.strokes("vectors", []);
        assert!(!svg.finish().contains("<path"));
    }
}
