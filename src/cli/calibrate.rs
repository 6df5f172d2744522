//! `ringcal calibrate`

/// Arguments of `ringcal calibrate`.
#[derive(Debug, clap::Args)]
pub struct Arguments {}

/// Runs the command.
pub fn run(_arguments: Arguments) -> anyhow::Result<()> {
    anyhow::bail!("calibrate is not written yet")
}
