//! `ringcal calibrate`: image files and folders in, camera_info.yaml, calibration.json and report.html out.
//!
//! Every file is used except those without a board, repeats of another file and frames of another size; calibration.json
//! has them all, with the reason. A file that cannot be read does not stop the others.

mod lens;
mod summary;

use super::measuring::Measuring;
use super::output::print;
use crate::calibrate::{ModelChoice, choose_model, cross_validate};
use crate::camera::Camera;
use crate::detect::{Detection, Detector};
use crate::formats::{CalibrationJson, CameraInfo, Outcome, write_by_rename};
use crate::frame::Frame;
use crate::refine::calibrate_refined;
use crate::report::report_html;
use crate::session::{Session, SessionRules, View};
use crate::source::{self, read_board};
use anyhow::Context;
use lens::LensArguments;
use rayon::prelude::*;
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// Arguments of `ringcal calibrate`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Image files, and folders of them.
    #[arg(required = true, value_name = "INPUT")]
    inputs: Vec<PathBuf>,
    /// The board file.
    #[arg(long, value_name = "FILE")]
    board: PathBuf,
    /// Folder that gets camera_info.yaml, calibration.json and report.html; made where it is missing.
    #[arg(long, value_name = "DIR")]
    output: PathBuf,
    #[command(flatten)]
    lens: LensArguments,
    #[command(flatten)]
    measuring: Measuring,
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
    if let Some(bag) = arguments.inputs.iter().find(|path| is_bag(path)) {
        anyhow::bail!(
            "{}: rosbag2 bags are not read in this version, only image files and folders",
            bag.display()
        );
    }
    if let Some(path) = arguments.inputs.iter().find(|path| !path.exists()) {
        anyhow::bail!("{}: no such file or folder", path.display());
    }
    let mut options = arguments.lens.options(arguments.measuring.estimator)?;
    std::fs::create_dir_all(&arguments.output)
        .with_context(|| format!("{}: cannot be made", arguments.output.display()))?;
    let frames = source::frames(arguments.inputs)
        .map(|recorded| (recorded.path.to_string_lossy().into_owned(), recorded.frame));
    let detector = Detector::new(board, arguments.measuring.options());
    let collected = collect(&detector, frames);
    let found = collected.session.views();
    if arguments.lens.model() == ModelChoice::Auto {
        let chosen = choose_model(detector.board(), found, &options);
        let (model, scores) = chosen.context("no lens model fits")?;
        eprint!("{}", summary::scores(&scores));
        options.model = model;
    }
    let refined = calibrate_refined(detector.board(), found, &options);
    let (calibration, views) = refined.with_context(|| {
        let given = collected.outcomes.len();
        format!(
            "no calibration from {given} inputs, {} of them usable",
            found.len()
        )
    })?;
    let file = CalibrationJson::new(
        &arguments.camera_name,
        arguments.measuring.estimator.name(),
        &calibration,
        &views,
        &collected.outcomes,
    );
    write_files(&arguments.output, &file, calibration.camera)?;
    for (view, fit) in views.iter().zip(&calibration.views) {
        if let Some(left_out) = &fit.left_out {
            eprintln!("warning: {}: left out: {left_out}", view.source);
        }
    }
    let validated = cross_validate(detector.board(), &views, &options, &calibration);
    print(&summary::summary(
        &calibration,
        &validated,
        &collected.session,
        collected.outcomes.len(),
    ))?;
    Ok(())
}

/// By name alone, so that a bag is told from a broken picture before anything is opened.
fn is_bag(path: &Path) -> bool {
    let name = path.to_string_lossy().to_ascii_lowercase();
    let name = name.strip_suffix(".zstd").unwrap_or(&name);
    name.ends_with(".mcap") || name.ends_with(".db3") || path.join("metadata.yaml").is_file()
}

/// The views of a run and what became of every input.
struct Collected {
    session: Session,
    outcomes: Vec<Outcome>,
}

