//! One ring measured by its grey values alone: window, starts, fit, and the gate that decides whether to believe it.

use super::blur::{Blur, Psf};
use super::choice::PsfChoice;
use super::fit::{Given, Known};
use super::fitted::{FitError, RingFitted};
use super::model::RingModel;
use super::problem::Workspace;
use super::shape::Shape;
use super::start::{Cut, cut, is_sharp, levels};
use super::window::Window;
use crate::centre::Ellipse;
use crate::frame::{Frame, Linear};

/// How far the fitted centre may be from where the ring was seen, in minor semi-axes of what was seen.
const FARTHEST: f64 = 0.5;
/// Fitted size over the size seen: blur makes a ring look larger than it is.
const SIZES_SEEN: (f64, f64) = (0.3, 1.6);
/// The residuals of a ring are noise: larger than this fraction of its contrast, something else is in the window.
const MOST_NOISE: f64 = 0.25;
/// A centre less certain than this fraction of the outer minor semi-axis is no measurement.
const LEAST_CERTAIN: f64 = 0.1;
/// The window is cut anew where the fitted blur is not within these factors of the one it was cut for.
const SAME_BLUR: (f64, f64) = (0.7, 1.25);
/// Windows are cut so often at most.
const CUTS: usize = 4;
/// Edges of a blurred ring stand too far out and look too sharp: sizes (of the ellipse seen) and blurs (of the one seen, and of
/// the size) that are tried.
const SIZES: [f64; 6] = [1.12, 1.0, 0.9, 0.8, 0.7, 0.58];
const BLURS: [f64; 3] = [1.0, 1.35, 1.8];
const BLURS_OF_SIZE: [f64; 5] = [0.12, 0.2, 0.3, 0.42, 0.56];
/// So many of the starts are fitted.
const FITTED: usize = 3;

/// Why a ring has no photometric centre.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum RingError {
    /// The ring lies outside the frame.
    #[error("the ring is outside the frame")]
    Outside,
    /// The fit failed.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The fit ended on something that is not this ring.
    #[error("the fit ended on something else: {what}")]
    NotThisRing {
        /// What gave it away.
        what: &'static str,
    },
    /// Something covers a part of the ring: the fit explains its grey values far worse than those of the others.
    #[error("something covers it: its residuals are {times:.1} times as large as the others'")]
    Covered {
        /// Its residuals over what is usual.
        times: f64,
    },
}

/// A ring as it was seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Its outline, px: the outer ellipse, or the blurred patch where no edge shows.
    pub outline: Ellipse,
    /// Inner over outer radius on the board.
    pub ratio: f64,
    /// 1 for a dark ring, -1 for a light one.
    pub sign: f64,
}

/// A ring to be measured alone.
#[derive(Debug, Clone, Copy)]
pub struct RingStart<'a> {
    /// What was seen of it.
    pub seen: Seen,
    /// The blur its edges gave, px.
    pub sigma_px: f64,
    /// The shape of the blur.
    pub psf: PsfChoice,
    /// Light from grey values.
    pub linear: &'a Linear,
}

/// Measures a ring that stands alone.
///
/// # Errors
/// [`RingError`] where its pixels determine no ring, or another one than was asked for.
pub fn measure_ring(
    frame: &Frame,
    ring: &RingStart,
    room: &mut Workspace,
) -> Result<RingFitted, RingError> {
    let mut outline = ring.seen.outline;
    let mut sigma_px = ring.sigma_px.max(0.3);
    let mut best: Option<RingFitted> = None;
    for _ in 0..CUTS {
        let pixels =
            cut(frame, &outline, sigma_px, Cut::ALONE, ring.linear).ok_or(RingError::Outside)?;
        let fitted = match best {
            None => fit_starts(&pixels, ring, room)?,
            Some(before) => {
                let psf = before.model.blur.psf;
                let again = known(&pixels, ring).fit_with(&before.model, psf, room);
                match again
                    .map_err(RingError::from)
                    .and_then(|f| gate(&ring.seen, f))
                {
                    Ok(fitted) => fitted,
                    Err(_) => break,
                }
            }
        };
        let model = fitted.model;
        let fitted_px = model.blur.sigma_px().max(0.3);
        best = Some(fitted);
        let change = fitted_px / sigma_px;
        let same = change > SAME_BLUR.0 && change < SAME_BLUR.1;
        if same || fitted_px.max(sigma_px) < 1.0 {
            break;
        }
        sigma_px = fitted_px;
        outline = model.shape.ellipse(1.0).unwrap_or(outline);
    }
    best.ok_or(RingError::Outside)
}

