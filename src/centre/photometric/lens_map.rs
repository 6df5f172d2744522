//! The map from the board to the frame that its own centres tell: a homography and a lens, smooth; before a lens that no polynomial
//! describes a `fan`.
//!
//! A ring knows little of its own perspective, but the centres of a board's rings lie so exactly that the second derivatives of
//! the map through them (`through`) are known far better. What a ring needs of the map is its shape there.
//!
//! To second order the map is X -> c + J d + H[d, d] / 2, d in outer radii. Of H, a circle shows only what moves its outline as a
//! perspective does: with K = J^-1 H the outline of radius a moves outwards by a^2 e.K[e, e] / 2 in direction e, whose part
//! with one period around the circle is -a^2 g.e, g_i = -(sum_j K_i,jj + 2 sum_j K_j,ij) / 8. (For a homography that is
//! all; a lens adds a part with three periods, which no parameter of a ring resembles.)

use super::bent::Bent;
use super::fan::Fan;
use super::shape::Shape;
use crate::camera::homography::apply;
use crate::camera::{Camera, Distortion, Intrinsics, PlumbBob};
use nalgebra::{Matrix2, Matrix3, Point2, SMatrix, SVector, Vector2};

/// Parameters of the lens: the coefficients, its axis in the frame and its pixels' shape.
pub(super) const MOST_LENS: usize = 8;
/// Parameters of a map: the homography's first eight entries, then the lens. Those that are not free never change.
pub(super) const MAP: usize = 8 + MOST_LENS;
/// Derivatives of a place or a perspective by them.
pub(super) type ByMap = SMatrix<f64, 2, MAP>;

/// A homography to the camera's normalised coordinates, followed by the camera's lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LensMap {
    pub(super) homography: Matrix3<f64>,
    pub(super) camera: Camera,
    /// What comes before the lens.
    pub(super) fan: Fan,
    /// How many parameters of the lens are free, in the order of [`LensMap::lens`].
    pub(super) free: usize,
}

impl LensMap {
    /// How many parameters are free.
    pub(super) fn parameters(&self) -> usize {
        8 + self.free
    }

    /// This map with its free parameters changed by a step.
    pub(super) fn moved(&self, step: &SVector<f64, MAP>) -> Self {
        let mut moved = *self;
        for k in 0..8 {
            moved.homography[(k / 3, k % 3)] += step[k];
        }
        let mut lens = self.lens();
        for k in 0..self.free {
            lens[k] += step[8 + k];
        }
        if self.free > 0 {
            let [k1, k2, p1, p2, x, y, aspect, k3] = lens;
            moved.camera.distortion = PlumbBob { k1, k2, p1, p2, k3 }.into();
            let (k, half) = (&mut moved.camera.intrinsics, self.camera.intrinsics.fx);
            let middle = middle(&self.camera);
            (k.cx, k.cy) = (middle.x + half * x, middle.y + half * y);
            k.fy = half * (1.0 + aspect);
            // without a lens its axis and the pixels' shape change nothing: the homography makes up for them
            let [.., old_x, old_y, old_aspect, _] = self.lens();
            let (wide, wider) = (1.0 + old_aspect, 1.0 + aspect);
            let h = &mut moved.homography;
            for column in 0..3 {
                let depth = h[(2, column)];
                h[(0, column)] -= (x - old_x) * depth;
                h[(1, column)] = (h[(1, column)] * wide - (y - old_y) * depth) / wider;
            }
        }
        moved
    }

    /// k1, k2, p1, p2; the axis from the middle of the frame, in focal lengths; by how much fy is larger than fx; k3. (A map that takes the
    /// middle for the axis is wrong by hundredths of a pixel in the corners.)
    pub(super) fn lens(&self) -> [f64; MOST_LENS] {
        // a lens of another model is a known one, and nothing of it is free
        let Distortion::PlumbBob(PlumbBob { k1, k2, p1, p2, k3 }) = self.camera.distortion else {
            return [0.0; MOST_LENS];
        };
        let k = &self.camera.intrinsics;
        let axis = (Point2::new(k.cx, k.cy) - middle(&self.camera)) / k.fx;
        [k1, k2, p1, p2, axis.x, axis.y, k.fy / k.fx - 1.0, k3]
    }

    /// Where a place of the board (m) is seen, px.
    pub(super) fn place(&self, plane_m: Point2<f64>) -> Option<Point2<f64>> {
        let ideal = self.fan.apply(&apply(&self.homography, plane_m)?);
        Some(self.camera.pixel(&self.camera.distortion.distort(&ideal)))
    }

