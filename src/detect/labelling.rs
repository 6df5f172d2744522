//! Rings that stand in a grid: each gets a column and a row by walking from neighbour to neighbour.
//!
//! Every ring carries a scale of its own: in the coordinates in which its outer ellipse is the unit circle, its
//! neighbours stand at pitch over outer radius, at right angles, whatever the view.

use super::nodes::Nodes;
use super::places::Places;
use crate::centre::Ellipse;
use nalgebra::Vector2;
use std::collections::{BTreeMap, VecDeque};

/// A neighbour's distance over the expected one; a diagonal neighbour stands at 1.41.
const NEIGHBOUR: (f64, f64) = (0.7, 1.3);
/// How far the axes of a seed may be from a right angle (cosine).
const RIGHT_ANGLE: f64 = 0.4;
/// What a neighbour that is farther away (logarithm) loses against a nearer one, in cosines.
const NEARER: f64 = 0.6;
/// Of so many neighbours at most, the nearest, a walk's first two are chosen.
const MOST_NEIGHBOURS: usize = 24;
/// How far from its predicted place a ring may be, as a fraction of the step there.
const WALK_TOLERANCE: f64 = 0.3;
/// The same once all others predict.
const FIT_TOLERANCE: f64 = 0.2;
/// How much larger or smaller than a ring the next one may look (logarithm): blur that inverts the contrast of some rings lets these look
/// half as large.
const ALIKE: f64 = 0.8;
/// The same of candidates: what is most alike of several outlines of one ring is taken, and text is not, which has letters of any size.
const CANDIDATES_ALIKE: f64 = 0.4;
/// The least lattice that determines a plane.
const LEAST_MEMBERS: usize = 4;

/// Each ring is a step of so many walks at most, on average.
const MOST_STEPS: usize = 8;

/// Column and row of a lattice: the origin and the quarter turn are arbitrary, the handedness is not.
pub(super) type Label = (i32, i32);

/// Rings by their place in a lattice.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Lattice {
    /// Index of the ring at each label.
    pub(super) members: BTreeMap<Label, usize>,
    /// Where they lie in the frame.
    pub(super) places: Places,
}

/// The lattices that rings form, given by their outer ellipses: largest first; each ring is in at most one. `spacing` is pitch over
/// outer radius. Those through which a walk finds fewer than `least` rings are passed over: texture has such in plenty.
///
/// A walk may come to nothing and begin anew from each of its rings: all walks together take at most [`MOST_STEPS`] steps for each ring.
pub(super) fn lattices(outers: &[Ellipse], spacing: f64, least: usize) -> Vec<Lattice> {
    let nodes = Nodes::of(outers, ALIKE);
    let settled = |free: &[bool], members| settle(&nodes, free, members);
    let mut found = walk_all(&nodes, spacing, least, settled, |lattice| {
        lattice.members.values().copied().collect()
    });
    found.sort_by_key(|l| std::cmp::Reverse(l.members.len()));
    found
}

/// The rings of such lattices before those that do not agree with the others are left out and those that are missed are added: to see
/// which are worth measuring, that will do.
pub(super) fn walks(outers: &[Ellipse], spacing: f64, least: usize) -> Vec<Vec<usize>> {
    let nodes = Nodes::of(outers, CANDIDATES_ALIKE);
    let members = |_: &[bool], members: BTreeMap<Label, usize>| {
        Some(members.into_values().collect::<Vec<usize>>())
    };
    let mut found = walk_all(&nodes, spacing, least, members, Clone::clone);
    found.sort_by_key(|walk| std::cmp::Reverse(walk.len()));
    found
}

/// What becomes of the walks from all rings that no earlier one has taken.
fn walk_all<L>(
    nodes: &Nodes,
    spacing: f64,
    least: usize,
    becomes: impl Fn(&[bool], BTreeMap<Label, usize>) -> Option<L>,
    members: impl Fn(&L) -> Vec<usize>,
) -> Vec<L> {
    let count = nodes.all.len();
    let mut free = vec![true; count];
    let mut found = Vec::new();
    let mut steps = 0;
    for seed in 0..count {
        if !free[seed] || steps > MOST_STEPS * count {
            continue;
        }
        let Some(walk) = grow(nodes, &free, seed, spacing) else {
            continue;
        };
        steps += walk.len();
        if walk.len() < least.max(LEAST_MEMBERS) {
            continue;
        }
        let Some(lattice) = becomes(&free, walk) else {
            continue;
        };
        for member in members(&lattice) {
            free[member] = false;
        }
        found.push(lattice);
    }
    found
}

