//! The command line: one file per subcommand.
//!
//! Results go to stdout, logs to stderr. Exit codes: 0 done, 1 the job could not be done (says why), 2 wrong usage.

mod board;
mod calibrate;
mod check;
mod collect;
mod convert;
mod demo;
mod detect;
mod interrupt;
mod looking;
mod measuring;
mod node;
mod output;
mod progress;
mod reading;
mod simulate;

use clap::{Parser, Subcommand};
use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;

/// Calibrates cameras from a small, out-of-focus board of concentric circles.
#[derive(Debug, Parser)]
#[command(name = "ringcal", version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run the ROS 2 node.
    Node(node::Arguments),
    /// Find the board in image files and bags.
    Detect(detect::Arguments),
    /// Calibrate a camera from image files, folders or bags.
    Calibrate(calibrate::Arguments),
    /// Hold an existing calibration against new views, or against another calibration.
    Check(check::Arguments),
    /// Write a camera file in another format.
    Convert(convert::Arguments),
    /// Make a sheet with the board to print, true to scale, or propose a board for a camera.
    Board(Box<board::Arguments>),
    /// Render frames of a defocused board together with the truth.
    Simulate(Box<simulate::Arguments>),
    /// The whole job on this machine without hardware, over DDS.
    Demo(demo::Arguments),
}

/// Runs the program with the arguments of its process, the program's name first.
pub fn main(mut arguments: Vec<OsString>) -> ExitCode {
    let called_as_node = arguments
        .first()
        .and_then(|program| Path::new(program).file_stem())
        .is_some_and(|stem| stem == "ringcal_node");
    if called_as_node {
        arguments.insert(1, "node".into());
    }
    let parsed = match Arguments::try_parse_from(arguments) {
        Ok(parsed) => parsed,
        Err(error) => return usage(&error),
    };
    let done = match parsed.command {
        Command::Node(arguments) => node::run(arguments),
        Command::Detect(arguments) => detect::run(arguments),
        Command::Calibrate(arguments) => calibrate::run(arguments),
        Command::Check(arguments) => check::run(arguments),
        Command::Convert(arguments) => convert::run(&arguments),
        Command::Board(arguments) => board::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::Demo(arguments) => demo::run(arguments),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => match error.downcast_ref::<clap::Error>() {
            Some(error) => usage(error),
            None => {
                eprintln!("ringcal: {error:#}");
                ExitCode::FAILURE
            }
        },
    }
}

/// Prints help and version to stdout with exit code 0, mistakes to stderr with 2.
fn usage(error: &clap::Error) -> ExitCode {
    let _ = error.print();
    ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
}
