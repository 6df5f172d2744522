use super::super::testing::{Written, add_rows, frames, number, read, write_db3};
use super::super::{Bag, StorageError};
use std::path::Path;

/// Frames among messages that are not to be read, each long enough to need several pages.
fn messages() -> Vec<Written<'static>> {
    let mut all = Vec::new();
    for (topic, type_name, data) in frames("/image", 0..40) {
        all.push(("/tf", "tf2_msgs/msg/TFMessage", vec![9; 3000]));
        // padded at the end, which no reader minds
        let mut padded = data;
        padded.resize(9000, 0);
        all.push((topic, type_name, padded));
    }
    all
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let name =
        |e: std::io::Result<std::fs::DirEntry>| e.unwrap().file_name().into_string().unwrap();
    let mut names: Vec<_> = entries.map(name).collect();
    names.sort();
    names
}

#[test]
fn rows_come_in_order_and_nothing_is_left_beside_the_bag() {
    let folder = tempfile::tempdir().unwrap();
    // a name with characters that mean something in a URI
    let path = folder.path().join("a?b #1%.db3");
    drop(write_db3(&path, &messages()));
    let opened = Bag::open(&path).unwrap();
    assert_eq!(opened.topics()[0].messages, Some(40));
    let (numbers, ends) = read(&path, None);
    assert_eq!(numbers, (0..40).collect::<Vec<_>>());
    assert!(ends.is_empty());
    assert_eq!(names(folder.path()).len(), 1);
}

#[test]
fn a_file_cut_off_gives_the_rows_before_the_cut() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.db3");
    drop(write_db3(&path, &messages()));
    let whole = std::fs::read(&path).unwrap();
    let mut least = 0;
    for cut in (100..whole.len()).step_by(1111) {
        std::fs::write(&path, &whole[..cut]).unwrap();
        let opened = Bag::open(&path).unwrap();
        let Ok(topic) = opened.topic(None) else {
            assert_eq!(least, 0, "cut to {cut} bytes");
            continue;
        };
        let mut numbers = Vec::new();
        let mut ends = Vec::new();
        for message in opened.messages(topic) {
            match message {
                Ok(message) => numbers.push(number(message)),
                Err(end) => ends.push(end),
            }
        }
        assert_eq!(numbers, (0..numbers.len() as u8).collect::<Vec<_>>());
        // a page that ends a table may be all that is missing
        if numbers.len() < 40 {
            assert_eq!(ends.len(), 1, "cut to {cut} bytes");
            assert!(
                matches!(ends[0].reason, StorageError::CutOff),
                "{}",
                ends[0]
            );
        }
        assert!(numbers.len() >= least, "cut to {cut} bytes");
        least = numbers.len();
    }
    assert!(least >= 38, "{least}");
    std::fs::write(&path, &whole[..whole.len() * 6 / 10]).unwrap();
    assert!(read(&path, None).0.len() >= 20);
}

#[test]
fn a_write_ahead_log_is_read_and_left_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.db3");
    let writer = write_db3(&path, &frames("/image", 0..3));
    writer
        .query_row("PRAGMA journal_mode = WAL", [], |_| Ok(()))
        .unwrap();
    add_rows(&writer, &frames("/image", 3..8));
    // as a recorder that is killed leaves them
    let copy = tempfile::tempdir().unwrap();
    for name in ["a.db3", "a.db3-wal"] {
        std::fs::copy(folder.path().join(name), copy.path().join(name)).unwrap();
    }
    let log = std::fs::read(copy.path().join("a.db3-wal")).unwrap();
    assert!(!log.is_empty());
    let (numbers, ends) = read(&copy.path().join("a.db3"), None);
    assert_eq!(numbers, (0..8).collect::<Vec<_>>());
    assert!(ends.is_empty());
    assert_eq!(names(copy.path()), ["a.db3", "a.db3-wal"]);
    assert_eq!(std::fs::read(copy.path().join("a.db3-wal")).unwrap(), log);
    // without its log the file has the rows from before
    std::fs::remove_file(copy.path().join("a.db3-wal")).unwrap();
    assert_eq!(read(&copy.path().join("a.db3"), None).0, [0, 1, 2]);
    assert_eq!(names(copy.path()), ["a.db3"]);
}

#[test]
fn files_and_messages_may_be_compressed() {
    let folder = tempfile::tempdir().unwrap();
    let plain = folder.path().join("a.db3");
    let packed_messages: Vec<_> = frames("/image", 0..5)
        .into_iter()
        .map(|(topic, name, data)| (topic, name, ::zstd::encode_all(&*data, 1).unwrap()))
        .collect();
    drop(write_db3(&plain, &packed_messages));
    assert_eq!(read(&plain, None).0, [0, 1, 2, 3, 4]);
    let packed = folder.path().join("b.db3.zstd");
    let whole = ::zstd::encode_all(&*std::fs::read(&plain).unwrap(), 1).unwrap();
    std::fs::write(&packed, whole).unwrap();
    assert_eq!(read(&packed, None).0, [0, 1, 2, 3, 4]);
}

#[test]
fn a_database_of_something_else_is_no_bag_and_damage_never_causes_a_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.db3");
    drop(rusqlite::Connection::open(&path).map(|c| c.execute_batch("CREATE TABLE a(b)")));
    let opened = Bag::open(&path).unwrap();
    assert!(
        opened.notes()[0].contains("no such table"),
        "{:?}",
        opened.notes()
    );
    std::fs::remove_file(&path).unwrap();
    drop(write_db3(&path, &frames("/image", 0..5)));
    let whole = std::fs::read(&path).unwrap();
    for at in (0..whole.len()).step_by(7) {
        let mut damaged = whole.clone();
        damaged[at] ^= 0xff;
        std::fs::write(&path, &damaged).unwrap();
        let Ok(opened) = Bag::open(&path) else {
            continue;
        };
        for topic in opened.topics() {
            for message in opened.messages(topic).flatten() {
                let _ = message.decode();
            }
        }
    }
}
