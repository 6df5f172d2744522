//! The shape and size of the blur.

/// The shape of a lens's blur.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Psf {
    /// A normal distribution: diffraction, aberrations, small defocus.
    #[default]
    Gaussian,
    /// A disc of even light: what a round aperture makes of a point far out of focus.
    Disc,
}

impl Psf {
    /// The word for it in options and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gaussian => "gaussian",
            Self::Disc => "disc",
        }
    }
}

/// A blur, the same over one window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blur {
    /// Its shape.
    pub psf: Psf,
    /// Standard deviation of a Gaussian, radius of a disc; px.
    pub size_px: f64,
}

impl Blur {
    /// A Gaussian of this standard deviation, px.
    pub fn gaussian(sigma_px: f64) -> Self {
        Self::of_sigma(Psf::Gaussian, sigma_px)
    }

    /// A disc of this radius, px.
    pub fn disc(radius_px: f64) -> Self {
        Self {
            psf: Psf::Disc,
            size_px: radius_px,
        }
    }

    /// The blur of this shape that has this standard deviation along an axis, px.
    pub fn of_sigma(psf: Psf, sigma_px: f64) -> Self {
        let size_px = match psf {
            Psf::Gaussian => sigma_px,
            Psf::Disc => 2.0 * sigma_px,
        };
        Self { psf, size_px }
    }

    /// Smaller sizes than this look the same, in pixels of the grid: the pixel's own box hides them.
    pub(super) fn least_size(&self) -> f64 {
        match self.psf {
            Psf::Gaussian => super::sharp::LEAST_SIGMA,
            Psf::Disc => 2.0 * super::sharp::LEAST_SIGMA,
        }
    }

    /// Standard deviation along an axis, px: half the radius of a disc.
    pub fn sigma_px(&self) -> f64 {
        match self.psf {
            Psf::Gaussian => self.size_px,
            Psf::Disc => 0.5 * self.size_px,
        }
    }
}
