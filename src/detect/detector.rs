//! The detector: a board and how to look for it.

use super::{Detection, Miss};
use crate::board::Board;
use crate::centre::Estimator;
use crate::frame::Frame;

/// How to look for a board.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DetectOptions {
    /// Which construction gives the projected centre.
    pub estimator: Estimator,
}

/// Finds one board in frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Detector {
    board: Board,
    options: DetectOptions,
}

impl Detector {
    /// A detector of `board`.
    pub fn new(board: Board, options: DetectOptions) -> Self {
        Self { board, options }
    }

    /// The board it looks for.
    pub fn board(&self) -> &Board {
        &self.board
    }

    /// Finds the board in a whole frame.
    ///
    /// # Errors
    /// [`Miss`] says why no board was found.
    pub fn detect(&self, frame: &Frame) -> Result<Detection, Miss> {
        let _ = (frame, self.options);
        Err(Miss::NoRing)
    }
}
