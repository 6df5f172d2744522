//! The map through a board's rings: least squares over what their fits measure.
//!
//! A ring's fit gives its centre c and its perspective q with errors that are strongly correlated. With G = C_cq C_qq^-1 the part
//! `e = c - G q` of the centre has nothing to do with q's error. So a map m of parameters t, whose rings have the perspectives q(t), has to
//! satisfy
//!
//! ```text
//! e_i = m_i(t) - G_i q_i(t)    with the covariance V = C_cc - G C_qc
//! q_i = q_i(t)                 with the covariance C_qq
//! ```
//!
//! and the ring's centre, given the board, is `e_i + G_i q_i(t)`. (To draw the map through centres that have been corrected by the map's own
//! perspectives looks simpler; but a ring in a corner then draws the map after it, which confirms it: errors of ten standard
//! deviations.)

use super::fan::Fan;
use super::lens_map::{ByMap, LensMap, MAP, MOST_LENS};
use super::sighting::{BoardPerspective, Sighting};
use crate::camera::Camera;
use crate::camera::homography::fit_homography;
use nalgebra::{SMatrix, SVector, Vector2};
use rayon::prelude::*;

/// Parameters of the lens for so many rings: radial r^2; all but r^6; all.
const RINGS_FOR: [(usize, usize); 3] = [(9, 1), (14, 7), (30, 8)];
/// Standard deviations of what is known of a lens before: it moves the frame's corner by about half of its distance at most, its axis is
/// not far from the middle of the frame (half diagonals), and pixels are all but square.
const LENS_PRIOR: [f64; MOST_LENS] = [0.5, 0.5, 0.5, 0.5, 0.05, 0.05, 0.01, 0.5];
/// Steps through the centres alone, and then with the perspectives.
const STEPS: (usize, usize) = (8, 6);
/// Converged where a step would gain less than this in the weighted sum of squares.
const SETTLED: f64 = 1e-3;
/// What is so many standard deviations off the map counts less (Huber 1964).
const ROBUST: f64 = 3.0;
/// The squared length of two standard normal numbers has this median.
const MEDIAN: f64 = 1.386_294_361_119_890_6;
/// Centres that fit a map so badly want another lens: the fans that are tried then.
const SUSPECT: f64 = 1.5;
const FANS: [f64; 2] = [0.8, 1.6];
/// A fan has to lower what is left by this many variances. The median can be high by chance, and the lens's polynomial undoes most of a
/// wrong fan, but not in the corners.
const FAN_WORTH: f64 = 20.0;

/// Normal equations of a map's parameters: matrix and right side.
type Equations = (SMatrix<f64, MAP, MAP>, SVector<f64, MAP>);
/// Covariance of a map's parameters.
type Covariance = SMatrix<f64, MAP, MAP>;

/// A map, and the perspectives of the rings that it went through.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Through {
    pub(super) map: LensMap,
    pub(super) perspectives: Vec<BoardPerspective>,
    /// The squared deviation of the rings from the map, in their variances: 1 where all is noise.
    misfit: f64,
    /// What it leaves of centres and perspectives together, in variances.
    cost: f64,
}

impl Through {
    /// The map through rings of this outer radius (m) seen by a camera; `None` where they determine no plane. Of a
    /// [`blank`](super::lens_map::blank) camera the lens is found too. What the rings lie beside the map by more than their noise makes the
    /// perspectives less certain.
    pub(super) fn rings(rings: &[Sighting], outer_radius_m: f64, camera: &Camera) -> Option<Self> {
        let with = |fan| Self::with_fan(rings, outer_radius_m, camera, fan);
        let mut best = with(Fan::default());
        let suspect = |found: &Self| found.misfit > SUSPECT;
        if camera.distortion.is_none() && best.as_ref().is_none_or(suspect) {
            for other in FANS.map(|fan| with(Fan(fan))).into_iter().flatten() {
                let better = |best: &Self| other.cost + FAN_WORTH < best.cost;
                if best.as_ref().is_none_or(better) {
                    best = Some(other);
                }
            }
        }
        let mut best = best?;
        for perspective in &mut best.perspectives {
            perspective.covariance *= best.misfit.max(1.0);
        }
        Some(best)
    }

