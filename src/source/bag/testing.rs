//! Small bags for tests, written as recorders write them.

use super::message::tests::image;
use super::{Bag, Breakoff, ImageMessage};
use crate::frame::Pixels;
use ::mcap::{Compression, WriteOptions, records::MessageHeader};
use rusqlite::{Connection, params};
use std::collections::BTreeMap;
use std::path::Path;

/// Topic, message type and bytes.
pub(in crate::source) type Written<'a> = (&'a str, &'a str, Vec<u8>);

/// Frames of one topic: the grey value is the number of the frame.
pub(in crate::source) fn frames(topic: &str, numbers: std::ops::Range<u8>) -> Vec<Written<'_>> {
    let image = |n: u8| (topic, "sensor_msgs/msg/Image", image(i32::from(n), n));
    numbers.map(image).collect()
}

/// Writes an MCAP file with chunks of about two messages.
pub(in crate::source) fn write_mcap(
    path: &Path,
    messages: &[Written],
    compression: Option<Compression>,
) {
    let file = std::io::BufWriter::new(std::fs::File::create(path).unwrap());
    let options = WriteOptions::new()
        .compression(compression)
        .chunk_size(Some(200));
    let mut writer = options.create(file).unwrap();
    for (at, (topic, type_name, data)) in messages.iter().enumerate() {
        let schema = writer.add_schema(type_name, "ros2msg", b"").unwrap();
        let channel = writer
            .add_channel(schema, topic, "cdr", &BTreeMap::new())
            .unwrap();
        let header = MessageHeader {
            channel_id: channel,
            sequence: 0,
            log_time: 1_000_000_000 * at as u64,
            publish_time: 0,
        };
        writer.write_to_known_channel(&header, data).unwrap();
    }
    writer.finish().unwrap();
}

/// Writes a SQLite file, in the order given.
pub(in crate::source) fn write_db3(path: &Path, messages: &[Written]) -> Connection {
    let file = Connection::open(path).unwrap();
    file.execute_batch(
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, \
         serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL); \
         CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, \
         timestamp INTEGER NOT NULL, data BLOB NOT NULL); \
         CREATE INDEX timestamp_idx ON messages (timestamp ASC);",
    )
    .unwrap();
    add_rows(&file, messages);
    file
}

/// Adds messages to a SQLite file, in one transaction.
pub(super) fn add_rows(file: &Connection, messages: &[Written]) {
    file.execute_batch("BEGIN").unwrap();
    for (at, (topic, type_name, data)) in messages.iter().enumerate() {
        let (topic, type_name) = (*topic, *type_name);
        file.execute(
            "INSERT INTO topics(name, type, serialization_format, offered_qos_profiles) \
             SELECT ?1, ?2, 'cdr', '' WHERE NOT EXISTS (SELECT 1 FROM topics WHERE name = ?1)",
            [topic, type_name],
        )
        .unwrap();
        let row = "INSERT INTO messages(topic_id, timestamp, data) \
                   VALUES ((SELECT id FROM topics WHERE name = ?1), ?2, ?3)";
        let time = 1_000_000_000 * at as i64;
        file.execute(row, params![topic, time, data]).unwrap();
    }
    file.execute_batch("COMMIT").unwrap();
}

/// The number that is written in a frame, from its pixels.
pub(super) fn number(message: ImageMessage) -> u8 {
    let recorded = message.decode();
    match recorded.frame.unwrap().pixels {
        Pixels::U8(plane) => {
            assert_eq!(recorded.stamp.sec, i32::from(plane.at(0, 0)));
            plane.at(0, 0)
        }
        Pixels::U16(_) => panic!("the frames are 8 bit"),
    }
}

/// The numbers of all frames of a bag's topic, and where it ended early.
pub(super) fn read(path: &Path, topic: Option<&str>) -> (Vec<u8>, Vec<Breakoff>) {
    let bag = Bag::open(path).unwrap();
    let topic = bag.topic(topic).unwrap();
    let (mut numbers, mut ends) = (Vec::new(), Vec::new());
    for message in bag.messages(topic) {
        match message {
            Ok(message) => numbers.push(number(message)),
            Err(end) => ends.push(end),
        }
    }
    (numbers, ends)
}
