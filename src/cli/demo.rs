//! `ringcal demo`

/// Arguments of `ringcal demo`.
#[derive(Debug, clap::Args)]
pub struct Arguments {}

/// Runs the command.
pub fn run(_arguments: Arguments) -> anyhow::Result<()> {
    anyhow::bail!("demo is not written yet")
}
