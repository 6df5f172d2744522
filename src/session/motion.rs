//! How far the rings moved between two views, whatever their labels.
//!
//! A board without marks fits its own labels in two ways (rows != columns) or four (square), and a board seen in part
//! numbers its rings from the first one seen. So the same board in the same place may be labelled differently in two
//! frames. Here two views are laid over one another in every way that fits and the closest one counts.

use super::View;
use crate::detect::{Indices, Ring};
use nalgebra::Point2;
use std::collections::HashMap;

/// Motion of the rings that two views share, px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Average over the rings.
    pub mean_px: f64,
    /// Largest of any ring.
    pub max_px: f64,
}

/// A label of `a` as a label of `b`: a rotation by quarter turns, then a shift.
#[derive(Debug, Clone, Copy)]
struct Relabel {
    quarter_turns: u8,
    row_shift: i32,
    column_shift: i32,
}

impl Relabel {
    fn apply(self, row: u16, column: u16) -> (i32, i32) {
        let (row, column) = turned(self.quarter_turns, row, column);
        (row + self.row_shift, column + self.column_shift)
    }
}

fn turned(quarter_turns: u8, row: u16, column: u16) -> (i32, i32) {
    let (row, column) = (i32::from(row), i32::from(column));
    match quarter_turns {
        0 => (row, column),
        1 => (column, -row),
        2 => (-row, -column),
        _ => (-column, row),
    }
}

/// Motion between two views; `None` where no way of laying them over one another makes half of the rings of the
/// smaller view meet.
pub fn motion(a: &View, b: &View) -> Option<Motion> {
    let of_b: HashMap<(i32, i32), Point2<f64>> = b
        .rings
        .iter()
        .map(|r| ((i32::from(r.row), i32::from(r.column)), r.centre.point))
        .collect();
    let needed = a.rings.len().min(b.rings.len()).div_ceil(2).max(1);
    (0..4)
        .filter_map(|quarter_turns| shifted(quarter_turns, a, b))
        .filter_map(|relabel| distances(relabel, &a.rings, &of_b, needed))
        .min_by(|m, n| m.mean_px.total_cmp(&n.mean_px))
}

/// The shift that completes a rotation: extents onto extents where both are known whole, else the middle ring of `a`
/// onto the ring of `b` next to it in the picture.
fn shifted(quarter_turns: u8, a: &View, b: &View) -> Option<Relabel> {
    let (row, column) = if a.indices == Indices::Absolute && b.indices == Indices::Absolute {
        let extent = |labels: &mut dyn Iterator<Item = (i32, i32)>| {
            labels.fold((i32::MAX, i32::MAX, i32::MIN, i32::MIN), |e, l| {
                (e.0.min(l.0), e.1.min(l.1), e.2.max(l.0), e.3.max(l.1))
            })
        };
        let from = extent(
            &mut a
                .rings
                .iter()
                .map(|r| turned(quarter_turns, r.row, r.column)),
        );
        let to = extent(&mut b.rings.iter().map(|r| turned(0, r.row, r.column)));
        let same_size = from.2 - from.0 == to.2 - to.0 && from.3 - from.1 == to.3 - to.1;
        if a.rings.is_empty() || b.rings.is_empty() || !same_size {
            return None;
        }
        (to.0 - from.0, to.1 - from.1)
    } else {
        let middle = a.rings.get(a.rings.len() / 2)?;
        let next = b.rings.iter().min_by(|r, s| {
            let distance = |ring: &Ring| (ring.centre.point - middle.centre.point).norm();
            distance(r).total_cmp(&distance(s))
        })?;
        let from = turned(quarter_turns, middle.row, middle.column);
        (
            i32::from(next.row) - from.0,
            i32::from(next.column) - from.1,
        )
    };
    Some(Relabel {
        quarter_turns,
        row_shift: row,
        column_shift: column,
    })
}

fn distances(
    relabel: Relabel,
    rings: &[Ring],
    of_b: &HashMap<(i32, i32), Point2<f64>>,
    needed: usize,
) -> Option<Motion> {
    let (mut sum, mut max, mut count) = (0.0, 0.0_f64, 0_usize);
    for ring in rings {
        if let Some(point) = of_b.get(&relabel.apply(ring.row, ring.column)) {
            let distance = (point - ring.centre.point).norm();
            sum += distance;
            max = max.max(distance);
            count += 1;
        }
    }
    (count >= needed).then(|| Motion {
        mean_px: sum / count as f64,
        max_px: max,
    })
}
