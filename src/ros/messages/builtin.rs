//! builtin_interfaces and std_msgs.

use crate::frame::Stamp;
use ros2_client::Message;
use serde::{Deserialize, Serialize};

/// builtin_interfaces/msg/Time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Time {
    /// Whole seconds.
    pub sec: i32,
    /// Nanoseconds within the second.
    pub nanosec: u32,
}

/// std_msgs/msg/Header.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Header {
    /// When the data was taken.
    pub stamp: Time,
    /// The coordinate frame it belongs to.
    pub frame_id: String,
}

impl Message for Header {}

impl From<Time> for Stamp {
    fn from(time: Time) -> Self {
        Self {
            sec: time.sec,
            nanosec: time.nanosec,
        }
    }
}

impl From<Stamp> for Time {
    fn from(stamp: Stamp) -> Self {
        Self {
            sec: stamp.sec,
            nanosec: stamp.nanosec,
        }
    }
}
