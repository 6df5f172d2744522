//! The figures of the page, one file each. Each is drawn from numbers alone, has its legend and its units in it, and
//! a sentence that says how to read it.

mod blur;
mod by_radius;
mod by_view;
mod chart;
mod coverage;
mod distortion;
mod frame_plot;
mod residuals;
mod uncertainty;

pub(super) use blur::blur;
pub(super) use by_radius::by_radius;
pub(super) use by_view::by_view;
pub(super) use coverage::coverage;
pub(super) use distortion::distortion;
pub(super) use residuals::{magnification, residuals};
pub(super) use uncertainty::uncertainty;

use super::escape::escaped;
use super::svg::Svg;

/// A figure of the page.
pub(super) struct Figure {
    /// Its heading.
    pub title: String,
    /// The picture.
    pub svg: Svg,
    /// How to read it.
    pub reading: String,
}

impl Figure {
    /// As an element of the page.
    pub fn html(self) -> String {
        let (title, reading) = (escaped(&self.title), escaped(&self.reading));
        format!(
            "<figure><h3>{title}</h3>\n{}\n<figcaption>{reading}</figcaption></figure>\n",
            self.svg.finish()
        )
    }
}

#[cfg(test)]
mod tests;