    fn with_fan(
        rings: &[Sighting],
        outer_radius_m: f64,
        camera: &Camera,
        fan: Fan,
    ) -> Option<Self> {
        let map = start(rings, camera, fan)?;
        let (map, covariance) = settled(map, STEPS.0, |map| by_centres(map, rings))?;
        // perspectives change so nearly linearly that their derivatives are taken once
        let by_map = perspectives_by_map(&map, &covariance, rings, outer_radius_m)?;
        let mut shown = Vec::new();
        let (map, covariance) = settled(map, STEPS.1, |map| {
            shown = show(map, &by_map, rings, outer_radius_m)?;
            by_rings(map, &shown, rings)
        })?;
        if !map.lens().iter().all(|v| v.is_finite()) {
            return None;
        }
        let pairs = shown.iter().zip(rings);
        let said = pairs.map(|(shown, ring)| shown.said(&map, &covariance, ring, outer_radius_m));
        let perspectives = said.collect::<Option<Vec<_>>>()?;
        let pairs = rings.iter().zip(&perspectives);
        let off: Vec<(f64, f64)> = pairs
            .map(|(ring, said)| {
                let centre = off(&map, ring, &said.perspective)?;
                Some((centre, ring.contradicts(said)?))
            })
            .collect::<Option<_>>()?;
        Some(Self {
            misfit: misfit(&map, &off)?,
            cost: cost(&off),
            map,
            perspectives,
        })
    }
}

/// A map after Gauss-Newton steps, so many at most, and the covariance of its parameters, for the normal equations of a map.
fn settled(
    mut map: LensMap,
    steps: usize,
    mut equations: impl FnMut(&LensMap) -> Option<Equations>,
) -> Option<(LensMap, Covariance)> {
    let mut last = None;
    for _ in 0..steps {
        let (normal, right) = equations(&map)?;
        let factor = normal.cholesky()?;
        let step = factor.solve(&right);
        map = map.moved(&step);
        last = Some(factor);
        if step.dot(&right) < SETTLED {
            break;
        }
    }
    Some((map, last?.inverse()))
}

/// A homography through the centres, before a lens that does nothing yet.
fn start(rings: &[Sighting], camera: &Camera, fan: Fan) -> Option<LensMap> {
    let pairs = rings
        .iter()
        .map(|ring| Some((ring.plane_m, fan.undo(&camera.unproject(&ring.centre)?)?)));
    let homography = fit_homography(&pairs.collect::<Option<Vec<_>>>()?)?;
    let known = !camera.distortion.is_none();
    let most = RINGS_FOR
        .iter()
        .rev()
        .find(|(least, _)| rings.len() >= *least && !known);
    Some(LensMap {
        homography: homography / homography[(2, 2)],
        camera: *camera,
        fan,
        free: most.map_or(0, |(_, coefficients)| *coefficients),
    })
}

/// Normal equations of the centres alone.
fn by_centres(map: &LensMap, rings: &[Sighting]) -> Option<Equations> {
    let (mut normal, mut right) = prior(map);
    for ring in rings {
        let missing = ring.centre - map.place(ring.plane_m)?;
        let variance = ring.variance();
        let weight = robust(missing.norm_squared() / variance) / variance;
        let rows = map.derivatives(ring.plane_m)?;
        normal.gemm_tr(weight, &rows, &rows, 1.0);
        right.gemv_tr(weight, &rows, &missing, 1.0);
    }
    Some((normal, right))
}

/// How the rings' perspectives change with the parameters of a map, which have this covariance.
fn perspectives_by_map(
    map: &LensMap,
    covariance: &Covariance,
    rings: &[Sighting],
    outer_radius_m: f64,
) -> Option<Vec<ByMap>> {
    let aside: Vec<(f64, LensMap)> = (0..map.parameters())
        .map(|k| {
            let h = 0.1 * covariance[(k, k)].sqrt();
            let mut step = SVector::zeros();
            step[k] = h;
            (h, map.moved(&step))
        })
        .collect();
    let changes = rings.par_iter().map(|ring| {
        let here = map.ring(ring.plane_m, outer_radius_m)?.perspective;
        let mut changes = ByMap::zeros();
        for (k, (h, aside)) in aside.iter().enumerate() {
            let there = aside.ring(ring.plane_m, outer_radius_m)?.perspective;
            changes.set_column(k, &((there - here) / *h));
        }
        Some(changes)
    });
    changes.collect()
}

