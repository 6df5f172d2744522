//! Errors of every estimator over k, for one ring size, one reading of k and one noise.

use crate::trial::Place;
use anyhow::Result;
use rayon::prelude::*;
use ringcal::centre::Estimator;
use ringcal::enhance::{Target, enhance};
use std::fmt::Write;
use std::num::NonZeroU32;

/// The paper's blurs.
pub const KS: [f64; 8] = [5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0];
/// What the paper's text says of its figure: estimator, k, error in px.
pub const PAPER: [(Estimator, f64, f64); 7] = [
    (Estimator::Cross, 5.0, 0.180_74),
    (Estimator::OneSided, 5.0, 0.189_33),
    (Estimator::BigEllipse, 5.0, 0.244_75),
    (Estimator::OneSided, 40.0, 2.777_81),
    (Estimator::BigEllipse, 40.0, 2.168_89),
    (Estimator::SmallEllipse, 40.0, 1.901_36),
    (Estimator::Cross, 40.0, 1.105_12),
];

/// Errors of some trials.
#[derive(Debug, Clone, Copy, Default)]
pub struct Cell {
    squares: f64,
    found: usize,
    trials: usize,
}

impl Cell {
    /// Root mean square error of the rings found, px; `None` where none was.
    pub fn rmse_px(&self) -> Option<f64> {
        (self.found > 0).then(|| (self.squares / self.found as f64).sqrt())
    }

    fn add(&mut self, error_px: Option<f64>) {
        self.trials += 1;
        if let Some(error) = error_px {
            self.squares += error * error;
            self.found += 1;
        }
    }

    fn text(&self) -> String {
        match self.rmse_px() {
            None if self.trials == 0 => "-".to_owned(),
            None => "none".to_owned(),
            Some(rmse) if self.found < self.trials => {
                format!("{rmse:.3} ({}/{})", self.found, self.trials)
            }
            Some(rmse) => format!("{rmse:.4}"),
        }
    }
}

/// All of one blur.
#[derive(Debug, Clone)]
pub struct Row {
    pub k: f64,
    /// In the order of [`Estimator::ALL`].
    pub plain: [Cell; 6],
    /// From the enhanced frame.
    pub enhanced: [Cell; 6],
    pub bound_px: Option<f64>,
}

/// All blurs.
#[derive(Debug, Clone)]
pub struct Table {
    pub rows: Vec<Row>,
}

impl Table {
    pub fn measure(outer_px: f64, divisor: f64, noise: f64, trials: usize) -> Result<Self> {
        let rows = KS
            .into_par_iter()
            .map(|k| Row::measure(outer_px, k, k / divisor, noise, trials));
        Ok(Self {
            rows: rows.collect::<Result<_>>()?,
        })
    }

    /// For a terminal.
    pub fn text(&self, title: &str) -> String {
        let mut out =
            format!("\n{title}: rmse of the centre, px (found / trials where some are missed)\n");
        for enhanced in [false, true] {
            let _ = writeln!(
                out,
                "{}",
                if enhanced {
                    "from the enhanced frame"
                } else {
                    "from the frame"
                }
            );
            let _ = write!(out, "{:>4}", "k");
            for estimator in Estimator::ALL {
                let _ = write!(out, "{:>15}", estimator.name());
            }
            let _ = writeln!(out, "{:>10}  paper", "bound");
            for row in &self.rows {
                let _ = write!(out, "{:>4}", row.k);
                for cell in row.cells(enhanced) {
                    let _ = write!(out, "{:>15}", cell.text());
                }
                let _ = writeln!(out, "{:>10}  {}", row.bound(), paper(row.k));
            }
        }
        out
    }

    /// For docs/figure10.md.
    pub fn markdown(&self, title: &str) -> String {
        let mut out = String::new();
        for enhanced in [false, true] {
            let what = if enhanced {
                ", from the enhanced frame"
            } else {
                ""
            };
            let _ = writeln!(out, "**{title}{what}**\n");
            let names: Vec<&str> = Estimator::ALL.iter().map(|e| e.name()).collect();
            let _ = writeln!(out, "| k | {} | bound | the paper |", names.join(" | "));
            let _ = writeln!(out, "|{}", "---|".repeat(names.len() + 3));
            for row in &self.rows {
                let cells: Vec<String> = row.cells(enhanced).iter().map(Cell::text).collect();
                let _ = writeln!(
                    out,
                    "| {} | {} | {} | {} |",
                    row.k,
                    cells.join(" | "),
                    row.bound(),
                    paper(row.k)
                );
            }
            let _ = writeln!(out);
        }
        out
    }
}

impl Row {
    fn measure(outer_px: f64, k: f64, sigma_px: f64, noise: f64, trials: usize) -> Result<Self> {
        let mut row = Self {
            k,
            plain: Default::default(),
            enhanced: Default::default(),
            bound_px: None,
        };
        for trial in 0..trials {
            let place = Place::new(outer_px, sigma_px, trial)?;
            let frame = place.frame(noise, trial as u64)?;
            let sharpened = enhance(&frame, Target::Dark, NonZeroU32::MIN).frame;
            if trial == 0 && noise > 0.0 {
                row.bound_px = place.bound_px(&frame, noise);
            }
            for (i, estimator) in Estimator::ALL.into_iter().enumerate() {
                row.plain[i].add(place.error_px(&frame, estimator)?);
                // the photometric fit is one of light, which an enhanced frame no longer shows
                if estimator != Estimator::Photometric {
                    row.enhanced[i].add(place.error_px(&sharpened, estimator)?);
                }
            }
        }
        Ok(row)
    }

    fn cells(&self, enhanced: bool) -> &[Cell; 6] {
        if enhanced {
            &self.enhanced
        } else {
            &self.plain
        }
    }

    fn bound(&self) -> String {
        self.bound_px
            .map_or("-".to_owned(), |bound| format!("{bound:.4}"))
    }
}

fn paper(k: f64) -> String {
    let said = PAPER.iter().filter(|said| said.1 == k);
    let texts: Vec<String> = said
        .map(|(e, _, px)| format!("{} {px:.3}", e.name()))
        .collect();
    texts.join(", ")
}
