//! The options of `ringcal simulate`; values out of range are wrong usage.

use crate::camera::{Camera, Distortion, Intrinsics, LensModel};
use crate::simulate::{Defocus, Psf, ThinLens};
use crate::source::read_camera_file;
use std::path::PathBuf;

/// Arguments of `ringcal simulate`.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct Arguments {
    /// Board file (YAML)
    #[arg(long, value_name = "FILE")]
    pub board: PathBuf,
    /// Folder for the frames and truth.json
    #[arg(long, value_name = "DIR")]
    pub output: PathBuf,
    /// Poses of the board
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub views: u16,
    /// Frames of each pose, with different noise
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=100))]
    pub frames_per_view: u16,
    /// Simulate this camera: camera_info.yaml, or any other format that `ringcal convert` reads
    #[arg(long, value_name = "FILE", conflicts_with_all = ["width", "height", "focal_px", "fx", "fy", "cx", "cy", "model", "distortion"])]
    camera_info: Option<PathBuf>,
    /// Width of the frames, px
    #[arg(long, default_value_t = 1280, value_parser = clap::value_parser!(u32).range(16..=16384))]
    pub width: u32,
    /// Height of the frames, px
    #[arg(long, default_value_t = 960, value_parser = clap::value_parser!(u32).range(16..=16384))]
    pub height: u32,
    /// Focal length along x and y, px [default: the width]
    #[arg(long, value_name = "PX", value_parser = positive, conflicts_with_all = ["fx", "fy"])]
    focal_px: Option<f64>,
    /// Focal length along x, px
    #[arg(long, value_name = "PX", value_parser = positive, requires = "fy")]
    fx: Option<f64>,
    /// Focal length along y, px
    #[arg(long, value_name = "PX", value_parser = positive, requires = "fx")]
    fy: Option<f64>,
    /// Principal point along x, px [default: the middle]
    #[arg(long, value_name = "PX", value_parser = finite)]
    cx: Option<f64>,
    /// Principal point along y, px [default: the middle]
    #[arg(long, value_name = "PX", value_parser = finite)]
    cy: Option<f64>,
    /// Lens model: plumb_bob, rational_polynomial or equidistant (fisheye)
    #[arg(long, value_name = "NAME", default_value = "plumb_bob")]
    model: LensModel,
    /// Lens distortion in the order of ROS: k1,k2,p1,p2,k3 of plumb_bob, and k4,k5,k6 of rational_polynomial; k1,k2,k3,k4 of
    /// equidistant [default: zeros]
    #[arg(long, value_name = "K,...", value_parser = finite, value_delimiter = ',', allow_hyphen_values = true)]
    distortion: Vec<f64>,
    /// Gaussian blur, standard deviation, px
    #[arg(long, value_name = "PX", value_parser = not_negative, group = "blur")]
    blur_sigma: Option<f64>,
    /// Disc blur (pillbox), radius, px
    #[arg(long, value_name = "PX", value_parser = not_negative, group = "blur")]
    disc_radius: Option<f64>,
    /// Blur by depth: f-number of a thin lens
    #[arg(long, value_name = "N", value_parser = positive, group = "blur", requires_all = ["focal_length_m", "focus_m"])]
    f_number: Option<f64>,
    /// Focal length of the thin lens, m
    #[arg(long, value_name = "M", value_parser = positive, requires = "f_number")]
    focal_length_m: Option<f64>,
    /// Distance the thin lens is focused at, m
    #[arg(long, value_name = "M", value_parser = positive, requires = "f_number")]
    focus_m: Option<f64>,
    /// Distance between pixels, m [default: what makes the thin lens agree with the focal length in px]
    #[arg(long, value_name = "M", value_parser = positive, requires = "f_number")]
    pixel_m: Option<f64>,
    /// Shape of the thin lens's blur
    #[arg(long, value_name = "gaussian|disc", value_parser = psf, default_value = "disc")]
    lens_psf: Psf,
    /// Read noise, standard deviation, fraction of full scale
    #[arg(long, default_value_t = 0.0, value_name = "FRACTION", value_parser = not_negative)]
    pub noise: f64,
    /// Shot noise: electrons at full scale [default: none]
    #[arg(long, value_name = "ELECTRONS", value_parser = positive)]
    pub full_well: Option<f64>,
    /// Change of light from the left edge to the right, fraction
    #[arg(long, default_value_t = 0.0, value_name = "FRACTION", value_parser = shading)]
    pub shading: f64,
    /// Bits of a grey value
    #[arg(long, default_value_t = 8, value_name = "8|16", value_parser = depth)]
    pub depth: u8,
    /// Largest tilt of the board, degrees
    #[arg(long, default_value_t = 40.0, value_name = "DEG", value_parser = tilt)]
    pub max_tilt: f64,
    /// Response: grey is light to the power of 1 / gamma
    #[arg(long, default_value_t = 1.0, value_name = "G", value_parser = positive)]
    pub gamma: f64,
    /// Seed of poses and noise
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
}

