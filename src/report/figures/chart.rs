//! A chart: a linear scale from zero up the left side, places along the bottom.

use super::frame_plot::WIDTH;
use crate::report::svg::{Anchor, Svg};

const HEIGHT: f64 = 270.0;
const LEFT: f64 = 58.0;
const RIGHT: f64 = 8.0;
const TOP: f64 = 26.0;
const BOTTOM: f64 = 44.0;
/// Steps of the vertical scale, about.
const STEPS: f64 = 4.0;
/// Names along the bottom, at most.
const NAMES: usize = 10;

/// A chart being drawn.
pub(super) struct Chart {
    pub svg: Svg,
    low: f64,
    high: f64,
    places: usize,
}

impl Chart {
    /// A chart of `places` values between `low` and `high`, with what is measured above the scale, and what the places are below.
    pub fn new(
        (low, high): (f64, f64),
        places: usize,
        (what, along): (&str, &str),
        label: impl Into<String>,
    ) -> Self {
        let step = round_step((high - low) / STEPS);
        // a value on a line, but for rounding, needs no line beyond it
        let low = (low / step + 1e-9).floor() * step;
        let high = ((high / step - 1e-9).ceil() * step).max(low + step);
        let mut chart = Self {
            svg: Svg::new(WIDTH, HEIGHT, label),
            low,
            high,
            places: places.max(1),
        };
        chart.scale(step);
        let middle = 0.5 * (LEFT + WIDTH - RIGHT);
        chart.svg.text("label", [0.0, 14.0], Anchor::Start, what);
        chart
            .svg
            .text("label", [middle, HEIGHT - 6.0], Anchor::Middle, along);
        chart
    }

    /// Lines across with their values.
    fn scale(&mut self, step: f64) {
        let digits = (-step.log10().floor()).max(0.0) as usize;
        let lines = ((self.high - self.low) / step).round() as i64;
        for line in 0..=lines {
            let value = self.low + line as f64 * step;
            let y = self.y(value);
            let zero = value.abs() < 1e-6 * step;
            let class = if zero { "axis" } else { "rule" };
            self.svg.line(class, [LEFT, y], [WIDTH - RIGHT, y]);
            let value = if zero { 0.0 } else { value };
            let text = format!("{value:.digits$}");
            self.svg
                .text("muted", [LEFT - 6.0, y + 5.0], Anchor::End, &text);
        }
    }

    /// Height of a value.
    pub fn y(&self, value: f64) -> f64 {
        let part = (value - self.low) / (self.high - self.low);
        HEIGHT - BOTTOM - part.clamp(0.0, 1.0) * (HEIGHT - TOP - BOTTOM)
    }

    /// Middle of a place.
    pub fn x(&self, place: usize) -> f64 {
        LEFT + (place as f64 + 0.5) * self.pace()
    }

    /// Width of a place.
    fn pace(&self) -> f64 {
        (WIDTH - LEFT - RIGHT) / self.places as f64
    }

    /// A bar from zero, or from the lower end, to a value.
    pub fn bar(&mut self, class: &str, place: usize, value: f64, says: &str) {
        let width = (0.72 * self.pace()).min(36.0);
        let (top, foot) = (self.y(value), self.y(0.0));
        let at = [self.x(place) - 0.5 * width, top];
        self.svg.rect_saying(class, at, [width, foot - top], says);
    }

    /// A level across the whole chart.
    pub fn level(&mut self, class: &str, value: f64) {
        let y = self.y(value);
        self.svg.line(class, [LEFT, y], [WIDTH - RIGHT, y]);
    }

    /// Names below the places, as many as there is room for.
    pub fn names(&mut self, name: impl Fn(usize) -> String) {
        let every = self.places.div_ceil(NAMES);
        for place in (0..self.places).step_by(every) {
            let at = [self.x(place), HEIGHT - BOTTOM + 17.0];
            self.svg.text("muted", at, Anchor::Middle, &name(place));
        }
    }
}

/// 1, 2 or 5 times a power of ten, the next above.
pub(super) fn round_step(exact: f64) -> f64 {
    if !(exact.is_finite() && exact > 0.0) {
        return 1.0;
    }
    let decade = 10.0_f64.powf(exact.log10().floor());
    let step = [1.0, 2.0, 5.0]
        .into_iter()
        .find(|s| s * decade >= exact * (1.0 - 1e-9));
    step.unwrap_or(10.0) * decade
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_is_round_and_holds_the_values() {
        assert_eq!(round_step(0.013), 0.02);
        assert_eq!(round_step(2.0), 2.0);
        assert_eq!(round_step(0.7), 1.0);
        assert_eq!(round_step(f64::NAN), 1.0);
        let chart = Chart::new((-0.02, 0.13), 5, ("px", "view"), "");
        assert!((chart.low + 0.05).abs() < 1e-12 && (chart.high - 0.15).abs() < 1e-12);
        assert!(chart.y(0.13) > TOP && chart.y(-0.05) == HEIGHT - BOTTOM);
        let nothing = Chart::new((0.0, 0.0), 0, ("", ""), "");
        assert!(nothing.high > nothing.low && nothing.x(0).is_finite());
    }

    #[test]
    fn many_places_have_few_names() {
        let mut chart = Chart::new((0.0, 1.0), 200, ("px", "view"), "");
        chart.names(|place| format!("n{place}"));
        let text = chart.svg.finish();
        assert_eq!(text.matches(">n").count(), 10);
        assert!(text.contains(">n0<") && text.contains(">n180<"));
    }
}
