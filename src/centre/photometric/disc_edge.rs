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

use super::boundary::sweeps;
use super::coverage::{COVERAGE_PARAMETERS, Plane};
use super::shape::{SHAPE_PARAMETERS, Shape};
use super::window::Grid;
use std::f32::consts::FRAC_1_PI;

/// Discs up to this many radii of curvature of the circle where it bends most; the segment's series and the fourth order end there.
const MOST_BENT: f64 = 0.75;
/// Smaller circles bend too much within a pixel: least semi-axis, pixels of the grid.
const LEAST_RADIUS: f64 = 4.0;
/// Smaller discs have too sharp a rim for three distances, pixels of the grid.
const LEAST_DISC: f64 = 1.8;
/// The least of a squared root that is divided by.
const TINY: f32 = 1e-12;

/// A circle over a window, and the disc that blurs it; pixels of the grid.
pub(super) struct DiscEdge {
    shape: Shape,
    radius: f64,
    /// Q = x^T (xx, xy, yy) x + 2 (lx, ly) . x - square about the ring's centre.
    form: [f32; 3],
    linear: [f32; 2],
    square: f32,
    centre: [f32; 2],
    /// Rows it reaches.
    rows: (usize, usize),
    /// Radius of the disc.
    disc: f32,
    pixel_px: f32,
}

/// A row of pixels: how each of them stands to the edge, and what it sees of it.
#[derive(Debug, Clone, Default)]
pub(super) struct DiscRow {
    /// Distance beyond the edge; normal at its foot; curvature there, and the two numbers by which the edge is no circle.
    near: [Vec<f32>; 6],
    /// Coverage; how far the tips are from the normal, pixels of the grid; change by the disc's radius.
    seen: [Vec<f32>; 3],
}

impl DiscEdge {
    /// `None` where the circle's image is no ellipse, or bends too much for it.
    pub(super) fn new(grid: &Grid, shape: &Shape, radius: f64, disc: f64) -> Option<Self> {
        let ellipse = shape.ellipse(radius)?;
        let scale = grid.pixel_px;
        let (major, minor) = (ellipse.major / scale, ellipse.minor / scale);
        if disc < LEAST_DISC || minor < LEAST_RADIUS || disc * major > MOST_BENT * minor * minor {
            return None;
        }
        let (matrix, linear) = shape.quadric(radius);
        let (sin, cos) = ellipse.angle.sin_cos();
        let reach = (major * sin).hypot(minor * cos) + disc + 1.0;
        let row = |y: f64| y.clamp(0.0, grid.height as f64) as usize;
        let middle = (ellipse.centre.y - grid.top_px) / scale;
        let square = scale * scale;
        Some(Self {
            shape: *shape,
            radius,
            form: [matrix[(0, 0)], matrix[(0, 1)], matrix[(1, 1)]].map(|v| (v * square) as f32),
            linear: [(linear.x * scale) as f32, (linear.y * scale) as f32],
            square: (radius * radius) as f32,
            centre: [
                ((shape.centre.x - grid.left_px) / scale) as f32,
                ((shape.centre.y - grid.top_px) / scale) as f32,
            ],
            rows: (
                row((middle - reach).floor()),
                row((middle + reach).ceil() + 1.0),
            ),
            disc: disc as f32,
            pixel_px: scale as f32,
        })
    }

    /// Adds the coverage to the first of the planes and, with a contrast, its changes to the others.
    #[inline(always)]
    pub(super) fn cover(
        &self,
        grid: &Grid,
        room: &mut DiscRow,
        (values, changes): (&mut Plane, &mut [Plane; COVERAGE_PARAMETERS]),
        contrast: Option<f32>,
    ) {
        let stride = grid.stride();
        room.resize(stride);
        for row in self.rows.0..self.rows.1 {
            let at = row * stride;
            let y = row as f32 - self.centre[1];
            self.stand(y, room);
            self.see(room);
            let out = values[at..at + stride].iter_mut();
            out.zip(&room.seen[0]).for_each(|(out, seen)| *out += seen);
            if let Some(contrast) = contrast {
                self.change(y, room, changes, (at, contrast));
            }
        }
    }

