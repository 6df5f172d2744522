//! A step that all rings of a crowded board take together.
//!
//! Where blurred skirts reach far into the neighbours' windows, rings that are fitted one after the other, each with its neighbours
//! as they were, need dozens of rounds: blur that is too large in one looks like light that is missing in the next. But
//! the first derivatives say how each ring's best answer depends on its neighbours' parameters (`crowd`): that gives the step at which no
//! ring would want to move any more.

use super::around::around;
use super::crowd::Crowd;
use super::fit::{Given, Known};
use super::model::{BLUR, INSIDE, PAPER, RING, RingModel, Vector};
use super::problem::Workspace;
use super::under::Under;
use rayon::prelude::*;

/// Steps at most: rings that began with twice their contrast and half their size come back in a dozen.
const STEPS: usize = 16;
/// Another step is worth its while where the last one has lowered the sum of squares by this many variances for each ring: what is left
/// of a centre's error then is a few per cent of the noise's.
const WORTH_ANOTHER: f64 = 0.03;
/// A step moves no outline by more than this (blur sigmas) and changes no contrast by more than this part of it: what is farther off is
/// no longer linear.
const LONGEST: f64 = 0.7;
const MOST_CONTRAST: f64 = 0.2;
/// Shares of the step that are tried until one lowers the sum of squares.
const SHARES: [f64; 3] = [1.0, 0.4, 0.15];

/// Moves all rings that are fitted to where none of them would want to move any more. Returns the equations of the last step; `None` where no
/// ring has another in reach.
pub(super) fn settle_together(ratio: f64, rings: &mut [Under]) -> Option<Crowd> {
    let mut known = None;
    let mut crowd = Crowd::of(ratio, rings)?;
    for step in 0..STEPS {
        if step > 0 {
            crowd = Crowd::of(ratio, rings)?;
        }
        let Some((before, after)) = step_together(ratio, rings, &crowd, known) else {
            break;
        };
        if before - after < WORTH_ANOTHER * rings.len() as f64 {
            break;
        }
        known = Some(after);
    }
    Some(crowd)
}

/// One such step, to first order, from the sum of squares where the rings stand (if that is known). Returns the sums before and after it, in
/// variances of the rings' noise; `None` where no step was taken.
fn step_together(
    ratio: f64,
    rings: &mut [Under],
    crowd: &Crowd,
    known: Option<f64>,
) -> Option<(f64, f64)> {
    let steps = crowd.steps()?;
    let before: Vec<RingModel> = rings.iter().map(|ring| ring.model).collect();
    let squares = known.unwrap_or_else(|| squares_of_all(ratio, rings, &before));
    for share in SHARES {
        let models: Vec<RingModel> = before
            .iter()
            .zip(&steps)
            .map(|(model, step)| moved(model, &(step * share)).unwrap_or(*model))
            .collect();
        let after = squares_of_all(ratio, rings, &models);
        if after < squares {
            for (ring, model) in rings.iter_mut().zip(models) {
                if let Ok(fitted) = &mut ring.fitted {
                    ring.model = model;
                    fitted.model = model;
                }
            }
            return Some((squares, after));
        }
    }
    None
}

/// What all rings leave in their windows, in variances of their noise.
fn squares_of_all(ratio: f64, rings: &[Under], models: &[RingModel]) -> f64 {
    let left = rings.par_iter().enumerate();
    let left = left.map_init(Workspace::default, |room, (i, ring)| {
        let (Ok(fitted), Some(window)) = (ring.fitted, ring.window.as_ref()) else {
            return 0.0;
        };
        let around = around(&window.grid, ratio, (i, models), room);
        let known = Known {
            window,
            ratio,
            around: around.as_ref(),
            given: Given::NearStart,
        };
        let residuals = room.residuals(&known, &models[i]).iter();
        residuals.map(|&r| f64::from(r * r)).sum::<f64>() / (fitted.noise * fitted.noise)
    });
    // in their order, so that it is the same on any number of threads
    left.collect::<Vec<f64>>().into_iter().sum()
}

/// The model after a step, which is cut where it is too long; `None` where nothing is left of the ring.
fn moved(model: &RingModel, step: &Vector) -> Option<RingModel> {
    let outer = model.shape.ellipse(1.0)?;
    let radius_px = outer.mean_radius();
    let (sigma_px, size_px) = (model.blur.sigma_px(), model.blur.size_px);
    let affine = step[2].abs().max(step[3].abs()).max(step[4].abs());
    let outline = step[0].hypot(step[1])
        + 0.5 * affine * radius_px.powi(3)
        + step[5].hypot(step[6]) * radius_px * radius_px
        + 0.5 * step[BLUR].abs() / size_px.max(f64::MIN_POSITIVE);
    let contrast = (model.paper - model.ring)
        .abs()
        .min((model.inside - model.ring).abs());
    let light = (step[PAPER] - step[RING])
        .abs()
        .max((step[INSIDE] - step[RING]).abs());
    let short = (LONGEST * sigma_px / outline.max(f64::MIN_POSITIVE))
        .min(MOST_CONTRAST * contrast / light.max(f64::MIN_POSITIVE))
        .min(1.0);
    let next = model.with_parameters(&(model.parameters() + step * short));
    next.shape.ellipse(1.0).map(|_| next)
}
