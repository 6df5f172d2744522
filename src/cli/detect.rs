//! `ringcal detect`

/// Arguments of `ringcal detect`.
#[derive(Debug, clap::Args)]
pub struct Arguments {}

/// Runs the command.
pub fn run(_arguments: Arguments) -> anyhow::Result<()> {
    anyhow::bail!("detect is not written yet")
}
