//! The rings of one board: each measured by its grey values, with what the others know.
//!
//! A few rings (the jury) are fitted from several starts and with both shapes of blur; they say which it is, how much larger than its
//! circle a blurred outline looks, and how the blur changes over the board. All rings then start from there. Where blurred
//! skirts of neighbours reach into a ring's window they are part of its model, from the neighbours' own fits, until nothing
//! moves. What stands in a window and is no ring is left out (`trust`). Last, the rings share their perspective (`law`).

use super::alone::Ends;
use super::around::{around, reaches};
use super::blur::Psf;
use super::border::mend;
use super::choice::PsfChoice;
use super::crowd::Crowd;
use super::fit::{Given, Known};
use super::flatten::{bend_back, flatten};
use super::joint::settle_together;
use super::jury::verdict;
use super::kept::{KeptRing, KeptWindow, RingMeasured, worth_keeping};
use super::lens_map::{LensMap, blank};
use super::model::RingModel;
use super::plane::PlaneView;
use super::problem::Workspace;
use super::ring::{RingError, Seen, gate};
use super::round::out_of_round;
use super::shared::Shared;
use super::under::Under;
use super::uneven::even_out;
use super::usual::{MOST_IF_GIVEN, Usual};
use crate::camera::Camera;
use crate::centre::Ellipse;
use crate::frame::{Frame, Linear};
use nalgebra::Point2;
use rayon::prelude::*;

/// Rounds of fits while neighbours' skirts are still moving; after the first two, all rings step together before each.
const ROUNDS: usize = 6;

/// Times that bends are taken out of the pixels, each with a better map.
const FLATTENED: usize = 2;

/// Where more of the rings than this have no fit after two rounds, further ones are in vain.
const HOPELESS: f64 = 0.7;

/// What may be left of the bends in a centre although they are taken off, over what they move the ring's curves by: under blur they move a
/// fit by up to twice that, and before a fisheye the map is not quite the lens.
const BENT_LEFT: f64 = 1.5;

/// A ring of a board as it was seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardPlace {
    /// Where it is on the board, m.
    pub plane_m: Point2<f64>,
    /// The outline that was seen, px.
    pub outline: Ellipse,
    /// The blur its edge seems to have, px.
    pub sigma_px: f64,
}

/// A board to be measured.
#[derive(Debug, Clone, Copy)]
pub struct BoardStart<'a> {
    /// Its rings.
    pub places: &'a [BoardPlace],
    /// Outer radius, m.
    pub outer_radius_m: f64,
    /// Inner over outer radius.
    pub ratio: f64,
    /// 1 for dark rings, -1 for light ones.
    pub sign: f64,
    /// The shape of the blur.
    pub psf: PsfChoice,
    /// The camera, where it is known already: it gives the rings' perspective.
    pub camera: Option<Camera>,
    /// Light from grey values.
    pub linear: &'a Linear,
}

impl BoardStart<'_> {
    /// The board's plane through the outlines seen; `None` where they determine none.
    pub(super) fn view(&self) -> Option<PlaneView> {
        let seen = self.places.iter();
        let pairs: Vec<_> = seen
            .map(|place| (place.plane_m, place.outline.centre))
            .collect();
        PlaneView::through(&pairs)
    }

    pub(super) fn seen(&self, place: &BoardPlace) -> Seen {
        Seen {
            outline: place.outline,
            ratio: self.ratio,
            sign: self.sign,
        }
    }
}

/// A board measured.
#[derive(Debug, Clone, PartialEq)]
pub struct BoardMeasured {
    /// The shape of the blur.
    pub psf: Psf,
    /// Its rings, in the order given.
    pub rings: Vec<Result<RingMeasured, RingError>>,
    /// How far the outlines are from circles beyond what noise explains, in radii.
    pub out_of_round: f64,
}

/// Measures the rings of a board.
pub fn measure_board(frame: &Frame, board: &BoardStart) -> BoardMeasured {
    let view = board.view();
    let verdict = verdict(frame, board, view.as_ref());
    let mut rings: Vec<Under> = board
        .places
        .par_iter()
        .map(|place| Under::begin(frame, (board, place, view.as_ref()), &verdict))
        .collect();
    let mut moved = vec![true; rings.len()];
    for round in 0..ROUNDS {
        if round > 1 && settle_together(board.ratio, &mut rings) {
            moved.fill(true);
        }
        moved = fit_round(board, view.as_ref(), &mut rings, (round, &moved));
        let failed = rings.iter().filter(|ring| ring.fitted.is_err()).count();
        let is_hopeless = round > 0 && failed as f64 > HOPELESS * rings.len() as f64;
        if is_hopeless || !moved.contains(&true) {
            break;
        }
    }
    let camera = board
        .camera
        .unwrap_or_else(|| blank(frame.width(), frame.height()));
    let mut shared = Shared::of(board, &rings, &camera);
    for _ in 0..FLATTENED {
        let standing = (board, view.as_ref());
        if !flatten(frame, standing, &mut rings, &shared) {
            break;
        }
        shared = Shared::of(board, &rings, &camera);
    }
    let has_edge = |ring: &Under| ring.fitted.is_ok_and(|f| f.model.sheet.is_some());
    let mut is_stale = false;
    if rings.iter().any(has_edge)
        && let Some(map) = &shared.map
        && mend(frame, board, &mut rings, map)
    {
        let all = vec![true; rings.len()];
        fit_round(board, view.as_ref(), &mut rings, (ROUNDS, &all));
        is_stale = true;
    }
    if even_out(board, &mut rings) {
        settle_together(board.ratio, &mut rings);
        is_stale = true;
    }
    is_stale |= Usual::leave_out_covered(&mut rings);
    let out_of_round = out_of_round(board.ratio, &rings);
    let models: Vec<RingModel> = rings.iter().map(|ring| ring.model).collect();
    let crowd = rings.iter().any(|ring| ring.crowded);
    let crowd = crowd.then(|| Crowd::of(board.ratio, (&rings, &models), Ends::Free));
    is_stale |= bend_back(&mut rings);
    if let Some(crowd) = crowd.flatten() {
        crowd.widen(&mut rings);
        is_stale = true;
    }
    if is_stale {
        shared = Shared::of(board, &rings, &camera);
    }
    BoardMeasured {
        psf: verdict.psf,
        rings: finish(board, rings, shared),
        out_of_round,
    }
}