/// Looks for the board in all frames, as many at a time as there are threads, so that memory does not grow with the number
/// of files; offers them to a session in their order.
fn collect<E: Display + Send>(
    detector: &Detector,
    frames: impl Iterator<Item = (String, Result<Frame, E>)>,
) -> Collected {
    let mut all = Vec::new();
    let mut frames = frames.peekable();
    while frames.peek().is_some() {
        let batch: Vec<_> = frames.by_ref().take(rayon::current_num_threads()).collect();
        let found: Vec<(String, Result<Detection, String>)> = batch
            .into_par_iter()
            .map(|(source, frame)| {
                let detection = frame
                    .map_err(|error| error.to_string())
                    .and_then(|frame| detector.detect(&frame).map_err(|miss| miss.to_string()));
                (source, detection)
            })
            .collect();
        for (source, detection) in &found {
            if let Ok(detection) = detection {
                let (rings, blur) = (detection.rings.len(), detection.blur_sigma_px());
                eprintln!("{source}: {rings} rings, blur {blur:.1} px");
            }
        }
        all.extend(found);
    }
    let mut collected = Collected {
        session: Session::new(detector.board().clone(), SessionRules::for_files()),
        outcomes: Vec::new(),
    };
    let size = most_common_size(&all);
    for (source, detection) in all {
        collected.add(source, detection, size);
    }
    collected
}

/// Width and height, px, of most of the frames with a board, so that a stray picture decides nothing; of the first of them
/// where two are equally common.
fn most_common_size(found: &[(String, Result<Detection, String>)]) -> (usize, usize) {
    let mut counts: Vec<((usize, usize), usize)> = Vec::new();
    for detection in found.iter().filter_map(|(_, found)| found.as_ref().ok()) {
        let size = (detection.width, detection.height);
        match counts.iter_mut().find(|(other, _)| *other == size) {
            Some((_, count)) => *count += 1,
            None => counts.push((size, 1)),
        }
    }
    let most = counts.iter().rev().max_by_key(|(_, count)| *count);
    most.map_or((0, 0), |(size, _)| *size)
}

impl Collected {
    /// Takes in one frame; frames of another size than `size` are not of the same camera.
    fn add(&mut self, source: String, detection: Result<Detection, String>, size: (usize, usize)) {
        let at = self.session.views().len();
        let outcome = match detection {
            Err(reason) => {
                // the file's name stands before the reason already
                let bare = reason.strip_prefix(&format!("{source}: "));
                let reason = bare.map_or_else(|| reason.clone(), str::to_owned);
                Outcome::NotUsed { source, reason }
            }
            Ok(detection) if (detection.width, detection.height) != size => Outcome::NotUsed {
                reason: format!(
                    "{} x {} px, but most frames are {} x {} px: not of the same camera",
                    detection.width, detection.height, size.0, size.1
                ),
                source,
            },
            Ok(detection) => {
                let offer = self
                    .session
                    .offer(View::of_file(source.as_str(), &detection));
                if offer.kept() {
                    Outcome::Used(at)
                } else {
                    let reason = offer.to_string();
                    Outcome::NotUsed { source, reason }
                }
            }
        };
        if let Outcome::NotUsed { source, reason } = &outcome {
            eprintln!("{source}: not used: {reason}");
        }
        self.outcomes.push(outcome);
    }
}

fn write_files(folder: &Path, file: &CalibrationJson, camera: Camera) -> anyhow::Result<()> {
    let info = CameraInfo::new(file.camera_name.as_str(), camera);
    // camera_info.yaml last: where it is new, the others are too
    let files = [
        ("report.html", report_html(file)),
        ("calibration.json", file.to_json()?),
        ("camera_info.yaml", info.to_yaml()),
    ];
    for (name, text) in files {
        let path = folder.join(name);
        write_by_rename(&path, text.as_bytes())
            .with_context(|| format!("{}: cannot be written", path.display()))?;
        eprintln!("wrote {}", path.display());
    }
    Ok(())
}
