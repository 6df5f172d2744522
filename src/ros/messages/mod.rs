//! The ROS messages and services the node speaks, laid out as in their .msg files.
//!
//! Field names, order and types are the wire format; the tests compare them with the .msg texts.

mod builtin;
mod byte_sequence;
mod calibration;
mod sensor;
mod trigger;

pub use builtin::{Header, Time};
pub use calibration::{CalibrationStatus, RingCentre, RingCentreArray};
pub use sensor::{CameraInfo, CompressedImage, Image, RegionOfInterest};
pub use trigger::{TriggerRequest, TriggerResponse};

#[cfg(test)]
mod layout;
