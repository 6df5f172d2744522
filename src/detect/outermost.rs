//! Whether the outermost rows and columns of a grid are rings.
//!
//! Where blur has nearly drowned a row, a blot or the sheet's edge one step beyond the opposite row may look more like rings than the
//! row does, and the whole grid is then numbered one step off: a wrong answer that looks like a right one. So a row or column that
//! only a few edges speak for has to pass the test of its grey values: its rings must fit the model of a ring as well as all others do,
//! with about their contrast and blur. If they do not, the grid is tried one step to the other side. So it is where edges speak for a
//! line but none of its rings can be measured.

use super::centres::centres;
use super::detection::{Measured, Miss, Ring};
use super::detector::DetectOptions;
use super::grid::{Grid, Placed};
use super::lines::{Line, elsewhere, lines_missing, seen};
use crate::board::Board;
use crate::centre::Estimator;
use crate::frame::Frame;

/// A ring is like the others while its residuals are at most this much of theirs, and its contrast and its blur within these factors.
const MOST_NOISE: f64 = 2.5;
const CONTRASTS: (f64, f64) = (0.4, 2.0);
const BLURS: (f64, f64) = (0.6, 1.6);
/// At least this fraction of a doubtful line's rings must be like the others.
const ALIKE: f64 = 0.5;

/// Edges deceive from this blur on, sigma over the ring's width.
const DROWNED: f64 = 0.3;

/// The centres of a grid whose outermost lines are beyond doubt, or have passed the test of their grey values.
///
/// # Errors
/// [`Miss::LineMissing`] where a line has not, and the grid one step to the other side has not either.
pub(super) fn sure_centres(
    frame: &Frame,
    board: &Board,
    grid: Grid,
    options: &DetectOptions,
    sign: f64,
) -> Result<(Vec<Ring>, Option<Measured>), Miss> {
    let is_ring = |ring: &&Placed| !board.is_mark(ring.row, ring.column);
    let rings: Vec<Placed> = grid.rings.iter().filter(is_ring).copied().collect();
    let lines = Line::ALL.map(|line| seen(board, line, &rings));
    let centres = tested_centres(frame, board, grid, options, sign)?;
    if centres.1.is_some() {
        are_all_measured(board, &lines, &centres.0)?;
    }
    Ok(centres)
}

/// Whether a ring could be measured of each line of which edges were `seen`, and where it was of few of these, one that is like the rings
/// elsewhere: beside a sheet there are edges enough that a line of the board might be made of.
fn are_all_measured(board: &Board, seen: &[f64; 4], rings: &[Ring]) -> Result<(), Miss> {
    let is_missing = |&(line, seen): &(Line, f64)| {
        let of_line = |ring: &&Ring| line.contains(board, ring.row, ring.column);
        let measured = rings.iter().filter(of_line).count();
        let few = (measured as f64) < ALIKE * seen;
        few && (measured == 0 || !is_alike(board, line, rings, 1.0))
    };
    let lines = Line::ALL.into_iter().zip(*seen);
    let missing: Vec<Line> = lines.filter(is_missing).map(|line| line.0).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let others = elsewhere(board, &missing, rings.iter().map(|r| (r.row, r.column)));
    Err(lines_missing(board, &missing, others))
}

fn tested_centres(
    frame: &Frame,
    board: &Board,
    grid: Grid,
    options: &DetectOptions,
    sign: f64,
) -> Result<(Vec<Ring>, Option<Measured>), Miss> {
    let (placed, indices) = (grid.rings, grid.indices);
    if Line::ALL
        .iter()
        .any(|&line| seen(board, line, &placed) == 0.0)
    {
        // a part of the board is out of sight, and may be
        return Ok(centres(frame, board, (&placed, indices), options, sign));
    }
    let doubtful = |placed: &[Placed]| -> Vec<Line> {
        let lines = Line::ALL.into_iter();
        lines
            .filter(|line| line.is_in_doubt(board, placed))
            .collect()
    };
    let photometric = options.estimator == Estimator::Photometric;
    let lines = doubtful(&placed);
    if lines.is_empty() && !photometric {
        return Ok(centres(frame, board, (&placed, indices), options, sign));
    }
    let by_grey = DetectOptions {
        estimator: Estimator::Photometric,
        ..*options
    };
    let answer = |mut placed: Vec<Placed>, measured: (Vec<Ring>, Option<Measured>)| {
        if photometric {
            return measured;
        }
        // an estimator that needs edges takes those of the fits where none were seen
        for ring in &measured.0 {
            let known = |p: &Placed| (p.row, p.column) == (ring.row, ring.column);
            if !placed.iter().any(known) {
                placed.push(Placed {
                    row: ring.row,
                    column: ring.column,
                    ellipses: ring.ellipses,
                    blur_sigma_px: ring.blur_sigma_px,
                });
            }
        }
        placed.sort_by_key(|ring| (ring.row, ring.column));
        centres(frame, board, (&placed, indices), options, sign)
    };
    let first = centres(frame, board, (&placed, indices), &by_grey, sign);
    let is_wrong = |line: &Line| match lines.contains(line) {
        true => !is_alike(board, *line, &first.0, ALIKE * seen(board, *line, &placed)),
        // a blot may look like one ring and another, but not like all of a line
        false => {
            seen(board, *line, &placed) < line.rings(board) as f64
                && is_unmeasured(board, *line, &first.0)
        }
    };
    let wrong: Vec<Line> = Line::ALL.into_iter().filter(is_wrong).collect();
    if wrong.is_empty() {
        return Ok(answer(placed, first));
    }
    let others = elsewhere(board, &wrong, placed.iter().map(|r| (r.row, r.column)));
    let missing = lines_missing(board, &wrong, others);
    let mut moved = placed;
    for &line in &wrong {
        moved = line.moved(board, &moved);
    }
    let second = centres(frame, board, (&moved, indices), &by_grey, sign);
    let holds = wrong.iter().all(|line| {
        let line = line.opposite();
        is_alike(board, line, &second.0, ALIKE * line.rings(board) as f64)
    });
    if holds {
        Ok(answer(moved, second))
    } else {
        Err(missing)
    }
}

