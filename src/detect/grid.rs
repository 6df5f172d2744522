//! The board in a lattice: which rings are which, the missing ones looked for where they must be, the verdict.

use super::detection::{Indices, Miss};
use super::detector::DetectOptions;
use super::edges::median;
use super::labelling::{Label, Lattice, extent, lattices};
use super::marks::numbering_by_marks;
use super::orientation::{Numbering, choose};
use super::places::Places;
use super::plausible::is_plausible;
use super::required::Required;
use super::ring_fit::{Care, RingFit, measure, measure_disc};
use crate::board::Board;
use crate::centre::{Ellipse, RingEllipses};
use crate::frame::Frame;
use std::collections::BTreeMap;

/// How large drowned rings look, over their true size: tried after 1.
const DROWNED_SIZES: [f64; 2] = [0.7, 0.5];
/// A ring is taken for one of the board's if its size is that of the others within this (logarithm).
const SAME_SIZE: f64 = 0.5;
/// A ring this much smaller or larger (logarithm) than the board says is seen with its contrast inverted.
const ALIKE: f64 = 0.25;
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
pub(super) fn find_grid(
    frame: &Frame,
    board: &Board,
    rings: &[RingFit],
    sign: f64,
    options: &DetectOptions,
) -> Result<Grid, Miss> {
    let (measured, another) = measured(frame, board, rings, sign, options)?;
    let (rings, indices) = measured.verdict(options.required)?;
    Ok(Grid {
        rings,
        indices,
        another,
    })
}

/// The same among some of the rings of a frame: `None` where a row or column of further ones stands beside those that would be the
/// board's.
pub(super) fn find_grid_among(
    frame: &Frame,
    board: &Board,
    rings: &[RingFit],
    sign: f64,
    options: &DetectOptions,
) -> Option<Grid> {
    let (measured, another) = measured(frame, board, rings, sign, options).ok()?;
    if measured.goes_on() {
        return None;
    }
    let (rings, indices) = measured.verdict(options.required).ok()?;
    Some(Grid {
        rings,
        indices,
        another,
    })
}

/// The lattice that looks most like the board, its missing rings looked for, and the rings of another board.
fn measured<'a>(
    frame: &'a Frame,
    board: &'a Board,
    rings: &[RingFit],
    sign: f64,
    options: &DetectOptions,
) -> Result<(Measured<'a>, Option<usize>), Miss> {
    if rings.is_empty() {
        return Err(Miss::NoRing);
    }
    let spacing = board.pitch_m() / board.outer_radius_m();
    let outers: Vec<Ellipse> = rings.iter().map(|ring| ring.outer).collect();
    let lattices = lattices_of_any_size(board, rings, &outers, spacing);
    // a board that is less than half seen is no second one
    let boards = lattices
        .iter()
        .filter(|lattice| 2 * lattice.members.len() >= board.ring_count());
    let another = boards.clone().map(|l| l.members.len()).nth(1);
    let largest = boards.max_by(|a, b| size_px(a, &outers).total_cmp(&size_px(b, &outers)));
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
    measured.complete();
    Ok((measured, another))
}

/// The lattices of rings. Where most inner discs have drowned, blur as large as the rings lets them look smaller than they are, so that
/// their neighbours seem too far away; then other sizes are tried until one makes a board of them.
fn lattices_of_any_size(
    board: &Board,
    rings: &[RingFit],
    outers: &[Ellipse],
    spacing: f64,
) -> Vec<Lattice> {
    let mut best = lattices(outers, spacing);
    let drowned = rings.iter().filter(|ring| ring.inner.is_none()).count();
    let largest = |found: &[Lattice]| found.first().map_or(0, |l| l.members.len());
    if 2 * drowned <= rings.len() {
        return best;
    }
    for size in DROWNED_SIZES {
        if 2 * largest(&best) >= board.ring_count() {
            break;
        }
        let other = lattices(outers, spacing / size);
        if largest(&other) > largest(&best) {
            best = other;
        }
    }
    best
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

/// A lattice whose members are measured rings, and what is needed to measure more.
pub(super) struct Measured<'a> {
    pub(super) frame: &'a Frame,
    pub(super) board: &'a Board,
    sign: f64,
    care: Care,
    pub(super) rings: BTreeMap<Label, RingFit>,
    pub(super) places: Places,
    /// How large the rings look, over what the board says.
    size: f64,
}

