//! The coverage by a circle whose blur is less than half a pixel: pixel by pixel, because nodes would have to be as close as the blur
//! is small.
//!
//! Within a pixel such an edge is straight, at the distance d along its normal (M, m), M >= m >= 0. What the pixel's box and the blur
//! (sigma s) leave of it is the step integrated twice more, over M and over m:
//!
//! ```text
//! B = s^2 (J(u1) - J(u2) - J(u3) + J(u4)) / (M m),   u = (-d +- M/2 +- m/2) / s,   J'' = Phi
//! ```
//!
//! Changes by d and by s are the same with G = J' and with Phi, times s. Where the edge bends (curvature k) its distance is
//! d + k t^2 / 2 at t along it, and the pixel loses k / 2 times the integral of t^2 along the edge: s^2 of the blur, which moves the edge
//! as a whole, and the box's part, a cubic spline of d between the box's corners, blurred too. What is left is of second
//! order in k: less than 1e-3 of the contrast for circles of 8 pixels.

use super::edge::{BlurredEdge, Seen};
use super::feet::{Circle, Foot};
use super::normal::density_and_cumulative;
use super::real::Real;

/// Blur from which on other forms are as good, pixels of the grid.
pub(super) const MOST_SIGMA: f64 = 0.5;
/// Smaller blurs look the same, pixels of the grid: the pixel's own box hides them.
pub(super) const LEAST_SIGMA: f64 = 0.015;
/// Smaller circles bend too much within a pixel: least semi-axis, pixels of the grid.
pub(super) const LEAST_RADIUS: f64 = 5.0;
/// The step is flat beyond this many sigmas.
const REACH: f32 = 4.4;
/// The smaller part of the normal is taken as this at least, and as this many sigmas: differences would be rounding otherwise.
const LEAST_SLOPE: (f32, f32) = (0.05, 0.2);

/// A circle over a window, and its blur; pixels of the grid.
pub(super) struct SharpCircle {
    circle: Circle,
    sigma: f32,
    reach: f32,
}

impl SharpCircle {
    /// `None` where the circle is too small.
    pub(super) fn new(circle: &Circle, sigma: f64) -> Option<Self> {
        (circle.minor >= LEAST_RADIUS).then_some(Self {
            circle: *circle,
            sigma: sigma as f32,
            reach: REACH * sigma as f32 + 0.75,
        })
    }

    /// The density at a way inwards, and the powers 0 to 3 of the ways beyond, blurred.
    #[inline(always)]
    fn powers<T: Real>(&self, way: T) -> (T, [T; 4]) {
        let sigma = self.sigma;
        let u = (way * (1.0 / sigma)).within(-2.0 * REACH, 2.0 * REACH);
        let (density, cumulative) = density_and_cumulative(u);
        // beyond the reach the integrals go on as those of the sharp step
        let way = u.choose(way, u * sigma);
        let (squares, variance, spread) = (way * way, sigma * sigma, density * sigma);
        let first = way.times(cumulative, spread);
        let second = (squares + variance).times(cumulative, way * spread);
        let third = (way * (squares + 3.0 * variance))
            .times(cumulative, (squares + 2.0 * variance) * spread);
        (density, [cumulative, first, second, third])
    }
}

impl BlurredEdge for SharpCircle {
    fn circle(&self) -> &Circle {
        &self.circle
    }

    fn reach(&self) -> f32 {
        self.reach
    }

    #[inline(always)]
    fn value<T: Real>(&self, foot: &Foot<T>) -> T {
        self.see(foot).value
    }

    #[inline(always)]
    fn see<T: Real>(&self, foot: &Foot<T>) -> Seen<T> {
        let sigma = self.sigma;
        let least = LEAST_SLOPE.0.max(LEAST_SLOPE.1 * sigma);
        let [across, down] = foot.normal.map(|n| n.magnitude());
        let (large, small) = (across.larger(down), across.smaller(down).at_least(least));
        let half_bend = foot.curvature * 0.5;
        // farther away there is nothing but rounding
        let middle = half_bend.times(across.like(-sigma * sigma), -foot.distance);
        let middle = middle.within(-self.reach, self.reach);
        let scale = across.like(2.0) / (large * small);
        let zero = across.like(0.0);
        let (mut value, mut slope, mut change) = (zero, zero, zero);
        for (corner, [linear, square, cube]) in CORNERS.into_iter().zip(bends(large, small)) {
            let way = middle + large * corner[0] + small * corner[1];
            let (density, [zeroth, first, second, third]) = self.powers(way);
            let (linear, cube) = (half_bend * linear, half_bend * cube);
            let square = scale * (corner[0] * corner[1]) - half_bend * square;
            value = value + square * second - linear * first - cube * third;
            slope = slope + square * first * 2.0 - linear * zeroth - cube * second * 3.0;
            let by_sigma = (square * zeroth * 2.0 - cube * first * 6.0) * sigma;
            change = change + by_sigma - linear * density;
        }
        Seen {
            value,
            slope,
            growth: change - half_bend * slope * (2.0 * sigma),
            aside: None,
        }
    }
}

/// The corners of a pixel, in the order in which an edge leaves them behind.
const CORNERS: [[f32; 2]; 4] = [[0.5, 0.5], [0.5, -0.5], [-0.5, 0.5], [-0.5, -0.5]];

/// The integral of t^2 over the part of an edge that lies in the pixel, as a spline of the edge's way beyond each corner: what its first,
/// second and third power get there, where the edge goes on to the next side of the pixel.
#[inline(always)]
fn bends<T: Real>(large: T, small: T) -> [[T; 3]; 4] {
    let (near, far) = ((large - small) * 0.5, (large + small) * 0.5);
    let (flat, steep) = (small / large, large / small);
    let linear = flat + steep;
    let (steep_square, flat_square) = (steep * steep, flat * flat);
    let square = steep_square - flat_square;
    let cube = (flat_square * flat + steep_square * steep) * (1.0 / 3.0);
    let (near_linear, far_linear) = (near * near * linear, -(far * far * linear));
    [
        [near_linear, -(near * square), cube],
        [far_linear, -(far * square), -cube],
        [far_linear, far * square, -cube],
        [near_linear, near * square, cube],
    ]
}
