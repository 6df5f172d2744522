//! The map from the board to the frame that its own centres tell: a homography and a lens, smooth; before a lens that no polynomial
//! describes a `fan`.
//!
//! A ring knows little of its own perspective, but the centres of a board's rings lie so exactly that the second derivatives of
//! the map through them are known far better. What a ring needs of the map is its shape there.
//!
//! To second order the map is X -> c + J d + H[d, d] / 2, d in outer radii. Of H, a circle shows only what moves its outline as a
//! perspective does: with K = J^-1 H the outline of radius a moves outwards by a^2 e.K[e, e] / 2 in direction e, whose part
//! with one period around the circle is -a^2 g.e, g_i = -(sum_j K_i,jj + 2 sum_j K_j,ij) / 8. (For a homography that is
//! all; a lens adds a part with three periods, which no parameter of a ring resembles.)

use super::bent::{bends, bent};
use super::fan::Fan;
use super::shape::Shape;
use crate::camera::homography::{apply, fit_homography};
use crate::camera::{Camera, Distortion, Intrinsics, PlumbBob};
use nalgebra::{DMatrix, DVector, Matrix2, Matrix3, Point2, Vector2};

/// Coefficients of the lens for so many rings: radial r^2; r^4 and two tangential; r^6.
const RINGS_FOR: [(usize, usize); 3] = [(9, 1), (14, 4), (30, 5)];
/// The lens moves the frame's corner by about this fraction of its distance at most (standard deviation of a prior).
const LENS_PRIOR: f64 = 0.5;
const STEPS: usize = 8;
/// Converged where a step would gain less than this in the weighted sum of squares.
const SETTLED: f64 = 1e-3;
/// Centres count less from so many standard deviations off the map on (Huber 1964).
const ROBUST: f64 = 3.0;
const MOST_LENS: usize = 5;
/// The squared length of two standard normal numbers has this median.
const MEDIAN: f64 = 1.386_294_361_119_890_6;
/// Centres that fit a map so badly want another lens: the fans that are tried then.
const SUSPECT: f64 = 1.5;
const FANS: [f64; 2] = [0.8, 1.6];

/// A homography to the camera's normalised coordinates, followed by the camera's lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LensMap {
    homography: Matrix3<f64>,
    camera: Camera,
    /// What comes before the lens.
    fan: Fan,
    /// How many of the lens's coefficients are free, in the order k1, k2, p1, p2, k3.
    free: usize,
}

/// A map and the covariance of its free parameters: eight entries of the homography, then the lens.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Certain {
    pub(super) map: LensMap,
    covariance: DMatrix<f64>,
}

/// A centre that the map goes through: where on the board (m), where in the frame (px), how certain (px^2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Anchor {
    pub(super) plane_m: Point2<f64>,
    pub(super) at: Point2<f64>,
    pub(super) variance: f64,
}

impl LensMap {
    /// Least squares through centres seen by a camera; `None` where they determine no plane. Of a [`blank`] camera the lens is found
    /// too. What the centres lie beside the map by more than their noise makes it less certain.
    pub(super) fn through(anchors: &[Anchor], camera: &Camera) -> Option<Certain> {
        let mut best = Self::with_fan(anchors, camera, Fan::default());
        let known = !camera.distortion.is_none();
        let suspect = |(_, misfit): &(Certain, f64)| *misfit > SUSPECT;
        if !known && best.as_ref().is_none_or(suspect) {
            let others = FANS.map(|fan| Self::with_fan(anchors, camera, Fan(fan)));
            for other in others.into_iter().flatten() {
                if best.as_ref().is_none_or(|best| other.1 < best.1) {
                    best = Some(other);
                }
            }
        }
        let (mut certain, misfit) = best?;
        certain.covariance *= misfit.max(1.0);
        Some(certain)
    }

    /// The same with a given fan, and how badly it fits ([`LensMap::misfit`]).
    fn with_fan(anchors: &[Anchor], camera: &Camera, fan: Fan) -> Option<(Certain, f64)> {
        let known = !camera.distortion.is_none();
        let pairs = anchors
            .iter()
            .map(|a| Some((a.plane_m, fan.undo(&camera.unproject(&a.at)?)?)));
        let homography = fit_homography(&pairs.collect::<Option<Vec<_>>>()?)?;
        let enough = RINGS_FOR
            .iter()
            .rev()
            .find(|(rings, _)| anchors.len() >= *rings && !known);
        let mut map = Self {
            homography: homography / homography[(2, 2)],
            camera: *camera,
            fan,
            free: enough.map_or(0, |(_, coefficients)| *coefficients),
        };
        let mut settled = None;
        for _ in 0..STEPS {
            let (normal, right) = map.normal_equations(anchors)?;
            let factor = normal.cholesky()?;
            let step = factor.solve(&right);
            map = map.moved(&step);
            let gain = step.dot(&right);
            settled = Some(factor);
            if gain < SETTLED {
                break;
            }
        }
        let finite = map.lens().iter().all(|v| v.is_finite());
        let certain = Certain {
            covariance: settled.filter(|_| finite)?.inverse(),
            map,
        };
        let misfit = map.misfit(anchors)?;
        Some((certain, misfit))
    }

