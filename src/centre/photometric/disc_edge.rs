//! The coverage by a circle under a disc of blur that is smaller than the circle: pixel by pixel, in closed form.
//!
//! Around a pixel at the distance d beyond an edge of curvature k, both in radii of the disc, the disc and the circle that touches the
//! edge at the pixel's foot have a lens in common. Its tips stand x = (2 d + k (1 + d^2)) / (2 (1 + k d)) from the disc's middle and
//! h = sqrt(1 - x^2) to either side, and of the disc it is
//!
//! ```text
//! B = (arccos x - x h + s) / pi,   s = 2/3 k h^3 (1 + 3/10 (k h)^2 + 9/56 (k h)^4 + ...)   (the circle's own segment)
//! dB = -2 h / pi dd - h^3 / (3 pi) dk
//! ```
//!
//! What an ellipse bends otherwise than that circle is of fourth order along the edge. The pixel's box spreads the light along the
//! normal (n, m) by the second and fourth moments 1/12 and (n^4 + m^4) / 80 + n^2 m^2 / 24: three distances have the same. Along
//! the edge it moves a bent edge by k / 24.

use super::edge::{BlurredEdge, Seen};
use super::feet::{Circle, Foot};
use super::real::{Real, arccos};
use std::f32::consts::FRAC_1_PI;

/// Discs up to this many radii of curvature of the circle where it bends most; the segment's series and the fourth order end there.
const MOST_BENT: f64 = 0.75;
/// Smaller circles bend too much within a pixel: least semi-axis, pixels of the grid.
const LEAST_RADIUS: f64 = 4.0;
/// Smaller discs have too sharp a rim for three distances, pixels of the grid.
const LEAST_DISC: f64 = 1.8;
/// Where the two points of the arc between the tips are that stand for it (Gauss-Legendre).
const ASIDE: f32 = 0.577_350_26;

/// A circle over a window, and the disc that blurs it; pixels of the grid.
pub(super) struct DiscEdge {
    circle: Circle,
    /// Radius of the disc.
    disc: f32,
}

impl DiscEdge {
    /// `None` where the circle bends too much for it.
    pub(super) fn new(circle: &Circle, disc: f64) -> Option<Self> {
        let fits = disc >= LEAST_DISC
            && circle.minor >= LEAST_RADIUS
            && disc * circle.most_bent <= MOST_BENT;
        fits.then_some(Self {
            circle: *circle,
            disc: disc as f32,
        })
    }

    #[inline(always)]
    fn stand<T: Real>(&self, foot: &Foot<T>) -> Stand<T> {
        let disc = self.disc;
        let scale = 1.0 / disc;
        // deep inside, where no edge is in reach, the foot may be anywhere
        let bent = foot.curvature.at_most(MOST_BENT as f32 * scale);
        let (bend, skew) = ((foot.along * disc).at_most(2.0), foot.across * disc);
        let k = bent * disc;
        let [a, b] = foot.normal.map(|n| n * n);
        let square = (a * a + b * b) * 0.15 + a * b * 0.5;
        Stand {
            middle: (foot.distance + bent * (1.0 / 24.0)) * scale,
            k,
            fourth: k * (skew * skew * 0.5 + k * (bend - k) * 0.125),
            apart: square.sqrt() * scale,
            weight: k.like(1.0 / 24.0) / square,
        }
    }
}

impl BlurredEdge for DiscEdge {
    fn circle(&self) -> &Circle {
        &self.circle
    }

    fn reach(&self) -> f32 {
        self.disc + 1.0
    }

    #[inline(always)]
    fn value<T: Real>(&self, foot: &Foot<T>) -> T {
        self.stand(foot).lens()[0]
    }

    #[inline(always)]
    fn see<T: Real>(&self, foot: &Foot<T>) -> Seen<T> {
        let stand = self.stand(foot);
        let Stand {
            middle, k, fourth, ..
        } = stand;
        let [value, tips] = stand.lens();
        let square = tips * tips;
        let bends = k * k * square;
        let by_bend = k * bends.polynomial([5.0 / 56.0, 0.15, 1.0 / 3.0]);
        let by_disc = middle.within(-1.0, 1.0) * tips * 2.0
            - square * tips * (by_bend + square * fourth * 1.2);
        let scale = FRAC_1_PI / self.disc;
        Seen {
            value,
            slope: tips * (2.0 * scale),
            growth: by_disc * scale,
            aside: Some(tips * (ASIDE * self.disc)),
        }
    }
}

/// How pixels stand to the edge, in radii of the disc.
#[derive(Clone, Copy)]
struct Stand<T> {
    middle: T,
    k: T,
    fourth: T,
    /// How far from the middle, and with which weight, the two other distances are that stand for the pixel's box.
    apart: T,
    weight: T,
}

impl<T: Real> Stand<T> {
    /// The lens and its tips, averaged over the pixel.
    #[inline(always)]
    fn lens(&self) -> [T; 2] {
        let Self {
            middle, k, fourth, ..
        } = *self;
        let own = -(self.weight + self.weight) + 1.0;
        let [here, tips] = lens(middle, k, fourth);
        let [beyond, far_tips] = lens(middle + self.apart, k, fourth);
        let [before, near_tips] = lens(middle - self.apart, k, fourth);
        [
            own.times(here, self.weight * (beyond + before)),
            own.times(tips, self.weight * (far_tips + near_tips)),
        ]
    }
}

/// What a disc has in common with a circle of curvature `k` whose edge is `d` away, over the disc's area, and how far its tips are
/// from the normal; `fourth` is what the edge falls off beyond that circle with the fourth power of the way along it.
#[inline(always)]
fn lens<T: Real>(d: T, k: T, fourth: T) -> [T; 2] {
    let d = d.within(-1.2, 1.2);
    let above = d + d + k * (d * d + 1.0);
    let x = (above / (k.times(d, d.like(1.0)) * 2.0)).within(-1.0, 1.0);
    let square = -(x * x) + 1.0;
    let h = square.sqrt();
    let kh = k * k * square;
    let series = kh.polynomial([5.0 / 48.0, 9.0 / 56.0, 0.3, 1.0]);
    let segment = h * square * (k * series * (2.0 / 3.0) - square * fourth * 0.4);
    [(arccos(x) - x * h + segment) * FRAC_1_PI, h]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disc_and_a_circle_have_the_lens_of_geometry_in_common() {
        for (d, k) in [
            (0.0, 0.0),
            (0.3, 0.1),
            (-0.6, 0.4),
            (0.9, 0.7),
            (-0.95, 0.2),
        ] {
            // rows of the disc, against the circle of radius 1 / k that begins at d
            let rows = 20_000;
            let mut area = 0.0_f64;
            for i in 0..rows {
                let y = (f64::from(i) + 0.5) / f64::from(rows) * 2.0 - 1.0;
                let chord = (1.0 - y * y).sqrt();
                let begins = if k == 0.0 {
                    d
                } else {
                    d + (1.0 - (1.0 - k * k * y * y).sqrt()) / k
                };
                area += (chord - begins.clamp(-chord, chord)) * 2.0 / f64::from(rows);
            }
            let [seen, _] = lens(d as f32, k as f32, 0.0);
            let expected = area / std::f64::consts::PI;
            assert!(
                (f64::from(seen) - expected).abs() < 2e-4,
                "{d} {k}: {seen} {expected}"
            );
        }
        assert!(
            lens(1.3, 0.2, 0.0)[0].abs() < 1e-6 && (lens(-1.3, 0.2, 0.0)[0] - 1.0).abs() < 1e-6
        );
    }
}