/// Labels reached from a seed by steps that the seed's two axes predict and the walk updates.
fn grow(nodes: &Nodes, free: &[bool], seed: usize, spacing: f64) -> Option<BTreeMap<Label, usize>> {
    let axes = seed_axes(nodes, free, seed, spacing)?;
    let mut members = BTreeMap::from([((0, 0), seed)]);
    let mut taken = vec![false; nodes.all.len()];
    taken[seed] = true;
    let mut queue = VecDeque::from([((0, 0), axes)]);
    while let Some((label, axes)) = queue.pop_front() {
        let from = members[&label];
        let here = nodes.all[from].centre;
        for (axis, direction) in [(0, 1), (0, -1), (1, 1), (1, -1)] {
            let next = if axis == 0 {
                (label.0 + direction, label.1)
            } else {
                (label.0, label.1 + direction)
            };
            let step = axes[axis] * f64::from(direction);
            let usable = |i: usize| free[i] && !taken[i] && nodes.are_alike(from, i);
            if members.contains_key(&next) {
                continue;
            }
            let Some(at) = nodes.nearest(here + step, WALK_TOLERANCE * step.norm(), usable) else {
                continue;
            };
            taken[at] = true;
            members.insert(next, at);
            let mut moved = axes;
            moved[axis] = (nodes.all[at].centre - here) * f64::from(direction);
            queue.push_back((next, moved));
        }
    }
    Some(members)
}

/// The two neighbours of a seed that stand best at a right angle, as steps of the column and of the row.
fn seed_axes(nodes: &Nodes, free: &[bool], seed: usize, spacing: f64) -> Option<[Vector2<f64>; 2]> {
    let range = NEIGHBOUR.0 * spacing..NEIGHBOUR.1 * spacing;
    let here = &nodes.all[seed];
    let mut neighbours: Vec<(Vector2<f64>, Vector2<f64>)> = nodes
        .nearby
        .within(here.centre, range.end * here.major_px)
        .filter(|&(i, _)| i != seed && free[i] && nodes.are_alike(seed, i))
        .map(|(i, _)| (&nodes.all[i], nodes.all[i].centre - here.centre))
        .filter(|(node, step)| {
            range.contains(&(here.to_unit * step).norm())
                && range.contains(&(node.to_unit * step).norm())
        })
        .map(|(_, step)| (step, here.to_unit * step))
        .collect();
    // every two of them are compared: of text there may be hundreds
    if neighbours.len() > MOST_NEIGHBOURS {
        neighbours.sort_by(|a, b| a.1.norm().total_cmp(&b.1.norm()));
        neighbours.truncate(MOST_NEIGHBOURS);
    }
    let mut best: Option<(f64, [Vector2<f64>; 2])> = None;
    for (column, unit_column) in &neighbours {
        for (row, unit_row) in &neighbours {
            let cosine = unit_column.normalize().dot(&unit_row.normalize()).abs();
            let stretch = (unit_column.norm() / unit_row.norm()).ln().abs();
            // a grid's diagonals stand at a right angle too, and blur makes rings look larger: the nearer are the neighbours
            let length = 0.5 * (unit_column.norm() * unit_row.norm()).ln();
            let score = cosine + stretch + NEARER * length;
            let right_handed = column.perp(row) > 0.0;
            if right_handed && cosine < RIGHT_ANGLE && best.is_none_or(|(b, _)| score < b) {
                best = Some((score, [*column, *row]));
            }
        }
    }
    best.map(|(_, axes)| axes)
}

