//! The views to calibrate from, out of more than anybody wants to wait for: a recording at 30 frames a second.

use super::variety;
use super::{NOMINAL_FOCAL, View, motion};
use crate::board::Board;
use crate::calibrate::{
    CalibrateOptions, Estimate, NEEDED_RINGS, NEEDED_VIEWS, Told, focal_length_px, most_informative,
};
use nalgebra::{Point2, Vector2};
use rayon::prelude::*;

/// Views that the camera is first estimated from, at least and at most.
const FIRST: (usize, usize) = (12, 24);
/// Times as many that are tried where these do not tell it.
const MORE: [usize; 3] = [1, 2, 4];
/// Times that views are chosen, each with the camera of those chosen before.
const ROUNDS: usize = 2;
/// Average motion of the rings below which a view repeats another, as a part of the frame's width. What they share, a lens that is not
/// quite the model's or a board that is not quite flat, no number of repetitions averages out.
const SAME: f64 = 0.01;

/// Chooses the views that tell most about the camera together, at most `max_views`: their places in `views`, ascending.
///
/// Some views far apart give a first estimate of the camera. Every view is held against it; one that contradicts it, one that repeats
/// a chosen one, and one of another size than most are not chosen. Of the others the view that adds most to those
/// chosen before is taken, again and again ([`most_informative`]), of equally good ones the first; and all this once more with the camera of
/// the views chosen. Where no views tell the camera, those are chosen that differ most.
///
/// Whether the board was still is for the caller to say: a view does not show it.
pub fn choose(
    board: &Board,
    views: &[View],
    max_views: usize,
    options: &CalibrateOptions,
) -> Vec<usize> {
    let size = most_common_size(views);
    let usable = |at: &usize| {
        let view = &views[*at];
        (view.width, view.height) == size && view.rings.len() >= NEEDED_RINGS
    };
    let usable: Vec<usize> = (0..views.len()).filter(usable).collect();
    let places = places(board, views, &usable);
    let Some(first) = first_estimate(board, views, (&usable, &places), max_views, options) else {
        let picked = variety::spread(&places, max_views);
        return picked.into_iter().map(|at| usable[at]).collect();
    };
    let middles: Vec<Point2<f64>> = usable.iter().map(|at| middle(&views[*at])).collect();
    let mut struck = vec![false; usable.len()];
    let mut estimate = first;
    let mut chosen: Vec<usize> = Vec::new();
    for round in 0..ROUNDS {
        if round > 0 {
            let these: Vec<View> = chosen.iter().map(|at| views[usable[*at]].clone()).collect();
            let Ok(again) = Estimate::solve(board, &these, options) else {
                break;
            };
            for (place, at) in chosen.iter().enumerate() {
                struck[*at] |= !again.uses(place);
            }
            estimate = again;
        }
        let told: Vec<Option<Told>> = usable
            .par_iter()
            .zip(&struck)
            .map(|(at, struck)| {
                let judged = || estimate.judge(board, &views[*at]).ok();
                if *struck { None } else { judged() }
            })
            .collect();
        let repeats = |a: usize, b: usize| {
            let same_px = SAME * size.0 as f64;
            // the cheap question first: few views have their middles in the same place
            let near = (middles[a] - middles[b]).norm() <= same_px;
            near && motion(&views[usable[a]], &views[usable[b]])
                .is_some_and(|m| m.mean_px < same_px)
        };
        chosen = most_informative(&told, max_views, repeats);
    }
    chosen.into_iter().map(|at| usable[at]).collect()
}

/// A camera from views far apart; from more of them where they do not tell it.
fn first_estimate(
    board: &Board,
    views: &[View],
    (usable, places): (&[usize], &[variety::Place]),
    max_views: usize,
    options: &CalibrateOptions,
) -> Option<Estimate> {
    let first = max_views.clamp(FIRST.0, FIRST.1);
    MORE.iter().find_map(|times| {
        let picked = variety::spread(places, times * first);
        if picked.len() < NEEDED_VIEWS {
            return None;
        }
        let these: Vec<View> = picked.iter().map(|at| views[usable[*at]].clone()).collect();
        Estimate::solve(board, &these, options).ok()
    })
}

fn places(board: &Board, views: &[View], usable: &[usize]) -> Vec<variety::Place> {
    let Some(first) = usable.first().map(|at| &views[*at]) else {
        return Vec::new();
    };
    let size = (first.width as f64, first.height as f64);
    let homographies: Vec<_> = usable.iter().map(|at| views[*at].homography).collect();
    let focal_px =
        focal_length_px(&homographies, size).unwrap_or(NOMINAL_FOCAL * size.0.max(size.1));
    let place = |at: &usize| variety::place(board, &views[*at], focal_px);
    usable.par_iter().map(place).collect()
}

fn middle(view: &View) -> Point2<f64> {
    let sum: Vector2<f64> = view.rings.iter().map(|r| r.centre.point.coords).sum();
    Point2::from(sum / view.rings.len().max(1) as f64)
}

/// Width and height, px; of the first views where two sizes are equally common.
fn most_common_size(views: &[View]) -> (usize, usize) {
    let mut counts: Vec<((usize, usize), usize)> = Vec::new();
    for view in views {
        let size = (view.width, view.height);
        match counts.iter_mut().find(|(other, _)| *other == size) {
            Some((_, count)) => *count += 1,
            None => counts.push((size, 1)),
        }
    }
    let most = counts.iter().rev().max_by_key(|(_, count)| *count);
    most.map_or((0, 0), |(size, _)| *size)
}

#[cfg(test)]
mod tests;
