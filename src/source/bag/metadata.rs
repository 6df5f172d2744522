//! metadata.yaml: which files a bag has, in their order, and what is on which topic.
//!
//! Only what is needed is read, so that every version of the file will do. The recorder writes it when it ends: after a
//! crash it is missing, empty or older than the files.

use super::message::ImageKind;
use super::topic::Topic;
use crate::source::text_file::read_at_most;
use serde::Deserialize;
use std::io;
use std::path::{Path, PathBuf};

/// Its name in a bag's folder.
pub(super) const NAME: &str = "metadata.yaml";

/// No metadata.yaml is longer, bytes: message definitions and QoS profiles can be long, ten thousand files too.
const LONGEST: u64 = 16 << 20;

/// Why a metadata.yaml is of no use. Every message names the path.
#[derive(Debug, thiserror::Error)]
pub enum MetadataError {
    /// It cannot be read.
    #[error("{}: cannot be read: {reason}", path.display())]
    Unreadable {
        /// The path.
        path: PathBuf,
        /// What the operating system says.
        reason: io::Error,
    },
    /// It is longer than any.
    #[error("{}: more than {LONGEST} bytes, this describes no bag", path.display())]
    TooLong {
        /// The path.
        path: PathBuf,
    },
    /// It does not describe a bag.
    #[error("{}: does not describe a bag: {reason}", path.display())]
    Syntax {
        /// The path.
        path: PathBuf,
        /// Where it goes wrong.
        reason: String,
    },
}

/// What a metadata.yaml says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Metadata {
    /// Names of the files, without folders.
    pub(super) files: Vec<PathBuf>,
    /// The topics with images.
    pub(super) topics: Vec<Topic>,
}

#[derive(Debug, Deserialize)]
struct Root {
    rosbag2_bagfile_information: Information,
}

#[derive(Debug, Deserialize)]
struct Information {
    relative_file_paths: Option<Vec<String>>,
    topics_with_message_count: Option<Vec<TopicCount>>,
}

#[derive(Debug, Deserialize)]
struct TopicCount {
    topic_metadata: TopicMetadata,
    message_count: Option<u64>,
}

#[derive(Debug, Deserialize)]
struct TopicMetadata {
    name: String,
    #[serde(rename = "type")]
    type_name: String,
}

/// Reads the metadata.yaml of a bag's folder; `None` where there is none.
pub(super) fn read(folder: &Path) -> Result<Option<Metadata>, MetadataError> {
    let path = folder.join(NAME);
    let text = match read_at_most(&path, LONGEST) {
        Ok(Some(text)) => text,
        Ok(None) => return Err(MetadataError::TooLong { path }),
        Err(reason) if reason.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(reason) => return Err(MetadataError::Unreadable { path, reason }),
    };
    match serde_saphyr::from_str::<Root>(&text) {
        Ok(root) => Ok(Some(root.rosbag2_bagfile_information.into())),
        Err(error) => Err(MetadataError::Syntax {
            path,
            reason: error.to_string(),
        }),
    }
}

impl From<Information> for Metadata {
    fn from(information: Information) -> Self {
        let files = information.relative_file_paths.unwrap_or_default();
        let counts = information.topics_with_message_count.unwrap_or_default();
        Self {
            // early versions wrote the bag's own folder before the name, and nothing outside it is the bag's
            files: files
                .iter()
                .filter_map(|path| Path::new(path).file_name().map(PathBuf::from))
                .collect(),
            topics: counts
                .into_iter()
                .filter_map(|count| {
                    Some(Topic {
                        kind: ImageKind::of_type(&count.topic_metadata.type_name)?,
                        name: count.topic_metadata.name,
                        messages: count.message_count,
                    })
                })
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "\
rosbag2_bagfile_information:
  version: 5
  storage_identifier: sqlite3
  duration: {nanoseconds: 3000000}
  message_count: 7
  topics_with_message_count:
    - topic_metadata:
        name: /camera/image_raw
        type: sensor_msgs/msg/Image
        serialization_format: cdr
        offered_qos_profiles: \"- history: 3\\n  depth: 0\"
      message_count: 5
    - topic_metadata: {name: /tf, type: tf2_msgs/msg/TFMessage, serialization_format: cdr, offered_qos_profiles: []}
      message_count: 2
  compression_format: \"\"
  relative_file_paths: [drive/drive_0.db3, ../../drive_1.db3]
  custom_data: null
  ros_distro: humble
";

    #[test]
    fn files_and_image_topics_are_read_and_the_rest_is_not_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        assert!(read(folder.path()).unwrap().is_none());
        std::fs::write(folder.path().join(NAME), TEXT).unwrap();
        let metadata = read(folder.path()).unwrap().unwrap();
        assert_eq!(
            metadata.files,
            ["drive_0.db3", "drive_1.db3"].map(PathBuf::from)
        );
        let topic = Topic {
            name: "/camera/image_raw".into(),
            kind: ImageKind::Raw,
            messages: Some(5),
        };
        assert_eq!(metadata.topics, [topic]);
    }

    #[test]
    fn what_describes_no_bag_is_refused_with_its_path() {
        let folder = tempfile::tempdir().unwrap();
        for text in ["", "rows: 5\n", &TEXT[..300], "a: [", "\0\0\0"] {
            std::fs::write(folder.path().join(NAME), text).unwrap();
            let message = read(folder.path()).unwrap_err().to_string();
            assert!(message.contains(NAME), "{message}");
        }
    }
}
