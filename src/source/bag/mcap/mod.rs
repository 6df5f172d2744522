//! MCAP files, read from the start to the end: chunks are unpacked as they come, and what does not belong to the topic is
//! passed over. An index or a summary is not needed, so a file that was never finished is read as far as it goes.

mod records;
mod topics;

pub(super) use topics::topics;

use super::message::{ImageKind, ImageMessage};
use super::storage::StorageError;
use super::topic::Topic;
use ::mcap::records::Record;
use records::Records;
use std::collections::{HashMap, HashSet};
use std::io::Read;

/// The images of one topic in the order of the file.
pub(super) struct Messages<R> {
    records: Records<R>,
    channels: Channels,
    /// The channels of the topic.
    wanted: HashSet<u16>,
    topic: Topic,
}

impl<R: Read> Messages<R> {
    pub(super) fn new(source: R, topic: Topic) -> Self {
        Self {
            records: Records::new(source),
            channels: Channels::default(),
            wanted: HashSet::new(),
            topic,
        }
    }

    /// The next message; `None` after the last one of a file that is whole.
    pub(super) fn next(&mut self) -> Option<Result<ImageMessage, StorageError>> {
        let (channels, wanted, topic) = (&mut self.channels, &mut self.wanted, &self.topic);
        self.records.find(|record| {
            if let Some((id, name, kind)) = channels.learn(&record) {
                if (name, kind) == (&topic.name, topic.kind) {
                    wanted.insert(id);
                }
                return None;
            }
            match record {
                Record::Message { header, data } if wanted.contains(&header.channel_id) => {
                    Some(ImageMessage {
                        kind: topic.kind,
                        data: Ok(data.into_owned()),
                        recorded_ns: i64::try_from(header.log_time).unwrap_or(i64::MAX),
                    })
                }
                _ => None,
            }
        })
    }
}

/// What the records so far say of the message types.
#[derive(Debug, Default)]
struct Channels {
    /// The schemas that are those of images.
    schemas: HashMap<u16, ImageKind>,
}

impl Channels {
    /// Takes in a record; the channel's number, topic and messages where it announces a channel with images.
    fn learn<'a>(&mut self, record: &'a Record) -> Option<(u16, &'a str, ImageKind)> {
        match record {
            Record::Schema { header, .. } => {
                match ImageKind::of_type(&header.name) {
                    Some(kind) => self.schemas.insert(header.id, kind),
                    None => self.schemas.remove(&header.id),
                };
                None
            }
            Record::Channel(channel) if channel.message_encoding == "cdr" => {
                let kind = *self.schemas.get(&channel.schema_id)?;
                Some((channel.id, &channel.topic, kind))
            }
            _ => None,
        }
    }
}

#[cfg(test)]
pub(super) mod tests;
