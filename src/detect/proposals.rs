//! Ways to lay the board over rings of which edges show too few.
//!
//! Blur as large as the rings drowns whole rows and columns of a tilted board. Edges then do not say which of the board's lines are
//! missing, but the grey values do: where there are rings the model of a ring fits, with about the contrast and the blur of the others, and on
//! blank paper it does not. So each way to lay the board over the rings that show is measured, and the board is there if just one of
//! them holds.

use super::centres::centres;
use super::detection::{Indices, Measured as Report, Miss, Ring};
use super::detector::DetectOptions;
use super::grid::Placed;
use super::labelling::Label;
use super::lines::Line;
use super::measured::Measured;
use super::orientation::upright;
use super::other_size::Beside;
use super::outermost::is_alike;
use super::plausible::{Asked, has_the_ratio, is_plausible};
use super::required::Required;
use crate::board::Board;
use crate::frame::Frame;

/// What edges show can be the board from this fraction of its rings on, and there are so many ways to lay it over them at most.
const PROPOSED: f64 = 0.35;
const MOST_PROPOSED: usize = 4;
/// No grey values are asked of fewer rings, nor of less than half of a board's: any few stand on some plane.
const LEAST_ASKED: usize = 12;
/// So many ways are measured at most in one frame: each costs as much as a board.
const MOST_MEASURED: usize = 4;
/// At least this fraction of a line's rings must be like the others, where little else speaks for it.
const SURE: f64 = 0.6;

/// Why there is no board, and what may be one nevertheless.
pub(super) struct Refused {
    pub(super) miss: Miss,
    /// For each lattice the ways to lay the board over it, where blur lets edges say too little to decide.
    pub(super) proposals: Vec<Vec<Vec<Placed>>>,
}

impl From<Miss> for Refused {
    fn from(miss: Miss) -> Self {
        Self {
            miss,
            proposals: Vec::new(),
        }
    }
}

impl Refused {
    /// What is measured of the proposals: those of the fullest lattices.
    pub(super) fn to_measure(&self) -> impl Iterator<Item = &[Vec<Placed>]> {
        let mut left = MOST_MEASURED;
        self.proposals.iter().map_while(move |ways| {
            left = left.checked_sub(ways.len())?;
            Some(ways.as_slice())
        })
    }
}

impl Measured<'_> {
    /// Whether so many rings show that they can be the board.
    pub(super) fn shows_enough(&self) -> bool {
        self.rings.len() as f64 >= PROPOSED * self.board.ring_count() as f64
    }

    /// Ways to lay the board over rings that can be a part of it, where blur may have drowned whole lines of them: as many rings as show,
    /// outermost rows and columns alone without any, and nothing alike beside.
    pub(super) fn proposals(&self, required: Required) -> Vec<Vec<Placed>> {
        let (rows, columns) = (self.board.rows(), self.board.columns());
        let labels: Vec<Label> = self.rings.keys().copied().collect();
        let can_be = required == Required::Extent
            && labels.len() >= LEAST_ASKED.max(self.board.ring_count().div_ceil(2))
            && self.board.marks().is_empty()
            && self.is_heavily_blurred()
            && is_plausible(self.board, &self.rings, &self.places, Asked::Places)
            && has_the_ratio(self.board, &self.rings);
        if !can_be {
            return Vec::new();
        }
        let numberings = upright(&labels, &self.places.homography, rows, columns);
        let proposals = numberings.into_iter().filter_map(|numbering| {
            let placed = self.placed(numbering);
            let row = |row: u16| placed.iter().any(|ring| ring.row == row);
            let column = |column: u16| placed.iter().any(|ring| ring.column == column);
            let within =
                (1..rows.saturating_sub(1)).all(row) && (1..columns.saturating_sub(1)).all(column);
            (within && self.goes_on(numbering, Beside::Alike).is_none()).then_some(placed)
        });
        proposals.take(MOST_PROPOSED).collect()
    }
}

/// Whether the grey values (the estimator's, the photometric one's) agree with rings that edges alone place, some of the outermost rows and columns without any: these lines'
/// rings must be like the others. Then the centres of the rings are returned.
pub(super) fn confirmed(
    frame: &Frame,
    board: &Board,
    placed: &[Placed],
    options: &DetectOptions,
    sign: f64,
) -> Option<(Vec<Ring>, Option<Report>)> {
    let (rings, measured) = centres(frame, board, (placed, Indices::Absolute), options, sign);
    let fitted = rings.iter().filter(|ring| ring.kept.is_some()).count();
    let holds = fitted >= options.required.least(board)
        && Line::ALL
            .into_iter()
            .filter(|line| line.is_in_doubt(board, placed))
            .all(|line| is_alike(board, line, &rings, SURE * line.rings(board) as f64));
    holds.then_some((rings, measured))
}
