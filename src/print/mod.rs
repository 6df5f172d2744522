//! A board as a sheet of paper, true to scale.
//!
//! [`lay_out`] arranges the rings of a [`Board`](crate::board::Board), two rulers, and what a person wants to read on a
//! [`Sheet`]: shapes and texts in millimetres. [`svg`], [`pdf`] and [`png`] then draw the same sheet, so that what one of them shows
//! is what the others show. [`propose`] finds the board for a camera.
//!
//! Sheet coordinates: x right, y down from the upper left corner of the paper, millimetres, because paper is sold in them. The
//! board frame lies in it unturned: columns run to the right and rows down, as a camera sees the print.
//!
//! ```text
//! +--------------------------------------------+
//! | row 0, column 0   100 mm here must measure |  top band: what the rulers are for
//! |   ◢ 0 ' ' ' | ' ' ' 10 ' ' ' | ' ' '       |  ruler, its 0 at the centre of ring (0, 0)
//! |    +---------------------------+           |
//! |  0 |                           |           |
//! |  - |  field: rings and         |  legend   |
//! |  - |  the quiet zone           |  beside   |
//! | 10 |                           |  or below |
//! |    +---------------------------+           |
//! |      legend: name, sizes, YAML             |
//! +--------------------------------------------+
//! ```

mod compose;
mod coverage;
mod error;
mod for_camera;
mod glyphs;
mod layout;
mod legend;
mod numbers;
mod paper;
mod pdf;
mod png;
mod ruler;
mod sheet;
mod svg;
#[cfg(test)]
mod tests;

pub use error::PrintError;
pub use for_camera::{CameraSetup, MOST_BLUR, NoBoard, Proposal, propose};
pub use layout::{PrintOptions, lay_out};
pub use paper::{Paper, Stock};
pub use pdf::pdf;
pub use png::png;
pub use sheet::{Area, Shape, Sheet, Text, Tone, Turn};
pub use svg::svg;