    /// Derivatives of a place; none by what is not free.
    pub(super) fn derivatives(&self, plane_m: Point2<f64>) -> Option<ByMap> {
        let source = plane_m.to_homogeneous();
        let seen = self.homography * source;
        let ideal = apply(&self.homography, plane_m)?;
        let k = &self.camera.intrinsics;
        let focal = Matrix2::new(k.fx, 0.0, 0.0, k.fy);
        let fanned = self.fan.apply(&ideal);
        let by_u = focal * self.camera.distortion.jacobian(&fanned) * self.fan.jacobian(&ideal);
        let (u, r2) = (fanned.coords, fanned.coords.norm_squared());
        let (x, y) = (u.x, u.y);
        let mut out = ByMap::zeros();
        for k in 0..3 {
            let (p, e) = (source[k] / seen.z, ideal.coords * (source[k] / seen.z));
            out.fixed_view_mut::<2, 1>(0, k)
                .copy_from(&(by_u * Vector2::new(p, 0.0)));
            out.fixed_view_mut::<2, 1>(0, 3 + k)
                .copy_from(&(by_u * Vector2::new(0.0, p)));
            if k < 2 {
                out.fixed_view_mut::<2, 1>(0, 6 + k).copy_from(&(by_u * -e));
            }
        }
        let by_lens = [
            u * r2,
            u * (r2 * r2),
            Vector2::new(2.0 * x * y, r2 + 2.0 * y * y),
            Vector2::new(r2 + 2.0 * x * x, 2.0 * x * y),
        ];
        let by_lens = by_lens.map(|column| focal * column);
        let seen = self.camera.distortion.distort(&fanned);
        let by_camera = [
            Vector2::new(k.fx, 0.0) - by_u.column(0),
            Vector2::new(0.0, k.fx) - by_u.column(1) * (k.fx / k.fy),
            Vector2::new(0.0, k.fx * seen.y) - by_u.column(1) * (ideal.y * k.fx / k.fy),
            focal * u * (r2 * r2 * r2),
        ];
        let columns = by_lens.iter().chain(&by_camera);
        for (k, column) in columns.enumerate().take(self.free) {
            out.set_column(8 + k, column);
        }
        Some(out)
    }

    /// The image of the ring of this outer radius (m) about a place of the board.
    pub(super) fn ring(&self, plane_m: Point2<f64>, radius_m: f64) -> Option<Shape> {
        shape_under(|d| self.place(plane_m + d * radius_m))
    }

    /// What the lens's bends do to the ring of this size (outer radius, m; inner over outer radius) there.
    pub(super) fn bent(&self, plane_m: Point2<f64>, size: (f64, f64)) -> Option<Bent> {
        let (outer_radius_m, ratio) = size;
        Bent::of(&|d| self.place(plane_m + d * outer_radius_m), ratio)
    }
}

/// The middle of a camera's frame.
fn middle(camera: &Camera) -> Point2<f64> {
    let side = |pixels: u32| 0.5 * (f64::from(pixels) - 1.0);
    Point2::new(side(camera.width), side(camera.height))
}

/// A camera of which nothing is known but its frame's size: places are in half diagonals about the middle.
pub(super) fn blank(width: usize, height: usize) -> Camera {
    let (w, h) = (width as f64, height as f64);
    let half = 0.5 * w.hypot(h);
    Camera {
        width: width as u32,
        height: height as u32,
        intrinsics: Intrinsics {
            fx: half,
            fy: half,
            cx: 0.5 * (w - 1.0),
            cy: 0.5 * (h - 1.0),
        },
        distortion: PlumbBob::default().into(),
    }
}

/// The shape of a ring under a map from outer radii about its centre to the frame, px; `None` where the map has no image of it.
pub fn shape_under(map: impl Fn(Vector2<f64>) -> Option<Point2<f64>>) -> Option<Shape> {
    const H: f64 = 0.7;
    let at = |x: f64, y: f64| map(Vector2::new(x * H, y * H));
    let centre = at(0.0, 0.0)?;
    let (east, west) = (at(1.0, 0.0)? - centre, at(-1.0, 0.0)? - centre);
    let (south, north) = (at(0.0, 1.0)? - centre, at(0.0, -1.0)? - centre);
    let (se, nw) = (at(1.0, 1.0)? - centre, at(-1.0, -1.0)? - centre);
    let (ne, sw) = (at(1.0, -1.0)? - centre, at(-1.0, 1.0)? - centre);
    let linear = Matrix2::from_columns(&[(east - west) / (2.0 * H), (south - north) / (2.0 * H)]);
    let back = linear.try_inverse()?;
    let xx = back * (east + west) / (H * H);
    let yy = back * (south + north) / (H * H);
    let xy = back * (se + nw - ne - sw) / (4.0 * H * H);
    let g = Vector2::new(
        -(xx.x + yy.x + 2.0 * (xx.x + xy.y)) / 8.0,
        -(xx.y + yy.y + 2.0 * (xy.x + yy.y)) / 8.0,
    );
    let form = back.tr_mul(&back);
    Some(Shape {
        centre,
        affine: [form[(0, 0)], form[(0, 1)], form[(1, 1)]],
        perspective: back.tr_mul(&g),
    })
}

#[cfg(test)]
mod tests;
