//! `ringcal calibrate`: image files, folders and bags in, camera_info.yaml, calibration.json and report.html out,
//! and the camera in other formats.
//!
//! Every file is used except those without a board, repeats of another file and frames of another size; calibration.json
//! has them all, with the reason. Of a bag the views are kept that the node would keep. A file that cannot be read does not
//! stop the others. Where the views do not give a calibration, report.html alone is written: it says what is missing.

mod lens;
mod output;
mod summary;

use super::collect::{Collected, Rules, collect};
use super::measuring::Measuring;
use super::output::print;
use super::reading::{Collecting, Reading};
use crate::board::Board;
use crate::calibrate::{
    Assessment, CalibrateError, CalibrateOptions, Calibration, CrossValidation, Facts, Grade,
    ModelChoice, Rule, assess, cross_validate, refused,
};
use crate::detect::Detector;
use crate::formats::{CalibrationJson, CameraFormat, CameraInfo};
use crate::plural::counted;
use crate::refine::{Chosen, calibrate_chosen};
use crate::report::{Report, Solved, report_html};
use crate::session::{SessionRules, View};
use crate::source::read_board;
use anyhow::Context;
use lens::LensArguments;
use std::path::PathBuf;

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
    let inputs = arguments.reading.open_existing(&arguments.inputs)?;
    let options = arguments.lens.options(arguments.measuring.estimator)?;
    let measuring = arguments.measuring.options(&board)?;
    std::fs::create_dir_all(&arguments.output)
        .with_context(|| format!("{}: cannot be made", arguments.output.display()))?;
    let detector = Detector::new(board, measuring);
    let rules = Rules {
        files: Some(SessionRules::for_files()),
        stream: arguments.collecting.rules.to_calibrate(),
        options: options.clone(),
        pictures: true,
    };
    let collected = collect(&detector, inputs, &rules, arguments.collecting.quiet)?;
    let board = detector.board();
    match solve(board, &collected.views, options, arguments.lens.model()) {
        Ok(result) => arguments.conclude(board, &collected, &result),
        Err(error) => arguments.refuse(board, &collected, error),
    }
}

/// A calibration and what it comes from.
struct CalibrationOfViews {
    calibration: Calibration,
    /// The views with their centres found again.
    views: Vec<View>,
    validated: Result<CrossValidation, CalibrateError>,
}

fn solve(
    board: &Board,
    found: &[View],
    mut options: CalibrateOptions,
    model: ModelChoice,
) -> Result<CalibrationOfViews, CalibrateError> {
    let Chosen {
        calibration,
        views,
        scores,
    } = calibrate_chosen(board, found, (&options, model))?;
    eprint!("{}", summary::scores(&scores));
    options.model = calibration.camera.model();
    let validated = cross_validate(board, &views, &options, &calibration);
    Ok(CalibrationOfViews {
        calibration,
        views,
        validated,
    })
}

impl Arguments {
    /// Writes the files of a calibration and prints its summary.
    fn conclude(
        &self,
        board: &Board,
        collected: &Collected,
        result: &CalibrationOfViews,
    ) -> anyhow::Result<()> {
        let CalibrationOfViews {
            calibration,
            views,
            validated,
        } = result;
        let estimator = self.measuring.estimator.name();
        let facts = Facts::of(calibration, views, validated.as_ref());
        let mut assessment = assess(&facts);
        let misfit = assessment.criteria.iter();
        if misfit
            .filter(|c| c.rule == Rule::Misfit)
            .any(|c| c.grade > Grade::Good)
        {
            // before the board and the lens are doubted
            let suspects = self.lens.suspects().map(|text| sentence(&text));
            assessment.advice.splice(0..0, suspects);
        }
        let file = CalibrationJson::new(
            &self.camera_name,
            estimator,
            calibration,
            views,
            &collected.outcomes,
        );
        let page = report_html(&Report {
            views,
            solved: Some(Solved {
                calibration,
                validated: validated.as_ref().ok(),
            }),
            ..self.report_of(board, collected, &assessment)
        });
        let info = CameraInfo::new(file.camera_name.as_str(), calibration.camera);
        output::write_calibration(&self.output, page, &file, &info)?;
        let others = output::write_also(&self.output, &self.also, &info);
        for (view, fit) in views.iter().zip(&calibration.views) {
            if let Some(left_out) = &fit.left_out {
                eprintln!("warning: {}: left out: {left_out}", view.source);
            }
        }
        print(&summary::summary(
            calibration,
            (validated, &assessment),
            collected.coverage(),
            collected.frames,
        ))?;
        // last, because the calibration itself is done
        others
    }

    /// Writes the report of views that gave no calibration, and hands on why.
    fn refuse(
        &self,
        board: &Board,
        collected: &Collected,
        error: CalibrateError,
    ) -> anyhow::Result<()> {
        let mut assessment = refused(&error, collected.frames_read());
        let suspects = self.lens.suspects().filter(|_| error.may_be_the_options());
        if let Some(text) = &suspects {
            assessment.advice.insert(0, sentence(text));
        }
        let page = report_html(&self.report_of(board, collected, &assessment));
        // what the views lack matters more than a page that cannot be written
        if let Err(failed) = output::write_refusal(&self.output, &page) {
            eprintln!("warning: {failed:#}");
        }
        let (given, usable) = (collected.frames, collected.views.len());
        let given = counted(given, "input");
        let error = match suspects {
            Some(text) => anyhow::anyhow!("{error}; {text}"),
            None => error.into(),
        };
        Err(error).with_context(|| format!("no calibration from {given}, {usable} of them usable"))
    }

    /// A report without a calibration.
    fn report_of<'a>(
        &'a self,
        board: &'a Board,
        collected: &'a Collected,
        assessment: &'a Assessment,
    ) -> Report<'a> {
        Report {
            camera_name: &self.camera_name,
            estimator: self.measuring.estimator.name(),
            board,
            inputs: collected.frames,
            views: &collected.views,
            outcomes: &collected.outcomes,
            passed_over: &collected.passed_over,
            pictures: &collected.pictures,
            assessment,
            solved: None,
        }
    }
}

fn sentence(text: &str) -> String {
    let (first, rest) = text.split_at(1);
    format!("{}{rest}.", first.to_uppercase())
}