/// Whether no ring of a line could be measured, while most of the others could, in a blur that makes blots of their edges. (In a sharp
/// picture edges do not deceive, and it is the model that does not describe the line: a lens that bends much.)
fn is_unmeasured(board: &Board, line: Line, rings: &[Ring]) -> bool {
    let measured = |of_line: bool| {
        let of_line = rings
            .iter()
            .filter(move |ring| line.contains(board, ring.row, ring.column) == of_line);
        let (all, measured) = of_line.fold((0, 0), |(all, measured), ring| {
            (
                all + 1,
                measured + usize::from(ring.centre.covariance.is_some()),
            )
        });
        (all, measured)
    };
    let ((_, own), (others, measured)) = (measured(true), measured(false));
    let blurred = rings.iter().filter(|ring| is_drowned(ring)).count();
    own == 0 && 2 * measured > others && 2 * blurred > rings.len()
}

/// Whether a ring's blur is so heavy that its edges are not where they seem to be.
fn is_drowned(ring: &Ring) -> bool {
    ring.blur_sigma_px > DROWNED * ring.ellipses.width()
}

/// Whether so many rings of a line (and one at least) have grey values like those of the rings elsewhere.
pub(super) fn is_alike(board: &Board, line: Line, rings: &[Ring], least: f64) -> bool {
    let (own, others): (Vec<Grey>, Vec<Grey>) = {
        let (own, others): (Vec<&Ring>, Vec<&Ring>) = rings
            .iter()
            .partition(|ring| line.contains(board, ring.row, ring.column));
        let grey = |rings: Vec<&Ring>| rings.into_iter().filter_map(Grey::of).collect();
        (grey(own), grey(others))
    };
    let Some(usual) = Grey::usual(&others) else {
        return false;
    };
    let alike = own.iter().filter(|grey| grey.is_like(&usual)).count();
    alike > 0 && alike as f64 >= least
}

/// What a fit says of a ring's grey values.
#[derive(Debug, Clone, Copy)]
struct Grey {
    noise: f64,
    contrast: f64,
    sigma_px: f64,
}

impl Grey {
    fn of(ring: &Ring) -> Option<Self> {
        let fitted = &ring.kept.as_ref()?.fitted;
        Some(Self {
            noise: fitted.noise,
            contrast: fitted.model.paper - fitted.model.ring,
            sigma_px: fitted.model.blur.sigma_px(),
        })
    }

    /// The median of each.
    fn usual(all: &[Self]) -> Option<Self> {
        let median = |of: fn(&Self) -> f64| {
            let mut values: Vec<f64> = all.iter().map(of).collect();
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied()
        };
        Some(Self {
            noise: median(|grey| grey.noise)?,
            contrast: median(|grey| grey.contrast)?,
            sigma_px: median(|grey| grey.sigma_px)?,
        })
    }

    fn is_like(&self, usual: &Self) -> bool {
        let within =
            |own: f64, usual: f64, (low, high): (f64, f64)| own / usual > low && own / usual < high;
        // without noise the residuals are rounding, and differ
        let noise = usual.noise.max(2e-3 * usual.contrast.abs());
        self.noise < MOST_NOISE * noise
            && within(self.contrast, usual.contrast, CONTRASTS)
            && (self.sigma_px.max(usual.sigma_px) < 1.0
                || within(self.sigma_px, usual.sigma_px, BLURS))
    }
}
