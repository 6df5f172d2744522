//! The board in a lattice: which one it is, which rings are which, the verdict.

use super::detection::{Indices, Miss, Odd};
use super::detector::DetectOptions;
use super::labelling::{Label, Lattice, extent, lattices};
use super::marks::numbering_by_marks;
use super::measured::Measured;
use super::other_size::Beside;
use super::plausible::{has_the_ratio, is_plausible};
use super::required::Required;
use super::ring_fit::{Care, RingFit};
use crate::board::Board;
use crate::centre::{Ellipse, RingEllipses};
use crate::frame::Frame;

/// How large drowned rings look, over their true size: tried after 1.
const DROWNED_SIZES: [f64; 3] = [0.7, 0.5, 0.35];
/// Lattices of another size are tried where they have this fraction of the board's rings.
const WORTH_A_TRY: f64 = 0.3;

/// One ring of the board: where it is on the board and what it looks like.
pub(super) struct Placed {
    pub(super) row: u16,
    pub(super) column: u16,
    /// Both ellipses, px; where the inner one has drowned, the board's homography gives their shapes and the outer edge
    /// their place.
    pub(super) ellipses: RingEllipses,
    pub(super) blur_sigma_px: f64,
}

/// A board found.
pub(super) struct Grid {
    /// Every ring found, (row, column) each once, by row, then column.
    pub(super) rings: Vec<Placed>,
    pub(super) indices: Indices,
    /// Rings of another board in the same frame.
    pub(super) another: Option<usize>,
}

/// Finds the board among the rings of a frame: of several the one that looks largest.
///
/// A row or column of further rings, of those that `beside` says, makes it another board.
pub(super) fn find_grid(
    frame: &Frame,
    board: &Board,
    rings: &[RingFit],
    sign: f64,
    (options, beside): (&DetectOptions, Beside),
) -> Result<Grid, Miss> {
    if rings.is_empty() {
        return Err(Miss::NoRing);
    }
    let spacing = board.pitch_m() / board.outer_radius_m();
    let outers: Vec<Ellipse> = rings.iter().map(|ring| ring.outer).collect();
    let mut first = None;
    for lattices in lattices_of_any_size(board, rings, &outers, spacing) {
        let (measured, another) =
            match measured(frame, board, (rings, &outers), sign, (options, &lattices)) {
                Ok(measured) => measured,
                Err(miss) => {
                    first.get_or_insert(miss);
                    continue;
                }
            };
        match measured.verdict_or_without_strays(options.required, beside) {
            Ok((rings, indices)) => {
                return Ok(Grid {
                    rings,
                    indices,
                    another,
                });
            }
            Err(miss) => {
                first.get_or_insert(miss);
            }
        }
    }
    Err(first.unwrap_or(Miss::NoRing))
}

/// The lattice that looks most like the board, its missing rings looked for, and the rings of another board.
fn measured<'a>(
    frame: &'a Frame,
    board: &'a Board,
    (rings, outers): (&[RingFit], &[Ellipse]),
    sign: f64,
    (options, lattices): (&DetectOptions, &[Lattice]),
) -> Result<(Measured<'a>, Option<usize>), Miss> {
    // a board that is less than half seen is no second one
    let boards = lattices
        .iter()
        .filter(|lattice| 2 * lattice.members.len() >= board.ring_count());
    let another = boards.clone().map(|l| l.members.len()).nth(1);
    let largest = boards.max_by(|a, b| size_px(a, outers).total_cmp(&size_px(b, outers)));
    let Some(lattice) = largest.or(lattices.first()) else {
        return Err(too_few_or_no_grid(board, rings.len(), options.required));
    };
    let mut measured = Measured::new(
        frame,
        board,
        rings,
        sign,
        lattice,
        Care::of(options.estimator),
    );
    measured.complete(options.required.least(board));
    Ok((measured, another))
}

