//! What was found in one frame, or why nothing was.

use crate::centre::photometric::{KeptRing, Psf, RingError};
use crate::centre::{Centre, RingEllipses};
use nalgebra::Matrix3;
use std::sync::Arc;

/// Whether row and column numbers are those of the board or count from the first ring seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Indices {
    /// Row and column are the board's own: its whole extent was seen (up to the rotations that fit, see `grid`).
    Absolute,
    /// Numbering starts at the first row and column that were found.
    Relative,
}

impl Indices {
    /// The word used in messages and files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Absolute => "absolute",
            Self::Relative => "relative",
        }
    }
}

/// One ring of the board as it appears in the frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Ring {
    /// Row on the board.
    pub row: u16,
    /// Column on the board.
    pub column: u16,
    /// Projected centre, px of the frame, distortion not removed.
    pub centre: Centre,
    /// The images of its two circles, px.
    pub ellipses: RingEllipses,
    /// Standard deviation of the Gaussian that best explains the blur of its edges, px.
    pub blur_sigma_px: f64,
    /// Its fit and its pixels, where the photometric estimator measured it: what a second pass works from.
    pub kept: Option<Arc<KeptRing>>,
}

/// What the photometric estimator says of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// The shape of the blur.
    pub psf: Psf,
    /// The gamma of the response that was undone.
    pub response_gamma: f64,
    /// Rings that could not be measured so; they have the paper's centre, without a covariance.
    pub fell_back: Vec<FellBack>,
    /// How far the rings' outlines are from circles beyond what noise explains, in radii; 0 for a single ring.
    pub out_of_round: f64,
}

impl Measured {
    /// What a person wants to know of it, a plain sentence each.
    pub fn notes(&self) -> Vec<String> {
        let gamma = self.response_gamma;
        let shape = self.psf.name();
        let response = if gamma == 1.0 {
            String::new()
        } else {
            format!(", response gamma {gamma:.2}")
        };
        let first = format!("blur is a {shape}{response}");
        let fell_back = self.fell_back.iter().map(|ring| {
            format!(
                "row {}, column {}: centre from edges, without a covariance ({})",
                ring.row, ring.column, ring.reason
            )
        });
        std::iter::once(first).chain(fell_back).collect()
    }
}

/// A ring whose grey values could not be fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FellBack {
    /// Row on the board.
    pub row: u16,
    /// Column on the board.
    pub column: u16,
    /// Why.
    pub reason: RingError,
}

/// A board found in a frame; rings sorted by row, then column.
#[derive(Debug, Clone, PartialEq)]
pub struct Detection {
    /// Width of the frame, px.
    pub width: usize,
    /// Height of the frame, px.
    pub height: usize,
    /// What the row and column numbers mean.
    pub indices: Indices,
    /// The rings found, each (row, column) once.
    pub rings: Vec<Ring>,
    /// Board plane (m) to frame (px), least squares over the centres; for a single ring a scaled identity at its
    /// centre.
    pub homography: Matrix3<f64>,
    /// What the photometric estimator says; `None` where another one was asked for.
    pub photometric: Option<Measured>,
    /// Rings of another board of this kind in the frame, which was left out as it looks smaller.
    pub another: Option<usize>,
}

impl Detection {
    /// What a person wants to know of it, a plain sentence each.
    pub fn notes(&self) -> Vec<String> {
        let another = self.another.map(|rings| {
            format!("warning: another board is in view ({rings} rings); the one that looks larger was taken")
        });
        let measured = self.photometric.as_ref().map(Measured::notes);
        another
            .into_iter()
            .chain(measured.unwrap_or_default())
            .collect()
    }

    /// Median blur of the rings, px.
    pub fn blur_sigma_px(&self) -> f64 {
        let mut sigmas: Vec<f64> = self.rings.iter().map(|r| r.blur_sigma_px).collect();
        sigmas.sort_by(f64::total_cmp);
        sigmas.get(sigmas.len() / 2).copied().unwrap_or(0.0)
    }
}

/// What makes a grid of spots no board, whatever single spots look like.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Odd {
    /// Rings of one board are printed alike.
    #[error("their sizes differ")]
    Sizes,
    /// And in one ink.
    #[error("their contrasts differ")]
    Contrasts,
    /// Inner circles are as large as the board file says.
    #[error("their inner circles are of another size than the board file says")]
    Inners,
    /// The inner disc is of the ground that the ring is printed on.
    #[error("what they enclose is not as light as what is around them")]
    Insides,
    /// Only rings with less light than none would look like that.
    #[error("rings that look like that would be darker than black")]
    Darkness,
    /// Rings in rows that do not run across each other: a plane seen at an angle shows circles as ellipses that fit its rows and columns.
    #[error("their rows and columns do not stand at right angles, or not at equal distances")]
    Skewed,
    /// Squares, letters, pieces of rings.
    #[error("their outlines are not round")]
    Outlines,
}

