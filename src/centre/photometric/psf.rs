//! Gaussian or disc: the blur's shape by likelihood.
//!
//! Both models have as many parameters, so the likelier is the one with the smaller sum of squares. With an unknown noise level
//! the log likelihood of n pixels is `-n / 2 ln(sum of squares)` and a constant; over the rings of a view, which have one
//! lens but each its own window and noise, these add up.

use super::blur::{Blur, Psf};
use super::choice::PsfChoice;
use super::fit::{FitError, RingFitted, fit};
use super::model::RingModel;
use super::start::levels;
use super::window::Window;
use rayon::prelude::*;

/// The disc is tried from these radii, in standard deviations of the fitted Gaussian. Its own is 2; larger discs look sharper
/// to a Gaussian, because they invert the inner circle's contrast.
const DISC_STARTS: [f64; 3] = [1.7, 2.0, 2.4];
/// A smaller disc than this hardly changes with its radius, px.
const LEAST_START_PX: f64 = 0.5;
/// So many rings, spread over the view, choose for all.
const JURY: usize = 9;

/// The rings of a view, fitted with one shape of blur.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewFitted {
    /// The shape.
    pub psf: Psf,
    /// Log likelihood of the disc over the Gaussian; `None` where it was not asked for or no ring has both fits.
    pub disc_over_gaussian: Option<f64>,
    /// Each ring's fit, in the order given.
    pub rings: Vec<Result<RingFitted, FitError>>,
}

/// Fits one ring; the start's own blur says where to begin, whatever its shape.
///
/// # Errors
/// [`FitError`] where no shape of blur that may be chosen can be fitted.
pub fn fit_psf(
    window: &Window,
    start: &RingModel,
    ratio: f64,
    choice: PsfChoice,
) -> Result<RingFitted, FitError> {
    let gaussian = || fit(window, &with_blur(start, Psf::Gaussian), ratio);
    match choice {
        PsfChoice::Fixed(Psf::Gaussian) => gaussian(),
        PsfChoice::Fixed(Psf::Disc) => fit_disc(window, start, ratio),
        PsfChoice::Auto => {
            let gaussian = gaussian();
            let from = gaussian.as_ref().map_or(*start, |fitted| fitted.model);
            better(gaussian, fit_disc(window, &from, ratio))
        }
    }
}

/// Fits the rings of one view, each given by its window and start, with one shape of blur for all.
pub fn fit_view(rings: &[(Window, RingModel)], ratio: f64, choice: PsfChoice) -> ViewFitted {
    match choice {
        PsfChoice::Fixed(psf) => ViewFitted {
            psf,
            disc_over_gaussian: None,
            rings: fit_all(rings, ratio, psf),
        },
        PsfChoice::Auto => fit_likelier(rings, ratio),
    }
}

fn fit_all(
    rings: &[(Window, RingModel)],
    ratio: f64,
    psf: Psf,
) -> Vec<Result<RingFitted, FitError>> {
    rings
        .par_iter()
        .map(|(window, start)| fit_psf(window, start, ratio, PsfChoice::Fixed(psf)))
        .collect()
}

/// The jury is fitted with both, the rest with what it chose.
fn fit_likelier(rings: &[(Window, RingModel)], ratio: f64) -> ViewFitted {
    let stride = rings.len().div_ceil(JURY).max(1);
    let jury: Vec<_> = rings
        .par_iter()
        .step_by(stride)
        .map(|(window, start)| Both::fit(window, start, ratio))
        .collect();
    let evidences = jury.iter().filter_map(Both::disc_over_gaussian);
    let disc_over_gaussian = evidences.reduce(|sum, evidence| sum + evidence);
    let found = |psf| jury.iter().filter(|both| both.of(psf).is_ok()).count();
    let disc = match disc_over_gaussian {
        Some(evidence) => evidence > 0.0,
        None => found(Psf::Disc) > found(Psf::Gaussian),
    };
    let psf = if disc { Psf::Disc } else { Psf::Gaussian };
    let rings = rings
        .par_iter()
        .enumerate()
        .map(|(i, (window, start))| {
            if i % stride == 0 {
                *jury[i / stride].of(psf)
            } else {
                fit_psf(window, start, ratio, PsfChoice::Fixed(psf))
            }
        })
        .collect();
    ViewFitted {
        psf,
        disc_over_gaussian,
        rings,
    }
}

/// A ring fitted with either blur.
struct Both {
    gaussian: Result<RingFitted, FitError>,
    disc: Result<RingFitted, FitError>,
}

impl Both {
    fn fit(window: &Window, start: &RingModel, ratio: f64) -> Self {
        let gaussian = fit(window, &with_blur(start, Psf::Gaussian), ratio);
        let from = gaussian.as_ref().map_or(*start, |fitted| fitted.model);
        Self {
            disc: fit_disc(window, &from, ratio),
            gaussian,
        }
    }

    fn of(&self, psf: Psf) -> &Result<RingFitted, FitError> {
        match psf {
            Psf::Gaussian => &self.gaussian,
            Psf::Disc => &self.disc,
        }
    }

    fn disc_over_gaussian(&self) -> Option<f64> {
        let (gaussian, disc) = (self.gaussian.as_ref().ok()?, self.disc.as_ref().ok()?);
        let log = |fitted: &RingFitted| fitted.squares.max(f64::MIN_POSITIVE).ln();
        Some(0.5 * gaussian.pixels as f64 * (log(gaussian) - log(disc)))
    }
}

/// A disc from the radius that explains the window best with the start's shape.
fn fit_disc(window: &Window, start: &RingModel, ratio: f64) -> Result<RingFitted, FitError> {
    let mut room = Default::default();
    let sigma_px = start.blur.sigma_px();
    let (_, begin) = DISC_STARTS
        .into_iter()
        .filter_map(|radius| {
            let blur = Blur::disc((radius * sigma_px).max(LEAST_START_PX));
            levels(window, &start.shape, &blur, ratio, &mut room)
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .ok_or(FitError::Undetermined)?;
    let shading = start.shading;
    fit(window, &RingModel { shading, ..begin }, ratio)
}

/// The fit with the smaller sum of squares.
fn better(
    a: Result<RingFitted, FitError>,
    b: Result<RingFitted, FitError>,
) -> Result<RingFitted, FitError> {
    match (a, b) {
        (Ok(a), Ok(b)) => Ok(if b.squares < a.squares { b } else { a }),
        (a, b) => a.or(b),
    }
}

/// The start with a blur of this shape and the same standard deviation.
fn with_blur(start: &RingModel, psf: Psf) -> RingModel {
    RingModel {
        blur: Blur::of_sigma(psf, start.blur.sigma_px()),
        ..*start
    }
}
