//! How projected centres are measured: the options that `detect` and `calibrate` have in common.

use crate::board::Board;
use crate::centre::Estimator;
use crate::centre::photometric::{PsfChoice, ResponseGamma};
use crate::detect::{DetectOptions, Required};
use clap::error::ErrorKind;

/// The options of a command that measures centres.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct Measuring {
    /// What gives the projected centre: big_ellipse, small_ellipse, one_sided, cross, pole_polar or photometric.
    #[arg(long, value_name = "NAME", default_value = Estimator::default().name())]
    pub estimator: Estimator,
    /// Shape of the blur, for photometric: gaussian, disc (a round aperture far out of focus), or auto, the likelier.
    #[arg(long, value_name = "auto|gaussian|disc", default_value_t)]
    psf: PsfChoice,
    /// How grey values follow the light, for photometric: grey = light^(1/G) with G from 0.2 to 5 (1: proportional;
    /// about 2.2: pictures made for people), or auto, which estimates G.
    #[arg(
        long,
        value_name = "G|auto",
        default_value_t,
        allow_negative_numbers = true
    )]
    response_gamma: ResponseGamma,
    /// How many rings of the board must be seen, at most all; 0: one in every row and column, and 60 % of all. With fewer rows or columns the
    /// numbers begin at the first that were seen (indices relative).
    #[arg(long, value_name = "N", default_value_t = 0)]
    required_rings: u16,
}

impl Measuring {
    /// For a detector of this board, without a camera.
    ///
    /// # Errors
    /// Wrong usage: more rings are required than the board has.
    pub fn options(&self, board: &Board) -> Result<DetectOptions, clap::Error> {
        let required = usize::from(self.required_rings);
        // marks are no rings to measure
        let most = board.ring_count() - board.marks().len();
        if required > most {
            let text = format!("--required-rings {required}: the board has {most} rings\n");
            return Err(clap::Error::raw(ErrorKind::ValueValidation, text));
        }
        Ok(DetectOptions {
            estimator: self.estimator,
            psf: self.psf,
            response_gamma: self.response_gamma,
            required: Required::rings(required),
            camera: None,
        })
    }
}
