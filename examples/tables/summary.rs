//! The outcomes of all seeds as tables in Markdown.

use crate::Settings;
use crate::outcome::{Method, Outcome, PARAMETERS};
use crate::paper::{PIXEL_MM, TABLE_2, Target};
use crate::shots::lens;
use std::fmt::Write;

/// The outcomes of one board.
pub struct Summary {
    pub target: &'static Target,
    outcomes: Vec<(Method, Outcome)>,
}

impl Summary {
    pub fn new(target: &'static Target) -> Self {
        Self {
            target,
            outcomes: Vec::new(),
        }
    }

    pub fn add(&mut self, method: Method, outcome: Outcome) {
        self.outcomes.push((method, outcome));
    }

    fn of(&self, method: Method) -> impl Iterator<Item = &Outcome> + Clone {
        let own = self.outcomes.iter().filter(move |(m, _)| *m == method);
        own.map(|(_, outcome)| outcome)
    }
}

/// All tables.
pub fn text(summaries: &[Summary], settings: &Settings) -> String {
    let mut out = String::from(
        "### Table 2: one calibration of each kind\n\n\
         | board, distance | method | f_u, mm | f_v, mm | u0, px | v0, px | k1 | k2 | error, px |\n|---|---|---|---|---|---|---|---|---|\n",
    );
    let _ = writeln!(out, "| | **truth** | {} | |", bare(&TABLE_2[0].values));
    for summary in summaries {
        calibrations(&mut out, summary);
    }
    out.push_str(
        "\n### Errors of the centres\n\n\
         | board, distance | disc radius, px | method | boards | rings (left out) | rmse, px | less the displacement predicted, px | mean square z | beyond 2.5, % | inside the border | std over bound |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for summary in summaries {
        centres(&mut out, summary, settings);
    }
    out.push_str(
        "\n### Errors of the camera over the seeds\n\n\
         | board, distance | method | seeds | f, relative rms | principal point, px rms | k1 rms | k2 rms | mean square z | beyond 2.5 | joint | std over bound |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for summary in summaries {
        cameras(&mut out, summary);
    }
    out
}

/// One calibration for the terminal.
pub fn line(outcome: &Outcome) -> String {
    let c = &outcome.centres;
    let z: Vec<String> = scores(outcome).map(|z| format!("{z:.2}")).collect();
    format!(
        "{} views: {} rms {:.4} px; centres {:.4} px, z2 {:.2} (inside {:.2}); z of parameters {}",
        outcome.views,
        with_std(outcome),
        outcome.rms_px,
        root_mean(c.squares, c.rings),
        c.score_squares / c.scores as f64,
        outcome.inside.score_squares / outcome.inside.scores as f64,
        z.join(" ")
    )
}

fn place(target: &Target) -> String {
    format!("{}, {} m", target.name, target.distance_m)
}

/// The first seed's calibrations between the paper's.
fn calibrations(out: &mut String, summary: &Summary) {
    let place = place(summary.target);
    for method in Method::ALL {
        if let Some(outcome) = summary.of(method).next() {
            let (name, values) = (method.name(), with_std(outcome));
            let _ = writeln!(
                out,
                "| {place} | {name} | {values} | {:.4} |",
                outcome.rms_px
            );
        }
    }
    for printed in summary.target.printed() {
        let (name, values) = (printed.method, bare(&printed.values));
        let error = printed.error_px;
        let _ = writeln!(
            out,
            "| {place} | *the paper's {name}* | {values} | {error:.4} |"
        );
    }
}

