//! The detector: a board and how to look for it.

use super::centres::board_homography;
use super::detection::{Detection, Indices, Measured, Miss, Ring};
use super::evidence::{are_rings, clearer, evidence};
use super::grid::{Grid, find_grid};
use super::light::bad_light;
use super::likeness::are_the_boards;
use super::other_size::Beside;
use super::outermost::sure_centres;
use super::proposals::{Refused, confirmed};
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
            match self.search(scales, one.rings, care) {
                Ok(grid) => self.measured(frame, grid, one.sign),
                Err(refused) => self.by_grey(frame, refused, one.sign),
            }
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
        let centres = sure_centres(frame, &self.board, grid, &self.options, sign)?;
        self.judged(frame, centres, indices, another)
    }

    /// The board where edges say too little to know which ring is which, but grey values agree with just one way to lay it over them.
    fn by_grey(&self, frame: &Frame, refused: Refused, sign: f64) -> Result<Detection, Miss> {
        if self.options.estimator != Estimator::Photometric {
            return Err(refused.miss);
        }
        for ways in refused.to_measure() {
            let confirmed = ways
                .iter()
                .filter_map(|placed| confirmed(frame, &self.board, placed, &self.options, sign));
            let mut confirmed: Vec<_> = confirmed.collect();
            if let Some(centres) = confirmed.pop().filter(|_| confirmed.is_empty())
                && let Ok(found) = self.judged(frame, centres, Indices::Absolute, None)
            {
                return Ok(found);
            }
        }
        Err(refused.miss)
    }

    /// Whether measured rings are the board's.
    fn judged(
        &self,
        frame: &Frame,
        (rings, photometric): (Vec<Ring>, Option<Measured>),
        indices: Indices,
        another: Option<usize>,
    ) -> Result<Detection, Miss> {
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
    fn search(
        &self,
        scales: &mut Scales,
        rings: Vec<RingFit>,
        care: Care,
    ) -> Result<Grid, Refused> {
        let (frame, sign) = (scales.frame, scales.sign);
        let how = (&self.options, Beside::Alike);
        find_grid(frame, &self.board, &rings, sign, how).or_else(|first| {
            let all = add_drowned(scales, &self.board, rings, care);
            find_grid(frame, &self.board, &all, sign, how).map_err(|mut second| {
                second.proposals.extend(first.proposals);
                // what sharper rings say of the size is not unsaid by fainter ones
                if matches!(first.miss, Miss::WrongSize { .. } | Miss::Smaller { .. }) {
                    second.miss = first.miss;
                }
                second
            })
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
