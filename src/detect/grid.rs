//! The board in a lattice: which one it is, which rings are which, the verdict.

use super::detection::{Indices, Miss, Odd};
use super::detector::DetectOptions;
use super::labelling::{Label, Lattice, extent, lattices};
use super::marks::numbering_by_marks;
use super::measured::Measured;
use super::orientation::Numbering;
use super::other_size::Beside;
use super::plausible::{Asked, is_plausible, is_scattered};
use super::proposals::Refused;
use super::required::Required;
use super::ring_fit::{Care, RingFit};
use crate::board::Board;
use crate::centre::{Ellipse, RingEllipses};
use crate::frame::Frame;

/// How large drowned rings look, over their true size: tried after 1.
pub(super) const DROWNED_SIZES: [f64; 3] = [0.7, 0.5, 0.35];
/// So many lattices are tried at most: print beside a board may look larger and stand in rows, too.
const MOST_LIKELY: usize = 2;
/// Lattices of another size are tried where they have this fraction of the board's rings.
const WORTH_A_TRY: f64 = 0.3;

/// One ring of the board: where it is on the board and what it looks like.
#[derive(Clone, Copy)]
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
) -> Result<Grid, Refused> {
    if rings.is_empty() {
        return Err(Miss::NoRing.into());
    }
    let spacing = board.pitch_m() / board.outer_radius_m();
    let outers: Vec<Ellipse> = rings.iter().map(|ring| ring.outer).collect();
    let mut first = None;
    let mut proposals = Vec::new();
    for lattices in lattices_of_any_size(board, rings, &outers, spacing) {
        let (chosen, another) = likely(board, &outers, &lattices);
        if chosen.is_empty() {
            first.get_or_insert(too_few_or_no_grid(board, rings.len(), options.required));
        }
        for lattice in chosen {
            let care = Care::of(options.estimator);
            let mut measured = Measured::new(frame, board, rings, sign, lattice, care);
            if is_scattered(&measured.rings, &measured.places) {
                first.get_or_insert(Miss::NoGrid {
                    found: measured.rings.len(),
                    rows: board.rows(),
                    columns: board.columns(),
                });
                continue;
            }
            measured.complete(options.required.least(board));
            let refused = match measured.verdict_or_without_strays(options.required, beside) {
                Ok((rings, indices)) => {
                    return Ok(Grid {
                        rings,
                        indices,
                        another,
                    });
                }
                Err(refused) => refused,
            };
            proposals.extend(refused.proposals);
            // every second ring of a larger board may be a board of this size
            if matches!(refused.miss, Miss::WrongSize { .. }) {
                return Err(Refused {
                    miss: first.unwrap_or(refused.miss),
                    proposals,
                });
            }
            first.get_or_insert(refused.miss);
        }
    }
    Err(Refused {
        miss: first.unwrap_or(Miss::NoRing),
        proposals,
    })
}

/// The lattices that can be the board, those that look largest first, and how many rings of another board there are.
fn likely<'a>(
    board: &Board,
    outers: &[Ellipse],
    lattices: &'a [Lattice],
) -> (Vec<&'a Lattice>, Option<usize>) {
    // a board that is less than half seen is no second one
    let half = |lattice: &&Lattice| 2 * lattice.members.len() >= board.ring_count();
    let mut boards: Vec<&Lattice> = lattices.iter().filter(half).collect();
    let another = boards.get(1).map(|lattice| lattice.members.len());
    boards.sort_by(|a, b| size_px(b, outers).total_cmp(&size_px(a, outers)));
    boards.truncate(MOST_LIKELY);
    if boards.is_empty() {
        boards.extend(lattices.first());
    }
    (boards, another)
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
    /// The verdict; where it is none, that without the spots that are not like their neighbours.
    fn verdict_or_without_strays(
        mut self,
        required: Required,
        beside: Beside,
    ) -> Result<(Vec<Placed>, Indices), Refused> {
        let miss = match self.clone().verdict(required, beside) {
            Ok(found) => return Ok(found),
            Err(miss) => miss,
        };
        let mut proposals = self.proposals(required);
        let cleared = self.shows_enough() && self.leave_out_unlike();
        let miss = match cleared.then(|| self.clone().verdict(required, beside)) {
            Some(Ok(found)) => return Ok(found),
            // a size says more
            Some(Err(second @ (Miss::WrongSize { .. } | Miss::Smaller { .. }))) => second,
            Some(Err(_)) | None => miss,
        };
        if proposals.is_empty() {
            proposals = self.proposals(required);
        }
        Err(Refused {
            miss,
            proposals: vec![proposals],
        })
    }

    /// The rings that lie on the board, by row, then column.
    pub(super) fn placed(&self, numbering: Numbering) -> Vec<Placed> {
        let (rows, columns) = (self.board.rows(), self.board.columns());
        let rings = self.rings.iter().filter_map(|(&label, ring)| {
            let (column, row) = numbering.of(label);
            let column = u16::try_from(column).ok().filter(|&c| c < columns)?;
            let row = u16::try_from(row).ok().filter(|&r| r < rows)?;
            Some(Placed {
                row,
                column,
                ellipses: self.ellipses(label, ring)?,
                blur_sigma_px: ring.blur_sigma_px,
            })
        });
        let mut rings: Vec<Placed> = rings.collect();
        rings.sort_by_key(|ring| (ring.row, ring.column));
        rings
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
        if !is_plausible(self.board, &self.rings, &self.places, Asked::All) {
            return Err(Miss::NoGrid {
                found,
                rows,
                columns,
            });
        }
        if !self.has_the_ratio() {
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
        let mut rings = self.placed(numbering);
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
        if let Some((found_rows, found_columns)) = self.smaller(numbering) {
            return Err(Miss::Smaller {
                found_rows,
                found_columns,
                rows,
                columns,
            });
        }
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