/// A ring as a map shows it: its perspective, and how that and `m - G q` change with the map's parameters.
struct Shown<'a> {
    perspective: Vector2<f64>,
    by_map: &'a ByMap,
    centre_by_map: ByMap,
    /// What the ring's centre counts.
    weight: f64,
}

fn show<'a>(
    map: &LensMap,
    by_map: &'a [ByMap],
    rings: &[Sighting],
    outer_radius_m: f64,
) -> Option<Vec<Shown<'a>>> {
    let pairs = rings.iter().zip(by_map);
    let shown = pairs.map(|(ring, by_map)| {
        let perspective = map.ring(ring.plane_m, outer_radius_m)?.perspective;
        Some(Shown {
            perspective,
            by_map,
            centre_by_map: map.derivatives(ring.plane_m)? - ring.gain * by_map,
            weight: robust(off(map, ring, &perspective)?),
        })
    });
    shown.collect()
}

/// Normal equations of centres and perspectives.
fn by_rings(map: &LensMap, shown: &[Shown], rings: &[Sighting]) -> Option<Equations> {
    let (mut normal, mut right) = prior(map);
    for (shown, ring) in shown.iter().zip(rings) {
        let missing = ring.centre_given(&shown.perspective) - map.place(ring.plane_m)?;
        let weight = ring.given.try_inverse()? * shown.weight;
        normal += shown.centre_by_map.tr_mul(&(weight * shown.centre_by_map));
        right += shown.centre_by_map.tr_mul(&(weight * missing));
        let missing = ring.perspective - shown.perspective;
        let inverse = ring.of_perspective.try_inverse()?;
        let weight = inverse * robust(missing.dot(&(inverse * missing)));
        normal += shown.by_map.tr_mul(&(weight * shown.by_map));
        right += shown.by_map.tr_mul(&(weight * missing));
    }
    Some((normal, right))
}

impl Shown<'_> {
    /// What the map says of the ring in the end.
    fn said(
        &self,
        map: &LensMap,
        covariance: &Covariance,
        ring: &Sighting,
        outer_radius_m: f64,
    ) -> Option<BoardPerspective> {
        let moves = covariance * self.by_map.transpose();
        Some(BoardPerspective {
            perspective: map.ring(ring.plane_m, outer_radius_m)?.perspective,
            covariance: self.by_map * moves,
            with_ring: self.centre_by_map * moves * self.weight,
        })
    }
}

/// How far a ring's centre is off the map if its perspective is this one, in standard deviations squared.
fn off(map: &LensMap, ring: &Sighting, perspective: &Vector2<f64>) -> Option<f64> {
    let missing = ring.centre_given(perspective) - map.place(ring.plane_m)?;
    Some(missing.dot(&(ring.given.try_inverse()? * missing)))
}

/// By the median of the centres, for one ring that is none must not say that the map is wrong.
fn misfit(map: &LensMap, off: &[(f64, f64)]) -> Option<f64> {
    let mut squares: Vec<f64> = off.iter().map(|(centre, _)| *centre).collect();
    squares.sort_by(f64::total_cmp);
    let measured = 2.0 * squares.len() as f64;
    let deviations = (measured - map.parameters() as f64).max(1.0);
    Some(squares.get(squares.len() / 2)? / MEDIAN * measured / deviations)
}

/// What centres and perspectives are off the map, in standard deviations squared; those far off count less.
fn cost(off: &[(f64, f64)]) -> f64 {
    let weighed = |square: f64| robust(square) * square;
    off.iter()
        .map(|(centre, perspective)| weighed(*centre) + weighed(*perspective))
        .sum()
}

/// The weight of what is off by so many standard deviations squared.
fn robust(square: f64) -> f64 {
    ROBUST / square.sqrt().max(ROBUST)
}

/// What is known of a lens before.
fn prior(map: &LensMap) -> Equations {
    let (mut normal, mut right) = (SMatrix::zeros(), SVector::zeros());
    for (k, (value, std)) in map.lens().iter().zip(LENS_PRIOR).enumerate() {
        // what is not free stays where it is
        let (weight, value) = if k < map.free {
            (std.powi(-2), *value)
        } else {
            (1.0, 0.0)
        };
        normal[(8 + k, 8 + k)] = weight;
        right[8 + k] = -weight * value;
    }
    (normal, right)
}
