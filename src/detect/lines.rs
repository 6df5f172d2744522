//! The outermost rows and columns of a board.

use super::detection::Miss;
use super::grid::Placed;
use super::other_size::FULL;
use crate::board::Board;

/// A line is in doubt where fewer than this fraction of its rings showed edges.
const THIN: f64 = 0.5;

/// An outermost row or column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Line {
    FirstRow,
    LastRow,
    FirstColumn,
    LastColumn,
}

impl Line {
    pub(super) const ALL: [Self; 4] = [
        Self::FirstRow,
        Self::LastRow,
        Self::FirstColumn,
        Self::LastColumn,
    ];

    pub(super) fn contains(self, board: &Board, row: u16, column: u16) -> bool {
        match self {
            Self::FirstRow => row == 0,
            Self::LastRow => row + 1 == board.rows(),
            Self::FirstColumn => column == 0,
            Self::LastColumn => column + 1 == board.columns(),
        }
    }

    pub(super) fn opposite(self) -> Self {
        match self {
            Self::FirstRow => Self::LastRow,
            Self::LastRow => Self::FirstRow,
            Self::FirstColumn => Self::LastColumn,
            Self::LastColumn => Self::FirstColumn,
        }
    }

    pub(super) fn rings(self, board: &Board) -> usize {
        usize::from(match self {
            Self::FirstRow | Self::LastRow => board.columns(),
            Self::FirstColumn | Self::LastColumn => board.rows(),
        })
    }

    pub(super) fn is_in_doubt(self, board: &Board, placed: &[Placed]) -> bool {
        seen(board, self, placed) < THIN * self.rings(board) as f64
    }

    /// The grid without this line, moved to where the line was.
    pub(super) fn moved(self, board: &Board, placed: &[Placed]) -> Vec<Placed> {
        placed
            .iter()
            .filter(|ring| !self.contains(board, ring.row, ring.column))
            .map(|ring| {
                let (row, column) = match self {
                    Self::FirstRow => (ring.row - 1, ring.column),
                    Self::LastRow => (ring.row + 1, ring.column),
                    Self::FirstColumn => (ring.row, ring.column - 1),
                    Self::LastColumn => (ring.row, ring.column + 1),
                };
                Placed {
                    row,
                    column,
                    ..*ring
                }
            })
            .collect()
    }
}

/// How many rings of a line were seen.
pub(super) fn seen(board: &Board, line: Line, placed: &[Placed]) -> f64 {
    let seen = placed
        .iter()
        .filter(|ring| line.contains(board, ring.row, ring.column));
    seen.count() as f64
}

/// How many of these places (row, column) are in none of some lines.
pub(super) fn elsewhere(
    board: &Board,
    lines: &[Line],
    places: impl Iterator<Item = (u16, u16)>,
) -> usize {
    let among = |row, column| lines.iter().any(|l| l.contains(board, row, column));
    places.filter(|&(row, column)| !among(row, column)).count()
}

/// What is said of lines that are none: where the others are nearly all there, the size that they have.
pub(super) fn lines_missing(board: &Board, wrong: &[Line], found: usize) -> Miss {
    let is_row = |line: &&Line| matches!(line, Line::FirstRow | Line::LastRow);
    let wrong_rows = wrong.iter().filter(is_row).count();
    let (rows, columns) = (board.rows(), board.columns());
    let found_rows = usize::from(rows).saturating_sub(wrong_rows);
    let found_columns = usize::from(columns).saturating_sub(wrong.len() - wrong_rows);
    if found as f64 >= FULL * (found_rows * found_columns) as f64 {
        return Miss::Smaller {
            found_rows,
            found_columns,
            rows,
            columns,
        };
    }
    Miss::LineMissing {
        found,
        expected: board.ring_count(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::Polarity;

    #[test]
    fn what_is_left_of_a_board_is_told_with_its_size_where_it_is_full() {
        let board = Board::new(5, 6, 0.03, 0.005, 0.01, Polarity::DarkOnLight).unwrap();
        let wrong = [Line::LastColumn];
        let (rows, columns) = (5, 6);
        let full = Miss::Smaller {
            found_rows: 5,
            found_columns: 5,
            rows,
            columns,
        };
        assert_eq!(lines_missing(&board, &wrong, 24), full);
        let expected = 30;
        let patchy = Miss::LineMissing {
            found: 15,
            expected,
        };
        assert_eq!(lines_missing(&board, &wrong, 15), patchy);
    }
}
