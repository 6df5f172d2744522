//! `ringcal calibrate` as a user runs it: the real binary on pictures of a board.

use image::{GrayImage, Luma};
use nalgebra::{Point2, Rotation3, Vector3};
use ringcal::camera::{Camera, Intrinsics, PlumbBob, Pose};
use ringcal::formats::CameraInfo;
use std::path::Path;
use std::process::{Command, Output};

const BOARD: &str = "rows: 5\ncolumns: 6\npitch: 0.02\ninner_radius: 0.004\nouter_radius: 0.008\n";
const SAMPLES: usize = 3;

fn camera() -> Camera {
    Camera {
        width: 640,
        height: 480,
        intrinsics: Intrinsics {
            fx: 700.0,
            fy: 695.0,
            cx: 322.0,
            cy: 236.0,
        },
        distortion: PlumbBob {
            k1: -0.1,
            ..PlumbBob::default()
        }
        .into(),
    }
}

/// Normalised ray of every sample, `SAMPLES` x `SAMPLES` a pixel; the same for all views.
fn rays() -> Vec<Vector3<f64>> {
    let camera = camera();
    let count = SAMPLES as u32;
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(count) - 0.5;
    let mut rays = Vec::new();
    for y in 0..camera.height * count {
        for x in 0..camera.width * count {
            let ray = camera.unproject(&Point2::new(at(x), at(y))).unwrap();
            rays.push(Vector3::new(ray.x, ray.y, 1.0));
        }
    }
    rays
}

/// Dark rings on a light board.
fn picture(pose: &Pose, rays: &[Vector3<f64>]) -> GrayImage {
    let back = pose.rotation.inverse();
    let origin = back * -pose.translation_m;
    let dark = |ray: &Vector3<f64>| {
        let direction = back * ray;
        let on_board = origin - direction * (origin.z / direction.z);
        let (column, row) = ((on_board.x / 0.02).round(), (on_board.y / 0.02).round());
        let ring = (0.0..6.0).contains(&column) && (0.0..5.0).contains(&row);
        let distance = (on_board.x - column * 0.02).hypot(on_board.y - row * 0.02);
        ring && (0.004..0.008).contains(&distance)
    };
    let (width, height) = (camera().width, camera().height);
    let stride = width as usize * SAMPLES;
    GrayImage::from_fn(width, height, |x, y| {
        let first = y as usize * SAMPLES * stride + x as usize * SAMPLES;
        let count = (0..SAMPLES)
            .flat_map(|row| &rays[first + row * stride..][..SAMPLES])
            .filter(|ray| dark(ray))
            .count();
        Luma([(230.0 - 200.0 * count as f64 / (SAMPLES * SAMPLES) as f64) as u8])
    })
}

fn write_views(folder: &Path, count: u32) {
    let rays = rays();
    for i in 0..count {
        let (a, b) = (f64::from(i) * 2.4, f64::from(i % 3) - 1.0);
        let rotation = Rotation3::new(Vector3::new(0.45 * a.cos(), 0.45 * a.sin(), 0.1 * b));
        let middle = Vector3::new(0.02 * b, 0.01 * a.sin(), 0.28);
        let pose = Pose {
            rotation,
            translation_m: middle - rotation * Vector3::new(0.05, 0.04, 0.0),
        };
        picture(&pose, &rays)
            .save(folder.join(format!("view_{i}.png")))
            .unwrap();
    }
}

