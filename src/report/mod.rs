//! Results for people: pictures of what was found and the page of a calibration.

mod canvas;
mod encode;
mod escape;
mod figures;
mod html;
mod overlay;
mod picture;
mod svg;
mod tables;
mod text;
mod thumbnails;
mod verdict;
mod visible;

pub use encode::{EncodeError, Quality, grey_jpeg, grey_png, jpeg, png};
pub use html::{Report, Solved, report_html};
pub use overlay::{Scale, overlay};
pub use picture::{Picture, Pictures};
pub(crate) use text::wrap;
pub(crate) use thumbnails::MISSED_PICTURES;
pub use visible::visible;
