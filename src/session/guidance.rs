//! What to show the camera next, as one plain sentence.

use super::coverage::{COLUMNS, ROWS};
use super::{Coverage, Session};
use nalgebra::Vector3;

/// Tilt that tells the focal length from the distance well, rad. Directions that no view is tilted to by this much
/// are asked for.
const WANTED_TILT_RAD: f64 = 0.26;

/// The nine regions of the frame that are asked for, corners first because the distortion is largest there, with
/// the first and one past the last cell: (name, rows, columns).
const REGIONS: [(&str, [usize; 2], [usize; 2]); 9] = [
    ("top left corner", [0, 2], [0, 3]),
    ("top right corner", [0, 2], [COLUMNS - 3, COLUMNS]),
    ("bottom left corner", [ROWS - 2, ROWS], [0, 3]),
    (
        "bottom right corner",
        [ROWS - 2, ROWS],
        [COLUMNS - 3, COLUMNS],
    ),
    ("left edge", [2, ROWS - 2], [0, 3]),
    ("right edge", [2, ROWS - 2], [COLUMNS - 3, COLUMNS]),
    ("top edge", [0, 2], [3, COLUMNS - 3]),
    ("bottom edge", [ROWS - 2, ROWS], [3, COLUMNS - 3]),
    ("middle of the frame", [2, ROWS - 2], [3, COLUMNS - 3]),
];

/// What the user should do next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Guidance {
    /// No view yet.
    ShowBoard,
    /// Most of a region of the frame has seen no ring.
    MoveTo(&'static str),
    /// The board has never leant far about one of the picture's axes.
    Tilt(&'static str),
    /// Places and tilts are fine; a few more of both are needed.
    MoreViews {
        /// How many more.
        missing: usize,
    },
    /// The calibration can be solved.
    Enough {
        /// Views kept.
        views: usize,
    },
}

impl std::fmt::Display for Guidance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::ShowBoard => write!(f, "show the board to the camera and hold it still"),
            Self::MoveTo(region) => write!(f, "move the board into the {region}"),
            Self::Tilt(direction) => write!(f, "tilt the board more: {direction}"),
            Self::MoreViews { missing: 1 } => {
                write!(f, "1 more view needed, at another place or tilt")
            }
            Self::MoreViews { missing } => {
                write!(f, "{missing} more views needed, at other places and tilts")
            }
            Self::Enough { views } => write!(f, "enough views ({views}): calibrate"),
        }
    }
}

/// Places first, then tilts, then the number of views.
pub(super) fn guidance(session: &Session) -> Guidance {
    let views = session.views().len();
    if views >= session.rules().max_views {
        return Guidance::Enough { views };
    }
    if views == 0 {
        return Guidance::ShowBoard;
    }
    let bare = REGIONS
        .iter()
        .find(|(_, rows, columns)| covered(session.coverage_map(), *rows, *columns) < 1.0 / 3.0);
    if let Some((region, _, _)) = bare {
        return Guidance::MoveTo(region);
    }
    if let Some(direction) = missing_tilt(&session.normals()) {
        return Guidance::Tilt(direction);
    }
    match session.rules().min_views.saturating_sub(views) {
        0 => Guidance::Enough { views },
        missing => Guidance::MoreViews { missing },
    }
}

fn covered(map: &Coverage, rows: [usize; 2], columns: [usize; 2]) -> f64 {
    let (mut count, mut all) = (0, 0);
    for row in rows[0]..rows[1] {
        for column in columns[0]..columns[1] {
            count += usize::from(map.cell(row, column));
            all += 1;
        }
    }
    count as f64 / all as f64
}

/// Two axes of tilt are needed: parallel views tell nothing, and one axis alone leaves one focal length to the other.
fn missing_tilt(normals: &[Vector3<f64>]) -> Option<&'static str> {
    let wanted = WANTED_TILT_RAD.sin();
    let sideways = normals.iter().any(|n| n.x.abs() > wanted);
    let upright = normals.iter().any(|n| n.y.abs() > wanted);
    match (sideways, upright) {
        (false, _) => Some("bring its left or right side closer to the camera"),
        (_, false) => Some("bring its upper or lower side closer to the camera"),
        _ => None,
    }
}
