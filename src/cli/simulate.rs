//! `ringcal simulate`

/// Arguments of `ringcal simulate`.
#[derive(Debug, clap::Args)]
pub struct Arguments {}

/// Runs the command.
pub fn run(_arguments: Arguments) -> anyhow::Result<()> {
    anyhow::bail!("simulate is not written yet")
}