    /// How the pixels of a row stand to the edge. Q is quadratic along any ray, so that the way to its zero is known; the first
    /// ray follows the gradient at the pixel, the second the one where the first arrives.
    #[inline(always)]
    fn stand(&self, y: f32, room: &mut DiscRow) {
        let [xx, xy, yy] = self.form;
        let [lx, ly] = self.linear;
        let [distance, nx, ny, curvature, along, across] = &mut room.near;
        let n = distance.len();
        let (nx, ny, curvature) = (&mut nx[..n], &mut ny[..n], &mut curvature[..n]);
        let (along, across) = (&mut along[..n], &mut across[..n]);
        for i in 0..n {
            let x = i as f32 - self.centre[0];
            let (gx, gy) = (xx * x + xy * y + lx, xy * x + yy * y + ly);
            let q = (gx + lx) * x + (gy + ly) * y - self.square;
            let length = (gx * gx + gy * gy).max(TINY).sqrt();
            let (ux, uy) = (gx / length, gy / length);
            let bend = xx * ux * ux + 2.0 * xy * ux * uy + yy * uy * uy;
            let way = q / (length + (length * length - q * bend).max(0.0).sqrt());
            let (fx, fy) = (
                gx - way * (xx * ux + xy * uy),
                gy - way * (xy * ux + yy * uy),
            );
            let length = (fx * fx + fy * fy).max(TINY).sqrt();
            let (ux, uy) = (fx / length, fy / length);
            let bend = xx * ux * ux + 2.0 * xy * ux * uy + yy * uy * uy;
            let climb = gx * ux + gy * uy;
            let root = (climb * climb - q * bend).max(TINY).sqrt();
            let scale = 1.0 / root;
            // the gradient of a far pixel may lead past the circle
            distance[i] = q / (climb + root).max(1e-6);
            nx[i] = ux;
            ny[i] = uy;
            curvature[i] = (xx * uy * uy - 2.0 * xy * ux * uy + yy * ux * ux) * scale;
            along[i] = bend * scale;
            across[i] = (xy * (ux * ux - uy * uy) + (yy - xx) * ux * uy) * scale;
        }
    }

    /// What the pixels of a row see of the circle.
    #[inline(always)]
    fn see(&self, room: &mut DiscRow) {
        let disc = self.disc;
        let scale = 1.0 / disc;
        let [distance, nx, ny, curvature, along, across] = &room.near;
        let [seen, tip, growth] = &mut room.seen;
        let n = distance.len();
        let (nx, ny, curvature) = (&nx[..n], &ny[..n], &curvature[..n]);
        let (along, across) = (&along[..n], &across[..n]);
        let (seen, tip, growth) = (&mut seen[..n], &mut tip[..n], &mut growth[..n]);
        for i in 0..n {
            // deep inside, where no edge is in reach, the foot may be anywhere
            let bent = curvature[i].min(MOST_BENT as f32 * scale);
            let (bend, skew) = (along[i] * disc, across[i] * disc);
            let k = bent * disc;
            let fourth = k * (0.5 * skew * skew + 0.125 * k * (bend.min(2.0) - k));
            let (a, b) = (nx[i] * nx[i], ny[i] * ny[i]);
            let square = 0.15 * (a * a + b * b) + 0.5 * a * b;
            let weight = 1.0 / (24.0 * square);
            let apart = square.sqrt() * scale;
            let middle = (distance[i] + bent * (1.0 / 24.0)) * scale;
            let [here, tips] = lens(middle, k, fourth);
            let [beyond, far_tips] = lens(middle + apart, k, fourth);
            let [before, near_tips] = lens(middle - apart, k, fourth);
            let own = 1.0 - 2.0 * weight;
            seen[i] = own * here + weight * (beyond + before);
            let tips = own * tips + weight * (far_tips + near_tips);
            tip[i] = tips * disc;
            let (square, cube) = (tips * tips, tips * tips * tips);
            let bends = k * k * square;
            let by_bend = k * (1.0 / 3.0 + bends * (0.15 + bends * (5.0 / 56.0)));
            let by_disc =
                2.0 * middle.clamp(-1.0, 1.0) * tips - cube * (by_bend + 1.2 * square * fourth);
            growth[i] = FRAC_1_PI * scale * by_disc;
        }
    }

