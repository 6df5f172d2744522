//! SQLite files (`.db3`), read row by row in the order in which they were written.
//!
//! Nothing is ever written beside the bag. A file that was cut off still has the rows before the cut: SQLite refuses it whole
//! unless the schema is said to be writable, then it reads up to the first page that is missing.

mod open;

use super::files::BagFile;
use super::message::{ImageKind, ImageMessage, LONGEST_MESSAGE, MessageError};
use super::storage::StorageError;
use super::topic::{Topic, merged};
use open::Opened;
use rusqlite::{OptionalExtension, Row, params};
use std::collections::BTreeMap;

/// The next row of a topic. The size comes first: a row that is too long is never loaded.
const NEXT: &str = "SELECT rowid, timestamp, length(data), \
     CASE WHEN length(data) <= ?3 THEN data END \
     FROM messages WHERE topic_id = ?1 AND rowid > ?2 ORDER BY rowid LIMIT 1";

/// The images of one topic.
pub(super) struct Messages {
    file: Opened,
    topic: Topic,
    /// The topic's number in the file; `None` where it is not in this file.
    id: Option<i64>,
    /// The row that was read last.
    row: i64,
    ended: bool,
}

impl Messages {
    pub(super) fn open(file: &BagFile, topic: &Topic) -> Result<Self, StorageError> {
        let file = Opened::new(file)?;
        let id = file
            .connection
            .query_row(
                "SELECT id FROM topics WHERE name = ?1 AND type = ?2",
                params![topic.name, topic.kind.type_name()],
                |row| row.get(0),
            )
            .optional()?;
        Ok(Self {
            file,
            topic: topic.clone(),
            id,
            row: i64::MIN,
            ended: false,
        })
    }

    /// The next message; `None` after the last one of a file that is whole, or after an error.
    pub(super) fn next(&mut self) -> Option<Result<ImageMessage, StorageError>> {
        if self.ended {
            return None;
        }
        match self.read() {
            Ok(Some(message)) => Some(Ok(message)),
            Ok(None) => {
                self.ended = true;
                // a compressed file that ends early may look whole to SQLite
                self.file.damage.take().map(|damage| Err(damage.into()))
            }
            Err(error) => {
                self.ended = true;
                Some(Err(self.file.explain(error)))
            }
        }
    }

    fn read(&mut self) -> rusqlite::Result<Option<ImageMessage>> {
        let Some(id) = self.id else {
            return Ok(None);
        };
        let kind = self.topic.kind;
        let read = |row: &Row| Ok((row.get(0)?, message(kind, row)?));
        let mut statement = self.file.connection.prepare(NEXT)?;
        let found = statement.query_row(params![id, self.row, LONGEST_MESSAGE as i64], read);
        Ok(found.optional()?.map(|(row, message)| {
            self.row = row;
            message
        }))
    }
}

fn message(kind: ImageKind, row: &Row) -> rusqlite::Result<ImageMessage> {
    let length: i64 = row.get(2)?;
    let data = match row.get::<_, Option<Vec<u8>>>(3)? {
        Some(data) => Ok(data),
        None => Err(MessageError::TooLong {
            bytes: length.unsigned_abs(),
        }),
    };
    Ok(ImageMessage {
        kind,
        data,
        recorded_ns: row.get(1)?,
    })
}

/// The topics with images, their messages counted as far as the file goes.
pub(super) fn topics(file: &BagFile) -> Result<Vec<Topic>, StorageError> {
    let file = Opened::new(file)?;
    let mut topics = BTreeMap::new();
    let mut statement = file
        .connection
        .prepare("SELECT id, name, type FROM topics")?;
    let mut rows = statement.query([])?;
    while let Some(row) = rows.next()? {
        let type_name: String = row.get(2)?;
        if let Some(kind) = ImageKind::of_type(&type_name) {
            let topic = Topic {
                name: row.get(1)?,
                kind,
                messages: Some(0),
            };
            topics.insert(row.get::<_, i64>(0)?, topic);
        }
    }
    // the data are not read for this: they lie on pages of their own
    let mut statement = file.connection.prepare("SELECT topic_id FROM messages")?;
    let mut rows = statement.query([])?;
    // where the file ends early is told when it is read
    let broken = loop {
        let row = match rows.next() {
            Ok(Some(row)) => row,
            Ok(None) => break false,
            Err(_) => break true,
        };
        if let Ok(id) = row.get::<_, i64>(0)
            && let Some(topic) = topics.get_mut(&id)
        {
            topic.messages = topic.messages.map(|count| count + 1);
        }
    };
    if broken {
        // none that can be reached is not none
        for topic in topics.values_mut() {
            topic.messages = topic.messages.filter(|count| *count > 0);
        }
    }
    Ok(merged(topics.into_values()))
}

#[cfg(test)]
pub(super) mod tests;
