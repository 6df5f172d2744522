//! The detector: a board and how to look for it.

use super::centres::board_homography;
use super::detection::{Detection, Miss, Ring};
use super::grid::{Grid, find_grid};
use super::light::bad_light;
use super::likeness::are_the_boards;
use super::other_size::Beside;
use super::outermost::sure_centres;
use super::required::Required;
use super::ring_fit::{Care, RingFit};
use super::rings::{add_drowned, find_rings};
use super::scales::Scales;
use super::single::find_single;
use super::whole::find_whole;
use crate::board::{Board, Polarity};
use crate::camera::Camera;
use crate::centre::Estimator;
use crate::centre::photometric::{PsfChoice, ResponseGamma};
use crate::frame::Frame;
use std::ops::Range;

/// How to look for a board.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DetectOptions {
    /// What gives the projected centre.
    pub estimator: Estimator,
    /// Which shape of blur the photometric estimator fits.
    pub psf: PsfChoice,
    /// How the frame's grey values follow the light; only the photometric estimator asks.
    pub response_gamma: ResponseGamma,
    /// How much of the board must be seen.
    pub required: Required,
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

/// Fraction of a board's rings that must have a ring's grey values.
const LEAST_MEASURED: f64 = 0.5;
/// Contrast across the inner circle over that across the outer: 1 in print, less than a quarter where a dot is taken for a ring, more
/// than twice where a fit under heavy blur makes up levels that no print has, to resemble a spot of another shape.
const INSIDE: Range<f64> = 0.5..2.0;
/// Blur sigma over the ring's width from which edges say so little that blur is to blame.
const HEAVY: f64 = 0.5;
/// The same up to which a ring shows for what it is.
const PLAIN: f64 = 0.3;

/// One polarity looked at: the rings seen, and what came of the fast way.
struct Try {
    sign: f64,
    rings: Vec<RingFit>,
    known: Option<Result<Detection, Miss>>,
}

impl Try {
    /// How many rings show.
    fn shows(&self) -> usize {
        self.known.as_ref().map_or(self.rings.len(), evidence)
    }
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
        self.detect_polarity(frame)
            .map_err(|miss| explained(miss, frame))
    }

    fn detect_polarity(&self, frame: &Frame) -> Result<Detection, Miss> {
        let signs: &[f64] = match self.board.polarity() {
            Polarity::DarkOnLight => &[1.0],
            Polarity::LightOnDark => &[-1.0],
            Polarity::Auto => &[1.0, -1.0],
        };
        if self.board.is_single() {
            return self.best(signs, |sign| {
                find_single(frame, &self.board, &self.options, sign)
            });
        }
        let mut scales = Scales::new(frame, signs[0], self.board.radius_ratio());
        // the fast way for both before the slow one for either
        let mut grids = [None, None];
        for (grid, &sign) in grids.iter_mut().zip(signs) {
            scales.turn_to(sign);
            *grid = find_whole(&mut scales, &self.board, &self.options)
                .map(|grid| self.measured(frame, grid, sign));
            if let Some(found) = grid.take_if(|found| self.is_whole(found)) {
                return found;
            }
        }
        self.searched(frame, &mut scales, signs, grids)
    }

    /// The slow way for the polarities whose fast one came to nothing.
    fn searched(
        &self,
        frame: &Frame,
        scales: &mut Scales,
        signs: &[f64],
        known: [Option<Result<Detection, Miss>>; 2],
    ) -> Result<Detection, Miss> {
        let care = Care::of(self.options.estimator);
        let tries = signs.iter().zip(known).map(|(&sign, known)| {
            scales.turn_to(sign);
            let rings = match known {
                Some(_) => Vec::new(),
                None => find_rings(scales, &self.board, care),
            };
            Try { sign, rings, known }
        });
        let mut tries: Vec<Try> = tries.collect();
        // the sign that shows more rings first
        tries.sort_by_key(|one| std::cmp::Reverse(one.shows()));
        let shows: Vec<usize> = tries.iter().map(Try::shows).collect();
        let turned = tries.first().is_some_and(|one| one.sign != signs[0]);
        let mut answers = tries.into_iter().map(|one| {
            if let Some(found) = one.known {
                return found;
            }
            scales.turn_to(one.sign);
            let grid = self.search(scales, one.rings, care)?;
            self.measured(frame, grid, one.sign)
        });
        let first = answers.next().unwrap_or(Err(Miss::NoRing));
        let clear = shows.windows(2).all(|both| 2 * both[1] < both[0]);
        if self.is_whole(&first) || (clear && self.is_plain(&first)) {
            return first;
        }
        match answers.next() {
            // where neither is the board, the reason is that of the polarity named first
            Some(second) if turned && first.is_err() && second.is_err() => second,
            Some(second) => clearer(first, second),
            None => first,
        }
    }

    /// Whether most of the board's rings speak for a detection, in so little blur that the gaps between rings of the other polarity do not
    /// look like rings.
    fn is_plain(&self, detection: &Result<Detection, Miss>) -> bool {
        let sharp = |ring: &Ring| ring.blur_sigma_px < PLAIN * ring.ellipses.width();
        2 * evidence(detection) > self.board.ring_count()
            && detection.as_ref().is_ok_and(|found| {
                2 * found.rings.iter().filter(|ring| sharp(ring)).count() > found.rings.len()
            })
    }

    /// What is found for the sign for which more rings speak: the first one's where these are all of the board's, or as many.
    fn best(
        &self,
        signs: &[f64],
        mut find: impl FnMut(f64) -> Result<Detection, Miss>,
    ) -> Result<Detection, Miss> {
        let first = find(signs[0]);
        let Some(&other) = signs.get(1).filter(|_| !self.is_whole(&first)) else {
            return first;
        };
        clearer(first, find(other))
    }

    /// Whether every ring of the board speaks for a detection.
    fn is_whole(&self, detection: &Result<Detection, Miss>) -> bool {
        evidence(detection) == self.board.ring_count()
    }

    /// The rings of a grid measured, and whether they are the board's; `sign` is 1 for dark rings, -1 for light ones.
    fn measured(&self, frame: &Frame, grid: Grid, sign: f64) -> Result<Detection, Miss> {
        let (indices, another) = (grid.indices, grid.another);
        let (rings, photometric) = sure_centres(frame, &self.board, grid, &self.options, sign)?;
        let least = self.options.required.least(&self.board);
        if rings.len() < least {
            return Err(Miss::TooFewRings {
                found: rings.len(),
                expected: self.board.ring_count(),
            });
        }
        if let Some(measured) = &photometric {
            are_rings(&rings)?;
            are_the_boards(&self.board, &rings, measured)?;
        }
        let homography = board_homography(&self.board, &rings).ok_or(Miss::NoGrid {
            found: rings.len(),
            rows: self.board.rows(),
            columns: self.board.columns(),
        })?;
        Ok(Detection {
            width: frame.width(),
            height: frame.height(),
            indices,
            rings,
            homography,
            photometric,
            another,
        })
    }

    /// The board among all rings of the frame, or among these and whatever may be one whose inner disc has drowned.
    fn search(&self, scales: &mut Scales, rings: Vec<RingFit>, care: Care) -> Result<Grid, Miss> {
        let (frame, sign) = (scales.frame, scales.sign);
        let how = (&self.options, Beside::Alike);
        find_grid(frame, &self.board, &rings, sign, how).or_else(|_| {
            let all = add_drowned(scales, &self.board, rings, care);
            find_grid(frame, &self.board, &all, sign, how)
        })
    }
}

