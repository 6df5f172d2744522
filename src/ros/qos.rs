//! The qualities of service of the node's topics and services.

use ros2_client::QosProfile;
use ros2_client::qos::{Durability, History, WhenFull};

/// Frames: best effort matches every publisher, and only the newest counts.
pub fn frames() -> QosProfile {
    QosProfile::subscription_default()
}

/// What is published with each frame. A subscriber that cannot keep up loses messages, it never holds the node up.
pub fn results() -> QosProfile {
    QosProfile::publisher_default()
        .reliability_reliable(WhenFull::Fail)
        .history(History::KeepLast { depth: 10 })
}

/// Pictures: as [`results`], but large, so that only the newest is kept.
pub fn pictures() -> QosProfile {
    results().history(History::KeepLast { depth: 1 })
}

/// What late subscribers must see as well: the last message is kept for them.
pub fn latched() -> QosProfile {
    results()
        .durability(Durability::TransientLocal)
        .history(History::KeepLast { depth: 1 })
}

/// Services, as rcl's default: reliable, ten requests kept.
pub fn services() -> QosProfile {
    results()
}

/// /rosout, as rcl has it.
pub fn rosout() -> QosProfile {
    results()
        .durability(Durability::TransientLocal)
        .history(History::KeepLast { depth: 1000 })
        .lifespan(Some(std::time::Duration::from_secs(10)))
}
