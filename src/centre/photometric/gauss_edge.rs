//! The coverage by a circle under a Gaussian blur that is small against the circle: pixel by pixel, in closed form.
//!
//! The pixel's box is blur, too: with s^2 = sigma^2 + 1/12 the step at the distance u (in s, outwards) from a straight edge is
//! `Phi(-u) + phi(u) (b_4 He_3(u) / 24 + b_6 He_5(u) / 720)`, where the Edgeworth terms b_4 = -(n^4 + m^4) / (120 s^4) and
//! b_6 = (n^6 + m^6) / (252 s^6) are what the box, seen along the normal (n, m), is otherwise than a Gaussian.
//!
//! An edge that bends (curvature k, in 1 / s) loses `phi(u) C(u, k)`. C is a polynomial that was fitted to circles; it begins like the series of
//! the integral, k / 2 - 3/8 k^2 u + ..., and is right within 3e-4 of the contrast to k = 1/4. An ellipse's edge falls off beyond its
//! circle of curvature with the third and fourth power of the way along it, which adds 3/8 k^2 (b - k) + 3/2 k c^2 (`Feet`: b and c
//! are zero and k for a circle).
//!
//! The slope is -dB/du; the arc that is seen is a Gaussian of deviation 1 / sqrt(1 + k u), for which two points stand.

use super::edge::{BlurredEdge, Seen};
use super::feet::{Circle, Foot};
use super::normal::density_and_cumulative;
use super::real::Real;

/// Curvature of the edge where it bends most, in 1 / s.
pub(super) const MOST_BENT: f64 = 0.25;
/// The step is flat beyond this many s.
const REACH: f32 = 4.4;

/// A circle over a window, and the Gaussian that blurs it; pixels of the grid.
pub(super) struct GaussEdge {
    circle: Circle,
    sigma: f32,
    /// With the pixel's own blur.
    spread: f32,
}

impl GaussEdge {
    /// `None` where the circle bends too much for it.
    pub(super) fn new(circle: &Circle, sigma: f64) -> Option<Self> {
        let spread = (sigma * sigma + 1.0 / 12.0).sqrt();
        (spread * circle.most_bent <= MOST_BENT).then_some(Self {
            circle: *circle,
            sigma: sigma as f32,
            spread: spread as f32,
        })
    }

    #[inline(always)]
    fn stand<T: Real>(&self, foot: &Foot<T>) -> Stand<T> {
        let scale = 1.0 / self.spread;
        let square = scale * scale;
        let u = (foot.distance * scale).within(-REACH, REACH);
        // deep inside, where no edge is in reach, the foot may be anywhere
        let k = (foot.curvature * self.spread).at_most(1.2 * MOST_BENT as f32);
        let bend = (foot.along * self.spread).at_most(1.0);
        let skew = (foot.across * self.spread).within(-0.5, 0.5);
        let [a, b] = foot.normal.map(|n| n * n);
        Stand {
            u,
            v: u * u,
            k,
            unlike: k * (k * (bend - k) * 0.375 + skew * skew * 1.5),
            box4: (a * a + b * b) * (-square * square / (120.0 * 24.0)),
            box6: (a * a * a + b * b * b) * (square * square * square / (252.0 * 720.0)),
        }
    }
}

impl BlurredEdge for GaussEdge {
    fn circle(&self) -> &Circle {
        &self.circle
    }

    fn reach(&self) -> f32 {
        REACH * self.spread
    }

    #[inline(always)]
    fn value<T: Real>(&self, foot: &Foot<T>) -> T {
        let stand = self.stand(foot);
        let (density, below) = density_and_cumulative(-stand.u);
        let (he3, he5) = stand.odd();
        let bent = Bent::at(stand.k).of(stand.u, stand.v) + stand.unlike;
        density.times(stand.box4 * he3 + stand.box6 * he5 - bent, below)
    }

