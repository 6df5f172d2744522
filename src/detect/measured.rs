//! The rings of a lattice, the missing ones looked for where they must be.

use super::edges::median;
use super::labelling::{Label, Lattice, extent};
use super::light::is_clipped;
use super::orientation::{Numbering, choose};
use super::places::{Places, line_leads};
use super::plausible::has_the_ratio;
use super::ring_fit::{Care, RingFit, measure, measure_disc};
use crate::board::Board;
use crate::centre::RingEllipses;
use crate::frame::Frame;
use nalgebra::Point2;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// A ring is taken for one of the board's if its size is that of the others within this (logarithm).
const SAME_SIZE: f64 = 0.5;
/// A ring this much smaller or larger (logarithm) than the board says is seen with its contrast inverted.
const ALIKE: f64 = 0.25;
/// Where less than one in so many gaps has a ring, most are none of a board.
const FEW: usize = 4;
/// A place that moved by less than this fraction of the step to the next one shows nothing new.
const MOVED: f64 = 0.05;

/// A row or column that leads farther away than this fraction of the step leads to another place.
const ELSEWHERE: f64 = 0.1;

/// A lattice whose members are measured rings, and what is needed to measure more.
#[derive(Clone)]
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
    pub(super) fn new(
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
    /// beyond it on each side, as long as that finds any. A place that came to nothing is looked at again only where further rings have
    /// moved it.
    ///
    /// Where the lattice has more gaps than a board with the `least` rings that do, these are looked at first, and nothing more if nearly
    /// all of them stay empty: texture has such lattices.
    pub(super) fn complete(&mut self, least: usize) {
        let most_gaps = self.board.ring_count().saturating_sub(least);
        let mut tried: BTreeMap<Label, Point2<f64>> = BTreeMap::new();
        for _ in 0..self.board.rows().max(self.board.columns()) {
            let Some((gaps, beside)) = self.free_places() else {
                return;
            };
            let has_gaps = gaps.len() > most_gaps;
            let places = if has_gaps {
                gaps
            } else {
                [gaps, beside].concat()
            };
            let to_try = self.moved(places, &mut tried);
            let looked_at = to_try.len();
            let found: Vec<(Label, RingFit)> = to_try
                .into_par_iter()
                .filter_map(|label| Some((label, self.look_at(label)?)))
                .collect();
            if found.is_empty() || (has_gaps && FEW * found.len() < looked_at) {
                return;
            }
            self.rings.extend(found);
            self.settle_places();
        }
    }

    /// Those of the places that have not been tried where they are now; from now on they have.
    fn moved(
        &self,
        mut labels: Vec<Label>,
        tried: &mut BTreeMap<Label, Point2<f64>>,
    ) -> Vec<Label> {
        labels.retain(|&label| {
            let Some(place) = self.places.expect(label) else {
                return false;
            };
            let near = |at: &Point2<f64>| (place.at - at).norm() < MOVED * place.step_px();
            let known = tried.get(&label).is_some_and(near);
            if !known {
                tried.insert(label, place.at);
            }
            !known
        });
        labels
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

    /// Whether the inner circles are as large as the board file says, as far as edges tell.
    pub(super) fn has_the_ratio(&self) -> bool {
        has_the_ratio(self.board, &self.rings, None)
            || is_clipped(self.frame) && has_the_ratio(self.board, &self.rings, Some(self.sign))
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

    /// Labels without a ring: within the lattice, and those of the board beside it, or next to it where it is smaller than the board.
    fn free_places(&self) -> Option<(Vec<Label>, Vec<Label>)> {
        let numbering = self.numbering()?;
        let ((left, right), (top, bottom)) = extent(self.rings.keys().map(|&l| numbering.of(l)));
        let within = |label: &Label| {
            let (column, row) = numbering.of(*label);
            (left..=right).contains(&column) && (top..=bottom).contains(&row)
        };
        let grow = |first: i32, last: i32, size: i32| {
            if last - first + 1 < size {
                (first - 1, last + 1)
            } else {
                (first.max(0), last.min(size - 1))
            }
        };
        let (first, last) = grow(left, right, i32::from(self.board.columns()));
        let (above, below) = grow(top, bottom, i32::from(self.board.rows()));
        let places = (above..=below)
            .flat_map(|row| (first..=last).map(move |column| (column, row)))
            .map(|place| numbering.label(place))
            .filter(|label| !self.rings.contains_key(label))
            .partition(within);
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

    /// Measures a ring where the homography says it is, or where its row or column leads: before a wide lens rings beside those that are
    /// known stand up to half a step from the first.
    pub(super) fn look_at(&self, label: Label) -> Option<RingFit> {
        let place = self.places.expect(label)?;
        let rough = self.predicted_ellipses(label)?;
        let step_px = place.step_px();
        self.look_near(place.at, &rough, step_px).or_else(|| {
            let at = self.along_line(label)?;
            let off = at - place.at;
            if off.norm() <= ELSEWHERE * step_px {
                return None;
            }
            let mut moved = rough;
            moved.inner.centre += off;
            moved.outer.centre += off;
            self.look_near(at, &moved, step_px)
        })
    }

    fn look_near(&self, at: Point2<f64>, rough: &RingEllipses, step_px: f64) -> Option<RingFit> {
        let ratio = self.board.radius_ratio();
        let ring = measure(self.frame, rough, self.sign, ratio, self.care)
            .or_else(|| measure_disc(self.frame, &rough.outer, self.sign, ratio, self.care))?;
        let near = (ring.outer.centre - at).norm() < 0.25 * step_px;
        let relative = ring.outer.major / (self.size * rough.outer.major);
        let alike = relative.ln().abs() < SAME_SIZE;
        (near && alike).then_some(ring)
    }

    /// Where the next three rings of its row or column lead, by the parabola through them.
    fn along_line(&self, (column, row): Label) -> Option<Point2<f64>> {
        let directions = [(1, 0), (-1, 0), (0, 1), (0, -1)];
        directions.into_iter().find_map(|(across, down)| {
            let next = |k: i32| {
                let label = (column + k * across, row + k * down);
                Some(self.rings.get(&label)?.outer.centre)
            };
            Some(line_leads(next(1)?, next(2)?, next(3)?))
        })
    }

    /// How large a ring looks at its place, over how large the others do.
    pub(super) fn relative_size(&self, label: Label, ring: &RingFit) -> Option<f64> {
        let expected = self.predicted_ellipses(label)?.outer.mean_radius();
        Some(ring.outer.mean_radius() / (self.size * expected))
    }

    /// The two ellipses of a measured ring.
    pub(super) fn ellipses(&self, label: Label, ring: &RingFit) -> Option<RingEllipses> {
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
}
