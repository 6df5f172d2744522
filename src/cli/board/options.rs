//! The options of `ringcal board`; values out of range are wrong usage.

use crate::board::Polarity;
use crate::print::{CameraSetup, Paper, PrintOptions, Stock};
use std::path::PathBuf;

/// Arguments of `ringcal board`.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    group = clap::ArgGroup::new("which").required(true).args(["board", "for_camera"]),
    after_help = "Print at 100 %, not fitted to the page, and check the rulers. docs/boards.md says more."
)]
pub struct Arguments {
    /// The board's YAML file
    #[arg(long, value_name = "FILE")]
    pub board: Option<PathBuf>,
    /// What to write: a sheet to print (.svg, .pdf or .png), or with --for-camera also the board's file (.yaml)
    #[arg(long, value_name = "FILE", required_unless_present = "for_camera")]
    pub output: Option<PathBuf>,
    /// Paper: a6 to a0, letter, legal, tabloid or WIDTHxHEIGHT in mm, upright or lying [default: the smallest of a4 to a0 that holds the board]
    #[arg(long, value_name = "PAPER")]
    paper: Option<Paper>,
    /// Print on a roll of this width, mm; the page takes the length it needs
    #[arg(long, value_name = "MM", value_parser = roll, conflicts_with = "paper")]
    roll: Option<f64>,
    /// Border of the paper that the printer leaves white, mm
    #[arg(long, value_name = "MM", default_value_t = 5.0, value_parser = border)]
    margin_mm: f64,
    /// Width of the quiet zone around the rings, mm [default: 1.2 times the width of a ring]
    #[arg(long, value_name = "MM", value_parser = border)]
    quiet_mm: Option<f64>,
    /// Name printed on the sheet [default: the board file's]
    #[arg(long)]
    name: Option<String>,
    /// Pixels an inch, of a PNG file
    #[arg(long, default_value_t = 300.0, value_parser = positive)]
    pub dpi: f64,
    /// Propose a board for the camera that the options below describe, and print its board file
    #[arg(long, conflicts_with = "board", requires_all = ["focal_length_mm", "pixel_um", "f_number", "focus_m", "distance_m", "frame"])]
    pub for_camera: bool,
    #[command(flatten)]
    camera: CameraArguments,
}

/// What is known of a camera that needs a board.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "With --for-camera")]
struct CameraArguments {
    /// Focal length of the lens, mm
    #[arg(long, value_name = "MM", value_parser = positive, requires = "for_camera")]
    focal_length_mm: Option<f64>,
    /// Distance between pixels, um
    #[arg(long, value_name = "UM", value_parser = positive, requires = "for_camera")]
    pixel_um: Option<f64>,
    /// Aperture: focal length over its diameter, the 4 of f/4
    #[arg(long, value_name = "N", value_parser = positive, requires = "for_camera")]
    f_number: Option<f64>,
    /// Distance the lens is focused at, m; for infinity 1e6
    #[arg(long, value_name = "M", value_parser = positive, requires = "for_camera")]
    focus_m: Option<f64>,
    /// Distance at which the board will be held, m
    #[arg(long, value_name = "M", value_parser = positive, requires = "for_camera")]
    distance_m: Option<f64>,
    /// Size of the frame, px
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = frame, requires = "for_camera")]
    frame: Option<[u32; 2]>,
    /// Part of the frame's width and height that the rings may cover, 0.1 to 1
    #[arg(long, value_name = "PART", default_value_t = 0.7, value_parser = part, requires = "for_camera")]
    fill: f64,
    /// Light rings on dark ground instead of dark rings on light
    #[arg(long, requires = "for_camera")]
    light_on_dark: bool,
}

impl Arguments {
    /// How the board is to be printed.
    pub fn print_options(&self) -> PrintOptions {
        let of_file = self.board.as_ref().and_then(|path| path.file_stem());
        let of_file = of_file.map(|stem| stem.to_string_lossy().into_owned());
        let name = self.name.clone().or(of_file);
        PrintOptions {
            name: name.unwrap_or_else(|| "ringcal board".to_owned()),
            stock: match (&self.paper, self.roll) {
                (_, Some(width_mm)) => Stock::Roll { width_mm },
                (Some(paper), None) => Stock::Sheet(paper.clone()),
                (None, None) => Stock::Smallest,
            },
            quiet_mm: self.quiet_mm,
            margin_mm: self.margin_mm,
        }
    }

    /// The camera that needs a board, where it is described.
    pub fn camera(&self) -> Option<CameraSetup> {
        let camera = &self.camera;
        Some(CameraSetup {
            focal_length_mm: camera.focal_length_mm?,
            pixel_um: camera.pixel_um?,
            f_number: camera.f_number?,
            focus_m: camera.focus_m?,
            distance_m: camera.distance_m?,
            frame_px: camera.frame?,
            fill: camera.fill,
            polarity: match camera.light_on_dark {
                true => Polarity::LightOnDark,
                false => Polarity::DarkOnLight,
            },
        })
    }
}

fn number(text: &str, ok: impl Fn(f64) -> bool, needed: &str) -> Result<f64, String> {
    let value: f64 = text.trim().parse().map_err(|_| "not a number".to_owned())?;
    if value.is_finite() && ok(value) {
        Ok(value)
    } else {
        Err(format!("must be {needed}"))
    }
}

fn positive(text: &str) -> Result<f64, String> {
    // far beyond any camera, and no product of a few such numbers is infinite
    number(text, |v| (1e-9..=1e9).contains(&v), "finite and positive")
}

fn roll(text: &str) -> Result<f64, String> {
    number(text, |v| (20.0..=5000.0).contains(&v), "20 to 5000 (mm)")
}

fn border(text: &str) -> Result<f64, String> {
    number(text, |v| (0.0..=1000.0).contains(&v), "0 to 1000 (mm)")
}

fn part(text: &str) -> Result<f64, String> {
    number(text, |v| (0.1..=1.0).contains(&v), "0.1 to 1")
}

fn frame(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| {
        let side: u32 = text.trim().parse().ok()?;
        (16..=100_000).contains(&side).then_some(side)
    };
    let sides = text.split_once(['x', 'X']);
    let sides = sides.and_then(|(width, height)| Some([side(width)?, side(height)?]));
    sides.ok_or_else(|| {
        "must be WIDTHxHEIGHT, 16 to 100000 px each, for example 1920x1080".to_owned()
    })
}
