//! `ringcal calibrate`: image files, folders and bags in, camera_info.yaml, calibration.json and report.html out, and
//! the camera in other formats.
//!
//! Every file is used except those without a board, repeats of another file and frames of another size; calibration.json
//! has them all, with the reason. Of a bag the views are kept that the node would keep. A file that cannot be read does not
//! stop the others.

mod lens;
mod summary;

use super::collect::{Rules, collect};
use super::measuring::Measuring;
use super::output::print;
use super::reading::{Collecting, Reading};
use crate::calibrate::{ModelChoice, choose_model, cross_validate};
use crate::detect::Detector;
use crate::formats::{CalibrationJson, CameraFormat, CameraInfo, write_by_rename};
use crate::refine::calibrate_refined;
use crate::report::report_html;
use crate::session::SessionRules;
use crate::source::read_board;
use anyhow::Context;
use lens::LensArguments;
use std::path::{Path, PathBuf};

/// Arguments of `ringcal calibrate`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Image files, folders of them, and rosbag2 bags (MCAP, SQLite3).
    #[arg(required = true, value_name = "INPUT")]
    inputs: Vec<PathBuf>,
    /// The board file.
    #[arg(long, value_name = "FILE")]
    board: PathBuf,
    /// Folder that gets camera_info.yaml, calibration.json and report.html; made where it is missing.
    #[arg(long, value_name = "DIR")]
    output: PathBuf,
    /// Write the camera in these formats as well: ost (ost.txt), opencv (opencv.yaml), kalibr (camchain.yaml), mrcal
    /// (camera.cameramodel).
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    also: Vec<CameraFormat>,
    #[command(flatten)]
    lens: LensArguments,
    #[command(flatten)]
    measuring: Measuring,
    #[command(flatten)]
    reading: Reading,
    #[command(flatten)]
    collecting: Collecting,
    /// Name of the camera in camera_info.yaml.
    #[arg(long, value_name = "NAME", default_value = "camera")]
    camera_name: String,
}

/// Runs the command.
pub fn run(arguments: Arguments) -> anyhow::Result<()> {
    let board = read_board(&arguments.board)?;
    anyhow::ensure!(
        !board.is_single(),
        "a board of a single ring cannot calibrate a camera, at least 2 x 2 rings are needed"
    );
    if let Some(path) = arguments.inputs.iter().find(|path| !path.exists()) {
        anyhow::bail!("{}: no such file or folder", path.display());
    }
    let inputs = arguments.reading.open(&arguments.inputs)?;
    let mut options = arguments.lens.options(arguments.measuring.estimator)?;
    std::fs::create_dir_all(&arguments.output)
        .with_context(|| format!("{}: cannot be made", arguments.output.display()))?;
    let detector = Detector::new(board, arguments.measuring.options());
    let rules = Rules {
        files: Some(SessionRules::for_files()),
        stream: arguments.collecting.rules.to_calibrate(),
        options: options.clone(),
    };
    let collected = collect(&detector, inputs, &rules, arguments.collecting.quiet)?;
    let found = &collected.views;
    if arguments.lens.model() == ModelChoice::Auto {
        let chosen = choose_model(detector.board(), found, &options);
        let (model, scores) = chosen.context("no lens model fits")?;
        eprint!("{}", summary::scores(&scores));
        options.model = model;
    }
    let refined = calibrate_refined(detector.board(), found, &options);
    let (calibration, views) = refined.with_context(|| {
        let (given, usable) = (collected.frames, found.len());
        format!("no calibration from {given} inputs, {usable} of them usable")
    })?;
    let file = CalibrationJson::new(
        &arguments.camera_name,
        arguments.measuring.estimator.name(),
        &calibration,
        &views,
        &collected.outcomes,
    );
    let info = CameraInfo::new(file.camera_name.as_str(), calibration.camera);
    write_files(&arguments.output, &file, &info)?;
    let others = write_also(&arguments.output, &arguments.also, &info);
    for (view, fit) in views.iter().zip(&calibration.views) {
        if let Some(left_out) = &fit.left_out {
            eprintln!("warning: {}: left out: {left_out}", view.source);
        }
    }
    let validated = cross_validate(detector.board(), &views, &options, &calibration);
    print(&summary::summary(
        &calibration,
        &validated,
        collected.coverage(),
        collected.frames,
    ))?;
    // last, because the calibration itself is done
    others
}

fn write_files(folder: &Path, file: &CalibrationJson, info: &CameraInfo) -> anyhow::Result<()> {
    // camera_info.yaml last: where it is new, the others are too
    let files = [
        ("report.html", report_html(file)),
        ("calibration.json", file.to_json()?),
        ("camera_info.yaml", info.to_yaml()),
    ];
    for (name, text) in files {
        write_file(&folder.join(name), &text)?;
    }
    Ok(())
}

fn write_file(path: &Path, text: &str) -> anyhow::Result<()> {
    write_by_rename(path, text.as_bytes())
        .with_context(|| format!("{}: cannot be written", path.display()))?;
    eprintln!("wrote {}", path.display());
    Ok(())
}

/// Writes the formats that were asked for besides, as far as they can express the camera.
///
/// # Errors
/// Those that could not be written; the others are there.
fn write_also(folder: &Path, formats: &[CameraFormat], info: &CameraInfo) -> anyhow::Result<()> {
    let mut failed = Vec::new();
    for format in formats {
        let path = folder.join(format.file_name());
        let written = match format.write(info) {
            Ok(text) => write_file(&path, &text).map_err(|error| format!("{error:#}")),
            Err(error) => Err(format!("{} is not written: {error}", path.display())),
        };
        failed.extend(written.err());
    }
    anyhow::ensure!(failed.is_empty(), "{}", failed.join("; "));
    Ok(())
}
