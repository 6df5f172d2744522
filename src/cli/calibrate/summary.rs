//! The tables of `ringcal calibrate`.

use crate::calibrate::{
    Assessment, CalibrateError, Calibration, CrossValidation, ModelScore, Range,
};
use crate::plural::counted;

/// The result, for stdout.
pub fn summary(
    calibration: &Calibration,
    (validated, assessment): (&Result<CrossValidation, CalibrateError>, &Assessment),
    coverage: f64,
    inputs: u64,
) -> String {
    let camera = &calibration.camera;
    let used = || calibration.views.iter().filter(|view| view.used());
    let rings: usize = used()
        .map(|v| v.rings_used.len() - v.rings_left_out())
        .sum();
    let out: usize = used().map(|view| view.rings_left_out()).sum();
    let mut text = format!(
        "camera    {} x {} px, {}\nviews     {} of {}, {}, {out} left out\n\
         coverage  {:.0} % of the frame\nrms       {:.4} px\n",
        camera.width,
        camera.height,
        camera.model(),
        calibration.views_used(),
        counted(inputs, "input"),
        counted(rings, "ring"),
        100.0 * coverage,
        calibration.rms_px,
    );
    text += &match validated {
        Ok(validated) => format!(
            "          {:.4} px on views left out ({} parts)\n",
            validated.rms_px, validated.folds
        ),
        Err(error) => format!("          not cross-validated: {error}\n"),
    };
    text += &uncertainty(calibration);
    for rival in &calibration.rivals {
        text += &format!(
            "lens      {} explains the views as well; the standard deviations cover what it says otherwise\n",
            rival.camera.model()
        );
    }
    text += &format!("verdict   {assessment}\n");
    for advice in &assessment.advice {
        text += &format!("          {advice}\n");
    }
    text += &format!("\n{:4} {:>16} {:>14}\n", "name", "value", "std");
    let stds = calibration.stds();
    let numbers = calibration.values().into_iter().zip(stds);
    for (at, (name, (value, std))) in calibration.names.iter().zip(numbers).enumerate() {
        let digits = if at < 4 { 4 } else { 7 };
        let std = if calibration.fixed.contains(name) {
            "fixed".to_owned()
        } else {
            format!("{std:.digits$}")
        };
        text += &format!("{name:4} {value:>16.digits$} {std:>14}\n");
    }
    text
}

/// How certain it is where things are seen.
fn uncertainty(calibration: &Calibration) -> String {
    let distance_m = calibration.typical_distance_m();
    let of = |range| {
        let mut told: Vec<f64> = calibration
            .projection_std_map((10, 10), range)
            .into_iter()
            .flatten()
            .collect();
        told.sort_by(f64::total_cmp);
        let worst = told.last().copied().unwrap_or(f64::NAN);
        (told.get(told.len() / 2).copied().unwrap_or(f64::NAN), worst)
    };
    let (far, near) = (of(Range::Infinity), of(Range::At(distance_m)));
    format!(
        "certain   to {:.3} px at infinity ({:.3} at worst), {:.3} px at {distance_m:.2} m ({:.3})\n",
        far.0, far.1, near.0, near.1
    )
}

/// What became of each lens model, for stderr.
pub fn scores(scores: &[ModelScore]) -> String {
    let line = |score: &ModelScore| match &score.rms_px {
        Ok(rms_px) => format!("{}: {rms_px:.4} px on views left out\n", score.model),
        Err(error) => format!("{}: {error}\n", score.model),
    };
    scores.iter().map(line).collect()
}
