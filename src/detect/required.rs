//! How much of a board must be seen, and what its numbers mean where a part is not.

use super::detection::Indices;
use super::grid::Placed;
use crate::board::Board;

/// How much of a board must be seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Required {
    /// A ring of every row and of every column, and 60 % of all: then it is known which ring is which.
    #[default]
    Extent,
    /// So many rings, wherever they are, but not fewer than a plane needs.
    Rings(usize),
}

/// Fraction of the board's rings that must be found where its whole extent is required.
const LEAST_FOUND: f64 = 0.6;
/// The fewest points that determine how a plane is seen.
const LEAST_RINGS: usize = 4;

impl Required {
    /// A number of rings; 0 stands for [`Required::Extent`].
    pub fn rings(count: usize) -> Self {
        match count {
            0 => Self::Extent,
            count => Self::Rings(count),
        }
    }

    /// The fewest rings of `board` that can do.
    pub(super) fn least(self, board: &Board) -> usize {
        match self {
            Self::Extent => {
                let rings = board.ring_count() - board.marks().len();
                (LEAST_FOUND * rings as f64).ceil() as usize
            }
            Self::Rings(count) => count.max(LEAST_RINGS),
        }
    }

    /// What the numbers of the rings mean, if enough of them are there. Where rows or columns are missing, or the board has marks, and
    /// no marks were seen (`marked`), the numbers are changed to begin at the first that were seen.
    pub(super) fn judge(
        self,
        board: &Board,
        rings: &mut [Placed],
        marked: bool,
    ) -> Option<Indices> {
        let every_row = (0..board.rows()).all(|row| rings.iter().any(|ring| ring.row == row));
        let every_column =
            (0..board.columns()).all(|column| rings.iter().any(|ring| ring.column == column));
        let whole = every_row && every_column;
        let marks = rings
            .iter()
            .filter(|ring| board.is_mark(ring.row, ring.column));
        let to_measure = rings.len() - marks.count();
        if to_measure < self.least(board) || !(whole || self != Self::Extent) {
            return None;
        }
        if marked || (whole && board.marks().is_empty()) {
            return Some(Indices::Absolute);
        }
        let first_row = rings.iter().map(|ring| ring.row).min()?;
        let first_column = rings.iter().map(|ring| ring.column).min()?;
        for ring in rings {
            ring.row -= first_row;
            ring.column -= first_column;
        }
        Some(Indices::Relative)
    }
}
