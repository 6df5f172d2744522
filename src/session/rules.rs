//! When a frame becomes a view, and what the session answers.

use crate::calibrate::NEEDED_RINGS;
use std::fmt;

/// When a frame with a board is kept as a view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SessionRules {
    /// A board is still where no ring moved by more than this since the frame before, px; `None` asks for no
    /// stillness.
    pub max_motion_px: Option<f64>,
    /// A view is new where the rings moved by more than this on average, as a fraction of the frame's width, ...
    pub new_shift: f64,
    /// ... or where the board's normal turned by more than this, rad.
    pub new_tilt_rad: f64,
    /// Views a calibration should have.
    pub min_views: usize,
    /// Views kept at most.
    pub max_views: usize,
    /// Once `min_views` are kept and tell the camera, a view must add at least this part of what the views kept tell on average, in
    /// nats; when `max_views` are kept, a view that adds clearly more than the one that would be missed least takes its place.
    /// `None` keeps every new view up to `max_views`, whatever it says.
    pub least_gain: Option<f64>,
    /// The views are enough where the projection uncertainty at infinity is below this everywhere in the frame, px; `None` where the
    /// number of views and the coverage say it.
    pub target_px: Option<f64>,
    /// What a change of frame size or `frame_id` means.
    pub on_change: OnChange,
}

/// What a change of frame size or `frame_id` means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OnChange {
    /// Another camera, or the same in another mode: forget the views and start anew.
    StartAnew,
    /// A stray frame: refuse it and keep the views.
    Refuse,
}

impl Default for SessionRules {
    /// The rules of the node.
    fn default() -> Self {
        Self {
            max_motion_px: Some(2.0),
            new_shift: 0.05,
            new_tilt_rad: 5.0_f64.to_radians(),
            min_views: 10,
            max_views: 60,
            least_gain: Some(0.25),
            target_px: Some(0.1),
            on_change: OnChange::StartAnew,
        }
    }
}

impl SessionRules {
    /// The rules for image files. Whoever names files has chosen them already, so every one is used, except a repeat:
    /// a file whose rings lie within a thousandth of the frame's width of those of another, which would add weight
    /// and no information.
    pub fn for_files() -> Self {
        Self {
            max_motion_px: None,
            new_shift: 0.001,
            max_views: usize::MAX,
            least_gain: None,
            target_px: None,
            on_change: OnChange::Refuse,
            ..Self::default()
        }
    }
}

/// The answer to a frame with a board; displays as one plain sentence.
#[derive(Debug, Clone, PartialEq)]
pub struct Offer {
    /// Why the views so far were forgotten, where they were.
    pub restart: Option<Change>,
    /// What became of the frame.
    pub verdict: Verdict,
}

impl Offer {
    /// Whether the frame became a view.
    pub fn kept(&self) -> bool {
        matches!(
            self.verdict,
            Verdict::Kept { .. } | Verdict::Replaced { .. }
        )
    }
}

/// What became of a frame.
#[derive(Debug, Clone, PartialEq)]
pub enum Verdict {
    /// It is a view now.
    Kept {
        /// Views kept, this one included.
        views: usize,
    },
    /// It is a view now, in place of another one.
    Replaced {
        /// Views kept.
        views: usize,
        /// `source` of the view that is given up.
        replaced: String,
    },
    /// No frame with the board came right before, so nothing says whether it is still.
    FirstSight,
    /// The board moved since the frame before.
    Moving {
        /// The largest motion of a ring, px; `None` where too few rings are the same.
        motion_px: Option<f64>,
        /// What is allowed, px.
        limit_px: f64,
    },
    /// The board stands as in a view that is kept.
    NotNew {
        /// `source` of the view it repeats.
        like: String,
        /// Average motion of the rings against that view, px.
        shift_px: f64,
        /// Angle between the normals of the board, rad.
        tilt_rad: f64,
    },
    /// Too few rings for a pose of the board.
    TooFewRings {
        /// Rings seen.
        found: usize,
    },
    /// It is not where the camera that the views kept agree on would see it.
    Contradicts {
        /// In which way.
        reason: String,
    },
    /// The camera would hardly become more certain by it.
    AddsLittle {
        /// By how much fx would, %; `None` where fx is not estimated.
        fx_percent: Option<f64>,
        /// The number of views kept, where no more may be and each of them tells more.
        full: Option<usize>,
    },
    /// Enough views are kept.
    Full {
        /// Views kept at most.
        max_views: usize,
    },
    /// The frame is not of the camera that the session is about.
    Stray(Change),
}

/// What is different from the frames before.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Change {
    /// The size of the frames, px: (width, height).
    Size {
        /// Of the frames before.
        before: (usize, usize),
        /// Of this frame.
        now: (usize, usize),
    },
    /// The `frame_id`.
    FrameId {
        /// Of the frames before.
        before: String,
        /// Of this frame.
        now: String,
    },
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size { before, now } => write!(
                f,
                "the frame is {} x {} px, those before were {} x {}",
                now.0, now.1, before.0, before.1
            ),
            Self::FrameId { before, now } => {
                write!(f, "the frame_id is {now:?}, it was {before:?} before")
            }
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Kept { views } => write!(f, "kept as view {views}"),
            Self::Replaced { views, replaced } => write!(
                f,
                "replaces the view {replaced}, which told least; {views} views are kept"
            ),
            Self::FirstSight => write!(f, "the board came into sight; hold it still"),
            Self::Moving {
                motion_px: Some(motion),
                limit_px,
            } => write!(
                f,
                "the board moves by {motion:.1} px a frame; hold it still (at most {limit_px} px)"
            ),
            Self::Moving {
                motion_px: None, ..
            } => write!(f, "the rings in sight change; hold the board still"),
            Self::NotNew {
                like,
                shift_px,
                tilt_rad,
            } => write!(
                f,
                "repeats the view {like} (moved by {shift_px:.1} px, turned by {:.1} degrees)",
                tilt_rad.to_degrees()
            ),
            Self::TooFewRings { found } => write!(
                f,
                "{found} rings are too few for a view, at least {NEEDED_RINGS} are needed"
            ),
            Self::Contradicts { reason } => write!(
                f,
                "does not agree with the views kept: {reason}; if this goes on, reset and start anew"
            ),
            Self::AddsLittle { fx_percent, full } => {
                write!(f, "adds too little")?;
                if let Some(percent) = fx_percent {
                    write!(f, ": fx would become certain by {percent:.1} % more")?;
                }
                match full {
                    Some(views) => write!(f, "; each of the {views} views kept tells as much"),
                    None => write!(f, "; show the board at another place, tilt or distance"),
                }
            }
            Self::Full { max_views } => write!(f, "{max_views} views are kept already, enough"),
            Self::Stray(change) => write!(f, "not of the same camera: {change}"),
        }
    }
}

impl fmt::Display for Offer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(change) = &self.restart {
            write!(f, "{change}: started anew; ")?;
        }
        write!(f, "{}", self.verdict)
    }
}
