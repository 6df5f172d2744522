//! What to show the camera next, as one plain sentence.

use super::coverage::{COLUMNS, ROWS};
use super::{Coverage, Session};
use nalgebra::Vector3;

/// Tilt that tells the focal length from the distance well, rad. Directions that no view is tilted to by this much
/// are asked for.
const WANTED_TILT_RAD: f64 = 0.26;

/// Cells of a corner along each side; the edges and the middle have what is between.
const CORNER: usize = 3;
const FAR_ROW: usize = ROWS - CORNER;
const FAR_COLUMN: usize = COLUMNS - CORNER;

/// The nine regions of the frame that are asked for, corners first because the distortion is largest there, with
/// the first and one past the last cell: (name, rows, columns).
const REGIONS: [(&str, [usize; 2], [usize; 2]); 9] = [
    ("top left corner", [0, CORNER], [0, CORNER]),
    ("top right corner", [0, CORNER], [FAR_COLUMN, COLUMNS]),
    ("bottom left corner", [FAR_ROW, ROWS], [0, CORNER]),
    (
        "bottom right corner",
        [FAR_ROW, ROWS],
        [FAR_COLUMN, COLUMNS],
    ),
    ("left edge", [CORNER, FAR_ROW], [0, CORNER]),
    ("right edge", [CORNER, FAR_ROW], [FAR_COLUMN, COLUMNS]),
    ("top edge", [0, CORNER], [CORNER, FAR_COLUMN]),
    ("bottom edge", [FAR_ROW, ROWS], [CORNER, FAR_COLUMN]),
    (
        "middle of the frame",
        [CORNER, FAR_ROW],
        [CORNER, FAR_COLUMN],
    ),
];

/// What the user should do next.
#[derive(Debug, Clone, PartialEq)]
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
        /// How to show the board, where the views differ too little yet.
        advice: Option<&'static str>,
    },
    /// The views do not tell the camera yet, though they are many and differ.
    NotTold {
        /// What they leave open.
        reason: String,
    },
    /// The camera is not certain enough yet.
    Uncertain(LeastCertain),
    /// The calibration can be solved.
    Enough {
        /// Views kept.
        views: usize,
        /// The projection uncertainty that the target asked for, px; `None` without a target.
        std_px: Option<f64>,
    },
    /// No more views may be kept, and the camera is not as certain as it should be.
    Full {
        /// Views kept.
        views: usize,
        /// Where it is least so.
        least: LeastCertain,
    },
}

/// The part of the frame that is least certain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeastCertain {
    /// Its name.
    pub region: &'static str,
    /// Projection uncertainty at infinity there, px.
    pub std_px: f64,
    /// What it should be, px.
    pub target_px: f64,
}

impl std::fmt::Display for LeastCertain {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            region,
            std_px,
            target_px,
        } = self;
        write!(
            f,
            "{region}, where the camera is uncertain by {std_px:.2} px, {target_px} px is wanted"
        )
    }
}

impl std::fmt::Display for Guidance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::ShowBoard => write!(f, "show the board to the camera and hold it still"),
            Self::MoveTo(region) => write!(f, "move the board into the {region}"),
            Self::Tilt(direction) => write!(f, "tilt the board more: {direction}"),
            Self::MoreViews { missing, advice } => {
                let s = if *missing == 1 { "" } else { "s" };
                let place = if *missing == 1 {
                    "another place or tilt"
                } else {
                    "other places and tilts"
                };
                match advice {
                    Some(advice) => write!(f, "{missing} more view{s} needed: the board {advice}"),
                    None => write!(f, "{missing} more view{s} needed, at {place}"),
                }
            }
            Self::NotTold { reason } => write!(f, "the views do not tell the camera yet: {reason}"),
            Self::Uncertain(least) => write!(f, "show the board tilted in the {least}"),
            Self::Enough {
                views,
                std_px: None,
            } => write!(f, "enough views ({views}): calibrate"),
            Self::Enough {
                views,
                std_px: Some(px),
            } => write!(
                f,
                "enough views ({views}), the camera is uncertain by {px:.3} px at most: calibrate"
            ),
            Self::Full { views, least } => write!(
                f,
                "{views} views are kept, as many as may be: calibrate, or show the board in the {least}; a view that \
                 tells more replaces another"
            ),
        }
    }
}

/// What the estimate of the camera says where a target is set; before there is one, places first, then tilts, then the number of
/// views.
pub(super) fn guidance(session: &Session) -> Guidance {
    let (views, rules) = (session.views().len(), session.rules());
    if views == 0 {
        return Guidance::ShowBoard;
    }
    match (rules.target_px, session.estimate()) {
        (Some(target_px), Some(estimate)) => {
            if let Some((cell, std_px)) = estimate.least_certain() {
                let least = LeastCertain {
                    region: region_of(cell),
                    std_px,
                    target_px,
                };
                return with_target(session, estimate.views_used(), least);
            }
        }
        (None, _) if views >= rules.max_views => {
            return Guidance::Enough {
                views,
                std_px: None,
            };
        }
        _ => {}
    }
    if let Some(missing) = missing_coverage(session) {
        return missing;
    }
    match rules.min_views.saturating_sub(views) {
        0 if rules.target_px.is_none() => Guidance::Enough {
            views,
            std_px: None,
        },
        0 => Guidance::NotTold {
            reason: session
                .not_told()
                .map_or_else(|| "more of them are needed".to_owned(), ToString::to_string),
        },
        missing => more_views(session, missing),
    }
}

fn with_target(session: &Session, used: usize, least: LeastCertain) -> Guidance {
    let (views, rules) = (session.views().len(), session.rules());
    let certain = least.std_px <= least.target_px;
    match rules.min_views.saturating_sub(used) {
        0 if certain => Guidance::Enough {
            views,
            std_px: Some(least.std_px),
        },
        _ if views >= rules.max_views => Guidance::Full { views, least },
        missing if certain => more_views(session, missing),
        // without tilt the focal length is what is uncertain, and that shows in the corners wherever the board was
        _ => missing_tilt(&session.normals()).map_or(Guidance::Uncertain(least), Guidance::Tilt),
    }
}

fn more_views(session: &Session, missing: usize) -> Guidance {
    let advice = session.progress().advice();
    Guidance::MoreViews { missing, advice }
}

fn missing_coverage(session: &Session) -> Option<Guidance> {
    let bare = REGIONS
        .iter()
        .find(|(_, rows, columns)| covered(session.coverage_map(), *rows, *columns) < 1.0 / 3.0);
    if let Some((region, _, _)) = bare {
        return Some(Guidance::MoveTo(region));
    }
    missing_tilt(&session.normals()).map(Guidance::Tilt)
}

/// The region that a cell, counted by rows, lies in.
fn region_of(cell: usize) -> &'static str {
    let (row, column) = (cell / COLUMNS, cell % COLUMNS);
    let inside = |[first, end]: [usize; 2], at: usize| (first..end).contains(&at);
    REGIONS
        .iter()
        .find(|(_, rows, columns)| inside(*rows, row) && inside(*columns, column))
        .map_or("frame", |(name, _, _)| name)
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
