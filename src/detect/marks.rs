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
    let mut scored: Vec<(f64, Numbering)> = numberings(labels, board.rows(), board.columns())
        .into_iter()
        .filter_map(|numbering| Some((score(frame, board, numbering, places)?, numbering)))
        .collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    let &(best, numbering) = scored.first()?;
    let next = scored.get(1).map_or(0.0, |&(next, _)| next.max(0.0));
    (best > LEAST_SCORE && next < SURE * best).then_some(numbering)
}

/// How much darker the middles of marks are than those of the others; `None` where too few marks are seen.
fn score(frame: &Frame, board: &Board, numbering: Numbering, places: &Places) -> Option<f64> {
    let (mut marks, mut others) = (Vec::new(), Vec::new());
    for (row, column) in board.indices() {
        let label = numbering.label((i32::from(column), i32::from(row)));
        let Some(light) = middle(frame, board, places, label) else {
            continue;
        };
        if board.is_mark(row, column) {
            marks.push(light);
        } else {
            others.push(light);
        }
    }
    let mean = |lights: &[f64]| lights.iter().sum::<f64>() / lights.len() as f64;
    let enough = marks.len() >= LEAST_MARKS && !others.is_empty();
    enough.then(|| mean(&others) - mean(&marks))
}

/// How light the middle of a ring is: 0 as the ring, 1 as the paper around; `None` outside the frame.
fn middle(frame: &Frame, board: &Board, places: &Places, label: Label) -> Option<f64> {
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
    let contrast = paper - ring;
    (contrast != 0.0).then(|| ((middle - ring) / contrast).clamp(LIGHTS.0, LIGHTS.1))
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