impl<'a> Measured<'a> {
    fn new(
        frame: &'a Frame,
        board: &'a Board,
        rings: &[RingFit],
        sign: f64,
        lattice: &Lattice,
        care: Care,
    ) -> Self {
        let rings = lattice
            .members
            .iter()
            .map(|(&label, &at)| (label, rings[at]))
            .collect();
        let mut measured = Self {
            frame,
            board,
            sign,
            care,
            rings,
            places: lattice.places.clone(),
            size: 1.0,
        };
        measured.settle_size();
        measured
    }

    /// Looks for rings at every free place of the board; where the lattice is smaller than the board, also one step
    /// beyond it on each side, as long as that finds any.
    fn complete(&mut self) {
        for _ in 0..self.board.rows().max(self.board.columns()) {
            let Some(places) = self.free_places() else {
                return;
            };
            let found: Vec<(Label, RingFit)> = places
                .into_iter()
                .filter_map(|label| Some((label, self.look_at(label)?)))
                .collect();
            if found.is_empty() {
                return;
            }
            self.rings.extend(found);
            self.settle_places();
        }
    }

    /// Says anew where each ring is expected, by those that are there.
    pub(super) fn settle_places(&mut self) {
        let rings = self.rings.iter();
        if let Some(places) = Places::fit(rings.map(|(&label, ring)| (label, ring.outer.centre))) {
            self.places = places;
        }
        self.settle_size();
    }

    fn settle_size(&mut self) {
        let size = |(&label, ring): (&Label, &RingFit)| {
            let expected = self.predicted_ellipses(label)?.outer;
            Some(ring.outer.mean_radius() / expected.mean_radius())
        };
        let mut sizes: Vec<f64> = self.rings.iter().filter_map(size).collect();
        if !sizes.is_empty() {
            self.size = median(&mut sizes);
        }
    }

    pub(super) fn numbering(&self) -> Option<Numbering> {
        let labels: Vec<Label> = self.rings.keys().copied().collect();
        choose(
            &labels,
            &self.places.homography,
            self.board.rows(),
            self.board.columns(),
        )
    }

    /// Labels without a ring within the board, or next to the lattice where it is smaller than the board.
    fn free_places(&self) -> Option<Vec<Label>> {
        let numbering = self.numbering()?;
        let ((left, right), (top, bottom)) = extent(self.rings.keys().map(|&l| numbering.of(l)));
        let grow = |first: i32, last: i32, size: i32| {
            if last - first + 1 < size {
                (first - 1, last + 1)
            } else {
                (first.max(0), last.min(size - 1))
            }
        };
        let (left, right) = grow(left, right, i32::from(self.board.columns()));
        let (top, bottom) = grow(top, bottom, i32::from(self.board.rows()));
        let places = (top..=bottom)
            .flat_map(|row| (left..=right).map(move |column| (column, row)))
            .map(|place| numbering.label(place))
            .filter(|label| !self.rings.contains_key(label))
            .collect();
        Some(places)
    }

    /// Both circles where the homography says they are.
    fn predicted_ellipses(&self, label: Label) -> Option<RingEllipses> {
        let image = |radius_m: f64| self.places.circle(label, radius_m / self.board.pitch_m());
        Some(RingEllipses {
            inner: image(self.board.inner_radius_m())?,
            outer: image(self.board.outer_radius_m())?,
        })
    }

    /// Measures a ring where the homography says it is.
    pub(super) fn look_at(&self, label: Label) -> Option<RingFit> {
        let rough = self.predicted_ellipses(label)?;
        let ratio = self.board.radius_ratio();
        let ring = measure(self.frame, &rough, self.sign, ratio, self.care)
            .or_else(|| measure_disc(self.frame, &rough.outer, self.sign, ratio, self.care))?;
        let place = self.places.expect(label)?;
        let near = (ring.outer.centre - place.at).norm() < 0.25 * place.step_px();
        let relative = ring.outer.major / (self.size * rough.outer.major);
        let alike = relative.ln().abs() < SAME_SIZE;
        (near && alike).then_some(ring)
    }

    /// The two ellipses of a measured ring.
    fn ellipses(&self, label: Label, ring: &RingFit) -> Option<RingEllipses> {
        let mut ellipses = self.predicted_ellipses(label)?;
        let relative = ring.outer.mean_radius() / ellipses.outer.mean_radius();
        let alike = relative.ln().abs() < ALIKE;
        if let Some(inner) = ring.inner.filter(|_| alike) {
            return Some(RingEllipses {
                inner,
                outer: ring.outer,
            });
        }
        let shift = ring.outer.centre - ellipses.outer.centre;
        ellipses.inner.centre += shift;
        ellipses.outer.centre += shift;
        Some(ellipses)
    }

    fn verdict(mut self, required: Required) -> Result<(Vec<Placed>, Indices), Miss> {
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
            return Ok((rings, indices));
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
