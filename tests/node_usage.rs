//! What the node says and how it exits where it cannot start.

use std::process::{Command, Output};

fn node(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_ringcal"))
        .arg("node")
        .args(arguments)
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .output()
        .unwrap()
}

fn refuses(arguments: &[&str], code: i32, says: &str) {
    let output = node(arguments);
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {text}");
    assert!(text.contains(says), "{arguments:?}: {text}");
    assert!(output.stdout.is_empty());
}

#[test]
fn wrong_usage_is_exit_code_2() {
    refuses(&["image.png"], 2, "image.png");
    refuses(&["--ros-args", "--speed", "3"], 2, "--speed");
    refuses(&["--ros-args", "-r", "image"], 2, "from:=to");
    refuses(&["--ros-args", "-r", "__node:=2"], 2, "digit");
    refuses(&["--ros-args", "-p"], 2, "-p");
}

#[test]
fn what_cannot_be_done_is_exit_code_1_and_says_how_it_can() {
    refuses(&[], 1, "-p board_file:=");
    let missing = ["--ros-args", "-p", "board_file:=/no/such/board.yaml"];
    refuses(&missing, 1, "/no/such/board.yaml");
    let folder = tempfile::tempdir().unwrap();
    let board = folder.path().join("board.yaml");
    std::fs::write(&board, "rows: seven\n").unwrap();
    let broken = format!("board_file:={}", board.display());
    refuses(&["--ros-args", "-p", &broken], 1, "not a board file");
    refuses(
        &["--ros-args", "--params-file", "/no/params.yaml"],
        1,
        "/no/params.yaml",
    );
}

#[test]
fn help_says_what_can_be_given() {
    let output = node(&["--help"]);
    assert_eq!(output.status.code(), Some(0));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.contains("--params-file") && text.contains("board_file"),
        "{text}"
    );
}
