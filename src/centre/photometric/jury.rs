//! What a few rings of a board say for all: the shape of the blur, its size over the board, and how much larger than its circle a
//! blurred outline looks.
//!
//! The first of them is fitted without prejudice (`hearing`), the others from where it ended.

use super::blur::{Blur, Psf};
use super::board::{BoardPlace, BoardStart};
use super::fitted::RingFitted;
use super::hearing::{follow, hear, is_sharp, shape_of};
use super::model::RingModel;
use super::plane::PlaneView;
use super::problem::Workspace;
use super::psf::Both;
use crate::frame::Frame;
use nalgebra::{Matrix3, Point2, Vector3};
use rayon::prelude::*;

/// So many of the jury are asked for large discs before one is heard: it is the dearest question, and no ring but a board's answers it.
const LARGE: usize = 2;

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
    let jurors = jurors(board.places).into_iter().map(|i| board.places[i]);
    let jurors: Vec<BoardPlace> = jurors.collect();
    let mut room = Workspace::default();
    let hear = |place: &BoardPlace, large: bool, room: &mut Workspace| {
        Some((*place, hear(frame, board, (place, view), large, room)?.0))
    };
    let mut first = jurors.iter().enumerate();
    let first = first.find_map(|(i, place)| Some((i, hear(place, i < LARGE, &mut room)?)));
    let heard: Vec<(BoardPlace, Both)> = first.map_or_else(Vec::new, |(spokesman, first)| {
        let others: Vec<_> = jurors[spokesman + 1..]
            .par_iter()
            .map_init(Workspace::default, |room, place| {
                let same = follow(frame, board, (&first.0, &first.1), (place, view), room);
                same.map(|both| (*place, both))
                    .or_else(|| hear(place, false, room))
            })
            .flatten()
            .collect();
        std::iter::once(first).chain(others).collect()
    });
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

pub(super) fn relative_size(place: &BoardPlace, fitted: &RingFitted) -> f64 {
    let [xx, xy, yy] = fitted.model.shape.affine;
    let seen = place.outline.major * place.outline.minor;
    ((xx * yy - xy * xy).max(f64::MIN_POSITIVE).sqrt() * seen)
        .sqrt()
        .recip()
}

/// The middle one of some values; `None` of none.
pub(super) fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
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