/// The lattices of rings. Where most inner discs have drowned, blur as large as the rings lets them look smaller than they are, so that
/// their neighbours seem too far away; then they are those of other sizes, too, the fullest first.
fn lattices_of_any_size(
    board: &Board,
    rings: &[RingFit],
    outers: &[Ellipse],
    spacing: f64,
) -> Vec<Vec<Lattice>> {
    let mut all = vec![lattices(outers, spacing, 0)];
    let drowned = rings.iter().filter(|ring| ring.inner.is_none()).count();
    if 2 * drowned <= rings.len() {
        return all;
    }
    let largest = |found: &[Lattice]| found.first().map_or(0, |l| l.members.len());
    for size in DROWNED_SIZES {
        let other = lattices(outers, spacing / size, 0);
        let worth = largest(&other) as f64 >= WORTH_A_TRY * board.ring_count() as f64;
        if worth && all.iter().all(|known| known.first() != other.first()) {
            all.push(other);
        }
    }
    all.sort_by_key(|found| std::cmp::Reverse(largest(found)));
    all
}

/// Mean size of a lattice's rings, px.
fn size_px(lattice: &Lattice, outers: &[Ellipse]) -> f64 {
    let sizes = lattice.members.values().map(|&at| outers[at].mean_radius());
    sizes.sum::<f64>() / lattice.members.len() as f64
}

/// Why rings make no grid of this board: there are not enough of them, or they stand otherwise.
fn too_few_or_no_grid(board: &Board, found: usize, required: Required) -> Miss {
    if found < required.least(board) {
        Miss::TooFewRings {
            found,
            expected: board.ring_count(),
        }
    } else {
        Miss::NoGrid {
            found,
            rows: board.rows(),
            columns: board.columns(),
        }
    }
}

impl Measured<'_> {
    /// The verdict; under heavy blur, where it is none, that without the spots that are not like their neighbours.
    fn verdict_or_without_strays(
        self,
        required: Required,
        beside: Beside,
    ) -> Result<(Vec<Placed>, Indices), Miss> {
        let mut others = self.is_heavily_blurred().then(|| self.clone());
        self.verdict(required, beside).or_else(|miss| {
            let cleared = others.as_mut().is_some_and(Self::leave_out_unlike);
            match others.filter(|_| cleared) {
                Some(others) => others.verdict(required, beside).map_err(|_| miss),
                None => Err(miss),
            }
        })
    }

    fn verdict(
        mut self,
        required: Required,
        beside: Beside,
    ) -> Result<(Vec<Placed>, Indices), Miss> {
        self.leave_out_strays();
        let (rows, columns) = (self.board.rows(), self.board.columns());
        let found = self.rings.len();
        let labels: Vec<Label> = self.rings.keys().copied().collect();
        let by_marks = numbering_by_marks(self.frame, self.board, &labels, &self.places);
        let Some(numbering) = by_marks.or_else(|| self.numbering()) else {
            return Err(too_few_or_no_grid(self.board, found, required));
        };
        if !is_plausible(self.board, &self.rings, &self.places) {
            return Err(Miss::NoGrid {
                found,
                rows,
                columns,
            });
        }
        if !has_the_ratio(self.board, &self.rings) {
            let odd = Odd::Inners;
            return Err(Miss::Unlike { found, odd });
        }
        if let Some((found_rows, found_columns)) = self.other_size(numbering) {
            return Err(Miss::WrongSize {
                found_rows,
                found_columns,
                rows,
                columns,
            });
        }
        let mut rings: Vec<Placed> = self
            .rings
            .iter()
            .filter_map(|(&label, ring)| {
                let (column, row) = numbering.of(label);
                let column = u16::try_from(column).ok().filter(|&c| c < columns)?;
                let row = u16::try_from(row).ok().filter(|&r| r < rows)?;
                Some(Placed {
                    row,
                    column,
                    ellipses: self.ellipses(label, ring)?,
                    blur_sigma_px: ring.blur_sigma_px,
                })
            })
            .collect();
        rings.sort_by_key(|ring| (ring.row, ring.column));
        if let Some(indices) = required.judge(self.board, &mut rings, by_marks.is_some()) {
            return match self.goes_on(numbering, beside) {
                Some((found_rows, found_columns)) => Err(Miss::WrongSize {
                    found_rows,
                    found_columns,
                    rows,
                    columns,
                }),
                None => Ok((rings, indices)),
            };
        }
        let (found, expected) = (rings.len(), self.board.ring_count());
        let (columns, rows) = extent(self.rings.keys().map(|&l| numbering.of(l)));
        Err(if self.is_cut_off(numbering, columns, rows) {
            Miss::CutOff { found, expected }
        } else if required == Required::Extent && found >= required.least(self.board) {
            Miss::LineMissing { found, expected }
        } else {
            Miss::TooFewRings { found, expected }
        })
    }
}
