//! std_srvs/srv/Trigger.

use ros2_client::Message;
use serde::{Deserialize, Serialize};

/// The request of std_srvs/srv/Trigger, which has no fields: on the wire an empty structure is one byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct TriggerRequest {
    /// The byte that stands for nothing.
    pub structure_needs_at_least_one_member: u8,
}

/// The response of std_srvs/srv/Trigger.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct TriggerResponse {
    /// Whether it was done.
    pub success: bool,
    /// What was done, or why not.
    pub message: String,
}

impl Message for TriggerRequest {}
impl Message for TriggerResponse {}
