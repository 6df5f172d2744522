//! Board files.

use super::text_file::read_at_most;
use crate::board::{Board, BoardError};
use std::io;
use std::path::{Path, PathBuf};

/// No board file is longer, bytes.
const LONGEST: u64 = 64 * 1024;

/// Why a path gives no board. Every message names the path.
#[derive(Debug, thiserror::Error)]
pub enum BoardFileError {
    /// It cannot be read.
    #[error("board file {}: {reason}", path.display())]
    Unreadable {
        /// The path as given.
        path: PathBuf,
        /// What the operating system says.
        reason: io::Error,
    },
    /// It is longer than any board file.
    #[error("board file {}: more than {LONGEST} bytes, this is no board file", path.display())]
    TooLong {
        /// The path as given.
        path: PathBuf,
    },
    /// What it says is no board.
    #[error("board file {}: {reason}", path.display())]
    NoBoard {
        /// The path as given.
        path: PathBuf,
        /// What is wrong.
        reason: BoardError,
    },
}

/// Reads a board file.
///
/// # Errors
/// [`BoardFileError`] where it cannot be read or describes no board.
pub fn read_board(path: &Path) -> Result<Board, BoardFileError> {
    let owned = || path.to_owned();
    let text = read_at_most(path, LONGEST)
        .map_err(|reason| BoardFileError::Unreadable {
            path: owned(),
            reason,
        })?
        .ok_or_else(|| BoardFileError::TooLong { path: owned() })?;
    Board::from_yaml(&text).map_err(|reason| BoardFileError::NoBoard {
        path: owned(),
        reason,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refusals_name_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("board.yaml");
        assert!(
            read_board(&path)
                .unwrap_err()
                .to_string()
                .contains("board.yaml")
        );
        std::fs::write(&path, "rows: 7\n").unwrap();
        assert!(
            read_board(&path)
                .unwrap_err()
                .to_string()
                .ends_with("columns is missing")
        );
        std::fs::write(&path, "#".repeat(70_000)).unwrap();
        assert!(matches!(
            read_board(&path),
            Err(BoardFileError::TooLong { .. })
        ));
    }
}