    #[inline(always)]
    fn see<T: Real>(&self, foot: &Foot<T>) -> Seen<T> {
        let stand = self.stand(foot);
        let Stand { u, v, k, .. } = stand;
        let (density, below) = density_and_cumulative(-u);
        let (he3, he5) = stand.odd();
        let he4 = v * (v - 6.0) + 3.0;
        let he6 = v * (v * (v - 15.0) + 45.0) - 15.0;
        let (by4, by6) = (stand.box4 * he3, stand.box6 * he5);
        let polynomial = Bent::at(k);
        let bent = polynomial.of(u, v) + stand.unlike;
        let fall = polynomial.slope(u, v) - u * bent + 1.0;
        let slope = density * (fall + stand.box4 * he4 + stand.box6 * he6);
        let by_bend = Bent::by_bend(k, u, v) + stand.unlike * 3.0;
        let by_box = by4 * 4.0 + by6 * 6.0;
        let scale = 1.0 / self.spread;
        Seen {
            value: density.times(by4 + by6 - bent, below),
            slope: slope * scale,
            growth: (u * slope - density * (by_bend + by_box)) * (self.sigma * scale * scale),
            aside: Some(k.like(self.spread) / (k * u + 1.0).at_least(0.3).sqrt()),
        }
    }
}

/// How pixels stand to the edge, in s; the edge's bend otherwise than a circle's, and the box's terms.
#[derive(Clone, Copy)]
struct Stand<T> {
    u: T,
    v: T,
    k: T,
    unlike: T,
    box4: T,
    box6: T,
}

impl<T: Real> Stand<T> {
    /// He_3 and He_5.
    #[inline(always)]
    fn odd(&self) -> (T, T) {
        let Self { u, v, .. } = *self;
        (u * (v - 3.0), u * (v * (v - 10.0) + 15.0))
    }
}

/// C as a polynomial of u.
#[derive(Clone, Copy)]
struct Bent<T> {
    even: [T; 4],
    odd: [T; 3],
}

impl<T: Real> Bent<T> {
    #[inline(always)]
    fn at(k: T) -> Self {
        let w = k * k;
        let cube = k * w;
        Self {
            even: [
                k * w.polynomial([-0.165_48, 0.076_968, 0.499_76]),
                k * w.polynomial([1.4, 0.243_3, 0.000_677_83]),
                cube * w.polynomial([-0.609_03, 0.037_425]),
                cube * w.polynomial([0.216_28, -0.009_045_2]),
            ],
            odd: [
                w * w.polynomial([-1.756_6, -0.143_76, -0.370_46]),
                w * w.polynomial([3.627_8, -0.355_06, -0.004_123_4]),
                w * w * w.polynomial([-1.755_1, 0.067_459]),
            ],
        }
    }

    #[inline(always)]
    fn of(&self, u: T, v: T) -> T {
        let [e0, e2, e4, e6] = self.even;
        let [o1, o3, o5] = self.odd;
        let odd = v.times(v.times(o5, o3), o1);
        u.times(odd, v.times(v.times(v.times(e6, e4), e2), e0))
    }

    /// dC/du.
    #[inline(always)]
    fn slope(&self, u: T, v: T) -> T {
        let [_, e2, e4, e6] = self.even;
        let [o1, o3, o5] = self.odd;
        let even = v.times(v.times(o5 * 5.0, o3 * 3.0), o1);
        u.times(v.times(v.times(e6 * 6.0, e4 * 4.0), e2 + e2), even)
    }

    /// k dC/dk, to the fourth power of k.
    #[inline(always)]
    fn by_bend(k: T, u: T, v: T) -> T {
        let w = k * k;
        let even = w.times(
            v.polynomial([0.112_275, 0.729_9, 0.230_904]),
            k.like(0.499_76),
        );
        let odd = w.times(
            v.polynomial([0.269_836, -1.420_24, -0.575_04]),
            k.like(-0.740_92),
        );
        k * (k * u).times(odd, even)
    }
}
