//! What the rings at one side of a board know of one another: how far from them the sheet ends.
//!
//! Where the blur reaches the sheet's edge, a ring fitted without it ends up somewhere else, and its residuals do not always tell where
//! the edge is. But the edge is straight and so is the row of rings: a few that found it know where all others have to look.

use super::board::{BoardPlace, BoardStart};
use super::jury::median;
use super::lens_map::LensMap;
use super::model::RingModel;
use super::problem::Workspace;
use super::ring::{RingError, Seen};
use super::sheet::{Edge, SheetEnd};
use super::sheet_start::sides;
use super::start::Cut;
use super::under::Under;
use super::usual::Usual;
use crate::frame::Frame;
use nalgebra::{Point2, Vector2};
use rayon::prelude::*;

/// The sides of a board.
const SIDES: [[f64; 2]; 4] = [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]];
/// A ring whose blur is (the logarithm) so far from the others' may have taken an edge for blur.
const UNLIKE: f64 = 0.12;
/// Steps of a secant that finds an edge on the plane.
const STEPS: usize = 4;

/// Distance (m) of the sheet's edge from the outermost rings' centres, at each of the sides.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Margins {
    at_side_m: [Option<f64>; 4],
    /// Over all sides.
    usual_m: f64,
    /// Light beyond.
    beyond: f64,
}

impl Margins {
    /// As the rings have found them; `None` where none has.
    fn of(board: &BoardStart, rings: &[Under], map: &LensMap) -> Option<Self> {
        let mut found: [Vec<f64>; 4] = Default::default();
        let mut lights = Vec::new();
        for (ring, place) in rings.iter().zip(board.places) {
            let Some(end) = ring.fitted.ok().and_then(|fitted| fitted.model.sheet) else {
                continue;
            };
            lights.push(end.beyond);
            for edge in std::iter::once(end.edge).chain(end.other) {
                let at = side_of(board, place, map, &edge)
                    .and_then(|side| Some((side, margin_m(board, place, map, side, &edge)?)));
                if let Some((side, margin_m)) = at {
                    found[side].push(margin_m);
                }
            }
        }
        Some(Self {
            usual_m: median(found.concat())?,
            at_side_m: found.map(median),
            beyond: median(lights)?,
        })
    }

    /// The end of the sheet beside a ring. Where no ring at its side has found one, and something is wrong with the ring (`lost`),
    /// it may be as far out as it is elsewhere.
    fn end(
        &self,
        (board, place): (&BoardStart, &BoardPlace),
        map: &LensMap,
        lost: bool,
    ) -> Option<SheetEnd> {
        let elsewhere = lost.then_some(self.usual_m);
        let mut edges = (0..4)
            .filter(|&side| sides(board, place).contains(&Vector2::from(SIDES[side])))
            .filter_map(|side| edge(place, map, side, self.at_side_m[side].or(elsewhere)?));
        Some(SheetEnd {
            beyond: self.beyond,
            edge: edges.next()?,
            other: edges.next(),
        })
    }
}

/// Fits the rings again that have not found an edge which others at their side have; says whether any changed.
pub(super) fn mend(frame: &Frame, board: &BoardStart, rings: &mut [Under], map: &LensMap) -> bool {
    let Some(margins) = Margins::of(board, rings, map) else {
        return false;
    };
    let models: Vec<RingModel> = rings.iter().map(|ring| ring.model).collect();
    let level = |of: fn(&RingModel) -> f64| {
        median(rings.iter().filter_map(|r| Some(of(&r.fitted.ok()?.model))))
    };
    let (Some(paper), Some(ring), Some(inside), Some(blur_px)) = (
        level(|m| m.paper),
        level(|m| m.ring),
        level(|m| m.inside),
        level(|m| m.blur.size_px),
    ) else {
        return false;
    };
    let usual = Usual::of(rings);
    let work = rings.par_iter_mut().zip(board.places).enumerate();
    work.map_init(Workspace::default, |room, (i, (under, place))| {
        let unlike = (under.model.blur.size_px / blur_px).ln().abs() > UNLIKE;
        let lost = under.masked || unlike || usual.is_ring_noisy(under) != Some(false);
        let Some(end) = margins.end((board, place), map, lost) else {
            return false;
        };
        let has = under.fitted.ok().and_then(|f| f.model.sheet);
        if let Some(has) = has.filter(|has| has.count() == end.count() && !lost) {
            return bend(under, (board, place), map, &has, (i, &models), room);
        }
        let Some(shape) = map.ring(place.plane_m, board.outer_radius_m) else {
            return false;
        };
        let Some(outline) = shape.ellipse(1.0) else {
            return false;
        };
        let start = RingModel {
            shape,
            blur: under.model.blur,
            paper,
            ring,
            inside,
            shading: [0.0; 2],
            sheet: Some(end),
        };
        let seen = Seen {
            outline,
            ..under.seen
        };
        let mut again = Under::at(frame, board, (seen, Cut::OF_BORDER), start);
        again.fit((board, place, None), (i, &models), room);
        let mended = usual.is_ring_noisy(&again) == Some(false);
        let spoilt = usual.is_ring_noisy(under) == Some(true);
        if mended {
            *under = again;
        } else if under.fitted.is_err() || spoilt {
            // its pixels alone do not tell its shape; the map may, with the edge in place
            let failure = under.fitted.err().unwrap_or(RingError::NotThisRing {
                what: "its residuals are no noise",
            });
            *under = Under {
                fitted: Err(failure),
                ..Under::at(frame, board, (seen, Cut::OF_BORDER), start)
            };
        }
        mended
    })
    .reduce(|| false, |a, b| a || b)
}

