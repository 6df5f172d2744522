//! How a node tells others of its topics: not while somebody is getting to know it.
//!
//! Topics are told one after the other, for some 20 ms. A Fast DDS that gets to know the node in the middle of that is
//! sent the later topics at once and the earlier ones when it asks for them; it forgets some that come in this order,
//! for good (seen with 3.2: every second start of two nodes at the same moment on a busy machine). So before every topic
//! the node looks whether somebody new has come, and waits until they know one another.

use ros2_client::Node;
use rustdds::{
    DomainParticipant, DomainParticipantStatusEvent, DomainParticipantStatusListener, StatusEvented,
};
use std::time::{Duration, Instant};

/// How long two participants take, at most, until each has been told all that the other had to tell.
const ACQUAINTANCE: Duration = Duration::from_millis(250);

/// When RustDDS first announces a participant; to those it hears of before, 10 ms after.
const FIRST_ANNOUNCEMENT: Duration = Duration::from_millis(100);

/// How much before its announcement a topic must be told.
const MARGIN: Duration = Duration::from_millis(60);

/// No crowd of others keeps the node waiting longer.
const PATIENCE: Duration = Duration::from_secs(3);

/// When topics can be told.
pub struct Manners {
    arrivals: DomainParticipantStatusListener,
    joined: Instant,
    busy_until: Instant,
}

impl Manners {
    /// Of a participant that has just been made.
    pub fn new(participant: &DomainParticipant) -> Self {
        let joined = Instant::now();
        Self {
            arrivals: participant.status_listener(),
            joined,
            busy_until: joined,
        }
    }

    /// Returns when nobody is getting to know the participant.
    pub fn wait(&mut self) {
        loop {
            let now = Instant::now();
            if self.somebody_came() {
                self.busy_until = now + ACQUAINTANCE;
            }
            let announced = self.joined + FIRST_ANNOUNCEMENT;
            if (announced - MARGIN..announced + ACQUAINTANCE).contains(&now) {
                self.busy_until = self.busy_until.max(announced + ACQUAINTANCE);
            }
            let until = self.busy_until.min(self.joined + PATIENCE);
            if until <= now {
                return;
            }
            std::thread::sleep(until - now);
        }
    }

    fn somebody_came(&self) -> bool {
        let events = std::iter::from_fn(|| self.arrivals.try_recv_status());
        events.fold(false, |came, event| {
            came | matches!(
                event,
                DomainParticipantStatusEvent::ParticipantDiscovered { .. }
            )
        })
    }
}

/// A node whose topics and services are being made.
pub struct Newcomer {
    node: Node,
    manners: Manners,
}

impl Newcomer {
    /// A node that was made with good manners.
    pub fn new(node: Node, manners: Manners) -> Self {
        Self { node, manners }
    }

    /// The node to make one topic or service with, once it may be told.
    pub fn node(&mut self) -> &mut Node {
        self.manners.wait();
        &mut self.node
    }

    /// The node, for all that tells nobody of anything new.
    pub fn introduced(&mut self) -> &mut Node {
        &mut self.node
    }
}
