//! What a few rings of a board, fitted without prejudice, say for all: the shape of the blur, its size over the board, and how much
//! larger than its circle a blurred outline looks.

use super::blur::{Blur, Psf};
use super::board::{BoardPlace, BoardStart};
use super::choice::PsfChoice;
use super::fit::{Given, Known, RingFitted};
use super::model::RingModel;
use super::plane::PlaneView;
use super::problem::Workspace;
use super::psf::Both;
use super::ring::gate;
use super::shape::Shape;
use super::start::{Cut, cut, levels};
use super::window::Window;
use crate::frame::Frame;
use nalgebra::{Matrix3, Point2, Vector3};
use rayon::prelude::*;

/// Edges are where they seem to be while the blur is less than this fraction of the inner minor semi-axis.
const SHARP: f64 = 0.16;
/// Sizes (of the outline seen) and blurs (of the one seen) that are tried where they are not.
const SIZES: [f64; 4] = [1.0, 0.92, 0.84, 0.74];
const BLURS: [f64; 4] = [1.0, 1.35, 1.8, 2.4];
/// Sizes (of the outline seen) and disc radii (of that size) that are tried for discs about as large as the inner circle.
const LARGE_SIZES: [f64; 4] = [1.25, 1.05, 0.9, 0.75];
const LARGE_DISCS: [f64; 5] = [0.3, 0.45, 0.6, 0.8, 1.0];
/// They are not tried where a ring fits with less blur than this, sigma over the size of the outline.
const LIGHT: f64 = 0.17;
/// Blur below this looks the same whatever its shape, px.
const SHAPELESS_PX: f64 = 0.7;
/// Windows are cut for this much more blur than is seen where edges are not where they seem to be.
const HEAVY: f64 = 1.4;

/// What the jury says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Verdict {
    pub(super) psf: Psf,
    /// Size of the circle over that of the outline seen.
    size: f64,
    /// Blur sigma over the board, px: constant, along x and along y of the frame (px).
    sigma_px: Vector3<f64>,
    /// Levels of paper, ring and inside.
    levels: [f64; 3],
}

impl Verdict {
    /// Where the fit of a ring begins.
    pub(super) fn start(
        &self,
        board: &BoardStart,
        place: &BoardPlace,
        view: Option<&PlaneView>,
    ) -> RingModel {
        let seen = shape_of(place, view);
        let at = place.outline.centre;
        let sigma_px = self.sigma_px.dot(&Vector3::new(1.0, at.x, at.y));
        let sharp = is_sharp(board, place);
        let bounds = if sharp { (0.6, 1.6) } else { (0.7, 3.0) };
        let least = (bounds.0 * place.sigma_px).max(0.2);
        let sigma_px = sigma_px.clamp(least, (bounds.1 * place.sigma_px).max(least));
        let [paper, ring, inside] = self.levels;
        RingModel {
            shape: seen.scaled(self.size),
            blur: Blur::of_sigma(self.psf, sigma_px),
            paper,
            ring,
            inside,
            shading: [0.0; 2],
            sheet: None,
        }
    }
}

/// Asks the jury. Where none of it can be fitted, what was seen is believed.
pub(super) fn verdict(frame: &Frame, board: &BoardStart, view: Option<&PlaneView>) -> Verdict {
    let jurors = jurors(board.places);
    let heard: Vec<(BoardPlace, Both)> = jurors
        .par_iter()
        .map_init(Workspace::default, |room, &i| {
            let place = board.places[i];
            Some((place, hear(frame, board, &place, view, room)?.0))
        })
        .flatten()
        .collect();
    let evidence: f64 = heard
        .iter()
        .filter_map(|(_, both)| both.disc_over_gaussian())
        .sum();
    let found = |psf| {
        heard
            .iter()
            .filter(|(_, both)| both.of(psf).is_ok())
            .count()
    };
    let disc = evidence > 0.0 || found(Psf::Disc) > found(Psf::Gaussian);
    let psf = if disc { Psf::Disc } else { Psf::Gaussian };
    let fits: Vec<(BoardPlace, RingFitted)> = heard
        .iter()
        .filter_map(|(place, both)| Some((*place, (*both.of(psf)).ok()?)))
        .collect();
    Verdict {
        psf,
        size: median(
            fits.iter()
                .map(|(place, fitted)| relative_size(place, fitted)),
        )
        .unwrap_or(1.0),
        sigma_px: sigma_law(board, &fits),
        levels: common_levels(board, &fits),
    }
}

/// A few rings spread over the board, none of them at its border where it is large enough.
pub(super) fn jurors(places: &[BoardPlace]) -> Vec<usize> {
    let range = |of: fn(&BoardPlace) -> f64| {
        let low = places.iter().map(of).fold(f64::MAX, f64::min);
        let high = places.iter().map(of).fold(f64::MIN, f64::max);
        (0.5 * (low + high), 0.5 * (high - low))
    };
    let ((x, half_x), (y, half_y)) = (range(|p| p.plane_m.x), range(|p| p.plane_m.y));
    let mut chosen = Vec::new();
    for (u, v) in [
        (0.0, 0.0),
        (-0.6, -0.6),
        (0.6, 0.6),
        (0.6, -0.6),
        (-0.6, 0.6),
    ] {
        let wanted = Point2::new(x + u * half_x, y + v * half_y);
        let nearest = (0..places.len()).min_by(|&a, &b| {
            let apart = |i: usize| (places[i].plane_m - wanted).norm();
            apart(a).total_cmp(&apart(b))
        });
        chosen.extend(nearest.filter(|i| !chosen.contains(i)));
    }
    chosen
}

