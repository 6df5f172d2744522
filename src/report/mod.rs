//! Results for people.

mod html;
mod svg;

pub use html::report_html;
