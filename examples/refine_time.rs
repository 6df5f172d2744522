//! How long the photometric fit of a board takes: `cargo run --release --example refine_time -- FRAME.png BOARD.yaml`.
//!
//! Prints one line of JSON: the median times of the whole detection and of the fit alone, ms, and the rings. benches/compare_opencv.py
//! sets them beside a Gaussian blur of the same frame.

use anyhow::{Context, Result};
use nalgebra::Point2;
use ringcal::centre::Estimator;
use ringcal::centre::photometric::{BoardPlace, BoardStart, PsfChoice, measure_board};
use ringcal::detect::{DetectOptions, Detector};
use ringcal::frame::Linear;
use ringcal::source::{read_board, read_image};
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

const RUNS: usize = 25;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let frame = arguments.next().context("no frame given")?;
    let board = arguments.next().context("no board file given")?;
    let frame = read_image(Path::new(&frame))?;
    let board = read_board(Path::new(&board))?;
    let detector = |estimator| {
        let options = DetectOptions {
            estimator,
            ..DetectOptions::default()
        };
        Detector::new(board.clone(), options)
    };
    let found = detector(Estimator::Cross).detect(&frame)?;
    let places: Vec<BoardPlace> = found
        .rings
        .iter()
        .map(|ring| BoardPlace {
            plane_m: Point2::from(board.centre_m(ring.row, ring.column)),
            outline: ring.ellipses.outer,
            sigma_px: ring.blur_sigma_px,
        })
        .collect();
    let linear = Linear::new(1.0, false);
    let start = BoardStart {
        places: &places,
        outer_radius_m: board.outer_radius_m(),
        ratio: board.radius_ratio(),
        sign: 1.0,
        psf: PsfChoice::Auto,
        camera: None,
        linear: &linear,
    };
    let refine_ms = median_ms(|| {
        black_box(measure_board(&frame, &start));
    });
    let photometric = detector(Estimator::Photometric);
    let detect_ms = median_ms(|| {
        let _ = black_box(photometric.detect(&frame));
    });
    let rings = places.len();
    println!(
        "{{\"rings\": {rings}, \"refine_ms\": {refine_ms:.4}, \"detect_ms\": {detect_ms:.4}}}"
    );
    Ok(())
}

fn median_ms(work: impl Fn()) -> f64 {
    let mut times: Vec<f64> = (0..RUNS)
        .map(|_| {
            let begin = Instant::now();
            work();
            begin.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[RUNS / 2]
}
