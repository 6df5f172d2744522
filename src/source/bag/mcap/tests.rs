use super::super::testing::{Written, frames, read, write_mcap};
use super::super::{Bag, StorageError};
use ::mcap::Compression;
use std::path::PathBuf;

const COMPRESSIONS: [Option<Compression>; 3] =
    [None, Some(Compression::Zstd), Some(Compression::Lz4)];

/// Ten frames among messages that are not to be read.
fn messages() -> Vec<Written<'static>> {
    let mut all = Vec::new();
    for frame in frames("/image", 0..10) {
        all.push(("/tf", "tf2_msgs/msg/TFMessage", vec![9; 70]));
        all.push(frame);
    }
    all
}

fn bag(compression: Option<Compression>) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    write_mcap(&path, &messages(), compression);
    (folder, path)
}

#[test]
fn every_compression_is_read_in_order() {
    for compression in COMPRESSIONS {
        let (_folder, path) = bag(compression);
        let opened = Bag::open(&path).unwrap();
        assert_eq!(opened.topics().len(), 1);
        assert_eq!(opened.topics()[0].messages, Some(10));
        let (numbers, ends) = read(&path, None);
        assert_eq!(numbers, (0..10).collect::<Vec<_>>());
        assert!(ends.is_empty());
    }
}

#[test]
fn a_file_cut_anywhere_gives_what_it_holds_and_says_so() {
    for compression in COMPRESSIONS {
        let (_folder, path) = bag(compression);
        let whole = std::fs::read(&path).unwrap();
        let mut before = 0;
        for cut in 0..whole.len() {
            std::fs::write(&path, &whole[..cut]).unwrap();
            let opened = Bag::open(&path).unwrap();
            let Ok(topic) = opened.topic(None) else {
                assert_eq!(before, 0, "cut to {cut} bytes");
                let [note] = opened.notes() else {
                    panic!("cut to {cut} bytes: {:?}", opened.notes());
                };
                assert!(note.contains("the file is cut off"), "{note}");
                continue;
            };
            let count = topic.messages.unwrap();
            let (numbers, ends) = read(&path, None);
            assert_eq!(numbers, (0..count as u8).collect::<Vec<_>>());
            assert!(count >= before, "cut to {cut} bytes");
            before = count;
            match &ends[..] {
                [end] => {
                    assert!(matches!(end.reason, StorageError::CutOff), "{end}");
                    assert_eq!(end.messages, count);
                }
                // only the summary is missing
                [] => assert_eq!(count, 10),
                _ => panic!("one file ends once"),
            }
        }
        assert_eq!(before, 10);
    }
}

#[test]
fn overwritten_bytes_never_cause_a_panic() {
    for compression in COMPRESSIONS {
        let (_folder, path) = bag(compression);
        let whole = std::fs::read(&path).unwrap();
        for at in 0..whole.len() {
            for byte in [0, 0x7f, 0xff] {
                let mut damaged = whole.clone();
                damaged[at] = byte;
                std::fs::write(&path, &damaged).unwrap();
                let opened = Bag::open(&path).unwrap();
                for topic in opened.topics() {
                    for message in opened.messages(topic).flatten() {
                        let _ = message.decode();
                    }
                }
            }
        }
    }
}

#[test]
fn a_file_that_is_compressed_as_a_whole_is_read_too() {
    let (folder, path) = bag(Some(Compression::Lz4));
    let packed = folder.path().join("b.mcap.zstd");
    let whole = ::zstd::encode_all(&*std::fs::read(&path).unwrap(), 1).unwrap();
    std::fs::write(&packed, &whole).unwrap();
    let (numbers, ends) = read(&packed, None);
    assert_eq!((numbers.len(), ends.len()), (10, 0));
    std::fs::write(&packed, &whole[..whole.len() - 20]).unwrap();
    let (_, ends) = read_any(&packed);
    assert_eq!(ends, 1);
}

/// How many messages and early ends there are, where a topic can be told at all.
fn read_any(path: &std::path::Path) -> (usize, usize) {
    let opened = Bag::open(path).unwrap();
    let topic = super::Topic {
        name: "/image".into(),
        kind: super::ImageKind::Raw,
        messages: None,
    };
    let all: Vec<_> = opened.messages(&topic).collect();
    let ends = all.iter().filter(|m| m.is_err()).count();
    (all.len() - ends, ends)
}