fn known<'a>(window: &'a Window, ring: &RingStart) -> Known<'a> {
    Known {
        window,
        ratio: ring.seen.ratio,
        around: None,
        given: Given::Nothing,
    }
}

/// The most likely of the fits from the most promising starts that end on this ring.
fn fit_starts(
    window: &Window,
    ring: &RingStart,
    room: &mut Workspace,
) -> Result<RingFitted, RingError> {
    let starts = starts(window, ring, room);
    let mut best: Option<RingFitted> = None;
    let mut failure = RingError::Fit(FitError::Undetermined);
    for start in starts.iter().take(FITTED) {
        let fitted = known(window, ring).fit_choice(start, ring.psf, room);
        match fitted
            .map_err(RingError::from)
            .and_then(|f| gate(&ring.seen, f))
        {
            Ok(fitted) if best.is_none_or(|b| fitted.squares < b.squares) => best = Some(fitted),
            Ok(_) => {}
            Err(error) => failure = error,
        }
    }
    best.ok_or(failure)
}

/// Starts near an outline, the most promising first, no two of them alike.
fn starts(window: &Window, ring: &RingStart, room: &mut Workspace) -> Vec<RingModel> {
    let seen_px = ring.seen.outline.mean_radius();
    let sharp = is_sharp(ring.sigma_px, ring.seen.ratio * ring.seen.outline.minor);
    let seen_blurs = BLURS.iter().map(|factor| factor * ring.sigma_px.max(0.3));
    let (sizes, blurs): (&[f64], Vec<f64>) = if sharp {
        (&SIZES[1..2], seen_blurs.take(2).collect())
    } else {
        let of_size = BLURS_OF_SIZE.iter().map(|factor| factor * seen_px);
        (&SIZES, seen_blurs.chain(of_size).collect())
    };
    let psf = match ring.psf {
        PsfChoice::Fixed(psf) => psf,
        PsfChoice::Auto => Psf::Gaussian,
    };
    let mut found: Vec<(f64, RingModel)> = Vec::new();
    for sigma_px in blurs {
        for &factor in sizes {
            let shape = Shape::frontal(&ring.seen.outline).scaled(factor);
            let blur = Blur::of_sigma(psf, sigma_px);
            found.extend(
                levels(window, (&shape, &blur), ring.seen.ratio, None, room)
                    .filter(|(_, model)| has_contrast(ring.seen.sign, model)),
            );
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.into_iter().map(|(_, model)| model).collect()
}

pub(super) fn has_contrast(sign: f64, model: &RingModel) -> bool {
    sign * (model.paper - model.ring) > 0.0 && sign * (model.inside - model.ring) > 0.0
}

/// The fit, where it is the ring that was seen.
pub(super) fn gate(seen: &Seen, fitted: RingFitted) -> Result<RingFitted, RingError> {
    let outer = &seen.outline;
    let model = &fitted.model;
    let contrast = seen.sign * (model.paper - model.ring);
    let relative = model
        .shape
        .ellipse(1.0)
        .map(|e| e.mean_radius() / outer.mean_radius());
    let what = if (model.shape.centre - outer.centre).norm() > FARTHEST * outer.minor {
        "its centre is elsewhere"
    } else if !relative.is_some_and(|s| s > SIZES_SEEN.0 && s < SIZES_SEEN.1) {
        "its size is another"
    } else if !has_contrast(seen.sign, model) {
        "its contrast is reversed"
    } else if fitted.noise > MOST_NOISE * contrast {
        "its residuals are no noise"
    } else if fitted.centre_covariance().trace().sqrt() > LEAST_CERTAIN * outer.minor {
        "its centre is uncertain"
    } else {
        return Ok(fitted);
    };
    Err(RingError::NotThisRing { what })
}
