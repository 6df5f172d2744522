//! Which topic of a bag the frames are taken from.

use super::message::ImageKind;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A topic with images.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Topic {
    /// Its name, `/camera/image_raw`.
    pub name: String,
    /// Its messages.
    pub kind: ImageKind,
    /// How many of them the bag holds; `None` where nobody has counted them.
    pub messages: Option<u64>,
}

/// Why no topic can be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TopicError {
    /// The bag has no images.
    #[error(
        "{}: the bag has no messages of type sensor_msgs/msg/Image or sensor_msgs/msg/CompressedImage{}",
        bag.display(), notes.iter().map(|note| format!("\n  {note}")).collect::<String>()
    )]
    NoImages {
        /// The bag's path as given.
        bag: PathBuf,
        /// What is wrong with it, which may be why.
        notes: Vec<String>,
    },
    /// It has several topics with images, and none was named.
    #[error(
        "{}: the bag has {} topics with images; name one with --topic:{}",
        bag.display(), topics.len(), list(topics)
    )]
    Several {
        /// The bag's path as given.
        bag: PathBuf,
        /// The topics.
        topics: Vec<Topic>,
    },
    /// The topic that was named is not among them.
    #[error("{}: the bag has no images on the topic {wanted}; it has{}", bag.display(), list(topics))]
    Unknown {
        /// The bag's path as given.
        bag: PathBuf,
        /// The name asked for.
        wanted: String,
        /// The topics with images.
        topics: Vec<Topic>,
    },
}

fn list(topics: &[Topic]) -> String {
    let mut text = String::new();
    for topic in topics {
        let (name, kind) = (&topic.name, topic.kind.type_name());
        let _ = match topic.messages {
            Some(1) => write!(text, "\n  {name}  {kind}  1 message"),
            Some(count) => write!(text, "\n  {name}  {kind}  {count} messages"),
            None => write!(text, "\n  {name}  {kind}"),
        };
    }
    text
}

/// Joins what several files say of the same topics: counts are added, the order is that of the names.
pub(super) fn merged(topics: impl IntoIterator<Item = Topic>) -> Vec<Topic> {
    let mut all: Vec<Topic> = Vec::new();
    for topic in topics {
        let same = |other: &&mut Topic| (&other.name, other.kind) == (&topic.name, topic.kind);
        match all.iter_mut().find(same) {
            Some(known) => {
                known.messages = known
                    .messages
                    .zip(topic.messages)
                    .map(|(a, b)| a.saturating_add(b));
            }
            None => all.push(topic),
        }
    }
    all.sort();
    all
}

/// The topic that was named, or else the only one with images; topics without a message do not count.
pub(super) fn choose<'a>(
    (bag, notes): (&Path, &[String]),
    topics: &'a [Topic],
    wanted: Option<&str>,
) -> Result<&'a Topic, TopicError> {
    let (bag, notes) = (bag.to_owned(), notes.to_vec());
    let mut filled = topics.iter().filter(|topic| topic.messages != Some(0));
    if let Some(wanted) = wanted {
        // a name may be given without the slash that it begins with in a bag
        let named = |topic: &&Topic| {
            topic.name == wanted || topic.name.strip_prefix('/').is_some_and(|n| n == wanted)
        };
        let found = filled.clone().find(named);
        return found.ok_or_else(|| {
            let topics: Vec<_> = filled.cloned().collect();
            if topics.is_empty() {
                return TopicError::NoImages { bag, notes };
            }
            let wanted = wanted.to_owned();
            TopicError::Unknown {
                bag,
                wanted,
                topics,
            }
        });
    }
    match (filled.next(), filled.next()) {
        (None, _) => Err(TopicError::NoImages { bag, notes }),
        (Some(only), None) => Ok(only),
        (Some(_), Some(_)) => {
            let filled = topics.iter().filter(|topic| topic.messages != Some(0));
            let topics = filled.cloned().collect();
            Err(TopicError::Several { bag, topics })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn topic(name: &str, messages: Option<u64>) -> Topic {
        Topic {
            name: name.to_owned(),
            kind: ImageKind::Raw,
            messages,
        }
    }

    #[test]
    fn the_only_topic_is_found_and_of_several_one_must_be_named() {
        let bag = (
            Path::new("drive"),
            &["drive/a.mcap: it is cut off".to_owned()][..],
        );
        let one = [topic("/a", Some(0)), topic("/b", Some(3))];
        assert_eq!(choose(bag, &one, None).unwrap().name, "/b");
        let two = [topic("/a", Some(1)), topic("/b", None)];
        assert_eq!(choose(bag, &two, Some("/b")).unwrap().name, "/b");
        assert_eq!(choose(bag, &two, Some("b")).unwrap().name, "/b");
        let message = choose(bag, &two, None).unwrap_err().to_string();
        assert_eq!(
            message,
            "drive: the bag has 2 topics with images; name one with --topic:\
             \n  /a  sensor_msgs/msg/Image  1 message\n  /b  sensor_msgs/msg/Image"
        );
        let message = choose(bag, &two, Some("/c")).unwrap_err().to_string();
        assert!(
            message.contains("/c") && message.contains("/a"),
            "{message}"
        );
        for wanted in [None, Some("/a")] {
            let refused = choose(bag, &one[..1], wanted).unwrap_err();
            assert!(matches!(refused, TopicError::NoImages { .. }));
            assert!(refused.to_string().ends_with("a.mcap: it is cut off"));
        }
    }

    #[test]
    fn counts_of_several_files_are_added() {
        let all = merged([
            topic("/b", Some(3)),
            topic("/a", Some(1)),
            topic("/b", Some(4)),
            topic("/a", None),
        ]);
        assert_eq!(all, [topic("/a", None), topic("/b", Some(7))]);
    }
}
