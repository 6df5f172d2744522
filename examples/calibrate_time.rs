//! How long a calibration takes: `cargo run --release --example calibrate_time -- POINTS BOARD.yaml WIDTH HEIGHT [ESTIMATOR]`.
//!
//! POINTS has a line `view row column x y` for each ring, px. Without an estimator the centres are points; with one, say
//! `small_ellipse`, they are what it measures of a ring, and the calibration predicts that too. Prints one line of JSON: seconds, iterations,
//! rms and the camera's parameters. benches/compare_opencv_calibrate.py sets them beside OpenCV.

use anyhow::{Context, Result};
use nalgebra::{Matrix3, Point2};
use ringcal::calibrate::{CalibrateOptions, calibrate};
use ringcal::centre::{Centre, Ellipse, RingEllipses};
use ringcal::detect::{Detection, Indices, Ring};
use ringcal::session::View;
use ringcal::source::read_board;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let mut next = |what: &str| arguments.next().with_context(|| format!("no {what} given"));
    let points = std::fs::read_to_string(next("file of points")?)?;
    let board = read_board(Path::new(&next("board file")?))?;
    let size = (next("width")?.parse()?, next("height")?.parse()?);
    let mut options = CalibrateOptions::default();
    if let Ok(estimator) = next("estimator") {
        options.estimator = estimator.parse().map_err(anyhow::Error::msg)?;
    }
    let views = views(&points, size)?;
    let begin = Instant::now();
    let calibration = calibrate(&board, &views, &options)?;
    let seconds = begin.elapsed().as_secs_f64();
    println!(
        "{{\"seconds\": {seconds}, \"views\": {}, \"iterations\": {}, \"rms_px\": {}, \"parameters\": {:?}}}",
        calibration.views_used(),
        calibration.iterations,
        calibration.rms_px,
        calibration.camera.parameters()
    );
    Ok(())
}

/// The views of the lines, by their numbers.
fn views(text: &str, size: (usize, usize)) -> Result<Vec<View>> {
    let mut rings: BTreeMap<usize, Vec<Ring>> = BTreeMap::new();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [view, row, column, x, y] = words[..] else {
            anyhow::bail!("not `view row column x y`: {line}");
        };
        let point = Point2::new(x.parse()?, y.parse()?);
        let ring = ring((row.parse()?, column.parse()?), point);
        rings.entry(view.parse()?).or_default().push(ring);
    }
    let view = |(number, rings)| View::of_file(format!("view {number}"), &detection(rings, size));
    Ok(rings.into_iter().map(view).collect())
}

/// A ring of which nothing is known but its centre.
fn ring((row, column): (u16, u16), point: Point2<f64>) -> Ring {
    let circle = |radius_px| Ellipse {
        centre: point,
        major: radius_px,
        minor: radius_px,
        angle: 0.0,
    };
    Ring {
        row,
        column,
        centre: Centre {
            point,
            covariance: None,
        },
        ellipses: RingEllipses {
            inner: circle(1.0),
            outer: circle(2.0),
        },
        blur_sigma_px: 1.0,
        kept: None,
    }
}

fn detection(rings: Vec<Ring>, (width, height): (usize, usize)) -> Detection {
    Detection {
        width,
        height,
        indices: Indices::Absolute,
        rings,
        // a calibration from points does not ask for it
        homography: Matrix3::identity(),
        photometric: None,
        another: None,
    }
}
