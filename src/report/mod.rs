//! Results for people: pictures of what was found and the page of a calibration.

mod canvas;
mod encode;
mod html;
mod overlay;
mod svg;
mod text;
mod visible;

pub use encode::{EncodeError, Quality, grey_jpeg, grey_png, jpeg, png};
pub use html::report_html;
pub use overlay::{Scale, overlay};
pub(crate) use text::wrap;
pub use visible::visible;
