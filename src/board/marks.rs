//! Marks: rings printed without their inner circle, which fix the board's orientation.

use super::{Board, BoardError};

/// At most this fraction of the rings are marks: the others are what is measured.
const MOST: f64 = 0.25;

impl Board {
    /// The same board with these rings (row, column) as marks.
    ///
    /// # Errors
    /// [`BoardError`] where one is no ring of the board or given twice, where they are too many or only one, and where they look the same after
    /// one of the turns that the board can be seen under.
    pub fn with_marks(self, marks: Vec<(u16, u16)>) -> Result<Self, BoardError> {
        if marks.is_empty() {
            return Ok(Self { marks, ..self });
        }
        let most = (MOST * self.ring_count() as f64) as usize;
        if marks.len() > most {
            let count = marks.len();
            return Err(BoardError::Marks { count, most });
        }
        for (i, &(row, column)) in marks.iter().enumerate() {
            if row >= self.rows || column >= self.columns {
                return Err(BoardError::MarkOffBoard { row, column });
            }
            if marks[..i].contains(&(row, column)) {
                return Err(BoardError::MarkTwice { row, column });
            }
        }
        if marks.len() == 1 {
            return Err(BoardError::OneMark);
        }
        // what a quarter turn leaves the same, a half turn does too
        let (last_row, last_column) = (self.rows - 1, self.columns - 1);
        let half = |(row, column): (u16, u16)| (last_row - row, last_column - column);
        if marks.iter().all(|&mark| marks.contains(&half(mark))) {
            return Err(BoardError::MarksSymmetric);
        }
        Ok(Self { marks, ..self })
    }

    /// Whether a ring is printed without its inner circle.
    pub fn is_mark(&self, row: u16, column: u16) -> bool {
        self.marks.contains(&(row, column))
    }
}
