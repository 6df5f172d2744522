//! What the rings of a board know of one another: perspective.
//!
//! A ring alone has to find its own perspective q, and pays for it with half the certainty of its centre: the two are
//! strongly correlated. But all rings share one plane and one lens, and the map through their centres (`lens_map`) knows q
//! far better (`through`). Where the rings' own q say that the map is not quite right (a lens it does not describe, a bent board), a polynomial
//! over the frame corrects it, of the degree that explains them best (Akaike 1974). Each ring's centre is then its own
//! measurement given the better q: `c + C_cq C_qq^-1 (q_board - q)`, the mean of the conditional normal distribution.
//! Centres are not drawn to one another or onto a plane.

use super::fitted::RingFitted;
use super::lens_map::LensMap;
use super::sighting::{BoardPerspective, Sighting};
use super::through::Through;
use crate::camera::Camera;
use nalgebra::{DMatrix, DVector, Matrix2, Matrix2xX, Point2, Vector2};

/// Rings for each coefficient of the polynomial, at least.
const RINGS_PER_COEFFICIENT: usize = 3;
/// Terms of the polynomials that are tried: of no degree up to the third.
const TERMS: [usize; 5] = [0, 1, 3, 6, 10];
/// What a coefficient has to lower chi-square by: more than Akaike's 2, because the map is right for most lenses.
const WORTH: f64 = 4.0;
/// A ring whose own perspective is this many standard deviations off the board's is left as it is.
const OUTLIER: f64 = 5.0;

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
    let own = || rings.iter().map(own_centre).collect();
    let pairs = rings.iter().zip(plane_m);
    let sightings = pairs.map(|(ring, plane_m)| Sighting::of(ring, *plane_m));
    let Some(sightings) = sightings.collect::<Option<Vec<_>>>() else {
        return (own(), None);
    };
    let Some(through) = Through::rings(&sightings, outer_radius_m, camera) else {
        return (own(), None);
    };
    let said = &through.perspectives;
    let centres = Correction::of(&sightings, said).map(|law| {
        let all = rings.iter().zip(&sightings).zip(said);
        let given = all.map(|((ring, sighting), said)| {
            let given = law.apply(sighting, said).filter(Given::is_near);
            given.map_or_else(|| own_centre(ring), |given| given.centre)
        });
        given.collect()
    });
    (centres.unwrap_or_else(own), Some(through.map))
}

fn own_centre(ring: &RingFitted) -> CentreAndCovariance {
    (ring.model.shape.centre, ring.centre_covariance())
}

/// A polynomial over the frame that is added to the map's perspective.
struct Correction {
    middle: Point2<f64>,
    scale_px: f64,
    /// Coefficients, term by term that of x and that of y; none where the map needs no correction.
    coefficients: DVector<f64>,
    covariance: DMatrix<f64>,
}

