//! Lattices that do not have the board's size: another board, or one that the frame cuts off.

use super::edges::median;
use super::labelling::{Label, extent};
use super::marks::spot;
use super::measured::Measured;
use super::orientation::Numbering;
use super::ring_fit::RingFit;
use rayon::prelude::*;

/// A lattice as full as this shows its true extent.
pub(super) const FULL: f64 = 0.8;
/// A line beside the lattice is there where so many of its rings show.
const GOES_ON: f64 = 0.5;
/// No ring beside a board is fainter than this, over the contrast of the board's: one that blur has nearly drowned may be.
const LEAST_CONTRAST: f64 = 0.05;
/// Under heavy blur the sheet's edge and what is beside it look like rings, too. A ring is as those of the board where its contrast and its
/// blur are within these factors of theirs,
const CONTRASTS: f64 = 2.5;
const BLURS: f64 = 1.6;
/// the contrast within this factor of that of the rings next to it,
const NEXT_CONTRASTS: f64 = 1.4;
/// its size over theirs (logarithm),
const SIZES: f64 = 0.2;
/// and its distance from its place, in steps.
const MISPLACED: f64 = 0.12;
/// One of so many times the board's rings is a wall of them.
const MANY: f64 = 1.5;

/// Which rings beside those of a board make it a part of something larger.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Beside {
    /// Whatever looks like a ring: there is a slower way to find the board.
    Any,
    /// Those that are as the board's.
    Alike,
}

