//! What the rings of a board know of one another: perspective.
//!
//! A ring alone has to find its own perspective q, and pays for it with half the certainty of its centre: the two are
//! strongly correlated. But all rings share one plane and one lens, and the map through their centres (`lens_map`) knows q
//! far better. Where the rings' own q say that the map is not quite right (a lens it does not describe, a bent board), a polynomial
//! over the frame corrects it, of the degree that explains them best (Akaike 1974). Each ring's centre is then its own
//! measurement given the better q: `c + C_cq C_qq^-1 (q_board - q)`, the mean of the conditional normal distribution.
//! Centres are not drawn to one another or onto a plane.

use super::fitted::RingFitted;
use super::lens_map::{Anchor, LensMap};
use crate::camera::Camera;
use nalgebra::{DMatrix, DVector, Matrix2, Point2, Vector2};
use rayon::prelude::*;

/// Rings for each coefficient of the polynomial, at least.
const RINGS_PER_COEFFICIENT: usize = 3;
/// What a coefficient has to lower chi-square by: more than Akaike's 2, because the map is right for most lenses.
const WORTH: f64 = 4.0;
/// A ring whose own perspective is this many standard deviations off the board's is left as it is.
const OUTLIER: f64 = 5.0;
/// The map is drawn through the better centres so often.
const ROUNDS: usize = 2;

/// A perspective and its covariance, px^-1 and px^-2.
pub(super) type Perspective = (Vector2<f64>, Matrix2<f64>);

/// A centre and its covariance, px and px^2.
pub type CentreAndCovariance = (Point2<f64>, Matrix2<f64>);

/// The centres of the rings of one board, given one another's perspective, and the map through them. `plane_m` are their places
/// on the board. Where they are too few to tell, the centres are those of the fits.
pub(super) fn share_perspective(
    rings: &[RingFitted],
    plane_m: &[Point2<f64>],
    outer_radius_m: f64,
    camera: &Camera,
) -> (Vec<CentreAndCovariance>, Option<LensMap>) {
    let mut map = None;
    let mut centres: Vec<CentreAndCovariance> = rings
        .iter()
        .map(|r| (r.model.shape.centre, r.centre_covariance()))
        .collect();
    for _ in 0..ROUNDS {
        let anchors: Vec<Anchor> = centres
            .iter()
            .zip(plane_m)
            .map(|((at, covariance), plane_m)| Anchor {
                plane_m: *plane_m,
                at: *at,
                variance: 0.5 * covariance.trace(),
            })
            .collect();
        let known = LensMap::through(&anchors, camera).and_then(|certain| {
            map = Some(certain.map);
            let perspectives = plane_m
                .par_iter()
                .map(|place| certain.perspective(*place, outer_radius_m));
            perspectives.collect::<Option<Vec<Perspective>>>()
        });
        let Some(known) = known else { break };
        let Some(law) = Correction::of(rings, &known) else {
            break;
        };
        centres = rings
            .iter()
            .zip(&known)
            .map(|(ring, q)| law.apply(ring, q))
            .collect();
    }
    (centres, map)
}

/// A polynomial over the frame that is added to the map's perspective.
struct Correction {
    middle: Point2<f64>,
    scale_px: f64,
    /// Terms of the polynomial; none where the map needs no correction.
    terms: usize,
    /// Coefficients of both components, x first.
    coefficients: DVector<f64>,
    covariance: DMatrix<f64>,
}

impl Correction {
    /// The polynomial that explains the rings' own perspectives best beside the `known` ones.
    fn of(rings: &[RingFitted], known: &[Perspective]) -> Option<Self> {
        let count = rings.len() as f64;
        let centre = |r: &RingFitted| r.model.shape.centre;
        let sum = rings.iter().map(|r| centre(r).coords).sum::<Vector2<f64>>();
        let middle = Point2::from(sum / count);
        let scale_px = rings
            .iter()
            .map(|r| (centre(r) - middle).norm())
            .fold(1.0, f64::max);
        [0, 1, 3, 6, 10]
            .into_iter()
            .filter(|terms| terms * RINGS_PER_COEFFICIENT <= rings.len())
            .filter_map(|terms| {
                let start = Self {
                    middle,
                    scale_px,
                    terms,
                    coefficients: DVector::zeros(2 * terms),
                    covariance: DMatrix::zeros(2 * terms, 2 * terms),
                };
                start.fitted(rings, known)
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, correction)| correction)
    }

