//! The other side of the node: a camera that publishes frames and a user who listens and calls.
//!
//! Everything here polls, so that a caller on one thread stays in charge of time.

use super::messages::{
    CalibrationStatus, CameraInfo, Header, Image, RingCentreArray, TriggerRequest, TriggerResponse,
};
use super::publishers::{EntityError, dds_name};
use super::qos;
use ros2_client::{
    Client, Context, MessageTypeName, Node, NodeCreateError, NodeName, NodeOptions, Publisher,
    ServiceMapping, ServiceTypeName, Subscription,
};
use serde::de::DeserializeOwned;
use std::time::{Duration, Instant};

/// Time between two looks at what has arrived.
const POLL: Duration = Duration::from_millis(2);

/// Why the client cannot be made or used.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// A topic or service.
    #[error(transparent)]
    Entity(#[from] EntityError),
    /// ros2-client does not make the node.
    #[error("{0}")]
    Node(#[from] NodeCreateError),
    /// Something did not happen in time.
    #[error("waited {} s in vain for {what}", limit.as_secs_f64())]
    Late {
        /// What was waited for.
        what: String,
        /// How long.
        limit: Duration,
    },
    /// Something could not be sent.
    #[error("cannot send {what}: {reason}")]
    Sending {
        /// What was to be sent.
        what: &'static str,
        /// What DDS says.
        reason: String,
    },
    /// Whoever uses the client wants to end.
    #[error("interrupted")]
    Interrupted,
}

impl From<ros2_client::CreateError> for ClientError {
    fn from(error: ros2_client::CreateError) -> Self {
        EntityError::from(error).into()
    }
}

/// A camera in front of one ringcal node, and its user.
pub struct CameraClient {
    node_name: String,
    frames: Publisher<Image>,
    frames_topic: String,
    centres: Subscription<RingCentreArray>,
    status: Subscription<CalibrationStatus>,
    camera_info: Subscription<CameraInfo>,
    calibrate: Client<TriggerRequest, TriggerResponse>,
    /// Behind the endpoints: fields are dropped in this order, and the node must go last but for the context.
    _node: Node,
    context: Context,
    interrupted: Box<dyn Fn() -> bool>,
}

impl CameraClient {
    /// A client named `name` of the ringcal node `node_name` (absolute), publishing frames on `topic`. All waiting ends early
    /// where `interrupted` answers true.
    ///
    /// # Errors
    /// [`ClientError`] for the first thing that cannot be made.
    pub fn open(
        context: &Context,
        name: &str,
        node_name: &str,
        topic: &str,
        interrupted: impl Fn() -> bool + 'static,
    ) -> Result<Self, ClientError> {
        let own_name = NodeName::new("/", name).map_err(|source| refused(name, source))?;
        let options = NodeOptions::new()
            .enable_rosout(false)
            .start_parameter_services(false);
        let mut node = context.new_node(own_name, options)?;
        let kind = MessageTypeName::new("sensor_msgs", "Image");
        let qos = qos::pictures();
        let frames_topic = node.create_topic(&dds_name(topic)?, kind, &qos)?;
        let frames = node.create_publisher(&frames_topic, Some(qos))?;
        let at = |leaf: &str| format!("{node_name}/{leaf}");
        let calibrate = node.create_client(
            ServiceMapping::Enhanced,
            &dds_name(&at("calibrate"))?,
            &ServiceTypeName::new("std_srvs", "Trigger"),
            qos::services(),
            qos::services(),
        )?;
        Ok(Self {
            centres: latest(&mut node, &at("centres"), ("ringcal", "RingCentreArray"))?,
            status: latest(&mut node, &at("status"), ("ringcal", "CalibrationStatus"))?,
            camera_info: latest(&mut node, &at("camera_info"), ("sensor_msgs", "CameraInfo"))?,
            node_name: node_name.to_owned(),
            frames,
            frames_topic: topic.to_owned(),
            calibrate,
            _node: node,
            context: context.clone(),
            interrupted: Box::new(interrupted),
        })
    }

    /// Waits until the node hears frames, answers calls and is heard.
    ///
    /// # Errors
    /// [`ClientError::Late`] after `limit`.
    pub fn wait_for_node(&self, limit: Duration) -> Result<(), ClientError> {
        let wanted = format!("rt{}", self.frames_topic);
        let service = format!("rr{}/calibrateReply", self.node_name);
        let centres = format!("rt{}/centres", self.node_name);
        self.until(limit, &format!("the node {}", self.node_name), || {
            let participant = self.context.domain_participant();
            let readers = participant.discovered_readers();
            let writers = participant.discovered_writers();
            let hears = readers
                .iter()
                .any(|r| *r.subscription_topic_data.topic_name() == wanted);
            let has = |topic: &String| {
                writers
                    .iter()
                    .any(|w| w.publication_topic_data.topic_name == *topic)
            };
            (hears && has(&service) && has(&centres)).then_some(())
        })
    }

    /// Publishes a frame.
    ///
    /// # Errors
    /// [`ClientError::Sending`].
    pub fn publish(&self, frame: Image) -> Result<(), ClientError> {
        self.frames
            .publish(frame)
            .map_err(|error| ClientError::Sending {
                what: "a frame",
                reason: error.to_string(),
            })
    }

    /// Waits for the centres of the frame with this header.
    ///
    /// # Errors
    /// [`ClientError::Late`] after `limit`.
    pub fn centres_of(
        &self,
        frame: &Header,
        limit: Duration,
    ) -> Result<RingCentreArray, ClientError> {
        self.until(limit, "the centres of a frame", || {
            newest(&self.centres).filter(|message| message.header == *frame)
        })
    }

    /// Waits for a status that fulfils a condition.
    ///
    /// # Errors
    /// [`ClientError::Late`] after `limit`.
    pub fn status_with(
        &self,
        what: &str,
        limit: Duration,
        condition: impl Fn(&CalibrationStatus) -> bool,
    ) -> Result<CalibrationStatus, ClientError> {
        self.until(limit, what, || newest(&self.status).filter(&condition))
    }

    /// Waits for the CameraInfo of a calibrated camera.
    ///
    /// # Errors
    /// [`ClientError::Late`] after `limit`.
    pub fn camera_info(&self, limit: Duration) -> Result<CameraInfo, ClientError> {
        self.until(limit, "the CameraInfo", || {
            newest(&self.camera_info).filter(|info| info.k[0] != 0.0)
        })
    }

    /// Calls ~/calibrate and waits for the answer.
    ///
    /// # Errors
    /// [`ClientError::Late`] after `limit`.
    pub fn calibrate(&self, limit: Duration) -> Result<TriggerResponse, ClientError> {
        let request = self
            .calibrate
            .send_request(TriggerRequest::default())
            .map_err(|error| ClientError::Sending {
                what: "the call of ~/calibrate",
                reason: error.to_string(),
            })?;
        self.until(limit, "the answer of ~/calibrate", || {
            match self.calibrate.receive_response() {
                Ok(Some((id, response))) if id == request => Some(response),
                // answers to other callers, or nothing yet
                _ => None,
            }
        })
    }

    /// Polls until there is a value.
    fn until<T>(
        &self,
        limit: Duration,
        what: &str,
        mut look: impl FnMut() -> Option<T>,
    ) -> Result<T, ClientError> {
        let end = Instant::now() + limit;
        loop {
            if let Some(found) = look() {
                return Ok(found);
            }
            if (self.interrupted)() {
                return Err(ClientError::Interrupted);
            }
            if Instant::now() >= end {
                return Err(ClientError::Late {
                    what: what.to_owned(),
                    limit,
                });
            }
            std::thread::sleep(POLL);
        }
    }
}

fn refused(name: &str, source: ros2_client::names::NameError) -> EntityError {
    EntityError::Refused {
        name: name.to_owned(),
        source,
    }
}

/// A subscription of what the node publishes, latched where it is latched.
fn latest<M: 'static>(
    node: &mut Node,
    topic: &str,
    (package, kind): (&str, &str),
) -> Result<Subscription<M>, ClientError> {
    let qos = if kind == "RingCentreArray" {
        qos::results()
    } else {
        qos::latched()
    };
    let kind = MessageTypeName::new(package, kind);
    let topic = node.create_topic(&dds_name(topic)?, kind, &qos)?;
    Ok(node.create_subscription(&topic, Some(qos))?)
}

/// The last message that has arrived since the last look.
fn newest<M: DeserializeOwned + 'static>(subscription: &Subscription<M>) -> Option<M> {
    let mut newest = None;
    while let Ok(Some((message, _))) = subscription.take() {
        newest = Some(message);
    }
    newest
}