impl Measured<'_> {
    /// Rows and columns seen, where the lattice is nearly full and does not have the board's size, and is not merely cut
    /// off by the frame's border.
    pub(super) fn other_size(&self, numbering: Numbering) -> Option<(usize, usize)> {
        let ((left, right), (top, bottom)) = extent(self.rings.keys().map(|&l| numbering.of(l)));
        let seen = ((bottom - top + 1) as usize, (right - left + 1) as usize);
        let wanted = (
            usize::from(self.board.rows()),
            usize::from(self.board.columns()),
        );
        let full = self.rings.len() as f64 >= FULL * (seen.0 * seen.1) as f64;
        let smaller = seen.0 < wanted.0 || seen.1 < wanted.1;
        let larger = seen.0 > wanted.0 || seen.1 > wanted.1;
        let wall = larger && self.rings.len() as f64 > MANY * self.board.ring_count() as f64;
        let odd = wall
            || full
                && (larger
                    || (smaller && !self.is_cut_off(numbering, (left, right), (top, bottom))));
        odd.then_some(seen)
    }

    /// Rows and columns seen, where the lattice is nearly full and smaller than the board.
    pub(super) fn smaller(&self, numbering: Numbering) -> Option<(usize, usize)> {
        let ((left, right), (top, bottom)) = extent(self.rings.keys().map(|&l| numbering.of(l)));
        let (rows, columns) = ((bottom - top + 1) as usize, (right - left + 1) as usize);
        let wanted = self.board.ring_count();
        let full = self.rings.len() as f64 >= FULL * (rows * columns) as f64;
        (full && rows * columns < wanted).then_some((rows, columns))
    }

    /// Leaves out the few spots beside a board of which (nearly) all is there that look like rings of one more row or column: under heavy
    /// blur noise has such spots. A line of which half shows is kept: it says that this is another board.
    pub(super) fn leave_out_strays(&mut self) {
        let Some(numbering) = self.numbering() else {
            return;
        };
        let (columns, rows) = (
            i32::from(self.board.columns()),
            i32::from(self.board.rows()),
        );
        // the row or column beyond the board that a ring stands in, and how many would fill it
        let beyond = |label: Label| {
            let (column, row) = numbering.of(label);
            if !(0..rows).contains(&row) {
                Some(((row, true), columns))
            } else if !(0..columns).contains(&column) {
                Some(((column, false), rows))
            } else {
                None
            }
        };
        let off: Vec<_> = self
            .rings
            .keys()
            .filter_map(|&l| Some((l, beyond(l)?)))
            .collect();
        let on_board = (self.rings.len() - off.len()) as f64;
        if off.is_empty() || on_board < FULL * self.board.ring_count() as f64 {
            return;
        }
        for &(label, (line, length)) in &off {
            let seen = off.iter().filter(|(_, (other, _))| *other == line).count();
            if (seen as f64) < GOES_ON * f64::from(length) {
                self.rings.remove(&label);
            }
        }
        self.settle_places();
    }

    /// Rows and columns seen, where a row or column of rings stands one step beyond the board: then this is a part of something larger.
    pub(super) fn goes_on(&self, numbering: Numbering, which: Beside) -> Option<(usize, usize)> {
        let (rows, columns) = (self.board.rows(), self.board.columns());
        let row = |row: i32| {
            (0..i32::from(columns))
                .map(|column| (column, row))
                .collect()
        };
        let column = |column: i32| (0..i32::from(rows)).map(|row| (column, row)).collect();
        let lines = [
            row(-1),
            row(i32::from(rows)),
            column(-1),
            column(i32::from(columns)),
        ];
        let usual = self.usual();
        let lines = lines.into_par_iter();
        let shows: Vec<bool> = lines
            .map(|line: Vec<Label>| self.is_line(numbering, line, which, &usual))
            .collect();
        let further = |lines: &[bool]| lines.iter().filter(|&&line| line).count();
        let (more_rows, more_columns) = (further(&shows[..2]), further(&shows[2..]));
        let size = (
            usize::from(rows) + more_rows,
            usize::from(columns) + more_columns,
        );
        (more_rows + more_columns > 0).then_some(size)
    }

    /// Whether at least half of a line of places have a ring.
    fn is_line(
        &self,
        numbering: Numbering,
        line: Vec<Label>,
        which: Beside,
        usual: &Usual,
    ) -> bool {
        let wanted = (GOES_ON * line.len() as f64).ceil() as usize;
        let (mut seen, mut left) = (0, line.len());
        for place in line {
            // as soon as it is known, nothing more is measured
            if seen >= wanted || seen + left < wanted {
                break;
            }
            left -= 1;
            let label = numbering.label(place);
            let ring = self.rings.get(&label).copied().or_else(|| {
                let printed = self.is_printed(label, LEAST_CONTRAST * usual.contrast);
                printed.then(|| self.look_at(label)).flatten()
            });
            let counts = |ring: &RingFit| which == Beside::Any || self.is_as(label, ring, usual);
            seen += usize::from(ring.as_ref().is_some_and(counts));
        }
        seen >= wanted
    }

    /// What the rings of the board usually are.
    fn usual(&self) -> Usual {
        let middle = |of: fn(&RingFit) -> f64| {
            let mut values: Vec<f64> = self.rings.values().map(of).collect();
            median(&mut values)
        };
        let drowned = self.rings.values().filter(|ring| ring.inner.is_none());
        Usual {
            contrast: middle(|ring| ring.contrast),
            blur_px: middle(|ring| ring.blur_sigma_px),
            drowned: 2 * drowned.count() > self.rings.len(),
        }
    }

    /// Whether a ring at a place is as those of the board.
    fn is_as(&self, label: Label, ring: &RingFit, usual: &Usual) -> bool {
        let within =
            |own: f64, usual: f64, factor: f64| own <= factor * usual && factor * own >= usual;
        let (Some(place), Some(size)) =
            (self.places.expect(label), self.relative_size(label, ring))
        else {
            return false;
        };
        within(ring.contrast, usual.contrast, CONTRASTS)
            && within(1.0 + ring.blur_sigma_px, 1.0 + usual.blur_px, BLURS)
            && ring.inner.is_none() == usual.drowned
            && self.is_as_lit(label, ring)
            && size.ln().abs() < SIZES
            && (ring.outer.centre - place.at).norm() < MISPLACED * place.step_px()
    }

    /// Whether a ring has about the contrast of those next to it, which is asked where blur makes spots of edges: of these, most are fainter.
    fn is_as_lit(&self, label: Label, ring: &RingFit) -> bool {
        !self.is_heavily_blurred()
            || self.contrast_around(label).is_none_or(|around| {
                ring.contrast <= NEXT_CONTRASTS * around && NEXT_CONTRASTS * ring.contrast >= around
            })
    }

    /// Whether a place has at least this contrast of paper and ring, which costs much less to see than to measure a ring. Where a part
    /// of that lies outside the frame it may have.
    fn is_printed(&self, label: Label, least: f64) -> bool {
        spot(self.frame, self.board, &self.places, label)
            .is_none_or(|spot| spot.contrast.abs() >= least)
    }

    /// Whether a place one step beyond the lattice lies outside the frame (or so near its border that a ring there is
    /// cut).
    pub(super) fn is_cut_off(
        &self,
        numbering: Numbering,
        columns: (i32, i32),
        rows: (i32, i32),
    ) -> bool {
        let ring = self.board.outer_radius_m() / self.board.pitch_m();
        let inside = |place: Label| {
            self.places.expect(numbering.label(place)).is_some_and(|p| {
                let margin = ring * p.step_px();
                let within = |v: f64, size: usize| v >= margin && v <= size as f64 - 1.0 - margin;
                within(p.at.x, self.frame.width()) && within(p.at.y, self.frame.height())
            })
        };
        let beyond = |i: i32, (first, last): (i32, i32)| i < first || i > last;
        (rows.0 - 1..=rows.1 + 1)
            .flat_map(|row| (columns.0 - 1..=columns.1 + 1).map(move |column| (column, row)))
            .filter(|&(column, row)| beyond(column, columns) || beyond(row, rows))
            .any(|place| !inside(place))
    }
}

/// What is usual on a board.
struct Usual {
    contrast: f64,
    blur_px: f64,
    /// Most inner discs do not show.
    drowned: bool,
}
