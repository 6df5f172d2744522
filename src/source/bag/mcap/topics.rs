//! What is on which topic of an MCAP file: from its summary, or where there is none by reading it all.

use super::records::Records;
use super::{Channels, ImageKind};
use crate::source::bag::files::BagFile;
use crate::source::bag::storage::{StorageError, mcap_source};
use crate::source::bag::topic::{Topic, merged};
use ::mcap::Summary;
use ::mcap::records::Record;
use ::mcap::sans_io::summary_reader::{SummaryReadEvent, SummaryReader, SummaryReaderOptions};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read, Seek};

/// No record of a summary is longer, bytes; message definitions and the index of a chunk are.
const LONGEST_SUMMARY_RECORD: usize = 16 << 20;

/// The topics with images.
///
/// # Errors
/// Where the file cannot be opened, or is damaged before the first image. Damaged later, it has the topics that come before.
pub(in crate::source::bag) fn topics(file: &BagFile) -> Result<Vec<Topic>, StorageError> {
    let summary = if file.packed { None } else { summary(file) };
    match summary {
        // without channels it says nothing: a writer may leave them out
        Some(summary) if !summary.channels.is_empty() => Ok(of_summary(&summary)),
        _ => counted(Records::new(mcap_source(file)?)),
    }
}

/// The summary; `None` where there is none that can be read.
fn summary(file: &BagFile) -> Option<Summary> {
    let source = File::open(&file.path).ok()?;
    let size = source.metadata().ok()?.len();
    let options = SummaryReaderOptions::default()
        .with_file_size(size)
        .with_record_length_limit(LONGEST_SUMMARY_RECORD);
    let mut source = BufReader::new(source);
    let mut reader = SummaryReader::new_with_options(options);
    while let Some(event) = reader.next_event() {
        match event.ok()? {
            SummaryReadEvent::ReadRequest(needed) => {
                let read = source.read(reader.insert(needed)).ok()?;
                reader.notify_read(read);
            }
            SummaryReadEvent::SeekRequest(to) => reader.notify_seeked(source.seek(to).ok()?),
        }
    }
    reader.finish()
}

fn of_summary(summary: &Summary) -> Vec<Topic> {
    let topics = summary.channels.values().filter_map(|channel| {
        let kind = ImageKind::of_type(&channel.schema.as_ref()?.name)?;
        let counts = summary.stats.as_ref().map(|s| &s.channel_message_counts);
        // a channel without a message may be left out of the counts
        let messages = counts.map(|counts| counts.get(&channel.id).copied().unwrap_or(0));
        (channel.message_encoding == "cdr").then(|| Topic {
            name: channel.topic.clone(),
            kind,
            messages,
        })
    });
    merged(topics)
}

/// Reads all records up to the end or the damage.
fn counted<R: Read>(mut records: Records<R>) -> Result<Vec<Topic>, StorageError> {
    let mut channels = Channels::default();
    let mut found: BTreeMap<u16, Topic> = BTreeMap::new();
    let end = records.find(|record| {
        if let Some((id, name, kind)) = channels.learn(&record) {
            found.entry(id).or_insert_with(|| Topic {
                name: name.to_owned(),
                kind,
                messages: Some(0),
            });
        } else if let Record::Message { header, .. } = record
            && let Some(topic) = found.get_mut(&header.channel_id)
        {
            topic.messages = topic.messages.map(|count| count + 1);
        }
        None::<()>
    });
    match end {
        Some(Err(error)) if found.values().all(|topic| topic.messages == Some(0)) => Err(error),
        // the reading says it again, with the place
        _ => Ok(merged(found.into_values())),
    }
}
