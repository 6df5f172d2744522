//! What `ringcal calibrate` is told about the lens and the sheet.

use crate::calibrate::{CalibrateOptions, Fixed, FixedError, ModelChoice, SheetOptions};
use crate::camera::LensModel;
use crate::centre::Estimator;
use crate::source::read_camera_file;
use clap::error::ErrorKind;
use std::path::PathBuf;

/// Options of the lens.
#[derive(Debug, Clone, clap::Args)]
pub struct LensArguments {
    /// Lens model: plumb_bob, rational_polynomial, equidistant (fisheye), or auto: the one that predicts left-out views best.
    #[arg(long, value_name = "NAME", default_value = "plumb_bob")]
    model: ModelChoice,
    /// Parameters that are not estimated, by name (fx, fy, cx, cy, k1, k2, p1, p2, k3, ...), principal_point, tangential,
    /// aspect_ratio, or radial=N for the first N radial coefficients only. NAME=VALUE gives the value; without it the value is
    /// that of --guess; without that a coefficient is 0, cx and cy are the middle of the frame, fx and fy the guess without
    /// distortion.
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = fixed_entry)]
    fix: Vec<String>,
    /// As camera_calibration has it: --fix principal_point
    #[arg(long)]
    fix_principal_point: bool,
    /// As camera_calibration has it: --fix aspect_ratio (fy over fx stays that of --guess, or 1)
    #[arg(long)]
    fix_aspect_ratio: bool,
    /// As camera_calibration has it: --fix tangential
    #[arg(long)]
    zero_tangent_dist: bool,
    /// As camera_calibration has it: radial coefficients that are estimated
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=6))]
    k_coefficients: Option<u8>,
    /// Camera to start from: camera_info.yaml, or any other format that `ringcal convert` reads
    #[arg(long, value_name = "FILE")]
    guess: Option<PathBuf>,
    /// Estimate how the board is bent: curvature along the rows and along the columns.
    #[arg(long)]
    bow: bool,
    /// Estimate the ratio of the pitches along the columns and along the rows.
    #[arg(long)]
    pitch_ratio: bool,
}

fn fixed_entry(entry: &str) -> Result<String, FixedError> {
    Fixed::from_entries([entry]).map(|_| entry.to_owned())
}

fn wrong_usage(error: FixedError) -> clap::Error {
    clap::Error::raw(ErrorKind::ValueValidation, format!("--fix: {error}\n"))
}

impl LensArguments {
    /// The lens model asked for.
    pub fn model(&self) -> ModelChoice {
        self.model
    }

    /// What the calibration is told, for centres of an estimator; of a model still to be chosen, the default one.
    pub fn options(&self, estimator: Estimator) -> anyhow::Result<CalibrateOptions> {
        let entries = self.entries();
        let guess = self.guess.as_deref().map(read_camera_file).transpose()?;
        let options = CalibrateOptions {
            model: match self.model {
                ModelChoice::Fixed(model) => model,
                ModelChoice::Auto => LensModel::default(),
            },
            fixed: Fixed::from_entries(&entries).map_err(wrong_usage)?,
            guess: guess.map(|info| info.camera),
            sheet: SheetOptions {
                bow: self.bow,
                pitch_ratio: self.pitch_ratio,
            },
            estimator,
        };
        if let ModelChoice::Fixed(model) = self.model {
            options.fixed.suits(model).map_err(wrong_usage)?;
        }
        Ok(options)
    }

    /// Everything that is fixed, as for `--fix`.
    fn entries(&self) -> Vec<String> {
        let mut entries = self.fix.clone();
        let flags = [
            (self.fix_principal_point, "principal_point"),
            (self.fix_aspect_ratio, "aspect_ratio"),
            (self.zero_tangent_dist, "tangential"),
        ];
        entries.extend(flags.iter().filter(|f| f.0).map(|f| f.1.to_owned()));
        entries.extend(self.k_coefficients.map(|count| format!("radial={count}")));
        entries
    }

    /// What the user said that may have led to a refusal, where there is something, and what to do about it.
    pub fn suspects(&self) -> Option<String> {
        let entries: Vec<String> = self.entries().iter().map(|e| spaced(e)).collect();
        let held = (!entries.is_empty()).then(|| {
            format!(
                "held: {} (--fix); let it go if it may be wrong",
                entries.join(", ")
            )
        });
        let guess = self.guess.as_ref().map(|path| {
            format!(
                "started from {} (--guess); leave it out if it may be wrong",
                path.display()
            )
        });
        let told: Vec<String> = held.into_iter().chain(guess).collect();
        (!told.is_empty()).then(|| told.join("; "))
    }
}

/// `cx=1000` as `cx = 1000`.
fn spaced(entry: &str) -> String {
    match entry.split_once('=') {
        Some((name, value)) => format!("{} = {}", name.trim(), value.trim()),
        None => entry.trim().to_owned(),
    }
}
