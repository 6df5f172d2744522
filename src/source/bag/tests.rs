use super::testing::{frames, read, write_db3, write_mcap};
use super::{Bag, BagError, StorageError, TopicError};
use std::fs;
use std::path::Path;

const METADATA: &str = "\
rosbag2_bagfile_information:
  version: 9
  storage_identifier: mcap
  message_count: 9
  topics_with_message_count:
    - topic_metadata: {name: /image, type: sensor_msgs/msg/Image}
      message_count: 9
  relative_file_paths: [a_0.mcap, a_1.mcap, a_10.mcap]
";

/// Three files of three frames each.
fn split(folder: &Path) {
    for (name, numbers) in [("a_0", 0..3), ("a_1", 3..6), ("a_10", 6..9)] {
        let path = folder.join(name).with_extension("mcap");
        write_mcap(&path, &frames("/image", numbers), None);
    }
}

#[test]
fn a_split_bag_is_read_in_order_with_and_without_its_metadata() {
    let folder = tempfile::tempdir().unwrap();
    split(folder.path());
    let all: Vec<u8> = (0..9).collect();
    assert_eq!(read(folder.path(), None).0, all);
    // of an empty file, as a crash leaves it, nothing is believed
    for (text, notes) in [(METADATA, 0), ("", 1)] {
        fs::write(folder.path().join("metadata.yaml"), text).unwrap();
        let bag = Bag::open(folder.path()).unwrap();
        assert_eq!(
            (bag.topics()[0].messages, bag.notes().len()),
            (Some(9), notes)
        );
        assert_eq!(read(folder.path(), None).0, all);
    }
}

#[test]
fn a_damaged_or_missing_file_does_not_stop_the_next_one() {
    let folder = tempfile::tempdir().unwrap();
    split(folder.path());
    fs::write(folder.path().join("metadata.yaml"), METADATA).unwrap();
    let second = folder.path().join("a_1.mcap");
    let bytes = fs::read(&second).unwrap();
    fs::write(&second, &bytes[..bytes.len() / 3]).unwrap();
    let (numbers, ends) = read(folder.path(), None);
    assert!(numbers.starts_with(&[0, 1, 2]) && numbers.ends_with(&[6, 7, 8]));
    assert_eq!(ends.len(), 1);
    assert_eq!(ends[0].file, second);
    fs::remove_file(&second).unwrap();
    let bag = Bag::open(folder.path()).unwrap();
    assert!(bag.notes()[0].contains("a_1.mcap"), "{:?}", bag.notes());
    assert_eq!(read(folder.path(), None).0, [0, 1, 2, 6, 7, 8]);
    // a file that is empty from a crash
    fs::write(&second, "").unwrap();
    let (numbers, ends) = read(folder.path(), None);
    assert_eq!((numbers.len(), ends.len()), (6, 1));
    assert!(matches!(ends[0].reason, StorageError::CutOff));
    assert!(ends[0].to_string().starts_with("no frame could be read"));
}

#[test]
fn both_kinds_of_file_name_their_topics() {
    let folder = tempfile::tempdir().unwrap();
    let mut messages = frames("/left", 0..3);
    messages.extend(frames("/right", 3..5));
    let (mcap, db3) = (folder.path().join("a.mcap"), folder.path().join("b.db3"));
    write_mcap(&mcap, &messages, None);
    drop(write_db3(&db3, &messages));
    for path in [mcap, db3] {
        let bag = Bag::open(&path).unwrap();
        let counts: Vec<_> = bag
            .topics()
            .iter()
            .map(|t| (&*t.name, t.messages))
            .collect();
        assert_eq!(counts, [("/left", Some(3)), ("/right", Some(2))]);
        assert!(matches!(bag.topic(None), Err(TopicError::Several { .. })));
        assert_eq!(read(&path, Some("/right")).0, [3, 4]);
    }
}

#[test]
fn what_is_no_bag_is_an_error_with_its_path() {
    let folder = tempfile::tempdir().unwrap();
    let refused = Bag::open(folder.path()).unwrap_err();
    assert!(matches!(refused, BagError::NoFiles { .. }));
    fs::write(folder.path().join("a.txt"), "hello").unwrap();
    for name in ["a.txt", "none"] {
        let message = Bag::open(&folder.path().join(name))
            .unwrap_err()
            .to_string();
        assert!(message.contains(name), "{message}");
    }
    let path = folder.path().join("a.mcap");
    fs::write(&path, "no MCAP at all").unwrap();
    let bag = Bag::open(&path).unwrap();
    assert!(matches!(bag.topic(None), Err(TopicError::NoImages { .. })));
}
