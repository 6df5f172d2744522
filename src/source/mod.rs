//! Offline input: image files, folders of them, and rosbag2 recordings, one frame at a time.
//!
//! [`Inputs`] gives the frames of several inputs in the order of the command line. A file that cannot be read is an item of its
//! own with the reason, and the rest go on. Only the names of a folder and one message of a bag are in memory at a time;
//! a frame is decoded by whoever asks for it ([`Recorded::read`]).

pub mod bag;
mod board_file;
mod camera_file;
mod error;
mod folder;
mod image_file;
mod inputs;
mod natural_order;
mod recorded;
mod text_file;

pub use board_file::{BoardFileError, read_board};
pub use camera_file::{NoCamera, read_camera_file, read_camera_of};
pub use error::SourceError;
pub use image_file::read_image;
pub use inputs::{Inputs, Item};
pub use recorded::{Origin, Recorded};

#[cfg(test)]
mod tests;
