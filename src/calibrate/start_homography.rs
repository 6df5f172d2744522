//! The homography that a view starts from, through most of its rings.
//!
//! It neglects the distortion, which moves rings of a full frame by tens of pixels; so it is asked no more than which rings cannot
//! belong to the others by far.

use super::observations::Observation;
use super::rays::pose_of_rays;
use crate::camera::homography::{apply, fit_homography};
use crate::camera::{Camera, Pose};
use nalgebra::{Matrix3, Point2};

/// Residual over the median residual beyond which a ring does not take part in the start.
const FAR: f64 = 8.0;
/// Residuals below this are close, px.
const CLOSE_PX: f64 = 0.5;
/// The same once the camera is known, and how often a pose is found again without what lies beyond.
const ROUNDING_PX: f64 = 1e-3;
const TRIMS: usize = 4;
/// Sets of four rings that are tried where some are far: with a third of the rings wrong one in five is right.
const TRIES: u64 = 60;

/// Board plane (m) to frame (px) through most rings; the others get no share. `None` where the rings stand in a line.
pub(super) fn mark(rings: &mut [Observation]) -> Option<Matrix3<f64>> {
    let all: Vec<(Point2<f64>, Point2<f64>)> = rings
        .iter()
        .map(|ring| (Point2::from(ring.board_m), ring.pixel))
        .collect();
    let through_all = fit_homography(&all)?;
    let (mut best, mut errors) = (through_all, distances(&through_all, &all));
    if far(&errors).is_empty() {
        return Some(best);
    }
    for attempt in 0..TRIES {
        let Some(four) = fit_homography(&four_of(&all, attempt)) else {
            continue;
        };
        let of_four = distances(&four, &all);
        if median(&of_four) < median(&errors) {
            (best, errors) = (four, of_four);
        }
    }
    for at in far(&errors) {
        rings[at].share = 0.0;
    }
    let near: Vec<_> = all
        .iter()
        .zip(rings.iter())
        .filter(|(_, ring)| ring.share > 0.0)
        .map(|(pair, _)| *pair)
        .collect();
    fit_homography(&near).or(Some(best))
}

/// Board plane (m) to frame (px) through the rings that have a share.
pub(super) fn of_marked(rings: &[Observation]) -> Option<Matrix3<f64>> {
    let near = rings.iter().filter(|ring| ring.share > 0.0);
    let pairs: Vec<_> = near
        .map(|ring| (Point2::from(ring.board_m), ring.pixel))
        .collect();
    fit_homography(&pairs)
}

fn distances(homography: &Matrix3<f64>, pairs: &[(Point2<f64>, Point2<f64>)]) -> Vec<f64> {
    pairs
        .iter()
        .map(|(plane, pixel)| {
            apply(homography, *plane).map_or(f64::INFINITY, |image| (image - pixel).norm())
        })
        .collect()
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

fn far(distances: &[f64]) -> Vec<usize> {
    beyond(distances, CLOSE_PX)
}

/// Places of the distances that are much larger than the median, or than `close_px` where that is smaller.
fn beyond(distances: &[f64], close_px: f64) -> Vec<usize> {
    let limit = FAR * median(distances).max(close_px);
    (0..distances.len())
        .filter(|at| distances[*at] > limit)
        .collect()
}

/// A pose through most rings of a view with a camera that is known, the rings that it puts far from where they are left without a
/// share; `None` where no four of them have one.
pub(super) fn pose_through_most(camera: &Camera, rings: &mut [Observation]) -> Option<Pose> {
    let all: Vec<(Point2<f64>, Point2<f64>)> = rings
        .iter()
        .map(|ring| (Point2::from(ring.board_m), ring.pixel - ring.bias_px))
        .collect();
    let errors = |pose: &Pose| errors_px(camera, pose, &all);
    let tried = (0..TRIES).map(|attempt| four_of(&all, attempt));
    let mut pose = std::iter::once(all.clone())
        .chain(tried)
        .filter_map(|some| pose_of_rays(camera, &some))
        .min_by(|a, b| median(&errors(a)).total_cmp(&median(&errors(b))))?;
    let mut out = Vec::new();
    for _ in 0..TRIMS {
        out = beyond(&errors(&pose), ROUNDING_PX);
        let near: Vec<_> = (0..all.len())
            .filter(|at| !out.contains(at))
            .map(|at| all[at])
            .collect();
        pose = pose_of_rays(camera, &near)?;
    }
    for (at, ring) in rings.iter_mut().enumerate() {
        ring.share = if out.contains(&at) { 0.0 } else { 1.0 };
    }
    Some(pose)
}

fn errors_px(camera: &Camera, pose: &Pose, pairs: &[(Point2<f64>, Point2<f64>)]) -> Vec<f64> {
    pairs
        .iter()
        .map(|(plane, pixel)| {
            camera
                .project(&pose.board_to_camera([plane.x, plane.y]))
                .map_or(f64::INFINITY, |image| (image - pixel).norm())
        })
        .collect()
}

/// Four different pairs, others at every attempt and the same in every run.
fn four_of(pairs: &[(Point2<f64>, Point2<f64>)], attempt: u64) -> Vec<(Point2<f64>, Point2<f64>)> {
    // Knuth's multiplicative generator; its high bits are good enough to pick rings
    let mut state = attempt.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mut places: Vec<usize> = (0..pairs.len()).collect();
    (0..4.min(pairs.len()))
        .map(|i| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let pick = i + (state >> 33) as usize % (places.len() - i);
            places.swap(i, pick);
            pairs[places[i]]
        })
        .collect()
}