fn is_sharp(board: &BoardStart, place: &BoardPlace) -> bool {
    place.sigma_px < SHARP * board.ratio * place.outline.minor
}

fn shape_of(place: &BoardPlace, view: Option<&PlaneView>) -> Shape {
    view.and_then(|view| view.ring_of(&place.outline))
        .unwrap_or_else(|| Shape::frontal(&place.outline))
}

/// Fits one ring with the shapes of blur that are asked for; its fits and its pixels.
pub(super) fn hear(
    frame: &Frame,
    board: &BoardStart,
    place: &BoardPlace,
    view: Option<&PlaneView>,
    room: &mut Workspace,
) -> Option<(Both, Window)> {
    let sharp = is_sharp(board, place);
    let cut_px = if sharp {
        place.sigma_px
    } else {
        HEAVY * place.sigma_px
    };
    let narrow = Cut {
        margin_sigmas: 0.75 * Cut::OF_BOARD.margin_sigmas,
        ..Cut::OF_BOARD
    };
    let pixels = cut(frame, &place.outline, cut_px, narrow, board.linear)?;
    let known = Known {
        window: &pixels,
        ratio: board.ratio,
        around: None,
        given: if sharp {
            Given::NearStart
        } else {
            Given::Nothing
        },
    };
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
    let tried = sizes
        .iter()
        .flat_map(|size| blurs.iter().map(move |blur| (size, blur)));
    let (_, start) = tried
        .filter_map(|(size, blur)| {
            let blur = Blur::of_sigma(start_psf, (blur * place.sigma_px).max(0.2));
            levels(&pixels, &seen.scaled(*size), &blur, board.ratio, room)
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))?;
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
    let size_px = (place.outline.major * place.outline.minor).sqrt();
    let light = |fitted: RingFitted| fitted.model.blur.sigma_px() < LIGHT * size_px;
    let settled = sharp || both.likelier().ok().and_then(gated).is_some_and(light);
    let both = if settled || board.psf == PsfChoice::Fixed(Psf::Gaussian) {
        both
    } else {
        with_large_disc(&known, &seen, both, room)
    };
    both.likelier().ok().and_then(gated)?;
    Some((both, pixels))
}

/// The fits, with a better one of a disc where a large disc explains the pixels: it inverts the inner circle's contrast, which no
/// Gaussian resembles, so that a start from one does not find it.
fn with_large_disc(known: &Known, seen: &Shape, both: Both, room: &mut Workspace) -> Both {
    let Some(outline) = seen.ellipse(1.0) else {
        return both;
    };
    let seen_px = (outline.major * outline.minor).sqrt();
    let tried = LARGE_SIZES
        .iter()
        .flat_map(|size| LARGE_DISCS.iter().map(move |disc| (size, disc)));
    let best = tried
        .filter_map(|(size, disc)| {
            let blur = Blur::disc(disc * size * seen_px);
            levels(known.window, &seen.scaled(*size), &blur, known.ratio, room)
        })
        .min_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, start)) = best else {
        return both;
    };
    let squares = |fit: &Result<RingFitted, _>| fit.as_ref().map_or(f64::INFINITY, |f| f.squares);
    let carefully = Known {
        given: Given::Nothing,
        ..*known
    };
    let disc = carefully.fit_with(&start, Psf::Disc, room);
    if squares(&disc) < squares(&both.disc) {
        Both { disc, ..both }
    } else {
        both
    }
}

fn relative_size(place: &BoardPlace, fitted: &RingFitted) -> f64 {
    let [xx, xy, yy] = fitted.model.shape.affine;
    let seen = place.outline.major * place.outline.minor;
    ((xx * yy - xy * xy).max(f64::MIN_POSITIVE).sqrt() * seen)
        .sqrt()
        .recip()
}

fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// The plane through the jury's blurs; a constant where they are too few.
fn sigma_law(board: &BoardStart, fits: &[(BoardPlace, RingFitted)]) -> Vector3<f64> {
    let sigma = |fitted: &RingFitted| fitted.model.blur.sigma_px();
    let seen = || median(board.places.iter().map(|place| place.sigma_px)).unwrap_or(1.0);
    let constant = median(fits.iter().map(|(_, fitted)| sigma(fitted))).unwrap_or_else(seen);
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for (place, fitted) in fits {
        let at = place.outline.centre;
        let row = Vector3::new(1.0, at.x, at.y);
        normal += row * row.transpose();
        right += row * sigma(fitted);
    }
    let plane = (fits.len() > 3)
        .then(|| normal.cholesky())
        .flatten()
        .map(|c| c.solve(&right));
    plane.unwrap_or_else(|| Vector3::new(constant, 0.0, 0.0))
}

fn common_levels(board: &BoardStart, fits: &[(BoardPlace, RingFitted)]) -> [f64; 3] {
    let of = |pick: fn(&RingModel) -> f64| median(fits.iter().map(|(_, f)| pick(&f.model)));
    let (light, dark) = if board.sign > 0.0 {
        (0.8, 0.2)
    } else {
        (0.2, 0.8)
    };
    [
        of(|m| m.paper).unwrap_or(light),
        of(|m| m.ring).unwrap_or(dark),
        of(|m| m.inside).unwrap_or(light),
    ]
}
