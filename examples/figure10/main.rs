//! Figure 10 of the paper, reproduced: the error of every estimator over the blur k.
//!
//! `cargo run --release --example figure10 -- [--trials N] [--markdown] [--svg FILE]`
//!
//! One ring, radii 1 : 2, tilted by 45 and 20 degrees under strong perspective, contrast 0.75 of full scale, 16 bit. What the paper
//! leaves open is done both ways: k is the standard deviation of the Gaussian or three of them, the outer circle has 100 or 200
//! px, noise is 0, 1 or 2 % of full scale; detection works on the frame as it is or on the frame enhanced as in paper III-A.
//! A cell is the root mean square error of the centre in px over the rings found; where some were not, how many were.

mod plot;
mod table;
mod trial;

use anyhow::{Context, Result, bail};
use table::Table;

fn main() -> Result<()> {
    let (mut trials, mut markdown, mut svg) = (6, false, None);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--trials" => {
                trials = arguments
                    .next()
                    .context("--trials needs a number")?
                    .parse()?
            }
            "--markdown" => markdown = true,
            "--svg" => svg = Some(arguments.next().context("--svg needs a file")?),
            other => bail!("unknown argument {other}"),
        }
    }
    let mut panels = Vec::new();
    for outer_px in [100.0, 200.0] {
        for (reading, divisor) in [("sigma = k", 1.0), ("sigma = k / 3", 3.0)] {
            for noise in [0.0, 0.01, 0.02] {
                let main_panel = divisor == 1.0 && noise == 0.01;
                if (markdown || svg.is_some()) && !main_panel {
                    continue;
                }
                let table = Table::measure(outer_px, divisor, noise, trials)?;
                let title = format!(
                    "outer radius {outer_px} px, {reading}, noise {} %",
                    100.0 * noise
                );
                match (markdown, svg.is_some()) {
                    (true, _) => println!("{}", table.markdown(&title)),
                    (false, false) => println!("{}", table.text(&title)),
                    _ => {}
                }
                if main_panel {
                    panels.push((title, table));
                }
            }
        }
    }
    if let Some(file) = svg {
        std::fs::write(&file, plot::draw(&panels)).with_context(|| file)?;
    }
    Ok(())
}
