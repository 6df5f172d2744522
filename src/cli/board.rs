//! `ringcal board`: a printable target, true to scale; or the board for a camera.

mod options;
mod words;

use super::output::print;
use crate::board::{Board, Polarity};
use crate::formats::write_by_rename;
use crate::print::{Sheet, lay_out, pdf, png, propose, svg};
use crate::source::read_board;
use anyhow::Context;
use clap::error::ErrorKind;
use std::path::Path;

pub use options::Arguments;

/// What a file is, by the end of its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Svg,
    Pdf,
    Png,
    Yaml,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let output = match &arguments.output {
        Some(path) => Some((path, kind(path, arguments.for_camera)?)),
        None => None,
    };
    let board = match (&arguments.board, arguments.camera()) {
        (Some(path), _) => read_board(path)?,
        (None, Some(camera)) => {
            let proposal = propose(&camera)?;
            eprint!("{}", words::assumed(&camera, &proposal));
            print(&proposal.board.to_yaml())?;
            proposal.board
        }
        // the options require one another
        (None, None) => anyhow::bail!("neither --board nor a camera"),
    };
    match output {
        Some((path, kind)) => write(arguments, &board, path, kind),
        None => Ok(()),
    }
}

/// What the file is to be.
fn kind(path: &Path, for_camera: bool) -> Result<Kind, clap::Error> {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    match ending.to_ascii_lowercase().as_str() {
        "svg" => Ok(Kind::Svg),
        "pdf" => Ok(Kind::Pdf),
        "png" => Ok(Kind::Png),
        "yaml" | "yml" if for_camera => Ok(Kind::Yaml),
        _ => {
            let yaml = if for_camera { ", .yaml" } else { "" };
            let sentence = format!(
                "--output {}: the name must end in .svg, .pdf{yaml} or .png\n",
                path.display()
            );
            Err(clap::Error::raw(ErrorKind::InvalidValue, sentence))
        }
    }
}

fn write(arguments: &Arguments, board: &Board, path: &Path, kind: Kind) -> anyhow::Result<()> {
    let bytes = if kind == Kind::Yaml {
        board.to_yaml().into_bytes()
    } else {
        let sheet = lay_out(board, &arguments.print_options())?;
        let bytes = match kind {
            Kind::Png => png(&sheet, arguments.dpi)?,
            Kind::Pdf => pdf(&sheet),
            Kind::Svg | Kind::Yaml => svg(&sheet).into_bytes(),
        };
        report(board, &sheet);
        bytes
    };
    write_by_rename(path, &bytes).with_context(|| path.display().to_string())?;
    eprintln!("wrote {}", path.display());
    Ok(())
}

/// Says on what it is to be printed.
fn report(board: &Board, sheet: &Sheet) {
    if board.polarity() == Polarity::Auto {
        eprintln!("polarity is auto: printed as dark_on_light");
    }
    eprintln!(
        "paper: {}, {:.1} x {:.1} mm; print at 100 %, not fitted to the page, and check the rulers",
        sheet.paper, sheet.width_mm, sheet.height_mm
    );
}