    /// The squared deviation of the centres from the map, in their variances: 1 where all is noise. By the median, for one ring that is none must
    /// not say that the map is wrong.
    fn misfit(&self, anchors: &[Anchor]) -> Option<f64> {
        let square = |anchor: &Anchor| {
            let missing = anchor.at - self.place(anchor.plane_m)?;
            Some(missing.norm_squared() / anchor.variance)
        };
        let mut squares = anchors.iter().map(square).collect::<Option<Vec<f64>>>()?;
        squares.sort_by(f64::total_cmp);
        let measured = 2.0 * squares.len() as f64;
        let deviations = (measured - (8 + self.free) as f64).max(1.0);
        Some(squares.get(squares.len() / 2)? / MEDIAN * measured / deviations)
    }

    fn normal_equations(&self, anchors: &[Anchor]) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let size = 8 + self.free;
        let mut normal = DMatrix::zeros(size, size);
        let mut right = DVector::zeros(size);
        for anchor in anchors {
            let missing = anchor.at - self.place(anchor.plane_m)?;
            let deviations = (missing.norm_squared() / anchor.variance).sqrt();
            let weight = (ROBUST / deviations.max(ROBUST)) / anchor.variance;
            let rows = self.derivatives(anchor.plane_m)?;
            normal.gemm_tr(weight, &rows, &rows, 1.0);
            right.gemv_tr(weight, &rows, &missing, 1.0);
        }
        for k in 0..self.free {
            let prior = LENS_PRIOR.powi(-2);
            normal[(8 + k, 8 + k)] += prior;
            right[8 + k] -= prior * self.lens()[k];
        }
        Some((normal, right))
    }

    /// This map with its free parameters changed by a step.
    fn moved(&self, step: &DVector<f64>) -> Self {
        let mut moved = *self;
        for k in 0..8 {
            moved.homography[(k / 3, k % 3)] += step[k];
        }
        let mut lens = self.lens();
        for k in 0..self.free {
            lens[k] += step[8 + k];
        }
        let [k1, k2, p1, p2, k3] = lens;
        if self.free > 0 {
            moved.camera.distortion = PlumbBob { k1, k2, p1, p2, k3 }.into();
        }
        moved
    }

    fn lens(&self) -> [f64; MOST_LENS] {
        // a lens of another model is a known one, and nothing of it is free
        match self.camera.distortion {
            Distortion::PlumbBob(PlumbBob { k1, k2, p1, p2, k3 }) => [k1, k2, p1, p2, k3],
            _ => [0.0; MOST_LENS],
        }
    }

    /// Where a place of the board (m) is seen, px.
    pub(super) fn place(&self, plane_m: Point2<f64>) -> Option<Point2<f64>> {
        let ideal = self.fan.apply(&apply(&self.homography, plane_m)?);
        Some(self.camera.pixel(&self.camera.distortion.distort(&ideal)))
    }

    /// Derivatives of a place by the homography's first eight entries and the lens, 2 rows.
    fn derivatives(&self, plane_m: Point2<f64>) -> Option<DMatrix<f64>> {
        let source = plane_m.to_homogeneous();
        let seen = self.homography * source;
        let ideal = apply(&self.homography, plane_m)?;
        let k = &self.camera.intrinsics;
        let focal = Matrix2::new(k.fx, 0.0, 0.0, k.fy);
        let fanned = self.fan.apply(&ideal);
        let by_u = focal * self.camera.distortion.jacobian(&fanned) * self.fan.jacobian(&ideal);
        let (u, r2) = (fanned.coords, fanned.coords.norm_squared());
        let (x, y) = (u.x, u.y);
        let mut out = DMatrix::zeros(2, 8 + self.free);
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
            u * (r2 * r2 * r2),
        ];
        for (k, column) in by_lens.iter().enumerate().take(self.free) {
            let mut place = out.fixed_view_mut::<2, 1>(0, 8 + k);
            place.copy_from(&(focal * column));
        }
        Some(out)
    }

    /// The image of the ring of this outer radius (m) about a place of the board.
    pub(super) fn ring(&self, plane_m: Point2<f64>, radius_m: f64) -> Option<Shape> {
        shape_under(|d| self.place(plane_m + d * radius_m))
    }

    /// What the lens's bends move its fit by, px.
    pub(super) fn bent(
        &self,
        plane_m: Point2<f64>,
        radius_m: f64,
        ratio: f64,
    ) -> Option<Vector2<f64>> {
        bent(|d| self.place(plane_m + d * radius_m), ratio)
    }

    /// How far its outline is bent beside that of a ring in perspective, px.
    pub(super) fn bends(&self, plane_m: Point2<f64>, radius_m: f64) -> Option<f64> {
        bends(|d| self.place(plane_m + d * radius_m))
    }
}

impl Certain {
    /// The perspective of the ring of this outer radius (m) about a place of the board, px^-1, and its covariance.
    pub(super) fn perspective(
        &self,
        plane_m: Point2<f64>,
        radius_m: f64,
    ) -> Option<(Vector2<f64>, Matrix2<f64>)> {
        let here = self.map.ring(plane_m, radius_m)?.perspective;
        let size = 8 + self.map.free;
        let mut rows = DMatrix::zeros(2, size);
        let mut step = DVector::zeros(size);
        for k in 0..size {
            let h = 0.1 * self.covariance[(k, k)].sqrt();
            step[k] = h;
            let there = self.map.moved(&step).ring(plane_m, radius_m)?.perspective;
            step[k] = 0.0;
            rows.fixed_view_mut::<2, 1>(0, k)
                .copy_from(&((there - here) / h));
        }
        let covariance = &rows * &self.covariance * rows.transpose();
        Some((here, Matrix2::from_fn(|i, j| covariance[(i, j)])))
    }
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
