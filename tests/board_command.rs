//! `ringcal board` as a user calls it: what it writes is where the board file says, and `ringcal detect` finds it.

use ringcal::board::Board;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The most that a printed centre may be off, mm.
const MOST_OFF_MM: f64 = 0.01;

const MARKED: &str = "rows: 4\ncolumns: 5\npitch: 0.035\ninner_radius: 0.005\nouter_radius: 0.011\n\
                      polarity: light_on_dark\nmarks: [[0, 0], [0, 1], [1, 0]]\n";
const SQUARE: &str = "rows: 7\ncolumns: 7\npitch: 0.0269\ninner_radius: 0.003\nouter_radius: 0.006\n\
                      polarity: dark_on_light\n";
const SINGLE: &str =
    "rows: 1\ncolumns: 1\ninner_radius: 0.03\nouter_radius: 0.06\npolarity: dark_on_light\n";
const OBLONG: &str = "rows: 2\ncolumns: 9\npitch: 0.03\ninner_radius: 0.006\nouter_radius: 0.009\n\
                      polarity: dark_on_light\n";
const BOARDS: [&str; 4] = [MARKED, SQUARE, SINGLE, OBLONG];

fn ringcal(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ringcal"));
    command
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Writes board.yaml and prints it to a file of this name.
fn printed(folder: &Path, yaml: &str, name: &str, options: &[&str]) -> PathBuf {
    std::fs::write(folder.join("board.yaml"), yaml).unwrap();
    let mut arguments = vec!["board", "--board", "board.yaml", "--output", name];
    arguments.extend(options);
    let output = ringcal(folder, &arguments);
    assert!(output.status.success(), "{}", stderr(&output));
    folder.join(name)
}

/// Numbers before the word `end`, of lines that contain it.
fn numbers_before(text: &str, end: &str) -> Vec<Vec<f64>> {
    let lines = text.lines().filter_map(|line| line.split_once(end));
    let numbers = |part: &str| {
        part.split_whitespace()
            .filter_map(|word| word.parse().ok())
            .collect()
    };
    lines.map(|(part, _)| numbers(part)).collect()
}

/// Ring centres in a PDF as mm from the upper left corner, and the height of its page, mm.
fn pdf_centres_mm(text: &str) -> Vec<[f64; 2]> {
    let points = numbers_before(&text.replace(['[', ']'], " "), "/Contents");
    let points = text
        .split_once("/MediaBox [0 0 ")
        .map_or(points, |(_, rest)| {
            let rest = rest.split(']').next().unwrap();
            vec![rest.split(' ').map(|word| word.parse().unwrap()).collect()]
        });
    let height_mm = points[0][1] / 72.0 * 25.4;
    // the page's unit: millimetres
    let scale = numbers_before(text, " 0 0 cm")[0][0];
    assert!((scale * 25.4 / 72.0 - 1.0).abs() < 1e-9, "{scale}");
    let placed = text.lines().filter(|line| line.contains(" Do Q"));
    let centre = |line: &str| {
        let words: Vec<_> = line.split(" cm").next().unwrap().split(' ').collect();
        let [x, y] =
            [words[words.len() - 2], words[words.len() - 1]].map(|w| w.parse::<f64>().unwrap());
        [x, height_mm - y]
    };
    placed.map(centre).collect()
}

fn svg_centres_mm(text: &str) -> Vec<[f64; 2]> {
    let attribute = |line: &str, name: &str| -> f64 {
        let (_, rest) = line.split_once(&format!("{name}=\"")).unwrap();
        rest.split('"').next().unwrap().parse().unwrap()
    };
    let circles = text.lines().filter(|line| line.starts_with("<circle"));
    circles
        .map(|line| [attribute(line, "cx"), attribute(line, "cy")])
        .collect()
}

/// The centres, row by row, form the board's lattice: no fit, only the first one is where it is.
fn assert_lattice(board: &Board, centres_mm: &[[f64; 2]]) {
    assert_eq!(centres_mm.len(), board.ring_count());
    let first = centres_mm[0];
    for ((row, column), centre) in board.indices().zip(centres_mm) {
        let [x, y] = board.centre_m(row, column);
        let off = (centre[0] - first[0] - 1e3 * x).hypot(centre[1] - first[1] - 1e3 * y);
        assert!(off < 1e-3, "ring {row} {column}: {off} mm");
    }
}

#[test]
fn pdf_and_svg_have_every_centre_where_the_board_file_says() {
    let folder = tempfile::tempdir().unwrap();
    for yaml in BOARDS {
        let board = Board::from_yaml(yaml).unwrap();
        let pdf = std::fs::read(printed(folder.path(), yaml, "board.pdf", &[])).unwrap();
        let svg = std::fs::read_to_string(printed(folder.path(), yaml, "board.svg", &[])).unwrap();
        let (pdf, svg) = (
            pdf_centres_mm(&String::from_utf8_lossy(&pdf)),
            svg_centres_mm(&svg),
        );
        assert_lattice(&board, &pdf);
        assert_lattice(&board, &svg);
        // both on the same place of the paper
        let apart = (pdf[0][0] - svg[0][0]).hypot(pdf[0][1] - svg[0][1]);
        assert!(apart < 1e-3, "{apart} mm");
    }
}

#[test]
fn detect_finds_the_picture_with_its_centres_where_the_svg_has_them() {
    let folder = tempfile::tempdir().unwrap();
    // dpi that make no whole number of pixels of the paper
    for (yaml, dpi) in BOARDS.into_iter().zip(["100", "93.7", "60", "110"]) {
        let board = Board::from_yaml(yaml).unwrap();
        let svg = std::fs::read_to_string(printed(folder.path(), yaml, "board.svg", &[])).unwrap();
        let centres_mm = svg_centres_mm(&svg);
        printed(folder.path(), yaml, "board.png", &["--dpi", dpi]);
        let per_mm = 1e-3 * (dpi.parse::<f64>().unwrap() / 0.0254).round();
        let found = ringcal(
            folder.path(),
            &[
                "detect",
                "board.png",
                "--board",
                "board.yaml",
                "--format",
                "jsonl",
            ],
        );
        let line: serde_json::Value = serde_json::from_slice(&found.stdout).unwrap();
        assert_eq!(line["found"], true, "{yaml}: {}", line["reason"]);
        let points = line["points"].as_array().unwrap();
        assert_eq!(
            points.len(),
            board.ring_count() - board.marks().len(),
            "{yaml}"
        );
        for point in points {
            let at = |key: &str| point[key].as_u64().unwrap() as usize;
            let centre = centres_mm[at("row") * usize::from(board.columns()) + at("col")];
            // the middle of the first pixel is (0, 0)
            let mm = ["x", "y"].map(|key| (point[key].as_f64().unwrap() + 0.5) / per_mm);
            let off = (mm[0] - centre[0]).hypot(mm[1] - centre[1]);
            assert!(off < MOST_OFF_MM, "{yaml}: {point}: {off} mm");
        }
    }
}

#[test]
fn the_board_file_can_be_read_back_out_of_every_print() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str| {
        let bytes = std::fs::read(printed(folder.path(), MARKED, name, &["--dpi", "40"])).unwrap();
        String::from_utf8_lossy(&bytes).into_owned()
    };
    let between = |text: &str, start: &str, end: &str| {
        let (_, rest) = text.split_once(start).unwrap();
        rest.split_once(end).unwrap().0.to_owned()
    };
    let pdf = between(&read("board.pdf"), "/Subject (", ") /Creator").replace("\\n", "\n");
    let svg = between(
        &read("board.svg"),
        "<metadata id=\"ringcal-board\">",
        "</metadata>",
    );
    let png = between(&read("board.png"), "Description\0\0\0\0\0", "]]\n") + "]]";
    let board = Board::from_yaml(MARKED).unwrap();
    for yaml in [pdf, svg, png] {
        assert_eq!(Board::from_yaml(&yaml).unwrap(), board, "{yaml}");
    }
}

