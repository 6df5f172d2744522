//! Results for people: pictures of what was found.

mod canvas;
mod encode;
mod overlay;
mod text;
mod visible;

pub use encode::{EncodeError, Quality, grey_jpeg, grey_png, jpeg, png};
pub use overlay::{Scale, overlay};
pub use visible::visible;
