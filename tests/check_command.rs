//! `ringcal check` as a user runs it: what it refuses.

use std::path::Path;
use std::process::{Command, Output};

fn ringcal(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ringcal"));
    command.current_dir(folder).args(arguments);
    command.output().unwrap()
}

fn camera(folder: &Path, name: &str, size: (u32, u32)) {
    let text = format!(
        r#"{{"camera": {{"model": "plumb_bob", "width": {}, "height": {}, "parameters": {{"fx": 640.0, "fy": 640.0,
        "cx": 319.5, "cy": 239.5, "k1": -0.1, "k2": 0.02, "p1": 0.0, "p2": 0.0, "k3": 0.0}}}}}}"#,
        size.0, size.1
    );
    std::fs::write(folder.join(name), text).unwrap();
}

#[test]
fn calibrations_of_other_frame_sizes_are_not_compared() {
    let folder = tempfile::tempdir().unwrap();
    camera(folder.path(), "large.json", (1280, 960));
    camera(folder.path(), "small.json", (640, 480));
    let arguments = [
        "check",
        "--camera-info",
        "large.json",
        "--compare",
        "small.json",
    ];
    let refused = ringcal(folder.path(), &arguments);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(!refused.status.success() && refused.stdout.is_empty());
    assert!(said.contains("1280 x 960 px and 640 x 480 px"), "{said}");
}
