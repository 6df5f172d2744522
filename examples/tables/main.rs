//! Tables 1 and 2 of the paper, reproduced on simulated frames, where the truth is known.
//!
//! `cargo run --release --example tables -- [--seeds N] [--first-seed N] [--views N] [--boards C1,C4] [--aperture F]
//! [--blur lens|even] [--output FILE]`
//!
//! A camera of 5496 x 3672 px, focused at 7.5 m, sees the boards C1 to C4 at 7.5, 4, 3 and 2 m, 20 views each; the blur is that
//! of a thin lens, a disc; with `--blur even` the same in the whole frame. The frames go through the detector, once with each method; the centres through the
//! calibration with k1 and k2 free. The tables are written anew after every seed: a long run may be stopped.

mod bound;
mod outcome;
mod paper;
mod poses;
mod shots;
mod summary;

use anyhow::{Context, Result, bail};
use outcome::{Method, Outcome};
use paper::{TARGETS, Target};
use std::time::Instant;
use summary::Summary;

/// What may be chosen.
pub struct Settings {
    seeds: u64,
    first_seed: u64,
    views: usize,
    targets: Vec<&'static Target>,
    /// Focal length over aperture.
    pub f_number: f64,
    /// The blur of the board's distance everywhere, not that of each point's own.
    pub even_blur: bool,
    output: Option<String>,
}

fn main() -> Result<()> {
    let settings = Settings::from_arguments(std::env::args().skip(1))?;
    let mut summaries: Vec<Summary> = settings.targets.iter().map(|t| Summary::new(t)).collect();
    for seed in (settings.first_seed..).take(settings.seeds as usize) {
        for summary in &mut summaries {
            measure(summary, seed, &settings)?;
        }
        if let Some(file) = &settings.output {
            std::fs::write(file, summary::text(&summaries, &settings)).context(file.clone())?;
        }
    }
    print!("{}", summary::text(&summaries, &settings));
    Ok(())
}

/// One seed of one board, by every method.
fn measure(summary: &mut Summary, seed: u64, settings: &Settings) -> Result<()> {
    let target = summary.target;
    let start = Instant::now();
    let shots = shots::take(target, seed, settings)?;
    eprintln!(
        "{} seed {seed}: frames {:.0?}",
        target.name,
        start.elapsed()
    );
    let board = target.board()?;
    for method in Method::ALL {
        match Outcome::of(method, &board, &shots) {
            Ok(outcome) => {
                eprintln!("{} {}", method.name(), summary::line(&outcome));
                summary.add(method, outcome);
            }
            Err(error) => eprintln!("{}: {error}", method.name()),
        }
    }
    Ok(())
}

impl Settings {
    fn from_arguments(mut arguments: impl Iterator<Item = String>) -> Result<Self> {
        let mut settings = Self {
            seeds: 1,
            first_seed: 1,
            views: 20,
            targets: TARGETS.iter().collect(),
            f_number: 8.0,
            even_blur: false,
            output: None,
        };
        while let Some(name) = arguments.next() {
            let value = arguments
                .next()
                .with_context(|| format!("{name} needs a value"))?;
            match name.as_str() {
                "--seeds" => settings.seeds = value.parse()?,
                "--first-seed" => settings.first_seed = value.parse()?,
                "--views" => settings.views = value.parse()?,
                "--boards" => settings.targets = targets(&value)?,
                "--aperture" => settings.f_number = value.parse()?,
                "--blur" => {
                    settings.even_blur = match value.as_str() {
                        "lens" => false,
                        "even" => true,
                        other => bail!("unknown blur {other}; known are lens, even"),
                    }
                }
                "--output" => settings.output = Some(value),
                other => bail!("unknown argument {other}"),
            }
        }
        Ok(settings)
    }
}

/// The boards of these names, separated by commas.
fn targets(names: &str) -> Result<Vec<&'static Target>> {
    let find = |name: &str| {
        let found = TARGETS.iter().find(|t| t.name.eq_ignore_ascii_case(name));
        found.with_context(|| format!("unknown board {name}; known are C1, C2, C3, C4"))
    };
    names.split(',').map(find).collect()
}