fn ringcal(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_ringcal"))
        .current_dir(folder)
        .arg("calibrate")
        .args(arguments)
        .output()
        .unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn pictures_of_a_board_become_three_files_with_the_true_camera() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    std::fs::write(folder.join("board.yaml"), BOARD).unwrap();
    std::fs::create_dir(folder.join("views")).unwrap();
    write_views(&folder.join("views"), 8);
    std::fs::copy(folder.join("views/view_2.png"), folder.join("copy.png")).unwrap();
    std::fs::write(folder.join("broken.png"), "no picture").unwrap();
    GrayImage::from_pixel(640, 480, Luma([128]))
        .save(folder.join("empty.png"))
        .unwrap();
    let output = ringcal(
        folder,
        &[
            "views",
            "copy.png",
            "broken.png",
            "empty.png",
            "--board",
            "board.yaml",
            "--output",
            "out/run",
            "--fix",
            "p1,p2,k2,k3",
            "--camera-name",
            "front",
        ],
    );
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let table = String::from_utf8(output.stdout.clone()).unwrap();
    assert!(table.contains("8 of 11 inputs, 240 rings"), "{table}");
    assert!(table.contains("\nverdict   "), "{table}");

    let text = std::fs::read_to_string(folder.join("out/run/camera_info.yaml")).unwrap();
    let info = CameraInfo::from_yaml(&text).unwrap();
    assert_eq!(info.camera_name, "front");
    let (found, truth) = (info.camera.intrinsics, camera().intrinsics);
    assert!((found.fx - truth.fx).abs() < 2.0, "{found:?}");
    assert!((found.fy - truth.fy).abs() < 2.0, "{found:?}");
    assert!((found.cx - truth.cx).abs() < 2.0, "{found:?}");
    assert!((found.cy - truth.cy).abs() < 2.0, "{found:?}");
    assert!((info.camera.parameters()[4] + 0.1).abs() < 0.01);

    let text = std::fs::read_to_string(folder.join("out/run/calibration.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    let unused: Vec<(&str, &str)> = json["views"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|view| view["used"] == false)
        .map(|view| {
            (
                view["source"].as_str().unwrap(),
                view["reason"].as_str().unwrap(),
            )
        })
        .collect();
    let sources: Vec<&str> = unused.iter().map(|(source, _)| *source).collect();
    assert_eq!(sources, ["copy.png", "broken.png", "empty.png"]);
    assert!(
        unused[0].1.starts_with("repeats the view views/view_2.png"),
        "{unused:?}"
    );
    assert!(json["rms_px"].as_f64().unwrap() < 0.1, "{}", json["rms_px"]);
    assert_eq!(json["std"]["k3"], 0.0);
    let page = std::fs::read_to_string(folder.join("out/run/report.html")).unwrap();
    assert!(page.contains("Calibration of front") && page.contains("8 used of 11 inputs"));
    // the views, the copy of one, and the file without a board; the broken one has no picture
    assert_eq!(page.matches("<image ").count(), 8 + 2);
    for reason in [
        "repeats the view views/view_2.png",
        "broken.png",
        "hardly any contrast",
    ] {
        assert!(page.contains(reason), "{reason}");
    }
    assert_eq!(
        std::fs::read_dir(folder.join("out/run")).unwrap().count(),
        3
    );
    let of_another_size = text_of_smaller(info);
    std::fs::write(folder.join("small.yaml"), of_another_size).unwrap();
    let rest = ["views", "--board", "board.yaml", "--output", "other"];
    for (options, words) in [
        (
            ["--fix", "cx=10000"],
            "; held: cx = 10000 (--fix); let it go if it may be wrong",
        ),
        (
            ["--guess", "small.yaml"],
            "320 x 240 px, the frames are 640 x 480 px",
        ),
    ] {
        let output = ringcal(folder, &[rest.as_slice(), &options].concat());
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains(words), "{said}");
        assert!(!folder.join("other/camera_info.yaml").exists());
    }
}

fn text_of_smaller(mut info: CameraInfo) -> String {
    (info.camera.width, info.camera.height) = (320, 240);
    info.to_yaml()
}

#[test]
fn what_cannot_be_done_says_why_and_exits_with_1_and_wrong_usage_with_2() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    std::fs::write(folder.join("board.yaml"), BOARD).unwrap();
    let single = "rows: 1\ncolumns: 1\ninner_radius: 0.05\nouter_radius: 0.1\n";
    std::fs::write(folder.join("single.yaml"), single).unwrap();
    std::fs::write(folder.join("drive.mcap"), "no MCAP").unwrap();
    write_views(folder, 2);
    let rest = ["--board", "board.yaml", "--output", "out"];
    let cases: [(&[&str], i32, &str); 16] = [
        (
            &["view_0.png", "view_1.png"],
            1,
            "2 views, at least 3 are needed",
        ),
        (&["drive.mcap"], 1, "the bag has no messages of type"),
        (&["missing.png"], 1, "missing.png: no such file"),
        (
            &["view_0.png", "--fix", "k1,k9"],
            2,
            "known are fx, fy, cx, cy, k1, k2, p1, p2, k3",
        ),
        (
            &["view_0.png", "--model", "fisheye"],
            2,
            "known are plumb_bob",
        ),
        (&["view_0.png", "--estimator", "best"], 2, "big_ellipse"),
        (&["view_0.png", "--psf", "round"], 2, "gaussian, disc"),
        (&["view_0.png", "--response-gamma", "9"], 2, "0.2 to 5"),
        (&["view_0.png", "--shape", "round"], 2, "--shape"),
        (
            &["view_0.png", "--model", "equidistant", "--fix", "p1=1"],
            2,
            "equidistant has no p1; it has fx, fy",
        ),
        (
            &["view_0.png", "--fix", "k1=0,k1=1"],
            2,
            "k1 is fixed at 0 and at 1",
        ),
        (&["view_0.png", "--fix", "radial=9"], 2, "k1, k2, k3"),
        (&["view_0.png", "--fix", "fx=-5"], 2, "more than 0 px"),
        (&["view_0.png", "--fix", "fx=inf"], 2, "NAME=NUMBER"),
        (
            &["view_0.png", "--required-rings", "31"],
            2,
            "the board has 30 rings",
        ),
        (&[], 2, "INPUT"),
    ];
    for (arguments, code, words) in cases {
        let output = ringcal(folder, &[arguments, &rest].concat());
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
        assert!(said.contains(words), "{arguments:?}: {said}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
    }
    for (board, words) in [("single.yaml", "single ring"), ("none.yaml", "none.yaml")] {
        let output = ringcal(folder, &["view_0.png", "--board", board, "--output", "out"]);
        assert_eq!(output.status.code(), Some(1));
        assert!(stderr(&output).contains(words), "{}", stderr(&output));
    }
    let kept: Vec<_> = std::fs::read_dir(folder.join("out"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    assert_eq!(kept, ["report.html"], "no camera where none was found");
    let page = std::fs::read_to_string(folder.join("out/report.html")).unwrap();
    assert!(page.contains("No calibration was made. 2 views, at least 3 are needed."));
    assert!(page.contains("Take 15 views or more"), "it says what to do");
}
