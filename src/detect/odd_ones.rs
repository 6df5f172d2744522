//! Rings that were measured but are none: what covers a ring has an edge, too, and a fit may settle on it.
//!
//! What a fit has settled on then stands beside the place that the other rings give it, or is blurred as none of its neighbours is.
//! One ring after the other is left out, the oddest first, since an odd one moves the places of the others.

use super::detection::Ring;
use super::edges::median;
use super::labelling::Label;
use super::places::{Places, line_leads};
use nalgebra::Point2;
use std::collections::BTreeMap;

/// How far a ring may stand from where the others expect it: in its minor semi-axes, and in distances of the median ring. A strong lens
/// leaves half of that at a board's corners.
const FARTHEST: f64 = 0.15;
/// The same where its grey values could not be fitted, and edges alone say where it is: what covers a ring makes edges, too.
const FARTHEST_BY_EDGES: f64 = 0.025;
const TIMES_USUAL: f64 = 4.0;
/// Blur over that of the rings around it, and the difference that counts at least, px. Blur changes over a tilted board, but not at once.
const BLURS: f64 = 2.0;
const LEAST_BLUR_PX: f64 = 1.0;
/// Rings this many steps away and nearer are around one.
const AROUND: i32 = 2;
/// So few say nothing about each other.
const FEW: usize = 6;
/// No more than one in so many is left out: where more are odd, they are not the exception.
const MOST_LEFT_OUT: usize = 4;

/// Leaves out what stands or is blurred as the others do not.
pub(super) fn leave_out_odd_ones(rings: &mut Vec<Ring>) {
    leave_out_misplaced(rings);
    let sharpness: Vec<(Label, f64)> = rings
        .iter()
        .filter(|ring| ring.kept.is_some())
        .map(|ring| (label(ring), ring.blur_sigma_px))
        .collect();
    let is_odd = |ring: &Ring| ring.kept.is_some() && is_blurred_otherwise(ring, &sharpness);
    let odd = rings.iter().filter(|ring| is_odd(ring)).count();
    if odd <= rings.len() / MOST_LEFT_OUT {
        rings.retain(|ring| !is_odd(ring));
    }
}

fn leave_out_misplaced(rings: &mut Vec<Ring>) {
    for _ in 0..rings.len() / MOST_LEFT_OUT {
        let known = rings.iter().map(|ring| (label(ring), ring.centre.point));
        let at: BTreeMap<Label, Point2<f64>> = known.clone().collect();
        let Some(places) = Places::fit(known).filter(|_| rings.len() >= FEW) else {
            return;
        };
        let off: Vec<f64> = rings.iter().map(|ring| off(ring, &places, &at)).collect();
        let usual = TIMES_USUAL * median(&mut off.clone());
        let odd = off.iter().zip(rings.iter()).enumerate();
        let odd = odd
            .map(|(i, (off, ring))| (i, off - usual - farthest(ring) * ring.ellipses.outer.minor))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((worst, _)) = odd.filter(|&(_, beyond)| beyond > 0.0) else {
            return;
        };
        rings.remove(worst);
    }
}

/// How far a ring may stand from its place, in minor semi-axes.
fn farthest(ring: &Ring) -> f64 {
    match ring.kept {
        Some(_) => FARTHEST,
        None => FARTHEST_BY_EDGES,
    }
}

fn label(ring: &Ring) -> Label {
    (i32::from(ring.column), i32::from(ring.row))
}

/// How far a ring stands from where the others expect it, px: all of them, or the next three or four of its row or column. In the corners of a fisheye's
/// frame the first is off by half a radius.
fn off(ring: &Ring, places: &Places, at: &BTreeMap<Label, Point2<f64>>) -> f64 {
    let (column, row) = label(ring);
    let mut all: Vec<Point2<f64>> = Vec::with_capacity(9);
    all.extend(places.expect((column, row)).map(|place| place.at));
    for (across, down) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
        let next = |k: i32| at.get(&(column + k * across, row + k * down));
        if let (Some(a), Some(b), Some(c)) = (next(1), next(2), next(3)) {
            // the parabola through three, and the cubic through four
            let parabola = line_leads(*a, *b, *c);
            all.push(parabola);
            all.extend(next(4).map(|d| parabola + (a - b) - 2.0 * (b - c) + (c - d)));
        }
    }
    let off = all
        .iter()
        .map(|expected| (ring.centre.point - expected).norm());
    off.min_by(f64::total_cmp).unwrap_or(0.0)
}

/// Whether a ring has much more blur, or much less, than the median of those around it.
fn is_blurred_otherwise(ring: &Ring, all: &[(Label, f64)]) -> bool {
    let (column, row) = label(ring);
    let near = |&&((c, r), _): &&(Label, f64)| {
        let steps = (c - column).abs().max((r - row).abs());
        steps > 0 && steps <= AROUND
    };
    let mut around: Vec<f64> = all.iter().filter(near).map(|&(_, blur)| blur).collect();
    if around.len() < FEW {
        return false;
    }
    let (own, usual) = (ring.blur_sigma_px, median(&mut around));
    own > BLURS * usual + LEAST_BLUR_PX || own < usual / BLURS - LEAST_BLUR_PX
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::centre::{Centre, Ellipse, RingEllipses};
    use nalgebra::Vector2;

    fn ring(row: u16, column: u16) -> Ring {
        let (x, y) = (f64::from(column), f64::from(row));
        // in perspective, and bent by a lens
        let scale = 60.0 / (1.0 + 0.03 * x) * (1.0 - 0.002 * (x * x + y * y));
        let circle = |radius: f64| Ellipse {
            centre: Point2::new(50.0 + scale * x, 50.0 + scale * y),
            major: radius,
            minor: radius,
            angle: 0.0,
        };
        let ellipses = RingEllipses {
            inner: circle(10.0),
            outer: circle(20.0),
        };
        Ring {
            row,
            column,
            centre: Centre {
                point: ellipses.outer.centre,
                covariance: None,
            },
            ellipses,
            blur_sigma_px: 1.0,
            kept: None,
        }
    }

    fn board() -> Vec<Ring> {
        let labels = (0..5).flat_map(|row| (0..6).map(move |column| (row, column)));
        labels.map(|(row, column)| ring(row, column)).collect()
    }

    #[test]
    fn a_ring_beside_its_place_is_left_out_and_no_other() {
        let mut rings = board();
        leave_out_odd_ones(&mut rings);
        assert_eq!(rings, board());
        rings[0].centre.point += Vector2::new(3.0, 2.0);
        rings[14].centre.point += Vector2::new(-2.0, 2.0);
        leave_out_odd_ones(&mut rings);
        let mut expected = board();
        expected.remove(14);
        expected.remove(0);
        assert_eq!(rings, expected);
    }

    #[test]
    fn blur_that_no_neighbour_has_is_odd_and_blur_that_changes_is_not() {
        let blur = |(column, row): Label| 1.0 + 0.8 * f64::from(column) + 0.2 * f64::from(row);
        let all: Vec<(Label, f64)> = board().iter().map(|r| (label(r), blur(label(r)))).collect();
        for ring in board() {
            let of = |blur_sigma_px: f64| Ring {
                blur_sigma_px,
                ..ring.clone()
            };
            let own = blur(label(&ring));
            assert!(!is_blurred_otherwise(&of(own), &all));
            assert!(is_blurred_otherwise(&of(4.0 * own + 4.0), &all));
        }
    }
}
