//! From rough ellipses to a measured ring: edges, ellipses, blur; or the verdict that it is none.

use super::candidates::looks_concentric;
use super::edges::{LevelRule, RAYS, RingEdges, median, ring_edges};
use super::ellipse_fit::{EXACT, EllipseFit, NEAR, Precision, fit_ellipse};
use crate::centre::{Ellipse, Estimator, RingEllipses};
use crate::frame::{Frame, Pixels};

/// What a ring is measured for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Care {
    /// A fit of its grey values starts from it.
    Start,
    /// Its edges are the result.
    Edges,
}

impl Care {
    /// As much as an estimator needs.
    pub(super) fn of(estimator: Estimator) -> Self {
        match estimator.construction() {
            Some(_) => Self::Edges,
            None => Self::Start,
        }
    }

    /// From which blur on, in a ring's narrowest widths, the edges are taken once more.
    fn filling_blur(self) -> f64 {
        match self {
            Self::Start => 2.0 * FILLING_BLUR,
            Self::Edges => FILLING_BLUR,
        }
    }

    /// Edges are sought along rays of the ellipses of the round before: how many at most, and how well ellipses through them have to be
    /// known.
    fn rounds(self) -> [(usize, Precision); 2] {
        match self {
            Self::Start => [(RAYS.0, NEAR), (RAYS.0, NEAR)],
            Self::Edges => [(RAYS.0, NEAR), (RAYS.1, EXACT)],
        }
    }

    /// Whether rays of the ellipses that came of a round would find what those of the ones before it did.
    fn is_settled(self, before: &RingEllipses, after: &RingEllipses) -> bool {
        let most = HARDLY * (after.outer.minor - after.inner.minor);
        self == Self::Start
            && moved(&before.inner, &after.inner) < most
            && moved(&before.outer, &after.outer) < most
    }

    /// The same of a disc's outline.
    fn is_settled_disc(self, before: &Ellipse, after: &Ellipse, ratio: f64) -> bool {
        self == Self::Start && moved(before, after) < HARDLY * (1.0 - ratio) * after.minor
    }
}

/// How far an ellipse's outline has moved, px.
fn moved(a: &Ellipse, b: &Ellipse) -> f64 {
    let sizes = (a.major - b.major).abs().max((a.minor - b.minor).abs());
    (a.centre - b.centre).norm() + sizes
}

/// Ellipses that moved by less than this fraction of the ring's width did not move.
const HARDLY: f64 = 0.15;
/// Fraction of the edge points that must lie on the ellipse.
const LEAST_INLIERS: f64 = 0.6;
/// How far edges may stray from the ellipse: px, and as a fraction of the ring's width.
const MOST_STRAY: (f64, f64) = (0.25, 0.12);
/// How far above the board's radius ratio the measured one may be.
const RATIO_SLACK: f64 = 1.5;
/// A disc less blurred than this fraction of what would be its inner radius is a plain disc. The inner disc of a ring drowns where a
/// disc of blur becomes as large as it, whose sigma is half of that; measured blur falls short of the true one there by a third, and the
/// outline, of which the inner radius is a part, looks a quarter larger than it is.
const DROWNING_BLUR: f64 = 0.25;
/// What an outline may be smaller by than the rough one: where the blur is too small for such a one, none is fitted.
const MOST_SHRUNK: f64 = 0.6;
/// Blur fills a ring and displaces its edges from this fraction of its narrowest width on.
const FILLING_BLUR: f64 = 0.12;
/// Where rays of a disc begin, as a fraction of its radius.
const DISC_MIDDLE: f64 = 0.05;

/// A ring measured on the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RingFit {
    /// The image of its outer circle, px.
    pub(super) outer: Ellipse,
    /// The image of its inner circle, px; `None` where the blur has drowned it.
    pub(super) inner: Option<Ellipse>,
    /// Standard deviation of the Gaussian that best explains the blur of the outer edge, px.
    pub(super) blur_sigma_px: f64,
    /// Distance of the edge points from the ellipses, px.
    pub(super) stray_px: f64,
    /// Grey difference across the outer edge, 0..1.
    pub(super) contrast: f64,
}

