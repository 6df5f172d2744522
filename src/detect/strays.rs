//! Spots in a lattice that are none of the board's rings.
//!
//! Under blur as heavy as the rings are wide, the sheet's edge and whatever is beside it make round spots, too, and a large disc makes two
//! outlines of some rings: that of the ring, and that of the patch in its middle. One such spot in a lattice moves the places of all,
//! or makes another size of it. Print beside a sharp board does it, too. But it is not like its neighbours. The oddest are left out first,
//! since an odd one moves the places of the others; where a ring must be, it is looked for by its grey values later.

use super::edges::median;
use super::labelling::Label;
use super::measured::Measured;
use super::ring_fit::RingFit;

/// Blur sigma over the ring's width from which on spots are asked.
const HEAVY: f64 = 0.25;
/// How much fainter than its neighbours' a ring's contrast may be: a shadow's edge is blurred as they are.
const FAINT: f64 = 3.0;
/// How much larger or smaller than the others' (logarithm) its outline may be.
const SIZES: f64 = 0.4;
/// How far from its place it may stand, in steps.
const MISPLACED: f64 = 0.2;
/// So few neighbours say nothing.
const FEW: usize = 3;
/// Those nearly as odd as the oddest are left out with it, its oddity times this: the lattices that text makes have many.
const AS_ODD: f64 = 0.6;
/// No more than one in so many is left out.
const MOST_LEFT_OUT: usize = 3;

impl Measured<'_> {
    /// Leaves out what is not like the rings around it; whether there was any.
    pub(super) fn leave_out_unlike(&mut self) -> bool {
        let before = self.rings.len();
        let least = before - before / MOST_LEFT_OUT;
        loop {
            let odd = self
                .rings
                .iter()
                .map(|(&l, ring)| (self.oddity(l, ring), l));
            let mut odd: Vec<(f64, Label)> = odd.collect();
            odd.sort_by(|a, b| b.0.total_cmp(&a.0));
            let worst = odd.first().map_or(0.0, |odd| odd.0);
            odd.retain(|&(oddity, _)| oddity > (AS_ODD * worst).max(1.0));
            odd.truncate(self.rings.len() - least);
            if odd.is_empty() {
                return self.rings.len() < before;
            }
            for (_, label) in odd {
                self.rings.remove(&label);
            }
            self.settle_places();
        }
    }

    /// Whether most inner discs have drowned, or edges are not where they seem to be.
    pub(super) fn is_heavily_blurred(&self) -> bool {
        let drowned = self.rings.values().filter(|ring| ring.inner.is_none());
        let ring = 1.0 - self.board.radius_ratio();
        let blur = |fit: &RingFit| fit.blur_sigma_px / (ring * fit.outer.minor);
        let mut blurs: Vec<f64> = self.rings.values().map(blur).collect();
        2 * drowned.count() > self.rings.len() || median(&mut blurs) > HEAVY
    }

    /// How unlike its neighbours a ring is: above 1 it is none.
    fn oddity(&self, label: Label, ring: &RingFit) -> f64 {
        let faint = self
            .contrast_within(label, 1)
            .or_else(|| self.contrast_within(label, 2))
            .map_or(0.0, |around| around / (FAINT * ring.contrast));
        let size = self
            .relative_size(label, ring)
            .map_or(f64::INFINITY, |size| size.ln().abs() / SIZES);
        let off = self.places.expect(label).map_or(f64::INFINITY, |place| {
            (ring.outer.centre - place.at).norm() / (MISPLACED * place.step_px())
        });
        faint.max(size).max(off)
    }

    /// The usual contrast of the rings next to a place; `None` where there are few.
    pub(super) fn contrast_around(&self, label: Label) -> Option<f64> {
        self.contrast_within(label, 1)
    }

    /// The same of those at most so many steps away.
    fn contrast_within(&self, (column, row): Label, steps: i32) -> Option<f64> {
        let next = (-steps..=steps)
            .flat_map(|down| (-steps..=steps).map(move |across| (column + across, row + down)));
        let mut contrasts: Vec<f64> = next
            .filter(|&next| next != (column, row))
            .filter_map(|next| Some(self.rings.get(&next)?.contrast))
            .collect();
        (contrasts.len() >= FEW).then(|| median(&mut contrasts))
    }
}
