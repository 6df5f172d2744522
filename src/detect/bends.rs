//! How a lens bends a lattice: what rings lie off the places that their homography gives them, smoothed.
//!
//! A ring is expected where those around it lie, itself left out: a quadratic through their bends, the nearer ones counting more. What
//! the quadratic says in its middle is a weighted sum of the bends around, and the weights follow from which places have a ring
//! at all. So every place of a lattice is solved for once, when the lattice changes, and not each time that somebody asks.

use super::labelling::{Label, extent};
use nalgebra::{SMatrix, SVector, Vector2};
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// Rings this many steps away and nearer say how the lens bends a place.
const REACH: i32 = 2;
/// Places within reach to either side.
const SIDE: i32 = 2 * REACH + 1;
/// How stiff the quadratic is in its constant, linear and square terms, relative to the rings that say how the lens bends: enough for few of
/// them to leave it alone.
const STIFFNESS: [f64; 6] = [0.0, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3];

/// What the rings of a lattice say of every place.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Bends {
    /// The first column and row that a ring is within reach of.
    first: Label,
    columns: i32,
    /// By row, then column, px.
    smooth: Vec<Vector2<f64>>,
}

impl Bends {
    /// Of rings that lie that far (px) from where the homography puts them.
    pub(super) fn of(rings: &BTreeMap<Label, Vector2<f64>>) -> Self {
        if rings.is_empty() {
            return Self {
                first: (0, 0),
                columns: 0,
                smooth: Vec::new(),
            };
        }
        let ((left, right), (top, bottom)) = extent(rings.keys().copied());
        let first = (left - REACH, top - REACH);
        let (columns, rows) = (right - left + SIDE, bottom - top + SIDE);
        let at = |(column, row): Label| ((row - first.1) * columns + column - first.0) as usize;
        let mut around = vec![0_u32; (columns * rows) as usize];
        let mut own = vec![Vector2::zeros(); around.len()];
        for (&label, &bend) in rings {
            own[at(label)] = bend;
            for (k, neighbour) in NEIGHBOURS.iter().enumerate() {
                // the ring is that neighbour of the place on its other side
                let (dx, dy) = neighbour.step;
                around[at((label.0 - dx, label.1 - dy))] |= 1 << k;
            }
        }
        let mut known = (0, None);
        let smooth = around.iter().enumerate().map(|(place, &mask)| {
            if mask != known.0 {
                known = (mask, solved(mask));
            }
            known.1.map_or_else(Vector2::zeros, |quadratic| {
                let parts = those_of(mask).map(|neighbour| {
                    let (dx, dy) = neighbour.step;
                    let there = (place as i32 + dy * columns + dx) as usize;
                    own[there] * (neighbour.weight * neighbour.terms.dot(&quadratic))
                });
                parts.sum()
            })
        });
        Self {
            first,
            columns,
            smooth: smooth.collect(),
        }
    }

    /// How the rings around a label bend, px; nothing where there is none.
    pub(super) fn at(&self, label: Label) -> Vector2<f64> {
        let (x, y) = (label.0 - self.first.0, label.1 - self.first.1);
        if x < 0 || y < 0 || x >= self.columns {
            return Vector2::zeros();
        }
        let bend = self
            .smooth
            .get(y as usize * self.columns as usize + x as usize);
        bend.copied().unwrap_or_default()
    }
}

/// A place within reach of another.
struct Neighbour {
    step: Label,
    weight: f64,
    /// Those of the quadratic there.
    terms: SVector<f64, 6>,
    /// What it adds to the normal matrix.
    normal: SMatrix<f64, 6, 6>,
}

/// All places within reach of one, itself left out.
static NEIGHBOURS: LazyLock<Vec<Neighbour>> = LazyLock::new(|| {
    let all = (0..SIDE * SIDE).map(|k| (k % SIDE - REACH, k / SIDE - REACH));
    let others = all.filter(|&step| step != (0, 0));
    others
        .map(|step| {
            let (x, y) = (f64::from(step.0), f64::from(step.1));
            let weight = (x * x + y * y).recip();
            let terms = SVector::from([1.0, x, y, x * x, x * y, y * y]);
            Neighbour {
                step,
                weight,
                terms,
                normal: terms * terms.transpose() * weight,
            }
        })
        .collect()
});

/// Those of a mask.
fn those_of(mask: u32) -> impl Iterator<Item = &'static Neighbour> {
    let all = NEIGHBOURS.iter().enumerate();
    all.filter(move |(k, _)| mask >> k & 1 == 1).map(|(_, n)| n)
}

/// What the constant of the quadratic through the places of a mask takes of each term; where they are too few for a quadratic that is
/// little more than their mean. `None` where there are none.
fn solved(mask: u32) -> Option<SVector<f64, 6>> {
    let mut normal = SMatrix::<f64, 6, 6>::zeros();
    for neighbour in those_of(mask) {
        normal += neighbour.normal;
    }
    let count = normal[(0, 0)];
    if count <= 0.0 {
        return None;
    }
    for (k, stiffness) in STIFFNESS.into_iter().enumerate() {
        normal[(k, k)] += stiffness * count;
    }
    Some(normal.cholesky()?.solve(&SVector::ith(0, 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadratic_is_continued_and_a_lone_ring_bends_its_neighbours_alike() {
        let bend = |(x, y): Label| {
            let (x, y) = (f64::from(x), f64::from(y));
            Vector2::new(0.3 - 0.1 * x + 0.02 * x * y, 0.2 * y - 0.03 * x * x)
        };
        let labels = (-2..5).flat_map(|y| (1..7).map(move |x| (x, y)));
        let rings = labels.map(|label| (label, bend(label))).collect();
        let bends = Bends::of(&rings);
        for label in [(3, 1), (1, -2), (6, 4)] {
            assert!((bends.at(label) - bend(label)).norm() < 0.02, "{label:?}");
        }
        assert_eq!(bends.at((9, 0)), Vector2::zeros());
        assert_eq!(bends.at((3, 99)), Vector2::zeros());
        let one = Bends::of(&BTreeMap::from([((2, 2), Vector2::new(1.0, -2.0))]));
        assert_eq!(one.at((2, 2)), Vector2::zeros());
        assert!((one.at((3, 2)) - Vector2::new(1.0, -2.0)).norm() < 0.01);
        assert_eq!(Bends::of(&BTreeMap::new()).at((0, 0)), Vector2::zeros());
    }
}