fn centres(out: &mut String, summary: &Summary, settings: &Settings) {
    let radius_px = lens(settings.f_number)
        .radius_px(summary.target.distance_m)
        .abs();
    for method in Method::ALL {
        let all = summary.of(method).map(|outcome| outcome.centres);
        let rings: usize = all.clone().map(|c| c.rings).sum();
        if rings == 0 {
            continue;
        }
        let left_out: usize = all.clone().map(|c| c.left_out).sum();
        let rmse = root_mean(all.clone().map(|c| c.squares).sum(), rings);
        let rest = root_mean(all.clone().map(|c| c.squares_predicted).sum(), rings);
        let scores: usize = all.clone().map(|c| c.scores).sum();
        let squares: f64 = all.clone().map(|c| c.score_squares).sum();
        let beyond: usize = all.clone().map(|c| c.beyond).sum();
        let over: f64 = all.map(|c| c.over_bound).sum();
        let inside = summary.of(method).map(|outcome| outcome.inside);
        let inside_scores: usize = inside.clone().map(|c| c.scores).sum();
        let inside_squares: f64 = inside.map(|c| c.score_squares).sum();
        let z = match scores {
            0 => "- | - | - | -".to_owned(),
            n => format!(
                "{:.2} | {:.1} | {:.2} | {:.2}",
                squares / n as f64,
                100.0 * beyond as f64 / n as f64,
                inside_squares / inside_scores as f64,
                // two coordinates a ring
                root_mean(2.0 * over, n)
            ),
        };
        let boards: usize = summary.of(method).map(|outcome| outcome.views).sum();
        let _ = writeln!(
            out,
            "| {} | {radius_px:.1} | {} | {boards} of {} | {rings} ({left_out}) | {rmse:.4} | {rest:.4} | {z} |",
            place(summary.target),
            method.name(),
            settings.views * summary.of(method).count(),
        );
    }
}

fn cameras(out: &mut String, summary: &Summary) {
    for method in Method::ALL {
        let seeds = summary.of(method).count();
        if seeds == 0 {
            continue;
        }
        let mean_square = |of: &dyn Fn(&Outcome) -> f64| {
            (summary.of(method).map(of).sum::<f64>() / seeds as f64).sqrt()
        };
        let focal = mean_square(&|o| {
            let e = o.errors();
            0.5 * ((e[0] / o.values[0]).powi(2) + (e[1] / o.values[1]).powi(2))
        });
        // the distance in the picture, not one of its coordinates
        let principal = mean_square(&|o| o.errors()[2].powi(2) + o.errors()[3].powi(2));
        let k = [4, 5].map(|i: usize| mean_square(&|o| o.errors()[i].powi(2)));
        let z: Vec<f64> = summary.of(method).flat_map(scores).collect();
        let squares: f64 = z.iter().map(|z| z * z).sum();
        let beyond = z.iter().filter(|z| z.abs() > 2.5).count();
        let joint: f64 = summary.of(method).map(|o| o.joint).sum();
        // of the parameter that is furthest from it
        let over: Vec<f64> = (0..PARAMETERS)
            .map(|i| mean_square(&|o| (o.stds[i] / o.bounds[i]).powi(2)))
            .collect();
        let over = over.into_iter().fold(0.0, f64::max);
        let _ = writeln!(
            out,
            "| {} | {} | {seeds} | {focal:.1e} | {principal:.2} | {:.5} | {:.4} | {:.2} | {beyond} of {} | {:.2} | {over:.2} |",
            place(summary.target),
            method.name(),
            k[0],
            k[1],
            squares / z.len() as f64,
            z.len(),
            joint / (seeds * PARAMETERS) as f64,
        );
    }
}

/// Errors in standard deviations.
fn scores(outcome: &Outcome) -> impl Iterator<Item = f64> {
    let errors = outcome.errors().into_iter();
    errors.zip(outcome.stds).map(|(error, std)| error / std)
}

fn root_mean(squares: f64, count: usize) -> f64 {
    (squares / count as f64).sqrt()
}

/// The six cells of a row: the focal lengths are in mm.
fn bare(values: &[f64; PARAMETERS]) -> String {
    let [fu, fv, u0, v0, k1, k2] = values;
    format!("{fu:.4} | {fv:.4} | {u0:.2} | {v0:.2} | {k1:.4} | {k2:.3}")
}

/// The same with standard deviations, from px.
fn with_std(outcome: &Outcome) -> String {
    let cell = |i: usize, factor: f64, digits: usize| {
        let (value, std) = (factor * outcome.values[i], factor * outcome.stds[i]);
        format!("{value:.digits$} ± {std:.digits$}")
    };
    let mm = PIXEL_MM;
    [
        cell(0, mm, 4),
        cell(1, mm, 4),
        cell(2, 1.0, 2),
        cell(3, 1.0, 2),
        cell(4, 1.0, 4),
        cell(5, 1.0, 3),
    ]
    .join(" | ")
}