/// A miss in bad light is a miss because of it, unless most rings were seen.
fn explained(miss: Miss, frame: &Frame) -> Miss {
    let light_is_to_blame = match miss {
        Miss::NoRing | Miss::NoGrid { .. } => true,
        Miss::TooFewRings { found, expected } => 2 * found < expected,
        _ => false,
    };
    if light_is_to_blame {
        bad_light(frame).unwrap_or(miss)
    } else {
        miss
    }
}

/// The answer for which more rings speak; the first where as many do.
fn clearer(
    first: Result<Detection, Miss>,
    second: Result<Detection, Miss>,
) -> Result<Detection, Miss> {
    if evidence(&second) > evidence(&first) {
        second
    } else {
        first
    }
}

/// How many rings speak for a detection.
fn evidence(detection: &Result<Detection, Miss>) -> usize {
    detection
        .as_ref()
        .map_or(0, |found| match found.photometric {
            Some(_) => measured(&found.rings).count(),
            None => found.rings.len(),
        })
}

/// The rings whose grey values are a ring's: paper shows again inside, which a plain dot does not have.
fn measured(rings: &[Ring]) -> impl Iterator<Item = &Ring> {
    rings.iter().filter(|ring| {
        ring.kept
            .as_ref()
            .is_some_and(|kept| INSIDE.contains(&kept.fitted.model.inner_over_outer()))
    })
}

/// Whether enough of the rings have the grey values of rings.
fn are_rings(rings: &[Ring]) -> Result<(), Miss> {
    let fitted = measured(rings).count();
    if fitted as f64 >= LEAST_MEASURED * rings.len() as f64 {
        return Ok(());
    }
    let median = |of: fn(&Ring) -> f64| {
        let mut values: Vec<f64> = rings.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    };
    let (sigma_px, width_px) = (
        median(|ring| ring.blur_sigma_px),
        median(|ring| ring.ellipses.width()),
    );
    if sigma_px > HEAVY * width_px {
        return Err(Miss::TooBlurred { sigma_px, width_px });
    }
    Err(Miss::NotRings {
        found: rings.len(),
        rings: fitted,
    })
}