#[test]
fn what_cannot_be_printed_is_refused_and_nothing_written() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("board.yaml"), SQUARE).unwrap();
    let cases: [(&[&str], i32, &str); 9] = [
        (
            &["--output", "x.pdf", "--paper", "a6"],
            1,
            "--paper a4 holds it",
        ),
        (
            &["--output", "x.pdf", "--roll", "100"],
            1,
            "a roll at least",
        ),
        (&["--output", "x.png", "--dpi", "1e6"], 1, "400 million"),
        (
            &["--output", "x.png", "--dpi", "1"],
            1,
            "wider than the rings",
        ),
        (
            &["--output", "x.png", "--dpi", "-3"],
            2,
            "finite and positive",
        ),
        (&["--output", "x.pdf", "--paper", "b17"], 2, "letter"),
        (&["--output", "x.pdf", "--roll", "inf"], 2, "20 to 5000"),
        (&["--output", "x.gif"], 2, ".svg, .pdf or .png"),
        (&[], 2, "--output"),
    ];
    for (options, code, sentence) in cases {
        let mut arguments = vec!["board", "--board", "board.yaml"];
        arguments.extend(options);
        let output = ringcal(folder.path(), &arguments);
        assert_eq!(output.status.code(), Some(code), "{options:?}");
        assert!(stderr(&output).contains(sentence), "{}", stderr(&output));
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

const CAMERA: [&str; 13] = [
    "--for-camera",
    "--focal-length-mm",
    "25",
    "--pixel-um",
    "2.4",
    "--f-number",
    "4",
    "--focus-m",
    "5",
    "--distance-m",
    "0.6",
    "--frame",
    "5496x3672",
];

#[test]
fn a_board_for_a_camera_is_a_board_file_on_stdout_and_a_print() {
    let folder = tempfile::tempdir().unwrap();
    let run = |more: &[&str]| {
        let arguments: Vec<_> = ["board"]
            .iter()
            .chain(&CAMERA)
            .chain(more)
            .copied()
            .collect();
        ringcal(folder.path(), &arguments)
    };
    let output = run(&["--output", "mine.yaml"]);
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    let board = Board::from_yaml(&text).unwrap();
    assert_ne!(board.rows(), board.columns());
    assert_eq!(
        std::fs::read_to_string(folder.path().join("mine.yaml")).unwrap(),
        text
    );
    assert!(stderr(&output).contains("thin lens") && stderr(&output).contains("limit:"));
    let output = run(&["--output", "mine.svg", "--light-on-dark"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let svg = std::fs::read_to_string(folder.path().join("mine.svg")).unwrap();
    assert_lattice(&board, &svg_centres_mm(&svg));
    assert!(svg.contains("light_on_dark"));

    let change = |option: &str, value: &str| {
        let mut arguments: Vec<_> = ["board"].iter().chain(&CAMERA).copied().collect();
        let at = arguments.iter().position(|a| *a == option).unwrap() + 1;
        arguments[at] = value;
        ringcal(folder.path(), &arguments)
    };
    for (option, value, code) in [
        ("--f-number", "0.5", 1),
        ("--focus-m", "0.02", 1),
        ("--distance-m", "0.01", 1),
        ("--f-number", "0", 2),
        ("--f-number", "nan", 2),
        ("--pixel-um", "-2.4", 2),
        ("--focus-m", "inf", 2),
        ("--frame", "5496", 2),
    ] {
        let output = change(option, value);
        assert_eq!(
            output.status.code(),
            Some(code),
            "{option} {value}: {}",
            stderr(&output)
        );
        assert!(output.stdout.is_empty());
    }
    let mut without: Vec<_> = ["board"].iter().chain(&CAMERA).copied().collect();
    without.truncate(12);
    assert_eq!(ringcal(folder.path(), &without).status.code(), Some(2));
}