impl Arguments {
    /// The camera asked for.
    ///
    /// # Errors
    /// Another number of coefficients than the lens model has, or a file without a camera.
    pub fn camera(&self) -> anyhow::Result<Camera> {
        match &self.camera_info {
            Some(path) => {
                let camera = read_camera_file(path)?.camera;
                let (width, height) = (camera.width, camera.height);
                anyhow::ensure!(
                    [width, height]
                        .iter()
                        .all(|side| (16..=16384).contains(side)),
                    "{}: frames of {width} x {height} px are not simulated, 16 to 16384 px a side are",
                    path.display()
                );
                Ok(camera)
            }
            None => Ok(self.camera_of_numbers()?),
        }
    }

    fn camera_of_numbers(&self) -> Result<Camera, clap::Error> {
        let focal_px = self.focal_px.unwrap_or(f64::from(self.width));
        let needed = self.model.coefficient_count();
        let zeros = vec![0.0; needed];
        let given = if self.distortion.is_empty() {
            &zeros
        } else {
            &self.distortion
        };
        let Some(distortion) = Distortion::new(self.model, given) else {
            let found = given.len();
            let text = format!(
                "--distortion has {found} numbers, {} has {needed}\n",
                self.model
            );
            let kind = clap::error::ErrorKind::WrongNumberOfValues;
            return Err(clap::Error::raw(kind, text));
        };
        Ok(Camera {
            width: self.width,
            height: self.height,
            intrinsics: Intrinsics {
                fx: self.fx.unwrap_or(focal_px),
                fy: self.fy.unwrap_or(focal_px),
                cx: self.cx.unwrap_or(0.5 * f64::from(self.width - 1)),
                cy: self.cy.unwrap_or(0.5 * f64::from(self.height - 1)),
            },
            distortion,
        })
    }

    /// The blur asked for.
    pub fn defocus(&self, camera: &Camera) -> anyhow::Result<Defocus> {
        if let Some(sigma_px) = self.blur_sigma {
            return Ok(Defocus::gaussian(sigma_px));
        }
        if let Some(radius_px) = self.disc_radius {
            return Ok(Defocus::disc(radius_px));
        }
        let (Some(f_number), Some(focal_length_m), Some(focus_m)) =
            (self.f_number, self.focal_length_m, self.focus_m)
        else {
            return Ok(Defocus::None);
        };
        anyhow::ensure!(
            focus_m > focal_length_m,
            "--focus-m {focus_m} must be more than --focal-length-m {focal_length_m}"
        );
        let image_m = focal_length_m * focus_m / (focus_m - focal_length_m);
        let lens = ThinLens {
            f_number,
            focal_length_m,
            pixel_m: self.pixel_m.unwrap_or(image_m / camera.intrinsics.fx),
            focus_m,
        };
        Ok(Defocus::ThinLens {
            psf: self.lens_psf,
            lens,
        })
    }
}

fn number(text: &str, ok: impl Fn(f64) -> bool, needed: &str) -> Result<f64, String> {
    let value: f64 = text
        .trim()
        .parse()
        .map_err(|_| "not a number".to_string())?;
    if value.is_finite() && ok(value) {
        Ok(value)
    } else {
        Err(format!("must be {needed}"))
    }
}

fn finite(text: &str) -> Result<f64, String> {
    number(text, |_| true, "finite")
}

fn positive(text: &str) -> Result<f64, String> {
    number(text, |v| v > 0.0, "finite and positive")
}

fn not_negative(text: &str) -> Result<f64, String> {
    number(text, |v| v >= 0.0, "finite and not negative")
}

fn shading(text: &str) -> Result<f64, String> {
    number(text, |v| v.abs() <= 1.0, "-1 to 1")
}

fn tilt(text: &str) -> Result<f64, String> {
    number(text, |v| (0.0..=80.0).contains(&v), "0 to 80 degrees")
}

fn depth(text: &str) -> Result<u8, String> {
    match text {
        "8" => Ok(8),
        "16" => Ok(16),
        _ => Err("must be 8 or 16".to_string()),
    }
}

fn psf(text: &str) -> Result<Psf, String> {
    match text {
        "gaussian" => Ok(Psf::Gaussian),
        "disc" => Ok(Psf::Disc),
        _ => Err("must be gaussian or disc".to_string()),
    }
}
