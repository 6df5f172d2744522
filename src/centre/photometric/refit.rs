//! Rings of a view fitted again, their shapes known from elsewhere.

use super::around::around;
use super::bent::{Bent, Image};
use super::fit::{Given, Known};
use super::fitted::RingFitted;
use super::kept::{KeptRing, KeptWindow};
use super::law::{CentreAndCovariance, given_perspective};
use super::model::RingModel;
use super::problem::Workspace;
use super::shape::Shape;
use super::straight::{found_of_bent, straighten};
use nalgebra::{Matrix2, Point2, Vector2};
use rayon::prelude::*;

/// The known shape may put the ring so many standard deviations from where it was; else it is not believed.
const FARTHEST: f64 = 6.0;

/// A fit that is free takes a wrong perspective for the bends of a lens. The known one is believed all the same where it leaves no more than
/// this in the pixels, of the contrast.
const BENT: f64 = 6e-3;

/// Part of a ring's bends that moves its centre although they are taken off: camera and pose are not quite the true ones. Measured near
/// the fold of a wide lens, where bends are as large as 0.3 px.
const UNSURE: f64 = 0.012;

/// Times that bends are taken off a ring's pixels: first where its free fit says it is, then where it was found without them. It stays when it
/// moves by less than this many of its standard deviations.
const TIMES: usize = 3;
const STAYS: f64 = 0.3;

/// A ring as a view keeps it, and its shape as a camera and a pose say it is.
#[derive(Debug, Clone, Copy)]
pub struct KnownRing<'a> {
    /// What was kept.
    pub kept: &'a KeptRing,
    /// The shape; its centre is where the ring is expected, which the fit does not use.
    pub shape: Shape,
}

/// The centres of one view's rings with these shapes, in their order, free of what a lens's bends do; `None` for a ring whose pixels
/// contradict its shape. `image` is where the camera sees a place about a ring's centre (by its number here), in outer radii.
pub fn refit(
    rings: &[KnownRing],
    ratio: f64,
    image: impl Fn(usize, Vector2<f64>) -> Option<Point2<f64>> + Sync,
) -> Vec<Option<CentreAndCovariance>> {
    let models: Vec<RingModel> = rings.iter().map(|ring| ring.kept.fitted.model).collect();
    let image = &image;
    rings
        .par_iter()
        .enumerate()
        .map_init(Workspace::default, |room, (i, ring)| {
            let image = |d| image(i, d);
            let bent = Bent::beside(ring.shape, &image, ratio)?;
            let (centre, covariance) = match &ring.kept.window {
                Some(window) => by_pixels(ring, window, (ratio, &image), (i, &models), room),
                None => by_fit(ring, (ratio, &bent), image, room),
            }?;
            let unsure = UNSURE * bent.beside_px;
            Some((centre, covariance + Matrix2::identity() * unsure * unsure))
        })
        .collect()
}

/// Without pixels: what the fit has found, less what it finds of such a ring. The free perspective takes up most of a lens's bends, so that it is
/// held against the one that is found of the bent ring and not against the ring's own.
fn by_fit(
    ring: &KnownRing,
    (ratio, bent): (f64, &Bent),
    image: impl Image,
    room: &mut Workspace,
) -> Option<CentreAndCovariance> {
    let fitted = &ring.kept.fitted;
    let found = found_of_bent(fitted, bent, image, ratio, room)?;
    let given = given_perspective(fitted, found.perspective)?;
    let unexplained = given.off * fitted.noise.powi(2) / (fitted.pixels as f64);
    let believed = given.is_near() || unexplained.sqrt() < BENT * contrast(fitted);
    let (centre, covariance) = given.centre;
    believed.then(|| (centre - (found.centre - ring.shape.centre), covariance))
}

/// Fitted again to its pixels, the bends taken off them.
fn by_pixels(
    ring: &KnownRing,
    kept: &KeptWindow,
    (ratio, image): (f64, &impl Image),
    (own, models): (usize, &[RingModel]),
    room: &mut Workspace,
) -> Option<CentreAndCovariance> {
    let fitted = &ring.kept.fitted;
    let given = given_perspective(fitted, ring.shape.perspective)?;
    let mut start = RingModel {
        shape: Shape {
            centre: given.centre.0,
            affine: fitted.model.shape.affine,
            perspective: ring.shape.perspective,
        },
        ..fitted.model
    };
    let whole = kept.restore();
    let around = around(&whole.grid, ratio, (own, models), room);
    let mut again = None;
    for _ in 0..TIMES {
        let mut window = whole.clone();
        // the bends as they are where the ring was seen, which is not quite where it is expected
        let seen = start.shape.centre - ring.shape.centre;
        straighten(&mut window, &start, |d| Some(image(d)? + seen), ratio, room)?;
        let known = Known {
            window: &window,
            ratio,
            around: around.as_ref(),
            given: Given::Perspective,
        };
        let fitted = known.fit_with(&start, start.blur.psf, room).ok()?;
        let moved = fitted.model.shape.centre - start.shape.centre;
        start = fitted.model;
        again = Some(fitted);
        if moved.norm_squared() < STAYS * STAYS * fitted.centre_covariance().trace() {
            break;
        }
    }
    let again = again?;
    let believed = (given.is_near() && agrees(&again, &given.centre))
        || again.noise < fitted.noise.hypot(BENT * contrast(fitted));
    believed.then(|| (again.model.shape.centre, again.centre_covariance()))
}

fn agrees(again: &RingFitted, linear: &CentreAndCovariance) -> bool {
    let off = again.model.shape.centre - linear.0;
    let variance = linear.1 + again.centre_covariance();
    variance
        .try_inverse()
        .is_some_and(|inverse| off.dot(&(inverse * off)) < FARTHEST * FARTHEST)
}

fn contrast(fitted: &RingFitted) -> f64 {
    (fitted.model.paper - fitted.model.ring).abs()
}
