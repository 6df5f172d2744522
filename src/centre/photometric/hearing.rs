//! One ring of a jury: fitted from many starts, or from where another one ended.

use super::blur::{Blur, Psf};
use super::board::{BoardPlace, BoardStart};
use super::choice::PsfChoice;
use super::fit::{Given, Known};
use super::fitted::{FitError, RingFitted};
use super::jury::relative_size;
use super::likes::{alike, among_likes};
use super::model::RingModel;
use super::plane::PlaneView;
use super::problem::Workspace;
use super::psf::Both;
use super::ring::{gate, has_contrast};
use super::shape::Shape;
use super::start::{self, Cut, cut, levels};
use super::window::Window;
use crate::frame::Frame;
use rayon::prelude::*;

/// Sizes (of the outline seen) and blurs (of the one seen) that are tried where they are not.
const SIZES: [f64; 4] = [1.0, 0.92, 0.84, 0.74];
const BLURS: [f64; 4] = [1.0, 1.35, 1.8, 2.4];
/// Sizes (of the outline seen) and disc radii (of that size) that are tried for discs about as large as the inner circle.
const LARGE_SIZES: [f64; 5] = [1.25, 1.1, 1.0, 0.9, 0.75];
const LARGE_DISCS: [f64; 7] = [0.3, 0.45, 0.6, 0.7, 0.8, 0.9, 1.0];
/// They are not tried where a ring fits with less blur than this, sigma over the size of the outline.
const LIGHT: f64 = 0.17;
/// Blur below this looks the same whatever its shape, px.
const SHAPELESS_PX: f64 = 0.7;
/// Windows are cut for this much more blur than is seen where edges are not where they seem to be.
const HEAVY: f64 = 1.4;
/// Where one ring says by so much (logarithm of likelihoods) which shape the blur has, the others are not asked again.
const DECISIVE: f64 = 30.0;

/// The pixels of a juror: fewer than of the other rings, because no centre comes of them.
fn window(frame: &Frame, board: &BoardStart, place: &BoardPlace) -> Option<Window> {
    let cut_px = if is_sharp(board, place) {
        place.sigma_px
    } else {
        HEAVY * place.sigma_px
    };
    let narrow = Cut {
        margin_sigmas: 0.75 * Cut::OF_BOARD.margin_sigmas,
        ..Cut::OF_BOARD
    };
    cut(frame, &place.outline, cut_px, narrow, board.linear)
}

fn known<'a>(window: &'a Window, board: &BoardStart, near: bool) -> Known<'a> {
    Known {
        window,
        ratio: board.ratio,
        around: None,
        given: if near {
            Given::NearStart
        } else {
            Given::Nothing
        },
    }
}

/// Of several shapes and blurs those that explain the pixels best.
fn best(known: &Known, tried: &[(Shape, Blur)]) -> Option<RingModel> {
    let levels = tried
        .par_iter()
        .map_init(Workspace::default, |room, (shape, blur)| {
            levels(known.window, (shape, blur), known.ratio, None, room)
        });
    let found: Vec<_> = levels.flatten().collect();
    let best = found.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, model)| model)
}

/// Fits a ring from where another one ended; `None` where it does not end on this ring. Where the other one was sure of the shape of
/// the blur, only that is fitted.
pub(super) fn follow(
    frame: &Frame,
    board: &BoardStart,
    (first, ended): (&BoardPlace, &Both),
    (place, view): (&BoardPlace, Option<&PlaneView>),
    room: &mut Workspace,
) -> Option<Both> {
    let pixels = window(frame, board, place)?;
    let known = known(&pixels, board, true);
    let seen = shape_of(place, view);
    let mut fit = |psf: Psf| {
        let there = (*ended.of(psf))?;
        let shape = seen.scaled(relative_size(first, &there));
        let blur = there.model.blur;
        let start = levels(&pixels, (&shape, &blur), board.ratio, None, room);
        let (_, start) = start.ok_or(FitError::Undetermined)?;
        known.fit_with(&start, psf, room)
    };
    let both = match ended.disc_over_gaussian() {
        Some(evidence) if evidence > DECISIVE => Both::only(Psf::Disc, fit(Psf::Disc)),
        Some(evidence) if evidence < -DECISIVE => Both::only(Psf::Gaussian, fit(Psf::Gaussian)),
        _ => Both {
            gaussian: fit(Psf::Gaussian),
            disc: fit(Psf::Disc),
        },
    };
    let both = among_likes(board, (place, view), &pixels, both, room);
    let ended = both.likelier().ok()?;
    gate(&board.seen(place), ended).is_ok().then_some(both)
}

