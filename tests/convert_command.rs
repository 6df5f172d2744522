//! `ringcal convert` as a user runs it, and the other commands that read a camera in any format.

use std::path::Path;
use std::process::{Command, Output};

/// Without k3, so that every format can hold it.
const TRUTH: &str = r#"{"camera": {"model": "plumb_bob", "width": 640, "height": 480, "parameters": {"fx": 700.1,
    "fy": 695.2, "cx": 322.3, "cy": 236.4, "k1": -0.1, "k2": 0.02, "p1": 0.001, "p2": -0.0007, "k3": 0.0}}}"#;
const FILES: [&str; 5] = [
    "camera_info.yaml",
    "ost.txt",
    "opencv.yaml",
    "camchain.yaml",
    "camera.cameramodel",
];

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("truth.json"), TRUTH).unwrap();
    folder
}

fn ringcal(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ringcal"));
    command.current_dir(folder).args(arguments);
    command.output().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn once_around_all_formats_is_the_same_camera() {
    let folder = folder();
    let mut from = "truth.json";
    for to in FILES {
        let done = ringcal(folder.path(), &["convert", from, to]);
        assert!(done.status.success(), "{from} to {to}: {}", stderr(&done));
        from = to;
    }
    let last = ringcal(
        folder.path(),
        &["convert", from, "-", "--to", "camera_info"],
    );
    let first = std::fs::read(folder.path().join(FILES[0])).unwrap();
    assert_eq!(last.stdout, first);
}

#[test]
fn any_two_formats_compare() {
    let folder = folder();
    for to in FILES {
        ringcal(folder.path(), &["convert", "truth.json", to]);
        let arguments = [
            "check",
            "--camera-info",
            to,
            "--compare",
            "truth.json",
            "--format",
            "json",
        ];
        let done = ringcal(folder.path(), &arguments);
        assert!(done.status.success(), "{to}: {}", stderr(&done));
        let json: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
        let worst_px = json["difference"]["worst_px"].as_f64().unwrap();
        assert!(worst_px < 1e-9, "{to}: {worst_px}");
    }
}

#[test]
fn what_cannot_be_done_is_told_and_nothing_is_written() {
    let folder = folder();
    let with_k3 = TRUTH.replace("\"k3\": 0.0", "\"k3\": 0.25");
    std::fs::write(folder.path().join("k3.json"), with_k3).unwrap();
    let fails = |arguments: &[&str], code: i32, word: &str| {
        let done = ringcal(folder.path(), arguments);
        assert_eq!(done.status.code(), Some(code));
        assert!(stderr(&done).contains(word), "{}", stderr(&done));
    };
    fails(&["convert", "k3.json", "camchain.yaml"], 1, "k3 = 0.25");
    fails(&["convert", "truth.json", "front.json"], 2, "give --to");
    fails(
        &["convert", "truth.json", "a.yaml", "--to", "xml"],
        2,
        "camera_info, ost, opencv, kalibr and mrcal",
    );
    fails(&["convert", "none.json", "a.yaml"], 1, "none.json");
    fails(
        &["convert", "truth.json", "a.yaml", "--camera", "left"],
        1,
        "no camera \"left\"",
    );
    let files = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(files, 2);
}