/// Fits the rings that have moved and those that have one in reach that has (in the first round all); says which may make others move.
fn fit_round(
    board: &BoardStart,
    view: Option<&PlaneView>,
    rings: &mut [Under],
    (round, moved): (usize, &[bool]),
) -> Vec<bool> {
    let models: Vec<RingModel> = rings.iter().map(|ring| ring.model).collect();
    let is_touched = |i: usize, ring: &Under| {
        let grid = ring.window.as_ref().map(|window| window.grid);
        let others = models.iter().zip(moved).enumerate();
        grid.is_some_and(|grid| {
            moved[i]
                || others
                    .filter(|(_, (_, moved))| **moved)
                    .any(|(j, (model, _))| j != i && reaches(model, &grid))
        })
    };
    let work = rings.par_iter_mut().zip(board.places).enumerate();
    let moved = work.map_init(Workspace::default, |room, (i, (ring, place))| {
        if round > 0 && !(ring.crowded && is_touched(i, ring)) {
            return false;
        }
        ring.fit((board, place, view), (i, &models), room);
        ring.crowded && ring.has_moved(&models[i])
    });
    moved.collect()
}

/// The rings with what they say together; those whose own pixels do not tell their shape get it from the map
/// through the others.
fn finish(
    board: &BoardStart,
    mut rings: Vec<Under>,
    shared: Shared,
) -> Vec<Result<RingMeasured, RingError>> {
    let Shared {
        centres,
        map,
        bent,
        straight,
    } = shared;
    if let Some(map) = map.filter(|_| centres.len() < rings.len()) {
        fit_given(board, &mut rings, &map);
    }
    let windows = rings.iter().zip(&bent).map(|(ring, bent)| {
        let grid = ring.window.as_ref().map(|window| window.grid);
        (grid, bent.map_or(0.0, |bent| bent.beside_px))
    });
    let keep = worth_keeping(&windows.collect::<Vec<_>>());
    let windows: Vec<Option<KeptWindow>> = rings
        .par_iter()
        .zip(keep)
        .map(|(ring, keep)| ring.window.as_ref().filter(|_| keep).map(KeptWindow::of))
        .collect();
    let mut shared = centres.into_iter();
    let rings = rings.into_iter().zip(windows).zip(bent);
    let measured = rings.map(|((ring, window), bent)| {
        let alone = ring.given;
        let fitted = ring.fitted?;
        let own = (fitted.model.shape.centre, fitted.centre_covariance());
        let next = if alone { Some(own) } else { shared.next() };
        let (mut centre, mut covariance) = next.unwrap_or(own);
        let moved = bent.map(|bent| bent.moved()).unwrap_or_default();
        if alone || !straight {
            centre -= moved;
        }
        covariance += moved * moved.transpose() * (BENT_LEFT * BENT_LEFT);
        Ok(RingMeasured {
            centre,
            covariance,
            kept: KeptRing { fitted, window },
        })
    });
    measured.collect()
}

/// Fits the rings that have no fit yet with the shape that the map gives them.
fn fit_given(board: &BoardStart, rings: &mut [Under], map: &LensMap) {
    let models: Vec<RingModel> = rings.iter().map(|ring| ring.model).collect();
    let usual = Usual::of(rings);
    let work = rings.par_iter_mut().zip(board.places).enumerate();
    work.filter(|(_, (ring, _))| ring.fitted.is_err())
        .for_each_init(Workspace::default, |room, (i, (ring, place))| {
            let (Some(window), Some(shape)) = (
                ring.window.as_ref(),
                map.ring(place.plane_m, board.outer_radius_m),
            ) else {
                return;
            };
            let around = around(&window.grid, board.ratio, (i, &models), room);
            let known = Known {
                window,
                ratio: board.ratio,
                around: around.as_ref(),
                given: Given::Shape,
            };
            let start = RingModel {
                shape,
                ..ring.model
            };
            let seen = ring.seen;
            let again = known.fit_with(&start, start.blur.psf, room);
            let again = again.map_err(RingError::from).and_then(|f| gate(&seen, f));
            if let Some(fitted) = again
                .ok()
                .filter(|f| !usual.is_noisy(f, &window.grid, MOST_IF_GIVEN))
            {
                ring.fitted = Ok(fitted);
                ring.given = true;
            }
        });
}
