//! `ringcal detect` as a user runs it: the real binary on pictures without a board, which tell options apart well enough.

use image::{GrayImage, Luma};
use ringcal::camera::{Camera, Intrinsics, PlumbBob};
use ringcal::formats::CameraInfo;
use std::path::Path;
use std::process::{Command, Output};

const BOARD: &str = "rows: 5\ncolumns: 6\npitch: 0.02\ninner_radius: 0.004\nouter_radius: 0.008\n";

/// A folder with a board file and two grey pictures, small.png and large.png.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let grey = |name: &str, width, height| {
        let picture = GrayImage::from_pixel(width, height, Luma([128]));
        picture.save(folder.path().join(name)).unwrap();
    };
    std::fs::write(folder.path().join("board.yaml"), BOARD).unwrap();
    grey("small.png", 160, 120);
    grey("large.png", 320, 240);
    folder
}

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ringcal"));
    command
        .current_dir(folder)
        .args(["detect", "--board", "board.yaml"])
        .args(arguments);
    command
}

fn detect(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_reader_that_has_seen_enough_ends_it_quietly() {
    let folder = folder();
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let output = command(folder.path(), &["small.png", "missing.png"])
        .stdout(writer)
        .output()
        .unwrap();
    assert_eq!(
        (output.status.code(), stderr(&output)),
        (Some(0), String::new())
    );
}

#[test]
fn blur_and_response_can_be_given() {
    let folder = folder();
    for options in [
        ["--psf", "auto", "--response-gamma", "auto"],
        ["--psf", "gaussian", "--response-gamma", "1"],
        ["--psf", "disc", "--response-gamma", "2.2"],
    ] {
        let output = detect(
            folder.path(),
            &[&["small.png"], options.as_slice()].concat(),
        );
        assert_eq!(output.status.code(), Some(0), "{options:?}");
        assert!(output.stdout.starts_with(b"small.png"), "{options:?}");
        assert_eq!(stderr(&output), "", "{options:?}");
    }
}

#[test]
fn other_values_are_wrong_usage_and_it_says_which_can_be_given() {
    let folder = folder();
    for (options, says) in [
        (["--psf", "pillbox"], "auto, gaussian, disc"),
        (["--response-gamma", "0.1"], "a number from 0.2 to 5"),
        (["--response-gamma", "-1"], "a number from 0.2 to 5"),
        (["--response-gamma", "nan"], "a number from 0.2 to 5"),
        (["--estimator", "best"], "photometric"),
        (["--required-rings", "31"], "the board has 30 rings"),
    ] {
        let output = detect(
            folder.path(),
            &[&["small.png"], options.as_slice()].concat(),
        );
        assert_eq!(output.status.code(), Some(2), "{options:?}");
        assert!(stderr(&output).contains(says), "{}", stderr(&output));
        assert!(output.stdout.is_empty(), "{options:?}");
    }
}

#[test]
fn a_camera_of_another_size_is_left_aside_with_a_warning() {
    let folder = folder();
    let camera = Camera {
        width: 160,
        height: 120,
        intrinsics: Intrinsics {
            fx: 150.0,
            fy: 150.0,
            cx: 79.5,
            cy: 59.5,
        },
        distortion: PlumbBob::default().into(),
    };
    let text = CameraInfo::new("camera", camera).to_yaml();
    std::fs::write(folder.path().join("camera_info.yaml"), text).unwrap();
    let given = [
        "small.png",
        "large.png",
        "--camera-info",
        "camera_info.yaml",
    ];
    let output = detect(folder.path(), &given);
    assert_eq!(output.status.code(), Some(0));
    let without = detect(folder.path(), &["small.png", "large.png"]);
    assert_eq!(output.stdout, without.stdout);
    assert_eq!(
        stderr(&output),
        "warning: large.png: 320 x 240 px, but the camera of --camera-info has 160 x 120 px: it is ignored here\n"
    );
}

#[test]
fn a_file_that_is_no_camera_info_ends_it_and_is_named() {
    let folder = folder();
    for (name, says) in [
        ("missing.yaml", "missing.yaml"),
        ("board.yaml", "not a camera_info file"),
    ] {
        let output = detect(folder.path(), &["small.png", "--camera-info", name]);
        assert_eq!(output.status.code(), Some(1), "{name}");
        assert!(stderr(&output).contains(says), "{}", stderr(&output));
        assert!(output.stdout.is_empty(), "{name}");
    }
}

#[test]
fn an_overlay_never_takes_the_place_of_an_input() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    std::fs::create_dir(path("c")).unwrap();
    std::fs::copy(path("small.png"), path("c/a.png")).unwrap();
    GrayImage::from_pixel(160, 120, Luma([90]))
        .save(path("c/b.bmp"))
        .unwrap();
    let before = std::fs::read(path("c/a.png")).unwrap();
    for given in [
        ["c", "--overlay", "c"],
        ["c/a.png", "--overlay", "./c/../c"],
    ] {
        let output = detect(folder.path(), &given);
        assert_eq!(output.status.code(), Some(1), "{given:?}");
        let said = stderr(&output);
        assert!(said.contains("a.png is an input"), "{said}");
        assert!(output.stdout.is_empty());
        assert_eq!(std::fs::read(path("c/a.png")).unwrap(), before);
        assert_eq!(std::fs::read_dir(path("c")).unwrap().count(), 2);
    }
    // a picture beside the image it shows, another name for another file of the same name, and again
    std::fs::copy(path("c/b.bmp"), path("b.bmp")).unwrap();
    for _ in 0..2 {
        let output = detect(folder.path(), &["c/b.bmp", "b.bmp", "--overlay", "c"]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        for name in ["c/b.png", "c/b_2.png", "c/b.bmp"] {
            assert!(path(name).exists(), "{name}");
        }
    }
    // a name that the second file of the same name would get may be an input too
    let output = detect(
        folder.path(),
        &["b.bmp", "c/b.bmp", "c/b_2.png", "--overlay", "c"],
    );
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
}
