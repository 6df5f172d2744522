//! Gaussian or disc: the blur's shape by likelihood.
//!
//! Both models have as many parameters, so the likelier is the one with the smaller sum of squares. With an unknown noise level
//! the log likelihood of n pixels is `-n / 2 ln(sum of squares)` and a constant; over the rings of a view, which have one
//! lens but each its own window and noise, these add up.

use super::blur::{Blur, Psf};
use super::choice::PsfChoice;
use super::fit::{Known, fit};
use super::fitted::{FitError, RingFitted};
use super::model::RingModel;
use super::problem::Workspace;
use super::start::{is_sharp, levels};

/// The disc is tried from these radii, in standard deviations of the fitted Gaussian. Its own is 2; larger discs look sharper
/// to a Gaussian, because they invert the inner circle's contrast.
const DISC_STARTS: [f64; 4] = [1.7, 2.0, 2.4, 3.0];
/// Which of them is a Gaussian's own, the only one where blur is small against the ring: no contrast is inverted there.
const OWN: usize = 1;
/// A smaller disc than this hardly changes with its radius, px.
const LEAST_START_PX: f64 = 0.5;

/// A ring fitted with either blur, as far as asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Both {
    /// With a Gaussian.
    pub gaussian: Result<RingFitted, FitError>,
    /// With a disc.
    pub disc: Result<RingFitted, FitError>,
}

impl Known<'_> {
    /// Fits it with one shape of blur; the start's own blur says where to begin, whatever its shape.
    ///
    /// # Errors
    /// [`FitError`] of the fit.
    pub fn fit_with(
        &self,
        start: &RingModel,
        psf: Psf,
        room: &mut Workspace,
    ) -> Result<RingFitted, FitError> {
        if start.blur.psf == psf {
            return fit(self, start, room);
        }
        match psf {
            Psf::Gaussian => {
                let blur = Blur::gaussian(start.blur.sigma_px());
                let begin = RingModel { blur, ..*start };
                fit(self, &begin, room)
            }
            Psf::Disc => self.fit_disc(start, room),
        }
    }

    /// Fits it with both shapes of blur.
    pub fn fit_both(&self, start: &RingModel, room: &mut Workspace) -> Both {
        let gaussian = self.fit_with(start, Psf::Gaussian, room);
        self.fit_disc_beside(gaussian, start, room)
    }

    /// Fits it with a disc too, from where the Gaussian ended.
    pub(super) fn fit_disc_beside(
        &self,
        gaussian: Result<RingFitted, FitError>,
        start: &RingModel,
        room: &mut Workspace,
    ) -> Both {
        let from = gaussian.as_ref().map_or(*start, |fitted| fitted.model);
        Both {
            disc: self.fit_with(&from, Psf::Disc, room),
            gaussian,
        }
    }

    /// Fits it with the blur that is chosen, or the likelier.
    ///
    /// # Errors
    /// [`FitError`] where no shape of blur that may be chosen can be fitted.
    pub fn fit_choice(
        &self,
        start: &RingModel,
        choice: PsfChoice,
        room: &mut Workspace,
    ) -> Result<RingFitted, FitError> {
        match choice {
            PsfChoice::Fixed(psf) => self.fit_with(start, psf, room),
            PsfChoice::Auto => self.fit_both(start, room).likelier(),
        }
    }

    /// A disc from the radius that explains the window best with the start's shape.
    fn fit_disc(&self, start: &RingModel, room: &mut Workspace) -> Result<RingFitted, FitError> {
        let sigma_px = start.blur.sigma_px();
        let inner = start.shape.ellipse(self.ratio);
        let starts = if inner.is_some_and(|inner| is_sharp(sigma_px, inner.minor)) {
            &DISC_STARTS[OWN..=OWN]
        } else {
            &DISC_STARTS[..]
        };
        let (_, begin) = starts
            .iter()
            .filter_map(|radius| {
                let blur = Blur::disc((radius * sigma_px).max(LEAST_START_PX));
                levels(
                    self.window,
                    (&start.shape, &blur),
                    self.ratio,
                    self.around,
                    room,
                )
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .ok_or(FitError::Undetermined)?;
        fit(self, &begin, room)
    }
}

impl Both {
    /// One fit, where the other shape was not asked for.
    pub(super) fn only(psf: Psf, fitted: Result<RingFitted, FitError>) -> Self {
        let missing = Err(FitError::Undetermined);
        match psf {
            Psf::Gaussian => Self {
                gaussian: fitted,
                disc: missing,
            },
            Psf::Disc => Self {
                gaussian: missing,
                disc: fitted,
            },
        }
    }

    /// The fit with this shape of blur.
    pub fn of(&self, psf: Psf) -> &Result<RingFitted, FitError> {
        match psf {
            Psf::Gaussian => &self.gaussian,
            Psf::Disc => &self.disc,
        }
    }

    /// Log likelihood of the disc over the Gaussian; `None` where one of them is missing.
    pub fn disc_over_gaussian(&self) -> Option<f64> {
        let (gaussian, disc) = (self.gaussian.as_ref().ok()?, self.disc.as_ref().ok()?);
        let log = |fitted: &RingFitted| fitted.squares.max(f64::MIN_POSITIVE).ln();
        Some(0.5 * gaussian.pixels as f64 * (log(gaussian) - log(disc)))
    }

    /// The fit with the smaller sum of squares.
    ///
    /// # Errors
    /// [`FitError`] where there is none.
    pub fn likelier(self) -> Result<RingFitted, FitError> {
        match (self.gaussian, self.disc) {
            (Ok(a), Ok(b)) => Ok(if b.squares < a.squares { b } else { a }),
            (a, b) => a.or(b),
        }
    }
}
