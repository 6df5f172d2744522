//! The rings of one board: each measured by its grey values, with what the others know.
//!
//! A few rings (the jury) are fitted from several starts and with both shapes of blur; they say which it is, how much larger than its
//! circle a blurred outline looks, and how the blur changes over the board. All rings then start from there. Where blurred
//! skirts of neighbours reach into a ring's window they are part of its model, from the neighbours' own fits, until nothing
//! moves. What stands in a window and is no ring is left out (`trust`). Last, the rings share their perspective (`law`).

use super::around::around;
use super::blur::Psf;
use super::choice::PsfChoice;
use super::fit::{Given, Known, RingFitted};
use super::jury::{Verdict, verdict};
use super::kept::{KeptRing, KeptWindow, RingMeasured};
use super::law::share_perspective;
use super::lens_map::{LensMap, blank};
use super::model::RingModel;
use super::plane::PlaneView;
use super::problem::Workspace;
use super::ring::{RingError, Seen, gate};
use super::start::{Cut, cut};
use super::trust::Surroundings;
use super::window::Window;
use crate::camera::Camera;
use crate::centre::Ellipse;
use crate::frame::{Frame, Linear};
use nalgebra::Point2;
use rayon::prelude::*;

/// Rounds of fits while neighbours' skirts are still moving.
const ROUNDS: usize = 3;
/// A ring whose shape is given has residuals of at most so much of the others' noise.
const MOST_NOISE: f64 = 1.5;
/// A ring has settled when it moved by less than this many of its standard deviations.
const SETTLED: f64 = 0.1;

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
}

/// Measures the rings of a board.
pub fn measure_board(frame: &Frame, board: &BoardStart) -> BoardMeasured {
    let view = board.view();
    let verdict = verdict(frame, board, view.as_ref());
    let mut rings: Vec<Under> = board
        .places
        .par_iter()
        .map(|place| Under::begin(frame, board, place, view.as_ref(), &verdict))
        .collect();
    for round in 0..ROUNDS {
        let moved = fit_round(board, &mut rings, round);
        if !moved {
            break;
        }
    }
    let camera = board
        .camera
        .unwrap_or_else(|| blank(frame.width(), frame.height()));
    finish(board, verdict.psf, rings, &camera)
}

/// A ring under measurement.
#[derive(Debug, Clone)]
struct Under {
    window: Option<Window>,
    model: RingModel,
    fitted: Result<RingFitted, RingError>,
    /// Other rings were in reach when it was last fitted.
    crowded: bool,
    /// Its shape is not its own but the map's.
    given: bool,
}

impl Under {
    fn begin(
        frame: &Frame,
        board: &BoardStart,
        place: &BoardPlace,
        view: Option<&PlaneView>,
        verdict: &Verdict,
    ) -> Self {
        let model = verdict.start(board, place, view);
        let outer = model.shape.ellipse(1.0).unwrap_or(place.outline);
        let sigma_px = model.blur.sigma_px();
        let window = cut(frame, &outer, sigma_px, Cut::OF_BOARD, board.linear);
        Self {
            window,
            model,
            fitted: Err(RingError::Outside),
            crowded: false,
            given: false,
        }
    }
}

/// Fits all rings that have neighbours in reach (in the first round all); says whether another round may change anything.
fn fit_round(board: &BoardStart, rings: &mut [Under], round: usize) -> bool {
    let models: Vec<RingModel> = rings.iter().map(|ring| ring.model).collect();
    let moved = rings.par_iter_mut().zip(board.places).enumerate().map_init(
        Workspace::default,
        |room, (i, (ring, place))| {
            if round > 0 && !ring.crowded {
                return false;
            }
            fit_one(board, &board.seen(place), ring, (i, &models), room);
            ring.crowded && has_moved(ring, &models[i])
        },
    );
    moved.reduce(|| false, |a, b| a || b)
}

fn has_moved(ring: &Under, before: &RingModel) -> bool {
    ring.fitted.as_ref().is_ok_and(|fitted| {
        let moved = (fitted.model.shape.centre - before.shape.centre).norm();
        let size = |model: &RingModel| model.shape.affine[0] + model.shape.affine[2];
        let grown = 0.5 * (size(&fitted.model) / size(before) - 1.0).abs();
        let std = fitted.centre_covariance().trace().sqrt();
        let radius = size(before).max(f64::MIN_POSITIVE).sqrt().recip();
        moved + grown * radius > SETTLED * std
    })
}