impl Correction {
    /// The polynomial that explains the rings' own perspectives best beside the `known` ones.
    fn of(rings: &[Sighting], known: &[BoardPerspective]) -> Option<Self> {
        let count = rings.len() as f64;
        let sum = rings.iter().map(|r| r.centre.coords).sum::<Vector2<f64>>();
        let middle = Point2::from(sum / count);
        let scale_px = rings
            .iter()
            .map(|r| (r.centre - middle).norm())
            .fold(1.0, f64::max);
        let none = Self {
            middle,
            scale_px,
            coefficients: DVector::zeros(0),
            covariance: DMatrix::zeros(0, 0),
        };
        let terms = TERMS.into_iter();
        let few = |terms: &usize| terms * RINGS_PER_COEFFICIENT <= rings.len();
        let sizes: Vec<usize> = terms.filter(few).map(|terms| 2 * terms).collect();
        let most = none.equations(rings, known, *sizes.last()?)?;
        sizes
            .into_iter()
            .filter_map(|size| most.solved(size))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, coefficients, covariance)| Self {
                coefficients,
                covariance,
                ..none
            })
    }

    /// Normal equations of this many coefficients.
    fn equations(
        &self,
        rings: &[Sighting],
        known: &[BoardPerspective],
        size: usize,
    ) -> Option<Equations> {
        let mut sums = Equations {
            normal: DMatrix::zeros(size, size),
            right: DVector::zeros(size),
            total: 0.0,
        };
        for (ring, known) in rings.iter().zip(known) {
            let weight = ring.of_perspective.try_inverse()?;
            let missing = ring.perspective - known.perspective;
            let pull = weight * missing;
            let square = missing.dot(&pull);
            // a ring that is none of this board must not choose the degree
            let trust = (OUTLIER * OUTLIER / square.max(f64::MIN_POSITIVE)).min(1.0);
            sums.total += trust * square;
            let terms = self.terms(&ring.centre).into_iter().take(size / 2);
            for (k, term) in terms.clone().enumerate() {
                let mut part = sums.right.fixed_rows_mut::<2>(2 * k);
                part += pull * (term * trust);
                for (l, other) in terms.clone().enumerate() {
                    let mut part = sums.normal.fixed_view_mut::<2, 2>(2 * k, 2 * l);
                    part += weight * (term * other * trust);
                }
            }
        }
        Some(sums)
    }

    /// The polynomial's terms at a place of the frame.
    fn terms(&self, at: &Point2<f64>) -> [f64; 10] {
        let p = (at - self.middle) / self.scale_px;
        let (x, y) = (p.x, p.y);
        [
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
        ]
    }

    fn apply(&self, ring: &Sighting, known: &BoardPerspective) -> Option<Given> {
        let size = self.coefficients.len();
        let terms = self.terms(&ring.centre);
        let row = Matrix2xX::from_fn(size, |i, k| if k % 2 == i { terms[k / 2] } else { 0.0 });
        let board = BoardPerspective {
            perspective: known.perspective + &row * &self.coefficients,
            covariance: known.covariance + &row * &self.covariance * row.transpose(),
            ..*known
        };
        Given::of(ring, &board)
    }
}

/// Normal equations of a correction, and what the perspectives miss without one.
struct Equations {
    normal: DMatrix<f64>,
    right: DVector<f64>,
    total: f64,
}

impl Equations {
    /// The first coefficients alone, with their covariance, behind what they cost: chi-square and the worth of the coefficients.
    fn solved(&self, size: usize) -> Option<(f64, DVector<f64>, DMatrix<f64>)> {
        let right = self.right.rows(0, size);
        let normal = self.normal.view((0, 0), (size, size)).into_owned();
        let covariance = if size > 0 {
            normal.cholesky()?.inverse()
        } else {
            normal
        };
        let coefficients = &covariance * right;
        let cost = self.total - right.dot(&coefficients) + WORTH * size as f64;
        cost.is_finite().then_some((cost, coefficients, covariance))
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
    fn of(ring: &Sighting, board: &BoardPerspective) -> Option<Self> {
        let (gain, with_ring) = (&ring.gain, board.with_ring * ring.gain.transpose());
        let moved = gain * board.covariance * gain.transpose() + with_ring + with_ring.transpose();
        Some(Self {
            centre: (ring.centre_given(&board.perspective), ring.given + moved),
            off: ring.contradicts(board)?,
        })
    }

    /// Whether its own perspective was near enough for that to be noise.
    pub(super) fn is_near(&self) -> bool {
        self.off < OUTLIER * OUTLIER
    }
}

/// A ring's centre given that its perspective is this one; `None` where its own has no covariance.
pub(super) fn given_perspective(ring: &RingFitted, perspective: Vector2<f64>) -> Option<Given> {
    // where it is on the board does not matter
    let sighting = Sighting::of(ring, Point2::origin())?;
    Given::of(&sighting, &BoardPerspective::exact(perspective))
}
