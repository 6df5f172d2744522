//! `ringcal detect` as a user runs it: the real binary on pictures without a board, which tell options apart well enough.

use image::{GrayImage, Luma};
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
