//! ringcal: camera calibration from a small board of concentric circles held close to the lens, out of focus.
//!
//! A [`frame::Frame`] becomes a [`detect::Detection`] of a [`board::Board`]; detections of several views become a
//! [`camera::Camera`].

pub mod board;
pub mod calibrate;
pub mod camera;
pub mod centre;
pub mod cli;
pub mod detect;
pub mod enhance;
pub mod formats;
pub mod frame;
pub mod report;
pub mod ros;
pub mod session;
pub mod simulate;
pub mod source;
