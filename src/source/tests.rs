use super::bag::testing::{frames, write_db3, write_mcap};
use super::*;
use crate::frame::{Frame, Pixels, Plane, Stamp};
use image::{GrayImage, ImageFormat, Luma};
use std::fs;
use std::path::{Path, PathBuf};

fn write_grey(path: &Path, value: u8) {
    let picture = GrayImage::from_pixel(4, 3, Luma([value]));
    picture.save_with_format(path, ImageFormat::Png).unwrap();
}

/// Every frame, by its origin; warnings are no frames.
fn all(inputs: Vec<PathBuf>) -> Vec<(Origin, Result<Frame, SourceError>)> {
    let items = Inputs::open(inputs, None).unwrap().items();
    let frame = |item| match item {
        Item::Frame(recorded) => Some((recorded.origin().clone(), recorded.read())),
        Item::Warning(_) => None,
    };
    items.filter_map(frame).collect()
}

fn values(inputs: Vec<PathBuf>) -> Vec<Option<u8>> {
    let value = |(_, frame): (Origin, Result<Frame, SourceError>)| match frame.ok()?.pixels {
        Pixels::U8(plane) => Some(plane.at(0, 0)),
        Pixels::U16(_) => None,
    };
    all(inputs).into_iter().map(value).collect()
}

#[test]
fn files_and_folders_come_in_the_order_given() {
    let folder = tempfile::tempdir().unwrap();
    let views = folder.path().join("views");
    fs::create_dir(&views).unwrap();
    for (name, value) in [("view_10.png", 10), ("view_2.png", 2), ("View_3.PNG", 3)] {
        write_grey(&views.join(name), value);
    }
    fs::write(views.join("notes.txt"), "not an image").unwrap();
    fs::write(views.join(".hidden.png"), "nor this").unwrap();
    fs::create_dir(views.join("deeper.png")).unwrap();
    let last = folder.path().join("a.dat");
    write_grey(&last, 99);
    let found = values(vec![last.clone(), views, last]);
    assert_eq!(found, [99, 3, 2, 10, 99].map(Some));
}

#[test]
fn a_broken_file_does_not_stop_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    write_grey(&path("a.png"), 1);
    let whole = fs::read(path("a.png")).unwrap();
    fs::write(path("b.png"), &whole[..whole.len() / 2]).unwrap();
    fs::write(path("c.png"), "").unwrap();
    fs::write(path("d.png"), "hello").unwrap();
    write_grey(&path("f.png"), 6);
    let inputs: Vec<_> = ["a.png", "b.png", "c.png", "d.png", "e.png", "f.png"]
        .map(path)
        .into();
    let all = all(inputs.clone());
    let paths: Vec<_> = all.iter().map(|(origin, _)| origin.path.clone()).collect();
    assert_eq!(paths, inputs);
    assert!(all[0].1.is_ok() && all[5].1.is_ok());
    for (at, words) in [
        (1, "truncated PNG"),
        (2, "empty"),
        (3, "not a PNG"),
        (4, "no such file"),
    ] {
        let message = all[at].1.as_ref().unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
        assert!(
            message.contains(&*inputs[at].to_string_lossy()),
            "{message}"
        );
    }
}

#[test]
fn an_empty_folder_is_an_error_that_says_so() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("README"), "nothing here").unwrap();
    let all = all(vec![folder.path().to_owned()]);
    assert_eq!(all.len(), 1);
    let message = all[0].1.as_ref().unwrap_err().to_string();
    assert!(message.contains("no image files"), "{message}");
}

#[test]
fn sixteen_bits_and_the_path_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deep.tif");
    let picture = image::ImageBuffer::from_fn(3, 2, |x, y| Luma([(40_000 + x + 10 * y) as u16]));
    picture.save(&path).unwrap();
    let frame = read_image(&path).unwrap();
    let expected = vec![40_000, 40_001, 40_002, 40_010, 40_011, 40_012];
    assert_eq!(
        frame.pixels,
        Pixels::U16(Plane::from_vec(3, 2, expected).unwrap())
    );
    assert_eq!(frame.source, path.to_string_lossy());
    assert_eq!(frame.stamp, Stamp::default());
}

#[test]
fn pictures_and_bags_come_in_the_order_given_and_say_where_they_are_from() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    write_grey(&path("a.png"), 77);
    write_mcap(&path("b.mcap"), &frames("/image", 0..3), None);
    drop(write_db3(&path("c.db3"), &frames("/image", 3..5)));
    let inputs: Vec<PathBuf> = ["b.mcap", "a.png", "c.db3"].map(path).into();
    let opened = Inputs::open(inputs.clone(), None).unwrap();
    assert!(opened.have_bags());
    assert_eq!(opened.frame_count(), Some(6));
    assert_eq!(values(inputs.clone()), [0, 1, 2, 77, 3, 4].map(Some));
    let all = all(inputs);
    let names: Vec<String> = all.iter().map(|(origin, _)| origin.to_string()).collect();
    assert!(names[1].ends_with("b.mcap: frame 1") && names[3].ends_with("a.png"));
    let frame = all[2].1.as_ref().unwrap();
    let (sec, nanosec) = (2, 500_000_000);
    assert_eq!(
        (frame.stamp, &*frame.source),
        (Stamp { sec, nanosec }, "camera")
    );
}

#[test]
fn a_bag_that_ends_early_warns_and_the_next_input_follows() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    write_mcap(&path("a.mcap"), &frames("/image", 0..9), None);
    let whole = fs::read(path("a.mcap")).unwrap();
    fs::write(path("a.mcap"), &whole[..whole.len() / 2]).unwrap();
    write_grey(&path("b.png"), 77);
    let inputs: Vec<PathBuf> = ["a.mcap", "b.png"].map(path).into();
    let mut warnings = Vec::new();
    let mut frames = 0;
    for item in Inputs::open(inputs.clone(), None).unwrap().items() {
        match item {
            Item::Warning(text) => warnings.push((frames, text)),
            Item::Frame(_) => frames += 1,
        }
    }
    assert_eq!(warnings.len(), 1);
    let (at, text) = &warnings[0];
    assert_eq!(*at, frames - 1);
    assert!(
        text.contains("a.mcap: ends after") && text.contains("cut off"),
        "{text}"
    );
    assert_eq!(values(inputs).last(), Some(&Some(77)));
}

#[test]
fn a_bag_among_pictures_is_left_aside_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    write_grey(&folder.path().join("a.png"), 7);
    let items = |paths: &[PathBuf]| -> Vec<Item> {
        let inputs = Inputs::open(paths.to_vec(), None).unwrap();
        inputs.items().collect()
    };
    let path = folder.path().to_owned();
    assert_eq!(items(std::slice::from_ref(&path)).len(), 1);
    fs::write(path.join("drive.mcap"), "").unwrap();
    let items = items(&[path]);
    let [Item::Warning(text), Item::Frame(_)] = items.as_slice() else {
        panic!("{items:?}");
    };
    assert!(text.contains("only its pictures"), "{text}");
    assert!(text.ends_with("drive.mcap"), "{text}");
}