/// Learns where the labels lie, drops the rings that disagree with the others and adds those that are expected.
fn settle(nodes: &Nodes, free: &[bool], mut members: BTreeMap<Label, usize>) -> Option<Lattice> {
    let mut places = places(nodes, &members)?;
    for _ in 0..8 {
        let before = members.clone();
        members.retain(|&label, &mut at| {
            places.expect(label).is_some_and(|place| {
                (nodes.all[at].centre - place.at).norm() < FIT_TOLERANCE * place.step_px()
            })
        });
        let left = members.len();
        if left < before.len() {
            places = self::places(nodes, &members)?;
        }
        add_expected(nodes, free, &places, &mut members);
        if members == before {
            break;
        }
        if members.len() > left {
            places = self::places(nodes, &members)?;
        }
    }
    Some(Lattice { members, places })
}

/// Adds what stands where a lattice expects further rings.
fn add_expected(
    nodes: &Nodes,
    free: &[bool],
    places: &Places,
    members: &mut BTreeMap<Label, usize>,
) {
    let mut taken = vec![false; nodes.all.len()];
    members.values().for_each(|&at| taken[at] = true);
    for label in around(members) {
        let Some(place) = places.expect(label) else {
            continue;
        };
        let usable = |i: usize| free[i] && !taken[i];
        let tolerance_px = FIT_TOLERANCE * place.step_px();
        if let Some(at) = nodes.nearest(place.at, tolerance_px, usable) {
            taken[at] = true;
            members.insert(label, at);
        }
    }
}

fn places(nodes: &Nodes, members: &BTreeMap<Label, usize>) -> Option<Places> {
    Places::fit(
        members
            .iter()
            .map(|(&label, &at)| (label, nodes.all[at].centre)),
    )
}

/// Free labels within one step of the labels' extent.
fn around(members: &BTreeMap<Label, usize>) -> Vec<Label> {
    let ((left, right), (top, bottom)) = extent(members.keys().copied());
    (top - 1..=bottom + 1)
        .flat_map(|row| (left - 1..=right + 1).map(move |column| (column, row)))
        .filter(|label| !members.contains_key(label))
        .collect()
}

/// First and last column, first and last row.
pub(super) fn extent(labels: impl Iterator<Item = Label>) -> ((i32, i32), (i32, i32)) {
    labels.fold(
        ((i32::MAX, i32::MIN), (i32::MAX, i32::MIN)),
        |((left, right), (top, bottom)), (column, row)| {
            (
                (left.min(column), right.max(column)),
                (top.min(row), bottom.max(row)),
            )
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point2;

    fn disc(x: f64, y: f64, radius: f64) -> Ellipse {
        Ellipse {
            centre: Point2::new(x, y),
            major: radius,
            minor: radius,
            angle: 0.0,
        }
    }

    #[test]
    fn letters_that_stand_as_the_next_column_but_are_of_another_size_are_not_walked_to() {
        let rings = (0..20).map(|i| disc(f64::from(i % 5 * 30), f64::from(i / 5 * 30), 10.0));
        let letters = |radius: f64| (0..4).map(move |row| disc(150.0, f64::from(row * 30), radius));
        let walked = |radius: f64| {
            let all: Vec<Ellipse> = rings.clone().chain(letters(radius)).collect();
            walks(&all, 3.0, 4)[0].len()
        };
        assert_eq!(walked(10.0), 24);
        assert_eq!(walked(16.0), 20);
        assert_eq!(walked(6.0), 20);
    }

    #[test]
    fn of_several_outlines_of_each_ring_those_that_are_alike_make_the_lattice() {
        // a small spot a little nearer to each place than the ring's outline
        let rings = (0..20).flat_map(|i| {
            let (x, y) = (f64::from(i % 5 * 30), f64::from(i / 5 * 30));
            let spot = if i % 2 == 0 { 3.0 } else { 4.0 };
            [disc(x, y, spot), disc(x + 0.3, y, 10.0)]
        });
        let all: Vec<Ellipse> = rings.collect();
        let walk = &walks(&all, 3.0, 15)[0];
        assert_eq!(walk.len(), 20);
        assert!(walk.iter().all(|&at| all[at].major == 10.0));
    }
}