    /// The correction with its coefficients, and what they cost: chi-square and the worth of the coefficients.
    fn fitted(mut self, rings: &[RingFitted], known: &[Perspective]) -> Option<(f64, Self)> {
        let size = 2 * self.terms;
        let (mut normal, mut right) = (DMatrix::zeros(size, size), DVector::zeros(size));
        let mut total = 0.0;
        for (ring, (known, _)) in rings.iter().zip(known) {
            let row = self.row(&ring.model.shape.centre);
            let weight = perspective_covariance(ring).try_inverse()?;
            let missing = ring.model.shape.perspective - known;
            let square = missing.dot(&(weight * missing));
            // a ring that is none of this board must not choose the degree
            let trust = (OUTLIER * OUTLIER / square.max(f64::MIN_POSITIVE)).min(1.0);
            total += trust * square;
            if size > 0 {
                normal += row.transpose() * weight * &row * trust;
                right += row.transpose() * (weight * missing) * trust;
            }
        }
        if size > 0 {
            self.covariance = normal.try_inverse()?;
            self.coefficients = &self.covariance * &right;
        }
        let cost = total - right.dot(&self.coefficients) + WORTH * size as f64;
        cost.is_finite().then_some((cost, self))
    }

    /// 2 x size: the polynomial's terms for both components.
    fn row(&self, at: &Point2<f64>) -> DMatrix<f64> {
        let p = (at - self.middle) / self.scale_px;
        let (x, y) = (p.x, p.y);
        let all = [
            1.0,
            x,
            y,
            x * x,
            x * y,
            y * y,
            x * x * x,
            x * x * y,
            x * y * y,
            y * y * y,
        ];
        let mut row = DMatrix::zeros(2, 2 * self.terms);
        for k in 0..self.terms {
            row[(0, k)] = all[k];
            row[(1, self.terms + k)] = all[k];
        }
        row
    }

    fn apply(&self, ring: &RingFitted, (known, known_to): &Perspective) -> CentreAndCovariance {
        let (centre, own) = (ring.model.shape.centre, ring.centre_covariance());
        let row = self.row(&centre);
        let correction = &row * &self.coefficients;
        let board = known + Vector2::new(correction[0], correction[1]);
        let uncertain = &row * &self.covariance * row.transpose();
        let uncertain = known_to + Matrix2::from_fn(|i, j| uncertain[(i, j)]);
        let given = given_perspective(ring, &(board, uncertain));
        let believed = given.filter(Given::is_near);
        believed.map_or((centre, own), |given| given.centre)
    }
}

/// A ring whose perspective is known.
pub(super) struct Given {
    /// Its centre then.
    pub(super) centre: CentreAndCovariance,
    /// How far its own perspective was off, in standard deviations squared.
    pub(super) off: f64,
}

impl Given {
    /// Whether its own perspective was near enough for that to be noise.
    pub(super) fn is_near(&self) -> bool {
        self.off < OUTLIER * OUTLIER
    }
}

/// A ring's centre given that its perspective is this one; `None` where its own has no covariance.
pub(super) fn given_perspective(
    ring: &RingFitted,
    (perspective, uncertain): &Perspective,
) -> Option<Given> {
    let inverse = perspective_covariance(ring).try_inverse()?;
    let off = perspective - ring.model.shape.perspective;
    let cross = ring.covariance.fixed_view::<2, 2>(0, 5).into_owned();
    let gain = cross * inverse;
    let known = ring.centre_covariance() - gain * cross.transpose();
    let covariance = known + gain * uncertain * gain.transpose();
    Some(Given {
        centre: (ring.model.shape.centre + gain * off, covariance),
        off: off.dot(&(inverse * off)),
    })
}

fn perspective_covariance(ring: &RingFitted) -> Matrix2<f64> {
    ring.covariance.fixed_view::<2, 2>(5, 5).into_owned()
}
