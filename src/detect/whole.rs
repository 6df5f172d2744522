//! The board where all of it shows at a coarse level: most frames are done with a fraction of their pixels.
//!
//! Levels are looked at from the coarsest on. As soon as the candidates hold a lattice of just the board's rows and columns, (nearly)
//! full, only these are measured. If all of the board's rings prove to be there, that is the board; where some are covered, the levels
//! below are asked, too, and what shows most of it is the board. Otherwise nothing is decided here, and the whole frame is searched at
//! all levels (`rings`).

use super::detector::DetectOptions;
use super::grid::{Grid, find_grid};
use super::labelling::{Lattice, extent, lattices};
use super::other_size::Beside;
use super::ring_fit::{Care, RingFit, measure};
use super::rings::spots;
use super::scales::Scales;
use crate::board::Board;
use crate::centre::{Ellipse, RingEllipses};
use rayon::prelude::*;

/// Fraction of the board's rings (marks not among them) that have to show before they are measured.
const LEAST_SHOWN: f64 = 0.75;

/// Fraction of these that a walk from ring to ring finds at least: what it missed is added where the others expect it.
const LEAST_WALKED: f64 = 0.33;

/// The board, where all of its rings are found among those that a coarse level shows, or most of them among those of all levels: what
/// stands beside a board whose other rings are covered may seem to go on with it where everything in the frame is asked.
pub(super) fn find_whole(
    scales: &mut Scales,
    board: &Board,
    options: &DetectOptions,
) -> Option<Grid> {
    let wanted = board.ring_count() - board.marks().len();
    let mut levels: Vec<Vec<RingEllipses>> = Vec::new();
    let mut tried = 0;
    let mut most: Option<Grid> = None;
    for level in (0..scales.count()).rev() {
        levels.insert(0, scales.rings(level).to_vec());
        if (levels.iter().map(Vec::len).sum::<usize>() as f64) < LEAST_SHOWN * wanted as f64 {
            continue;
        }
        let spots = spots(levels.iter().map(Vec::as_slice));
        let Some(members) = whole_lattice(board, &spots) else {
            continue;
        };
        if members.len() <= tried {
            continue;
        }
        tried = members.len();
        let Some(grid) = measured(scales, board, options, &spots, &members) else {
            continue;
        };
        if grid.rings.len() >= wanted {
            return Some(grid);
        }
        if most
            .as_ref()
            .is_none_or(|most| grid.rings.len() > most.rings.len())
        {
            most = Some(grid);
        }
    }
    most.filter(|grid| grid.rings.len() as f64 >= LEAST_SHOWN * wanted as f64)
}

/// Numbers of the candidates in the lattice that is the board and nothing else.
fn whole_lattice(board: &Board, spots: &[Vec<RingEllipses>]) -> Option<Vec<usize>> {
    let outers: Vec<Ellipse> = spots.iter().map(|spot| spot[0].outer).collect();
    let spacing = board.pitch_m() / board.outer_radius_m();
    let least = LEAST_SHOWN * (board.ring_count() - board.marks().len()) as f64;
    let found = lattices(&outers, spacing, (LEAST_WALKED * least) as usize);
    let lattice: &Lattice = found.first()?;
    let ((left, right), (top, bottom)) = extent(lattice.members.keys().copied());
    let seen = ((bottom - top + 1) as usize, (right - left + 1) as usize);
    let (rows, columns) = (usize::from(board.rows()), usize::from(board.columns()));
    let is_board = seen == (rows, columns) || seen == (columns, rows);
    // a second one of the same kind has to be told of
    let alone = found
        .get(1)
        .is_none_or(|l| 2 * l.members.len() < board.ring_count());
    (is_board && alone && lattice.members.len() as f64 >= least)
        .then(|| lattice.members.values().copied().collect())
}

fn measured(
    scales: &Scales,
    board: &Board,
    options: &DetectOptions,
    spots: &[Vec<RingEllipses>],
    members: &[usize],
) -> Option<Grid> {
    let (sign, ratio) = (scales.sign, board.radius_ratio());
    let care = Care::of(options.estimator);
    let rings: Vec<RingFit> = members
        .par_iter()
        .filter_map(|&at| {
            let tried = spots[at].iter();
            let mut fits =
                tried.filter_map(|rough| measure(scales.frame, rough, sign, ratio, care));
            fits.next()
        })
        .collect();
    find_grid(scales.frame, board, &rings, sign, (options, Beside::Any)).ok()
}
