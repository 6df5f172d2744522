//! How different views are before a camera is known: by where and how large the board is and how it leans.

use super::{Measures, View};
use crate::board::Board;
use crate::calibrate::plane_normal;

/// A view as a point in a space in which every side is about 1 long.
pub(super) type Place = [f64; 5];

/// The place of a view: x, y and size as [`Measures`] has them, and the board's normal seen with this focal length.
pub(super) fn place(board: &Board, view: &View, focal_px: f64) -> Place {
    let measures = Measures::of(board, view);
    let size = (view.width as f64, view.height as f64);
    let normal = plane_normal(&view.homography, focal_px, size).unwrap_or_default();
    [measures.x, measures.y, measures.size, normal.x, normal.y]
}

/// Places of at most `count` views that lie as far from one another as they can be picked one after another: each is the
/// farthest from those before it (Gonzalez 1985), the first one the farthest from the mean, and of equals the first.
pub(super) fn spread(places: &[Place], count: usize) -> Vec<usize> {
    let mean = mean(places);
    let mut distances: Vec<f64> = places.iter().map(|p| distance(p, &mean)).collect();
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < count.min(places.len()) {
        let mut best = None;
        for (at, far) in distances.iter().enumerate() {
            let farther = best.is_none_or(|(_, most)| *far > most);
            if farther && !chosen.contains(&at) {
                best = Some((at, *far));
            }
        }
        let Some((at, _)) = best else { break };
        let first = chosen.is_empty();
        chosen.push(at);
        for (far, place) in distances.iter_mut().zip(places) {
            let to_chosen = distance(place, &places[at]);
            *far = if first { to_chosen } else { far.min(to_chosen) };
        }
    }
    chosen.sort_unstable();
    chosen
}

/// The place that had better be given to a candidate: the later one of the two closest to one another, where the candidate is
/// farther from all others than they are from each other.
pub(super) fn exchange(kept: &[Place], candidate: &Place) -> Option<usize> {
    let mut closest: Option<(usize, f64)> = None;
    for (at, place) in kept.iter().enumerate() {
        for other in &kept[..at] {
            let apart = distance(place, other);
            if closest.is_none_or(|(_, least)| apart < least) {
                closest = Some((at, apart));
            }
        }
    }
    let (at, apart) = closest?;
    let others = kept.iter().enumerate().filter(|(other, _)| *other != at);
    let nearest = others
        .map(|(_, place)| distance(place, candidate))
        .fold(f64::INFINITY, f64::min);
    (nearest > apart).then_some(at)
}

fn mean(places: &[Place]) -> Place {
    let mut mean = Place::default();
    for place in places {
        for (sum, value) in mean.iter_mut().zip(place) {
            *sum += value / places.len() as f64;
        }
    }
    mean
}

fn distance(a: &Place, b: &Place) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(x: f64) -> Place {
        [x, 0.0, 0.0, 0.0, 0.0]
    }

    #[test]
    fn views_far_apart_are_picked() {
        let places: Vec<Place> = [0.0, 0.1, 0.5, 0.55, 1.0, 1.0].map(line).to_vec();
        assert_eq!(spread(&places, 2), [0, 4]);
        assert_eq!(spread(&places, 3), [0, 2, 4]);
        assert_eq!(spread(&places, 9).len(), 6);
        assert!(spread(&[], 3).is_empty());
    }

    #[test]
    fn a_view_that_repeats_gives_way_to_one_that_does_not() {
        let kept = [0.0, 0.5, 0.55, 1.0].map(line);
        assert_eq!(exchange(&kept, &line(0.8)), Some(2));
        assert_eq!(exchange(&kept, &line(0.52)), None);
        assert_eq!(exchange(&kept[..1], &line(0.8)), None);
    }
}
