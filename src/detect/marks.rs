//! Which way the board is turned, by its marks: rings without an inner circle are dark in the middle.

use super::labelling::Label;
use super::orientation::{Numbering, numberings};
use super::places::Places;
use crate::board::Board;
use crate::centre::Ellipse;
use crate::frame::{Frame, Pixels};

/// Points of a circle at which grey values are taken.
const POINTS: usize = 24;
/// Where the middle of a ring is looked at, in inner radii.
const MIDDLES: [f64; 2] = [0.0, 0.4];
/// Marks' middles are at least so much darker, contrast 1.
const LEAST_SCORE: f64 = 0.2;
/// The next best numbering has less than this fraction of the best one's score.
const SURE: f64 = 0.8;
/// What stands before a ring may be darker or lighter than anything on the board, but counts no more than this.
const LIGHTS: (f64, f64) = (-1.0, 1.5);
/// A ring, or a mark, has at least this fraction of the usual contrast.
const LEAST_CONTRAST: f64 = 0.4;
/// What each ring that looks like a mark takes from a score.
const STRAY_MARK: f64 = 0.3;
/// So many marks must be seen where they should be.
const LEAST_MARKS: usize = 2;

/// The numbering of a lattice under which the places of marks, and no others, are dark in the middle; `None` where the board has no
/// marks or they do not tell.
pub(super) fn numbering_by_marks(
    frame: &Frame,
    board: &Board,
    labels: &[Label],
    places: &Places,
) -> Option<Numbering> {
    if board.marks().is_empty() {
        return None;
    }
    let mut contrasts: Vec<f64> = labels
        .iter()
        .filter_map(|&label| Some(spot(frame, board, places, label)?.contrast))
        .collect();
    contrasts.sort_by(f64::total_cmp);
    let usual = *contrasts.get(contrasts.len() / 2)?;
    // beside the sheet, and behind what covers it, there is no ring and no mark
    let look = |label: Label| {
        let spot = spot(frame, board, places, label)?;
        let printed = spot.contrast / usual > LEAST_CONTRAST;
        printed.then(|| (spot.depth / spot.contrast).clamp(LIGHTS.0, LIGHTS.1))
    };
    let mut scored: Vec<(f64, Numbering)> = numberings(labels, board.rows(), board.columns())
        .into_iter()
        .filter_map(|numbering| Some((score(board, numbering, look)?, numbering)))
        .collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    let &(best, numbering) = scored.first()?;
    let next = scored.get(1).map_or(0.0, |&(next, _)| next.max(0.0));
    (best > LEAST_SCORE && next < SURE * best).then_some(numbering)
}

/// How much darker the middles of all marks are than those of the others usually, less what looks like a mark and should be none;
/// `None` where too few marks are seen.
fn score(board: &Board, numbering: Numbering, look: impl Fn(Label) -> Option<f64>) -> Option<f64> {
    let (mut marks, mut others) = (Vec::new(), Vec::new());
    for (row, column) in board.indices() {
        let label = numbering.label((i32::from(column), i32::from(row)));
        let Some(light) = look(label) else {
            continue;
        };
        if board.is_mark(row, column) {
            marks.push(light);
        } else {
            others.push(light);
        }
    }
    if marks.len() < LEAST_MARKS || others.is_empty() {
        return None;
    }
    let usual = others.iter().sum::<f64>() / others.len() as f64;
    let lightest = marks.into_iter().fold(f64::MIN, f64::max);
    let like_marks = others
        .iter()
        .filter(|&&other| 2.0 * other < usual + lightest);
    Some(usual - lightest - STRAY_MARK * like_marks.count() as f64)
}

/// What a place of the board looks like.
pub(super) struct Spot {
    /// Paper less ring.
    pub(super) contrast: f64,
    /// Middle less ring: as large as the contrast where there is an inner circle in focus.
    depth: f64,
}

/// `None` outside the frame.
pub(super) fn spot(frame: &Frame, board: &Board, places: &Places, label: Label) -> Option<Spot> {
    let at = places.expect(label)?.at;
    let pitch = board.pitch_m();
    let mean = |radius_m: f64| {
        let shape = places.circle(label, radius_m.max(1e-3 * pitch) / pitch)?;
        mean_along(
            frame,
            &Ellipse {
                centre: at,
                ..shape
            },
        )
    };
    let inner = board.inner_radius_m();
    let middles = MIDDLES.map(|fraction| mean(fraction * inner));
    let middle = (middles[0]? + middles[1]?) / 2.0;
    let ring = mean(0.5 * (inner + board.outer_radius_m()))?;
    let paper = mean(0.5 * pitch)?;
    Some(Spot {
        contrast: paper - ring,
        depth: middle - ring,
    })
}

fn mean_along(frame: &Frame, ellipse: &Ellipse) -> Option<f64> {
    let (sin_a, cos_a) = ellipse.angle.sin_cos();
    let mut sum = 0.0;
    for i in 0..POINTS {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / POINTS as f64).sin_cos();
        let (u, v) = (ellipse.major * cos, ellipse.minor * sin);
        let x = ellipse.centre.x + u * cos_a - v * sin_a;
        let y = ellipse.centre.y + u * sin_a + v * cos_a;
        sum += f64::from(match &frame.pixels {
            Pixels::U8(plane) => plane.bilinear(x, y)?,
            Pixels::U16(plane) => plane.bilinear(x, y)?,
        });
    }
    Some(sum / POINTS as f64)
}
