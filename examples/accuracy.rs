//! The accuracy table: every estimator against the simulator's truth, over blur kind and size, tilt, noise, light,
//! polarity, ring size and distortion. Run it before and after every change of detection or estimation:
//! `cargo run --release --example accuracy`.
//!
//! A cell is the root mean square distance of the centres from the truth in px over all rings of all boards of its row;
//! a board that is not found counts each of its rings as an error of 1 px.

use anyhow::Result;
use ringcal::board::{Board, Polarity};
use ringcal::camera::{Camera, Intrinsics, PlumbBob};
use ringcal::centre::Estimator;
use ringcal::detect::{DetectOptions, Detector};
use ringcal::frame::Frame;
use ringcal::simulate::{BitDepth, Defocus, Light, Scene, Truth, render, views};

/// What a ring that is not found counts, px.
const MISS_PX: f64 = 1.0;
/// Boards of each kind in a row of the table.
const BOARDS: usize = 3;
/// Tilts up to this, degrees.
const MAX_TILT_DEGREES: f64 = 40.0;

fn main() -> Result<()> {
    println!(
        "radial rmse of the centres, px; {} boards a row, tilts to {MAX_TILT_DEGREES} degrees",
        BOARDS * kinds()?.len()
    );
    print!("{:<22}{:>7}", "blur", "missed");
    for estimator in Estimator::ALL {
        print!("{:>15}", estimator.name());
    }
    println!();
    for (name, defocus) in blurs() {
        let row = Row::measure(defocus)?;
        print!("{name:<22}{:>7}", row.missed);
        for rms_px in row.rms_px {
            print!("{rms_px:>15.4}");
        }
        println!();
    }
    Ok(())
}

fn blurs() -> Vec<(String, Defocus)> {
    let gaussian = [0.0, 1.0, 2.0, 4.0, 6.0, 8.0, 10.0];
    let disc = [2.0, 4.0, 8.0, 12.0];
    let gaussian = gaussian.map(|s| (format!("gaussian sigma {s:>4} px"), Defocus::gaussian(s)));
    let disc = disc.map(|r| (format!("disc radius    {r:>4} px"), Defocus::disc(r)));
    gaussian.into_iter().chain(disc).collect()
}

/// Boards, lenses, light and noise that every blur is tried with.
struct Kind {
    board: Board,
    distortion: PlumbBob,
    read_noise: f64,
    shading: [f64; 2],
    depth: BitDepth,
}

fn kinds() -> Result<Vec<Kind>> {
    let barrel = PlumbBob {
        k1: -0.2,
        k2: 0.08,
        p1: 0.001,
        p2: -0.0005,
        k3: 0.0,
    };
    Ok(vec![
        Kind {
            // the paper's C4: small rings far apart
            board: Board::new(7, 7, 0.0269, 0.003, 0.006, Polarity::DarkOnLight)?,
            distortion: barrel,
            read_noise: 0.01,
            shading: [0.3, 0.0],
            depth: BitDepth::Eight,
        },
        Kind {
            // large rings close together
            board: Board::new(5, 6, 0.03, 0.0055, 0.0105, Polarity::LightOnDark)?,
            distortion: PlumbBob::default().into(),
            read_noise: 0.02,
            shading: [0.0, -0.2],
            depth: BitDepth::Sixteen,
        },
        Kind {
            // thin rings
            board: Board::new(4, 5, 0.04, 0.008, 0.012, Polarity::DarkOnLight)?,
            distortion: barrel,
            read_noise: 0.005,
            shading: [0.0, 0.0],
            depth: BitDepth::Eight,
        },
    ])
}

/// Errors of one row of the table.
struct Row {
    missed: usize,
    rms_px: [f64; Estimator::ALL.len()],
}

impl Row {
    fn measure(defocus: Defocus) -> Result<Self> {
        let mut missed = 0;
        let mut sums = [0.0; Estimator::ALL.len()];
        let mut rings = 0;
        for (k, kind) in kinds()?.into_iter().enumerate() {
            let camera = camera(kind.distortion);
            let poses = views(
                &camera,
                &kind.board,
                BOARDS,
                MAX_TILT_DEGREES.to_radians(),
                7 + k as u64,
            )?;
            for (i, pose) in poses.into_iter().enumerate() {
                let mut scene = Scene::new(camera, kind.board.clone(), pose);
                scene.defocus = defocus;
                scene.light = Light::on(kind.board.polarity());
                scene.light.shading = kind.shading;
                scene.sensor.read_noise = kind.read_noise;
                scene.sensor.depth = kind.depth;
                let rendering = render(&scene, (100 * k + i) as u64)?;
                rings += kind.board.ring_count();
                for (sum, estimator) in sums.iter_mut().zip(Estimator::ALL) {
                    let (squares, lost) =
                        squares(&kind.board, estimator, &rendering.frame, &rendering.truth);
                    *sum += squares;
                    missed += usize::from(lost && estimator == Estimator::default());
                }
            }
        }
        Ok(Self {
            missed,
            rms_px: sums.map(|sum| (sum / rings as f64).sqrt()),
        })
    }
}

/// Sum of the squared errors of one board, px^2, and whether it was missed.
fn squares(board: &Board, estimator: Estimator, frame: &Frame, truth: &Truth) -> (f64, bool) {
    let options = DetectOptions {
        estimator,
        ..DetectOptions::default()
    };
    let found = Detector::new(board.clone(), options).detect(frame);
    let miss = MISS_PX * MISS_PX;
    let sum = truth.rings.iter().map(|ring| {
        let place = found
            .iter()
            .flat_map(|d| &d.rings)
            .find(|r| (r.row, r.column) == (ring.row, ring.column));
        place.map_or(miss, |r| (r.centre.point - ring.centre).norm_squared())
    });
    (sum.sum(), found.is_err())
}

fn camera(distortion: PlumbBob) -> Camera {
    Camera {
        width: 1280,
        height: 960,
        intrinsics: Intrinsics {
            fx: 1200.0,
            fy: 1205.0,
            cx: 645.0,
            cy: 472.0,
        },
        distortion: distortion.into(),
    }
}