/// Measures a ring near rough ellipses; `None` where there is none. `sign` is 1 for dark rings, -1 for light ones; `ratio`
/// the board's inner over outer radius.
pub(super) fn measure(
    frame: &Frame,
    rough: &RingEllipses,
    sign: f64,
    ratio: f64,
    care: Care,
) -> Option<RingFit> {
    let mut ellipses = *rough;
    let mut fit = None;
    for (most_rays, precision) in care.rounds() {
        let before = ellipses;
        let mut edges = edges_of(frame, &ellipses, sign, (LevelRule::Extrema, most_rays))?;
        let stray_px;
        (ellipses, stray_px) = through(&edges, ratio, precision)?;
        fit = Some(RingFit {
            outer: ellipses.outer,
            inner: Some(ellipses.inner),
            blur_sigma_px: median(&mut edges.blur_sigma_px),
            stray_px,
            contrast: edges.contrast,
        });
        if care.is_settled(&before, &ellipses) {
            break;
        }
    }
    let found = fit?;
    let width = found.outer.minor - found.inner.map_or(0.0, |inner| inner.minor);
    if found.blur_sigma_px < care.filling_blur() * width {
        return Some(found);
    }
    Some(at_print_levels(frame, &found, sign, ratio, care).unwrap_or(found))
}

/// Measures the outer edge alone of a ring so blurred that its inner disc does not show; `None` where there is none, or
/// where the blur is too small to have drowned an inner disc.
pub(super) fn measure_disc(
    frame: &Frame,
    rough: &Ellipse,
    sign: f64,
    ratio: f64,
    care: Care,
) -> Option<RingFit> {
    let mut outline = *rough;
    let mut fit = None;
    for (most_rays, precision) in care.rounds() {
        let rays = RingEllipses {
            inner: scaled(&outline, DISC_MIDDLE),
            outer: outline,
        };
        let mut edges = edges_of(frame, &rays, sign, (LevelRule::Extrema, most_rays))?;
        let blur_sigma_px = median(&mut edges.blur_sigma_px);
        if blur_sigma_px < DROWNING_BLUR * ratio * MOST_SHRUNK * outline.minor {
            return None;
        }
        let outer = fit_ellipse(&edges.outer, precision)?;
        let drowned = blur_sigma_px > DROWNING_BLUR * ratio * outer.ellipse.minor;
        if !(drowned && is_clean(&outer, outer.ellipse.minor)) {
            return None;
        }
        let before = std::mem::replace(&mut outline, outer.ellipse);
        fit = Some(RingFit {
            outer: outline,
            inner: None,
            blur_sigma_px,
            stray_px: outer.scale_px,
            contrast: edges.contrast,
        });
        if care.is_settled_disc(&before, &outline, ratio) {
            break;
        }
    }
    fit
}

/// The same ring with its edges at the levels of the print; `None` where it has none there.
fn at_print_levels(
    frame: &Frame,
    ring: &RingFit,
    sign: f64,
    ratio: f64,
    care: Care,
) -> Option<RingFit> {
    let [_, (most_rays, precision)] = care.rounds();
    let ellipses = RingEllipses {
        inner: ring.inner?,
        outer: ring.outer,
    };
    let edges = edges_of(frame, &ellipses, sign, (LevelRule::Print, most_rays))?;
    let (moved, stray_px) = through(&edges, ratio, precision)?;
    Some(RingFit {
        outer: moved.outer,
        inner: Some(moved.inner),
        stray_px,
        ..*ring
    })
}

/// The ellipses through both edges and how far these stray from them, px; `None` where they are none of one ring.
fn through(edges: &RingEdges, ratio: f64, precision: Precision) -> Option<(RingEllipses, f64)> {
    let inner = fit_ellipse(&edges.inner, precision)?;
    let outer = fit_ellipse(&edges.outer, precision)?;
    let ellipses = RingEllipses {
        inner: inner.ellipse,
        outer: outer.ellipse,
    };
    let width = outer.ellipse.minor - inner.ellipse.minor;
    let clean = is_clean(&inner, width) && is_clean(&outer, width);
    (clean && looks_concentric(&ellipses, ratio, RATIO_SLACK))
        .then(|| (ellipses, inner.scale_px.max(outer.scale_px)))
}

fn edges_of(
    frame: &Frame,
    rough: &RingEllipses,
    sign: f64,
    rule: (LevelRule, usize),
) -> Option<RingEdges> {
    match &frame.pixels {
        Pixels::U8(plane) => ring_edges(plane, rough, sign, rule),
        Pixels::U16(plane) => ring_edges(plane, rough, sign, rule),
    }
}

fn is_clean(fit: &EllipseFit, width_px: f64) -> bool {
    let most_stray = MOST_STRAY.0 + MOST_STRAY.1 * width_px.max(0.0);
    fit.inliers >= LEAST_INLIERS && fit.scale_px <= most_stray
}

fn scaled(ellipse: &Ellipse, factor: f64) -> Ellipse {
    Ellipse {
        major: ellipse.major * factor,
        minor: ellipse.minor * factor,
        ..*ellipse
    }
}
