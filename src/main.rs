//! The `ringcal` binary; called as `ringcal_node` it is `ringcal node`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ringcal::cli::main(std::env::args_os().collect())
}