    /// Adds the changes: the slope times how far each parameter moves the edge at the pixel's foot.
    #[inline(always)]
    fn change(
        &self,
        y: f32,
        room: &DiscRow,
        changes: &mut [Plane; COVERAGE_PARAMETERS],
        (at, contrast): (usize, f32),
    ) {
        const _: () = assert!(SHAPE_PARAMETERS == 7);
        let [xx, xy, yy] = self.form;
        let [lx, ly] = self.linear;
        let [distance, nx, ny, curvature, ..] = &room.near;
        let [_, tip, growth] = &room.seen;
        let n = distance.len();
        let (nx, ny, curvature, tip) = (&nx[..n], &ny[..n], &curvature[..n], &tip[..n]);
        let [p0, p1, p2, p3, p4, p5, p6, by_disc] =
            changes.each_mut().map(|plane| &mut plane[at..at + n]);
        for (out, growth) in by_disc.iter_mut().zip(growth) {
            *out += contrast * growth;
        }
        let area = std::f32::consts::PI * self.disc * self.disc;
        for i in 0..n {
            let x = i as f32 - self.centre[0];
            // the arc between the tips by two points (Gauss-Legendre)
            let aside = tip[i] * 0.577_350_26;
            let inwards = distance[i] + 0.5 * curvature[i] * aside * aside;
            let (fx, fy) = (x - inwards * nx[i], y - inwards * ny[i]);
            let mut moved = [0.0; SHAPE_PARAMETERS];
            for side in [-aside, aside] {
                let (px, py) = (fx - side * ny[i], fy + side * nx[i]);
                let (gx, gy) = (xx * px + xy * py + lx, xy * px + yy * py + ly);
                let climb = (gx * nx[i] + gy * ny[i]).max(1e-6);
                let share = -contrast * tip[i] / (2.0 * climb * area);
                let at = [px * self.pixel_px, py * self.pixel_px];
                let all = sweeps(&self.shape, self.radius, at);
                for k in 0..SHAPE_PARAMETERS {
                    moved[k] += share * all[k];
                }
            }
            p0[i] += moved[0];
            p1[i] += moved[1];
            p2[i] += moved[2];
            p3[i] += moved[3];
            p4[i] += moved[4];
            p5[i] += moved[5];
            p6[i] += moved[6];
        }
    }
}

impl DiscRow {
    fn resize(&mut self, stride: usize) {
        let all = self.near.iter_mut().chain(&mut self.seen);
        all.for_each(|row| row.resize(stride, 0.0));
    }
}

/// What a disc has in common with a circle of curvature `k` whose edge is `d` away, over the disc's area, and how far its tips are
/// from the normal; `fourth` is what the edge falls off beyond that circle with the fourth power of the way along it.
#[inline(always)]
fn lens(d: f32, k: f32, fourth: f32) -> [f32; 2] {
    let d = d.clamp(-1.2, 1.2);
    let x = ((2.0 * d + k * (1.0 + d * d)) / (2.0 * (1.0 + k * d))).clamp(-1.0, 1.0);
    let square = 1.0 - x * x;
    let h = square.sqrt();
    let kh = k * k * square;
    let series = 1.0 + kh * (0.3 + kh * (9.0 / 56.0 + kh * (5.0 / 48.0)));
    let segment = h * square * (2.0 / 3.0 * k * series - 0.4 * square * fourth);
    [FRAC_1_PI * (arccos(x) - x * h + segment), h]
}

/// Within 3e-8 (Abramowitz and Stegun, 4.4.46).
#[inline(always)]
fn arccos(x: f32) -> f32 {
    let a = x.abs();
    let series = -0.001_262_491_1;
    let series = 0.006_670_09 + a * series;
    let series = -0.017_088_126 + a * series;
    let series = 0.030_891_88 + a * series;
    let series = -0.050_174_305 + a * series;
    let series = 0.088_978_99 + a * series;
    let series = -0.214_598_8 + a * series;
    let series = std::f32::consts::FRAC_PI_2 + a * series;
    let positive = (1.0 - a).max(0.0).sqrt() * series;
    if x < 0.0 {
        std::f32::consts::PI - positive
    } else {
        positive
    }
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
