//! How far out of focus each point of the board is.

/// The shape of the blur.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Psf {
    /// A normal distribution; its size is the standard deviation.
    #[default]
    Gaussian,
    /// A disc of even light (pillbox), as a round aperture makes; its size is the radius.
    Disc,
}

impl Psf {
    /// Standard deviation along one axis of a blur of this size.
    pub fn sigma_px(self, size_px: f64) -> f64 {
        match self {
            Self::Gaussian => size_px,
            Self::Disc => 0.5 * size_px,
        }
    }
}

/// A thin lens with a round aperture, focused at one distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThinLens {
    /// Focal length over the aperture's diameter.
    pub f_number: f64,
    /// Focal length of the lens, m (the camera's `fx` is its image distance in pixels, a little more).
    pub focal_length_m: f64,
    /// Distance between pixels, m.
    pub pixel_m: f64,
    /// Distance of the plane in focus from the lens, m.
    pub focus_m: f64,
}

impl ThinLens {
    /// Radius of the disc over the difference of inverse depth, px m.
    fn radius_px_m(&self) -> f64 {
        let image_m = self.focal_length_m * self.focus_m / (self.focus_m - self.focal_length_m);
        0.5 * self.focal_length_m / self.f_number * image_m / self.pixel_m
    }

    /// Radius of the disc of light from a point at this depth, px; negative nearer than the focus.
    pub fn radius_px(&self, depth_m: f64) -> f64 {
        self.radius_px_m() * (1.0 / self.focus_m - 1.0 / depth_m)
    }
}

/// How far out of focus the board is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Defocus {
    /// In focus everywhere.
    #[default]
    None,
    /// The same blur in the whole frame.
    Uniform {
        /// Its shape.
        psf: Psf,
        /// Standard deviation of a Gaussian or radius of a disc, px.
        size_px: f64,
    },
    /// Blur by depth: it varies over a tilted board.
    ThinLens {
        /// Disc is the lens itself; a Gaussian takes the same standard deviation.
        psf: Psf,
        /// The lens.
        lens: ThinLens,
    },
}

impl Defocus {
    /// A Gaussian blur of the same standard deviation everywhere, px.
    pub fn gaussian(sigma_px: f64) -> Self {
        Self::Uniform {
            psf: Psf::Gaussian,
            size_px: sigma_px,
        }
    }

    /// A disc of the same radius everywhere, px.
    pub fn disc(radius_px: f64) -> Self {
        Self::Uniform {
            psf: Psf::Disc,
            size_px: radius_px,
        }
    }

    /// The shape of the blur.
    pub fn psf(&self) -> Psf {
        match self {
            Self::None => Psf::Gaussian,
            Self::Uniform { psf, .. } | Self::ThinLens { psf, .. } => *psf,
        }
    }

    /// Size of the blur of a point at this depth (sigma of a Gaussian, radius of a disc), px, and its derivative
    /// with depth, px/m.
    pub fn size_px(&self, depth_m: f64) -> (f64, f64) {
        match self {
            Self::None => (0.0, 0.0),
            Self::Uniform { size_px, .. } => (*size_px, 0.0),
            Self::ThinLens { psf, lens } => {
                let share = match psf {
                    Psf::Disc => 1.0,
                    Psf::Gaussian => Psf::Disc.sigma_px(1.0),
                };
                let radius = share * lens.radius_px(depth_m);
                let slope = share * lens.radius_px_m() / (depth_m * depth_m);
                (radius.abs(), slope * radius.signum())
            }
        }
    }
}
