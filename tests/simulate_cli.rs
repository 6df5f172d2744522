//! `ringcal simulate` as a user calls it.

use std::path::Path;
use std::process::{Command, Output};

const BOARD: &str = "rows: 3\ncolumns: 4\npitch: 0.03\ninner_radius: 0.004\nouter_radius: 0.009\n";

fn simulate(folder: &Path, output: &str, options: &[&str]) -> Output {
    let board = folder.join("board.yaml");
    std::fs::write(&board, BOARD).unwrap();
    Command::new(env!("CARGO_BIN_EXE_ringcal"))
        .arg("simulate")
        .arg("--board")
        .arg(board)
        .arg("--output")
        .arg(folder.join(output))
        .args(["--width", "320", "--height", "240"])
        .args(options)
        .output()
        .unwrap()
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn writes_frames_and_their_truth() {
    let folder = tempfile::tempdir().unwrap();
    let options = [
        "--views",
        "2",
        "--frames-per-view",
        "2",
        "--focal-px",
        "300",
        "--distortion",
        "-0.1,0.02,0.001,-0.001,0",
        "--disc-radius",
        "3",
        "--noise",
        "0.01",
        "--depth",
        "16",
        "--seed",
        "4",
    ];
    let done = simulate(folder.path(), "a", &options);
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
    let a = folder.path().join("a");
    let frames = [
        "view_000_00.png",
        "view_000_01.png",
        "view_001_00.png",
        "view_001_01.png",
    ];
    assert_eq!(
        names(&a),
        ["truth.json"]
            .iter()
            .chain(&frames)
            .copied()
            .collect::<Vec<_>>()
    );
    let lines: Vec<String> = frames
        .iter()
        .map(|f| a.join(f).display().to_string())
        .collect();
    assert_eq!(
        String::from_utf8(done.stdout)
            .unwrap()
            .lines()
            .collect::<Vec<_>>(),
        lines
    );

    let truth: serde_json::Value =
        serde_json::from_slice(&std::fs::read(a.join("truth.json")).unwrap()).unwrap();
    assert_eq!(truth["camera"]["model"], "plumb_bob");
    assert_eq!(truth["camera"]["width"], 320);
    assert_eq!(truth["camera"]["parameters"]["fx"], 300.0);
    assert_eq!(truth["camera"]["parameters"]["k1"], -0.1);
    assert_eq!(truth["views"].as_array().unwrap().len(), 4);
    for (view, frame) in truth["views"].as_array().unwrap().iter().zip(frames) {
        assert_eq!(view["source"], frame);
        assert_eq!(view["blur"]["psf"], "disc");
        assert_eq!(view["rings"].as_array().unwrap().len(), 12);
        assert_eq!(view["rings"][5]["row"], 1);
        assert_eq!(view["rings"][5]["col"], 1);
        assert_eq!(view["rings"][5]["blur_sigma"], 1.5);
    }

    let image = image::open(a.join(frames[0])).unwrap();
    assert_eq!(image.color(), image::ColorType::L16);
    let image = image.into_luma16();
    assert_eq!(image.dimensions(), (320, 240));
    // the paper shows in the middle of each ring's hole, the ring around it is darker
    let centre = &truth["views"][0]["rings"][5];
    let (x, y) = (
        centre["x"].as_f64().unwrap().round(),
        centre["y"].as_f64().unwrap().round(),
    );
    let middle = image.get_pixel(x as u32, y as u32).0[0];
    let darkest = (0..12)
        .map(|r| image.get_pixel(x as u32 + r, y as u32).0[0])
        .min()
        .unwrap();
    assert!(
        u32::from(darkest) + 10_000 < u32::from(middle),
        "{darkest} {middle}"
    );

    let again = simulate(folder.path(), "b", &options);
    assert!(again.status.success());
    let read = |run: &str, name| std::fs::read(folder.path().join(run).join(name)).unwrap();
    for name in frames {
        assert_eq!(read("a", name), read("b", name), "{name}");
    }
    assert_ne!(read("a", frames[0]), read("a", frames[1]), "noise repeats");
}

#[test]
fn nonsense_is_wrong_usage_and_leaves_nothing() {
    for options in [
        &["--blur-sigma", "-1"][..],
        &["--blur-sigma", "nan"],
        &["--blur-sigma", "2", "--disc-radius", "3"],
        &["--distortion", "0.1,0.2"],
        &["--depth", "12"],
        &["--max-tilt", "85"],
        &["--views", "0"],
        &["--f-number", "2"],
        &["--shading", "1.5"],
    ] {
        let folder = tempfile::tempdir().unwrap();
        let refused = simulate(folder.path(), "out", options);
        assert_eq!(refused.status.code(), Some(2), "{options:?}");
        assert!(!refused.stderr.is_empty());
        assert!(!folder.path().join("out").exists());
    }
}

#[test]
fn a_folder_with_frames_of_another_run_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    assert!(
        simulate(folder.path(), "out", &["--views", "3"])
            .status
            .success()
    );
    let fewer = simulate(folder.path(), "out", &["--views", "2"]);
    assert_eq!(fewer.status.code(), Some(1));
    let message = String::from_utf8(fewer.stderr).unwrap();
    assert!(message.contains("view_002.png"), "{message}");
    assert!(
        simulate(folder.path(), "out", &["--views", "3"])
            .status
            .success()
    );
}

#[test]
fn frames_are_wanted_even_where_nobody_reads_their_names() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("board.yaml"), BOARD).unwrap();
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let done = Command::new(env!("CARGO_BIN_EXE_ringcal"))
        .current_dir(folder.path())
        .args(["simulate", "--board", "board.yaml", "--output", "out"])
        .args(["--views", "2", "--width", "320", "--height", "240"])
        .stdout(writer)
        .output()
        .unwrap();
    assert_eq!(done.status.code(), Some(0));
    assert_eq!(
        names(&folder.path().join("out")),
        ["truth.json", "view_000.png", "view_001.png"]
    );
}
