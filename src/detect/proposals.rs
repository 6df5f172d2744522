//! Ways to lay the board over rings of which edges show too few.
//!
//! Blur as large as the rings drowns whole rows and columns of a tilted board. Edges then do not say which of the board's lines are
//! missing, but the grey values do: where there are rings the model of a ring fits, with about the contrast and the blur of the others, and on
//! blank paper it does not. So each way to lay the board over the rings that show is measured, and the board is there if just one of
//! them holds.

use super::centres::centres;
use super::detection::{Indices, Measured as Report, Miss, Ring};
use super::detector::DetectOptions;
use super::edges::median;
use super::grid::Placed;
use super::labelling::Label;
use super::lines::{Line, seen};
use super::marks::spot;
use super::measured::Measured;
use super::orientation::{Numbering, upright};
use super::other_size::Beside;
use super::outermost::is_alike;
use super::plausible::{Asked, is_plausible};
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
/// Paper is blank where spots have less than this fraction of the usual contrast.
const BLANK: f64 = 0.03;

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
            && self.has_the_ratio();
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
            let shows = within && self.shows_print(numbering, &placed);
            (shows && self.goes_on(numbering, Beside::Alike).is_none()).then_some(placed)
        });
        proposals.take(MOST_PROPOSED).collect()
    }

    /// Whether something is printed where a board laid like that has lines of which no ring was seen. Blank paper costs a fit of a whole
    /// board to refuse, and many times that of a board, since nothing in it settles.
    fn shows_print(&self, numbering: Numbering, placed: &[Placed]) -> bool {
        let contrast = |row: u16, column: u16| {
            let label = numbering.label((i32::from(column), i32::from(row)));
            Some(
                spot(self.frame, self.board, &self.places, label)?
                    .contrast
                    .abs(),
            )
        };
        let mut known: Vec<f64> = placed
            .iter()
            .filter_map(|ring| contrast(ring.row, ring.column))
            .collect();
        if known.is_empty() {
            return true;
        }
        let usual = median(&mut known);
        let unseen = Line::ALL
            .into_iter()
            .filter(|&line| seen(self.board, line, placed) == 0.0);
        unseen.into_iter().all(|line| {
            let of_line = self.board.indices();
            let of_line = of_line.filter(|&(row, column)| line.contains(self.board, row, column));
            is_print(of_line.map(|(row, column)| contrast(row, column)), usual)
        })
    }
}

/// Whether half of some places or more have a contrast that the `usual` one leaves of print under any blur; what lies outside the frame
/// may have.
fn is_print(contrasts: impl Iterator<Item = Option<f64>>, usual: f64) -> bool {
    let (mut print, mut all) = (0, 0);
    for contrast in contrasts {
        print += usize::from(contrast.is_none_or(|contrast| contrast >= BLANK * usual));
        all += 1;
    }
    2 * print >= all
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blank_paper_is_no_print_and_what_lies_outside_may_be() {
        let seen = |contrasts: [f64; 4]| is_print(contrasts.into_iter().map(Some), 0.5);
        assert!(!seen([0.001, 0.004, 0.01, 0.2]));
        assert!(seen([0.001, 0.03, 0.004, 0.2]));
        assert!(is_print(
            [None, None, Some(0.0), Some(0.0)].into_iter(),
            0.5
        ));
    }
}
