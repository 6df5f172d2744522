//! The detector: a board and how to look for it.

use super::centres::board_homography;
use super::detection::{Detection, Indices, Miss};
use super::grid::find_grid;
use super::outermost::sure_centres;
use super::rings::{add_drowned, find_rings};
use super::single::find_single;
use crate::board::{Board, Polarity};
use crate::camera::Camera;
use crate::centre::Estimator;
use crate::centre::photometric::{PsfChoice, ResponseGamma};
use crate::frame::Frame;

/// How to look for a board.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DetectOptions {
    /// What gives the projected centre.
    pub estimator: Estimator,
    /// Which shape of blur the photometric estimator fits.
    pub psf: PsfChoice,
    /// How the frame's grey values follow the light; only the photometric estimator asks.
    pub response_gamma: ResponseGamma,
    /// The camera, where it is calibrated already: it gives the photometric estimator the perspective of each ring. Its
    /// size must be that of the frames.
    pub camera: Option<Camera>,
}

/// Finds one board in frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Detector {
    board: Board,
    options: DetectOptions,
}

/// Side of a ring that can be measured at all, px.
const LEAST_RING_PX: usize = 6;

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
        let (width, height) = (frame.width(), frame.height());
        let (rows, columns) = (self.board.rows(), self.board.columns());
        let least = LEAST_RING_PX * usize::from(rows.min(columns));
        if width.min(height) < least {
            return Err(Miss::FrameTooSmall {
                width,
                height,
                rows,
                columns,
            });
        }
        match self.board.polarity() {
            Polarity::DarkOnLight => self.detect_sign(frame, 1.0),
            Polarity::LightOnDark => self.detect_sign(frame, -1.0),
            Polarity::Auto => {
                let dark = self.detect_sign(frame, 1.0);
                if dark
                    .as_ref()
                    .is_ok_and(|d| d.rings.len() == self.board.ring_count())
                {
                    return dark;
                }
                let light = self.detect_sign(frame, -1.0);
                let found = |d: &Result<Detection, Miss>| d.as_ref().map_or(0, |d| d.rings.len());
                if found(&light) > found(&dark) {
                    light
                } else {
                    dark
                }
            }
        }
    }

    /// `sign` is 1 for dark rings, -1 for light ones.
    fn detect_sign(&self, frame: &Frame, sign: f64) -> Result<Detection, Miss> {
        if self.board.is_single() {
            return find_single(frame, &self.board, &self.options, sign);
        }
        let ratio = self.board.radius_ratio();
        let rings = find_rings(frame, sign, ratio);
        let placed = find_grid(frame, &self.board, &rings, sign).or_else(|_| {
            let all = add_drowned(frame, rings, sign, ratio);
            find_grid(frame, &self.board, &all, sign)
        })?;
        let (rings, photometric) = sure_centres(frame, &self.board, placed, &self.options, sign)?;
        let homography = board_homography(&self.board, &rings).ok_or(Miss::NoGrid {
            found: rings.len(),
            rows: self.board.rows(),
            columns: self.board.columns(),
        })?;
        Ok(Detection {
            width: frame.width(),
            height: frame.height(),
            indices: Indices::Absolute,
            rings,
            homography,
            photometric,
        })
    }
}