fn fit_one(
    board: &BoardStart,
    seen: &Seen,
    ring: &mut Under,
    (own, models): (usize, &[RingModel]),
    room: &mut Workspace,
) {
    let Some(window) = ring.window.as_mut() else {
        return;
    };
    let around = around(&window.grid, board.ratio, (own, models), room);
    ring.crowded = around.is_some();
    let mut known = Known {
        window,
        ratio: board.ratio,
        around: around.as_ref(),
        given: Given::NearStart,
    };
    let psf = ring.model.blur.psf;
    let mut fitted = known.fit_with(&ring.model, psf, room);
    if fitted.is_err() {
        // the start was not near after all
        let carefully = Known {
            given: Given::Nothing,
            ..known
        };
        fitted = carefully.fit_with(&ring.model, psf, room);
    }
    if let Ok(first) = &fitted
        && let Some(surroundings) = Surroundings::of(first, &known.window.grid)
    {
        let judgement = surroundings.judge(known.window, &room.residuals, first);
        if !judgement.is_clean() {
            // whatever stands there may have spoilt the fit: ask again without it
            let mut alone = known.window.clone();
            surroundings.mask(&mut alone, &judgement.without_suspects());
            let on_own = Known {
                window: &alone,
                ..known
            };
            let clean = on_own.fit_with(&first.model, psf, room).unwrap_or(*first);
            let residuals = room.residuals(&known, &clean.model);
            let again = surroundings.judge(known.window, residuals, &clean);
            let trusted = again.verdict();
            let window = ring.window.as_mut().filter(|_| !again.is_clean());
            if let Some(window) = window {
                surroundings.mask(window, &trusted);
                known = Known {
                    window,
                    ratio: board.ratio,
                    around: around.as_ref(),
                    given: Given::NearStart,
                };
                fitted = known.fit_with(&clean.model, psf, room);
                fitted = fitted.map(|f| f.widened_by(&clean));
            }
        }
    }
    ring.fitted = fitted.map_err(RingError::from).and_then(|f| gate(seen, f));
    if let Ok(fitted) = &ring.fitted {
        ring.model = fitted.model;
    }
}

/// Shares the perspective among the rings that were measured; those whose own pixels do not tell their shape get it from the map
/// through the others.
fn finish(board: &BoardStart, psf: Psf, mut rings: Vec<Under>, camera: &Camera) -> BoardMeasured {
    let fitted: Vec<RingFitted> = rings.iter().filter_map(|r| r.fitted.ok()).collect();
    let places: Vec<_> = rings
        .iter()
        .zip(board.places)
        .filter(|(ring, _)| ring.fitted.is_ok())
        .map(|(_, place)| place.plane_m)
        .collect();
    let (shared, map) = share_perspective(&fitted, &places, board.outer_radius_m, camera);
    if let Some(map) = map.filter(|_| places.len() < rings.len()) {
        fit_given(board, &mut rings, &map);
    }
    let mut shared = shared.into_iter();
    let measured = rings.into_iter().map(|ring| {
        let alone = ring.given;
        let fitted = ring.fitted?;
        let own = (fitted.model.shape.centre, fitted.centre_covariance());
        let next = if alone { Some(own) } else { shared.next() };
        let (centre, covariance) = next.unwrap_or(own);
        let window = ring.window.as_ref().and_then(KeptWindow::of);
        Ok(RingMeasured {
            centre,
            covariance,
            kept: KeptRing { fitted, window },
        })
    });
    BoardMeasured {
        psf,
        rings: measured.collect(),
    }
}

/// Fits the rings that have no fit yet with the shape that the map gives them.
fn fit_given(board: &BoardStart, rings: &mut [Under], map: &LensMap) {
    let models: Vec<RingModel> = rings.iter().map(|ring| ring.model).collect();
    let mut noises: Vec<f64> = rings
        .iter()
        .filter_map(|r| Some(r.fitted.ok()?.noise * r.window.as_ref()?.grid.pixel_px))
        .collect();
    noises.sort_by(f64::total_cmp);
    let noise_px = noises.get(noises.len() / 2).copied().unwrap_or(0.0);
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
            let seen = board.seen(place);
            let again = known.fit_with(&start, start.blur.psf, room);
            let usual =
                |fitted: &RingFitted| fitted.noise * window.grid.pixel_px < MOST_NOISE * noise_px;
            let again = again.map_err(RingError::from).and_then(|f| gate(&seen, f));
            if let Some(fitted) = again.ok().filter(usual) {
                ring.fitted = Ok(fitted);
                ring.given = true;
            }
        });
}
