//! What the node publishes, under which names, and whether anybody listens.

use super::messages::{
    CalibrationStatus, CameraInfo, CompressedImage, Header, Image, RingCentreArray,
};
use super::names::NameError;
use super::newcomer::Newcomer;
use super::pictures::Picture;
use super::qos;
use super::remap::Names;
use super::settings::Settings;
use ros2_client::{Context, CreateError, MessageTypeName, Name, Publisher, QosProfile};
use serde::Serialize;
use std::collections::BTreeSet;

/// Why an entity of the node cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum EntityError {
    /// Its name.
    #[error(transparent)]
    Name(#[from] NameError),
    /// A name that ROS takes and ros2-client does not.
    #[error("{name}: {source}")]
    Refused {
        /// The name.
        name: String,
        /// What ros2-client says.
        source: ros2_client::names::NameError,
    },
    /// DDS does not make it.
    #[error("DDS: {0}")]
    Dds(#[from] CreateError),
}

/// An absolute name as ros2-client has it.
pub fn dds_name(name: &str) -> Result<Name, EntityError> {
    Name::parse(name).map_err(|source| EntityError::Refused {
        name: name.to_owned(),
        source,
    })
}

/// One topic that the node publishes.
struct Outlet<M: Serialize> {
    /// Absolute name.
    topic: String,
    publisher: Publisher<M>,
}

impl<M: Serialize> Outlet<M> {
    fn open(
        newcomer: &mut Newcomer,
        names: &Names,
        name: &str,
        kind: (&str, &str),
        qos: QosProfile,
    ) -> Result<Self, EntityError> {
        let topic = names.topic(name)?;
        let kind = MessageTypeName::new(kind.0, kind.1);
        let node = newcomer.node();
        let dds_topic = node.create_topic(&dds_name(&topic)?, kind, &qos)?;
        let publisher = node.create_publisher(&dds_topic, Some(qos))?;
        Ok(Self { topic, publisher })
    }

    fn publish(&self, message: M) {
        if let Err(error) = self.publisher.publish(message) {
            // a subscriber that does not keep up: the next message will do
            tracing::debug!("{}: not sent: {}", self.topic, error.to_string());
        }
    }
}

/// A picture under two names: raw, and compressed below it.
struct PictureOutlet {
    raw: Outlet<Image>,
    compressed: Outlet<CompressedImage>,
}

impl PictureOutlet {
    fn open(node: &mut Newcomer, names: &Names, name: &str) -> Result<Self, EntityError> {
        let raw = Outlet::open(node, names, name, ("sensor_msgs", "Image"), qos::pictures())?;
        // as image_transport: the name below the topic's own, remapped or not
        let base = format!("{}/compressed", raw.topic);
        let compressed = Outlet::open(
            node,
            names,
            &base,
            ("sensor_msgs", "CompressedImage"),
            qos::pictures(),
        )?;
        Ok(Self { raw, compressed })
    }

    fn wanted(&self, listeners: &Listeners) -> bool {
        listeners.to(&self.raw.topic) || listeners.to(&self.compressed.topic)
    }

    fn publish(
        &self,
        listeners: &Listeners,
        header: &Header,
        picture: &Picture,
        settings: &Settings,
    ) {
        if listeners.to(&self.compressed.topic) {
            match picture.compressed(header.clone(), settings.jpeg_quality) {
                Ok(message) => self.compressed.publish(message),
                Err(error) => tracing::debug!("{}: {error}", self.compressed.topic),
            }
        }
        if listeners.to(&self.raw.topic)
            && let Some(message) = picture.raw(header.clone(), settings.debug_scale)
        {
            self.raw.publish(message);
        }
    }
}

/// Topics somebody subscribes, at one moment.
pub struct Listeners {
    /// Names as DDS has them.
    topics: BTreeSet<String>,
}

impl Listeners {
    /// Asks DDS. Subscriptions of this process do not count.
    pub fn now(context: &Context) -> Self {
        let readers = context.domain_participant().discovered_readers();
        let topics = readers
            .into_iter()
            .map(|reader| reader.subscription_topic_data.topic_name().clone());
        Self {
            topics: topics.collect(),
        }
    }

    fn to(&self, topic: &str) -> bool {
        self.topics.contains(&format!("rt{topic}"))
    }
}

/// Everything the node publishes.
pub struct Publishers {
    centres: Outlet<RingCentreArray>,
    status: Outlet<CalibrationStatus>,
    camera_info: Outlet<CameraInfo>,
    debug: PictureOutlet,
    enhanced: PictureOutlet,
}

impl Publishers {
    /// Makes them all.
    ///
    /// # Errors
    /// [`EntityError`] for the first that cannot be made.
    pub fn open(node: &mut Newcomer, names: &Names) -> Result<Self, EntityError> {
        Ok(Self {
            centres: Outlet::open(
                node,
                names,
                "~/centres",
                ("ringcal", "RingCentreArray"),
                qos::results(),
            )?,
            status: Outlet::open(
                node,
                names,
                "~/status",
                ("ringcal", "CalibrationStatus"),
                qos::latched(),
            )?,
            camera_info: Outlet::open(
                node,
                names,
                "~/camera_info",
                ("sensor_msgs", "CameraInfo"),
                qos::latched(),
            )?,
            debug: PictureOutlet::open(node, names, "~/debug_image")?,
            enhanced: PictureOutlet::open(node, names, "~/enhanced_image")?,
        })
    }

    /// Publishes the centres of a frame.
    pub fn centres(&self, message: RingCentreArray) {
        self.centres.publish(message);
    }

    /// Publishes the status.
    pub fn status(&self, message: CalibrationStatus) {
        self.status.publish(message);
    }

    /// Publishes the camera.
    pub fn camera_info(&self, message: CameraInfo) {
        self.camera_info.publish(message);
    }

    /// Publishes the debug picture where somebody listens; only then it is `drawn`.
    pub fn debug(
        &self,
        listeners: &Listeners,
        header: &Header,
        settings: &Settings,
        drawn: impl FnOnce() -> Option<Picture>,
    ) {
        if self.debug.wanted(listeners)
            && let Some(picture) = drawn()
        {
            self.debug.publish(listeners, header, &picture, settings);
        }
    }

    /// Publishes the enhanced frame where somebody listens; only then it is `made`.
    pub fn enhanced(
        &self,
        listeners: &Listeners,
        header: &Header,
        settings: &Settings,
        made: impl FnOnce() -> Option<Picture>,
    ) {
        if self.enhanced.wanted(listeners)
            && let Some(picture) = made()
        {
            self.enhanced.publish(listeners, header, &picture, settings);
        }
    }
}
