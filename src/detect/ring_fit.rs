//! From rough ellipses to a measured ring: edges, ellipses, blur; or the verdict that it is none.

use super::candidates::looks_concentric;
use super::edges::{median, ring_edges};
use super::ellipse_fit::{EllipseFit, fit_ellipse};
use crate::centre::RingEllipses;
use crate::frame::{Frame, Pixel, Pixels, Plane};

/// Edges are sought along rays of the ellipses of the round before.
const ROUNDS: usize = 2;
/// Fraction of the edge points that must lie on the ellipse.
const LEAST_INLIERS: f64 = 0.6;
/// How far edges may stray from the ellipse: px, and as a fraction of the ring's width.
const MOST_STRAY: (f64, f64) = (0.25, 0.12);

/// A ring measured on the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RingFit {
    /// The images of its circles, px.
    pub(super) ellipses: RingEllipses,
    /// Standard deviation of the Gaussian that best explains the blur of the outer edge, px.
    pub(super) blur_sigma_px: f64,
    /// Distance of the edge points from the ellipses, px.
    pub(super) stray_px: f64,
    /// Grey difference across the outer edge, 0..1.
    pub(super) contrast: f64,
}

/// Measures a ring near rough ellipses; `None` where there is none. `sign` is 1 for dark rings, -1 for light ones.
pub(super) fn measure(
    frame: &Frame,
    rough: &RingEllipses,
    sign: f64,
    ratio: f64,
) -> Option<RingFit> {
    match &frame.pixels {
        Pixels::U8(plane) => measure_in(plane, rough, sign, ratio),
        Pixels::U16(plane) => measure_in(plane, rough, sign, ratio),
    }
}

fn measure_in<T: Pixel>(
    plane: &Plane<T>,
    rough: &RingEllipses,
    sign: f64,
    ratio: f64,
) -> Option<RingFit> {
    let mut ellipses = *rough;
    let mut fit = None;
    for _ in 0..ROUNDS {
        let mut edges = ring_edges(plane, &ellipses, sign)?;
        let inner = fit_ellipse(&edges.inner)?;
        let outer = fit_ellipse(&edges.outer)?;
        ellipses = RingEllipses {
            inner: inner.ellipse,
            outer: outer.ellipse,
        };
        if !is_ring(&inner, &outer, &ellipses, ratio) {
            return None;
        }
        fit = Some(RingFit {
            ellipses,
            blur_sigma_px: median(&mut edges.blur_sigma_px),
            stray_px: inner.scale_px.max(outer.scale_px),
            contrast: edges.contrast,
        });
    }
    fit
}

fn is_ring(inner: &EllipseFit, outer: &EllipseFit, ellipses: &RingEllipses, ratio: f64) -> bool {
    let width = outer.ellipse.minor - inner.ellipse.minor;
    let most_stray = MOST_STRAY.0 + MOST_STRAY.1 * width.max(0.0);
    [inner, outer]
        .iter()
        .all(|fit| fit.inliers >= LEAST_INLIERS && fit.scale_px <= most_stray)
        && looks_concentric(ellipses, ratio, 1.5)
}