/// Why no board was found: one plain sentence a person can act on.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Miss {
    /// The frame is too small to hold the board.
    #[error(
        "the frame is {width} x {height} px, too small for a board of {rows} x {columns} rings"
    )]
    FrameTooSmall {
        /// Frame width, px.
        width: usize,
        /// Frame height, px.
        height: usize,
        /// Rows of the board.
        rows: u16,
        /// Columns of the board.
        columns: u16,
    },
    /// Nothing in the frame looks like a ring.
    #[error("no ring seen")]
    NoRing,
    /// Hardly any light.
    #[error(
        "too dark: the brightest grey value is {brightest} of {full}; more light or a longer exposure is needed"
    )]
    TooDark {
        /// The brightest grey value, but for a few pixels.
        brightest: u16,
        /// The greatest there can be.
        full: u16,
    },
    /// White all over.
    #[error(
        "over-exposed: {percent} % of the image is white; less light or a shorter exposure is needed"
    )]
    OverExposed {
        /// Of all pixels, those at the end of the scale.
        percent: u8,
    },
    /// One grey.
    #[error("hardly any contrast: all grey values are between {darkest} and {brightest}")]
    NoContrast {
        /// The darkest grey value, but for a few pixels.
        darkest: u16,
        /// The brightest grey value, but for a few pixels.
        brightest: u16,
    },
    /// Rings, but fewer than the board has.
    #[error("too few rings: {found} of {expected}")]
    TooFewRings {
        /// Rings that stand in a grid, or all where no grid was found.
        found: usize,
        /// Rings of the board.
        expected: usize,
    },
    /// A part of the board outside the frame.
    #[error("too few rings: {found} of {expected}; the board reaches beyond the image's border")]
    CutOff {
        /// Rings that stand in a grid.
        found: usize,
        /// Rings of the board.
        expected: usize,
    },
    /// Rings enough, but none of an outermost row or column that could be measured: nobody knows which ring is which.
    #[error("a whole row or column does not show: {found} of {expected} rings seen")]
    LineMissing {
        /// Rings that stand in a grid.
        found: usize,
        /// Rings of the board.
        expected: usize,
    },
    /// Rings that do not stand in the board's grid.
    #[error(
        "{found} rings seen, but they do not stand in a grid of {rows} x {columns}: show all of the board, flat, or give the file of the board that is shown"
    )]
    NoGrid {
        /// Rings seen.
        found: usize,
        /// Rows of the board.
        rows: u16,
        /// Columns of the board.
        columns: u16,
    },
    /// A grid of spots whose grey values are not those of rings: plain dots, gaps between things.
    #[error("a grid of {found} spots seen, but only {rings} of them look like rings")]
    NotRings {
        /// Spots that stand in the board's grid.
        found: usize,
        /// Those whose grey values fit a ring's.
        rings: usize,
    },
    /// A grid of rings of another size.
    #[error(
        "the rings' outer radius is {seen:.2} of the pitch, by the board file {given:.2}: another board, or a wrong file"
    )]
    OtherRadius {
        /// Outer radius over pitch as measured.
        seen: f64,
        /// By the board file.
        given: f64,
    },
    /// A grid of things that a ring can be laid into, but no printed board.
    #[error("a grid of {found} spots seen, but they are no board's rings: {odd}")]
    Unlike {
        /// Spots that stand in the board's grid.
        found: usize,
        /// What is odd about them.
        odd: Odd,
    },
    /// The rings are there, but hardly more than patches.
    #[error("blur too heavy: sigma about {sigma_px:.0} px, rings {width_px:.0} px wide")]
    TooBlurred {
        /// Median blur, px.
        sigma_px: f64,
        /// Median width of the rings, inner to outer edge, px.
        width_px: f64,
    },
    /// A grid smaller than the board, in a place where more of it may be out of sight.
    #[error(
        "found {found_rows} x {found_columns}, the board file says {rows} x {columns}: a wrong file, or the others are hidden or outside the image"
    )]
    Smaller {
        /// Rows seen.
        found_rows: usize,
        /// Columns seen.
        found_columns: usize,
        /// Rows of the board.
        rows: u16,
        /// Columns of the board.
        columns: u16,
    },
    /// A grid of another size.
    #[error("found {found_rows} x {found_columns}, the board file says {rows} x {columns}")]
    WrongSize {
        /// Rows seen.
        found_rows: usize,
        /// Columns seen.
        found_columns: usize,
        /// Rows of the board.
        rows: u16,
        /// Columns of the board.
        columns: u16,
    },
}