/// Fits a ring again whose edge is right but for what the lens bends of it; says whether that has changed anything.
fn bend(
    under: &mut Under,
    (board, place): (&BoardStart, &BoardPlace),
    map: &LensMap,
    end: &SheetEnd,
    others: (usize, &[RingModel]),
    room: &mut Workspace,
) -> bool {
    let Some(bent) = bent_end((board, place), map, end) else {
        return false;
    };
    let before = under.clone();
    under.model.sheet = Some(bent);
    under.fit((board, place, None), others, room);
    if under.fitted.is_err() {
        *under = before;
    }
    true
}

/// The image of the line that stands `margin_m` out from a ring at a side.
fn edge(place: &BoardPlace, map: &LensMap, side: usize, margin_m: f64) -> Option<Edge> {
    let out = Vector2::from(SIDES[side]);
    let along = Vector2::new(-out.y, out.x);
    let foot = place.plane_m + out * margin_m;
    let half = 0.5 * margin_m;
    let chord = map.place(foot + along * half)? - map.place(foot - along * half)?;
    let (at, anchor) = (map.place(foot)?, map.place(place.plane_m)?);
    let across = Vector2::new(chord.y, -chord.x);
    let normal = across.normalize() * across.dot(&(at - anchor)).signum();
    let straight = Edge {
        anchor,
        offset_px: normal.dot(&(at - anchor)),
        angle: normal.y.atan2(normal.x),
        bend: 0.0,
    };
    bent(place, map, side, (margin_m, straight))
}

/// An edge that stands `margin_m` out from a ring at a side, bent as the map bends it there.
fn bent(
    place: &BoardPlace,
    map: &LensMap,
    side: usize,
    (margin_m, edge): (f64, Edge),
) -> Option<Edge> {
    let out = Vector2::from(SIDES[side]);
    let along = Vector2::new(-out.y, out.x);
    let foot = place.plane_m + out * margin_m;
    let step = along * margin_m;
    let (one, other) = (map.place(foot + step)?, map.place(foot - step)?);
    let sagitta = edge
        .normal()
        .dot(&((one - map.place(foot)?) + (other - map.place(foot)?)));
    let half_px = 0.5 * (one - other).norm();
    Some(Edge {
        bend: sagitta / (half_px * half_px).max(f64::MIN_POSITIVE),
        ..edge
    })
}

/// The end of the sheet beside a ring, its edges bent as the map says.
fn bent_end(
    (board, place): (&BoardStart, &BoardPlace),
    map: &LensMap,
    end: &SheetEnd,
) -> Option<SheetEnd> {
    let of_map = |edge: &Edge| {
        let side = side_of(board, place, map, edge)?;
        let margin_m = margin_m(board, place, map, side, edge)?;
        bent(place, map, side, (margin_m, *edge))
    };
    Some(SheetEnd {
        edge: of_map(&end.edge)?,
        other: end.other.map(|other| of_map(&other).unwrap_or(other)),
        ..*end
    })
}

/// The side of the board that an edge beside a ring belongs to: the one that looks most like it.
fn side_of(board: &BoardStart, place: &BoardPlace, map: &LensMap, found: &Edge) -> Option<usize> {
    let standing = sides(board, place);
    (0..4)
        .filter(|&side| standing.contains(&Vector2::from(SIDES[side])))
        .filter_map(|side| {
            let like = edge(place, map, side, board.outer_radius_m)?;
            Some((side, like.normal().dot(&found.normal())))
        })
        .filter(|(_, cosine)| *cosine > 0.7)
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(side, _)| side)
}

/// How far out from a ring an edge stands on the plane, m.
fn margin_m(
    board: &BoardStart,
    place: &BoardPlace,
    map: &LensMap,
    side: usize,
    edge: &Edge,
) -> Option<f64> {
    let out = Vector2::from(SIDES[side]);
    let beyond = |margin_m: f64| -> Option<f64> {
        let at: Point2<f64> = map.place(place.plane_m + out * margin_m)?;
        Some((at - edge.anchor).dot(&edge.normal()) - edge.offset_px)
    };
    let (mut near, mut far) = (0.0, board.outer_radius_m);
    let mut at_near = beyond(near)?;
    for _ in 0..STEPS {
        let at_far = beyond(far)?;
        let slope = (at_far - at_near) / (far - near);
        if !slope.is_normal() {
            break;
        }
        (near, at_near, far) = (far, at_far, far - at_far / slope);
    }
    (far > board.outer_radius_m && far.is_finite()).then_some(far)
}