pub(super) fn is_sharp(board: &BoardStart, place: &BoardPlace) -> bool {
    start::is_sharp(place.sigma_px, board.ratio * place.outline.minor)
}

pub(super) fn shape_of(place: &BoardPlace, view: Option<&PlaneView>) -> Shape {
    view.and_then(|view| view.ring_of(&place.outline))
        .unwrap_or_else(|| Shape::frontal(&place.outline))
}

/// Fits one ring with the shapes of blur that are asked for; its fits and its pixels. Discs so large that they invert contrasts are
/// tried where that is asked for.
pub(super) fn hear(
    frame: &Frame,
    board: &BoardStart,
    (place, view): (&BoardPlace, Option<&PlaneView>),
    large: bool,
    room: &mut Workspace,
) -> Option<(Both, Window)> {
    let sharp = is_sharp(board, place);
    let pixels = window(frame, board, place)?;
    let known = known(&pixels, board, sharp);
    let start_psf = match board.psf {
        PsfChoice::Fixed(psf) => psf,
        PsfChoice::Auto => Psf::Gaussian,
    };
    let seen = shape_of(place, view);
    let (sizes, blurs) = if sharp {
        (&SIZES[..1], &BLURS[..1])
    } else {
        (&SIZES[..], &BLURS[..])
    };
    let blurs = blurs.iter().map(|blur| (blur * place.sigma_px).max(0.2));
    let blurs: Vec<Blur> = blurs.map(|px| Blur::of_sigma(start_psf, px)).collect();
    let tried = sizes
        .iter()
        .flat_map(|size| blurs.iter().map(move |blur| (seen.scaled(*size), *blur)));
    let start = best(&known, &tried.collect::<Vec<_>>())?;
    let gated = |fitted: RingFitted| gate(&board.seen(place), fitted).ok();
    let both = match board.psf {
        PsfChoice::Fixed(psf) => Both::only(psf, known.fit_with(&start, psf, room)),
        PsfChoice::Auto => {
            let gaussian = known.fit_with(&start, Psf::Gaussian, room);
            match gaussian {
                Ok(fitted) if fitted.model.blur.sigma_px() < SHAPELESS_PX => {
                    Both::only(Psf::Gaussian, gaussian)
                }
                _ => known.fit_disc_beside(gaussian, &start, room),
            }
        }
    };
    let size_px = place.outline.mean_radius();
    let light = |fitted: RingFitted| fitted.model.blur.sigma_px() < LIGHT * size_px;
    let settled = sharp || both.likelier().ok().and_then(gated).is_some_and(light);
    let both = if settled || !large || board.psf == PsfChoice::Fixed(Psf::Gaussian) {
        both
    } else {
        with_large_disc(&known, board, (place, view), both, room)
    };
    let both = among_likes(board, (place, view), &pixels, both, room);
    both.likelier().ok().and_then(gated)?;
    Some((both, pixels))
}

/// The fits, with a better one of a disc where a large disc explains the pixels: it inverts the inner circle's contrast, which no
/// Gaussian resembles, so that a start from one does not find it. Discs as large reach into the neighbours' windows: all rings are
/// drawn alike in each start.
fn with_large_disc(
    known: &Known,
    board: &BoardStart,
    (place, view): (&BoardPlace, Option<&PlaneView>),
    both: Both,
    room: &mut Workspace,
) -> Both {
    let (seen, seen_px) = (shape_of(place, view), place.outline.mean_radius());
    let tried: Vec<(f64, Blur)> = LARGE_SIZES
        .iter()
        .flat_map(|&size| {
            let discs = LARGE_DISCS.iter();
            discs.map(move |disc| (size, Blur::disc(disc * size * seen_px)))
        })
        .collect();
    let found = tried
        .par_iter()
        .map_init(Workspace::default, |room, &(size, blur)| {
            let around = alike(known.window, board, (place, view), (size, blur), room);
            let ring = (&seen.scaled(size), &blur);
            let (squares, model) = levels(known.window, ring, known.ratio, around.as_ref(), room)?;
            has_contrast(board.sign, &model).then_some((squares, model, around))
        });
    let found: Vec<_> = found.flatten().collect();
    let best = found.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, start, around)) = best else {
        return both;
    };
    let squares = |fit: &Result<RingFitted, _>| fit.as_ref().map_or(f64::INFINITY, |f| f.squares);
    let carefully = Known {
        given: Given::Nothing,
        around: around.as_ref(),
        ..*known
    };
    let disc = carefully.fit_with(&start, Psf::Disc, room);
    if squares(&disc) < squares(&both.disc) {
        Both { disc, ..both }
    } else {
        both
    }
}
