//! `ringcal check`: how well an existing calibration explains new views, and how far it is from another one.

use super::collect::{Rules, collect};
use super::measuring::Measuring;
use super::output::print;
use super::reading::{Collecting, Reading};
use crate::board::Board;
use crate::calibrate::{CalibrateOptions, Check, Difference, FIELD, FramesRead, check, difference};
use crate::camera::Camera;
use crate::detect::Detector;
use crate::formats::CheckJson;
use crate::plural::counted;
use crate::session::View;
use crate::source::{read_board, read_camera_file};
use anyhow::Context;
use std::fmt::Write;
use std::path::PathBuf;

/// Arguments of `ringcal check`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Image files, folders of them, and rosbag2 bags (MCAP, SQLite3).
    #[arg(required_unless_present = "compare", value_name = "INPUT")]
    inputs: Vec<PathBuf>,
    /// The board file.
    #[arg(
        long,
        value_name = "FILE",
        required_unless_present = "compare",
        requires = "inputs"
    )]
    board: Option<PathBuf>,
    /// The calibration that is checked: camera_info.yaml, or a camera in any other format that `ringcal convert` reads.
    #[arg(long, value_name = "FILE")]
    camera_info: PathBuf,
    /// Another calibration of the same camera: by how many pixels the two differ over the frame, once the rotation that aligns
    /// them best is taken off.
    #[arg(long, value_name = "FILE")]
    compare: Option<PathBuf>,
    #[command(flatten)]
    measuring: Measuring,
    #[command(flatten)]
    reading: Reading,
    #[command(flatten)]
    collecting: Collecting,
    /// What to print.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// Tables for people.
    Text,
    /// One object for programs.
    Json,
}

/// Runs the command.
pub fn run(arguments: Arguments) -> anyhow::Result<()> {
    let camera = read_camera_file(&arguments.camera_info)?.camera;
    let difference = match &arguments.compare {
        Some(path) => {
            let other = read_camera_file(path)?.camera;
            Some(compared(&camera, &other)?)
        }
        None => None,
    };
    let checked = match &arguments.board {
        Some(path) => {
            let board = read_board(path)?;
            Some(check_inputs(&arguments, board, &camera)?)
        }
        None => None,
    };
    let text = match arguments.format {
        Format::Json => {
            let checked = checked
                .as_ref()
                .map(|(views, check)| (views.as_slice(), check));
            CheckJson::new(checked, difference.as_ref()).to_json()?
        }
        Format::Text => {
            let mut text = String::new();
            if let Some((views, check)) = &checked {
                text += &table(views, check);
            }
            if let Some(difference) = &difference {
                text += &difference_table(difference);
            }
            text
        }
    };
    print(&text)?;
    Ok(())
}

/// How far two calibrations of one camera are apart.
fn compared(camera: &Camera, other: &Camera) -> anyhow::Result<Difference> {
    anyhow::ensure!(
        (camera.width, camera.height) == (other.width, other.height),
        "the two calibrations are of different frame sizes, {} x {} px and {} x {} px: they cannot be compared",
        camera.width,
        camera.height,
        other.width,
        other.height
    );
    difference(camera, other, FIELD)
        .context("the two calibrations have no part of the frame in common")
}

/// Finds the board in all inputs and holds what was found against the camera.
fn check_inputs(
    arguments: &Arguments,
    board: Board,
    camera: &Camera,
) -> anyhow::Result<(Vec<View>, Check)> {
    anyhow::ensure!(
        !board.is_single(),
        "a board of a single ring tells nothing about a camera, at least 2 x 2 rings are needed"
    );
    let inputs = arguments.reading.open_existing(&arguments.inputs)?;
    let measuring = arguments.measuring.options(&board)?;
    let detector = Detector::new(board, measuring);
    let rules = Rules {
        files: None,
        stream: arguments.collecting.rules.to_check(),
        options: CalibrateOptions::default(),
        pictures: false,
    };
    let collected = collect(&detector, inputs, &rules, arguments.collecting.quiet)?;
    anyhow::ensure!(
        !collected.views.is_empty(),
        no_view(collected.frames_read())
    );
    let views = collected.views;
    let checked = check(
        detector.board(),
        &views,
        camera,
        arguments.measuring.estimator,
    )?;
    Ok((views, checked))
}

/// Why there is nothing to check.
fn no_view(frames: FramesRead) -> String {
    let inputs = counted(frames.all, "input");
    match frames.with_board {
        0 => format!("the board was found in none of {inputs}"),
        boards => format!(
            "the board was found in {boards} of {inputs}, but none was kept as a view; hold it still at each place for a \
             moment, or take moving boards too with --max-motion-px 0"
        ),
    }
}

fn table(views: &[View], check: &Check) -> String {
    let mut text = format!("{}\n\n", check.verdict);
    if let Some(rms_px) = check.rms_px {
        text += &format!("rms       {rms_px:.4} px\n\n");
    }
    let width = views.iter().map(|v| v.source.chars().count()).max();
    let width = width.unwrap_or(0).clamp(6, 60);
    // writing to a String does not fail
    let _ = writeln!(text, "{:width$} {:>6} {:>10}", "source", "rings", "rms, px");
    for (view, resection) in views.iter().zip(&check.views) {
        let rings = view.rings.len();
        let _ = match &resection.fit.left_out {
            None => writeln!(
                text,
                "{:width$} {rings:>6} {:>10.4}",
                view.source, resection.fit.rms_px
            ),
            Some(left_out) => writeln!(text, "{:width$} {rings:>6} {left_out}", view.source),
        };
    }
    text += "\nmean of measured less predicted over the frame, px (x, y)\n";
    for row in check.field.chunks(FIELD.0) {
        for cell in row {
            let _ = if cell.tells() {
                write!(text, " {:>7.3},{:>7.3}", cell.bias_px.x, cell.bias_px.y)
            } else {
                write!(text, "        -       ")
            };
        }
        text.push('\n');
    }
    text
}

fn difference_table(difference: &Difference) -> String {
    let turned = difference.rotation_rad.norm().to_degrees();
    let mut text = format!(
        "\ndifference of the two calibrations at infinity, px, a rotation by {turned:.4} degrees taken off: {:.3} rms, {:.3} \
         at worst\n",
        difference.rms_px, difference.worst_px
    );
    for row in difference.offsets_px.chunks(difference.cells.0) {
        for offset in row {
            let _ = match offset {
                None => write!(text, "       -"),
                Some(offset) => write!(text, " {:>7.3}", offset.norm()),
            };
        }
        text.push('\n');
    }
    text
}
