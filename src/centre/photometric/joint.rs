//! A step that all rings of a crowded board take together.
//!
//! Where blurred skirts reach far into the neighbours' windows, rings that are fitted one after the other, each with its neighbours
//! as they were, need dozens of rounds: blur that is too large in one looks like light that is missing in the next. But
//! the first derivatives say how each ring's best answer depends on its neighbours' parameters (`crowd`): that gives the step at which no
//! ring would want to move any more.

use super::alone::Ends;
use super::crowd::Crowd;
use super::model::{BLUR, INSIDE, PAPER, RING, RingModel, Vector};
use super::under::Under;

/// Steps at most: rings that began with twice their contrast and half their size come back in a dozen.
const STEPS: usize = 16;
/// A step is worth its while where the sums of squares could be lower by this many variances for each ring: one ring that has not settled may
/// want all of it.
const WORTH_A_STEP: f64 = 0.003;
/// A step moves no outline by more than this (blur sigmas) and changes no contrast by more than this part of it: what is farther off is
/// no longer linear.
const LONGEST: f64 = 0.7;
const MOST_CONTRAST: f64 = 0.2;
/// Shares of the step that are tried until the rings want less than before.
const SHARES: [f64; 3] = [1.0, 0.4, 0.15];

/// Moves all rings that are fitted to where none of them would want to move any more; says whether any has moved.
pub(super) fn settle_together(ratio: f64, rings: &mut [Under]) -> bool {
    let mut models: Vec<RingModel> = rings.iter().map(|ring| ring.model).collect();
    let Some(mut crowd) = Crowd::of(ratio, (rings, &models), Ends::Held) else {
        return false;
    };
    let mut any = false;
    for _ in 0..STEPS {
        if crowd.wants() < WORTH_A_STEP * rings.len() as f64 {
            break;
        }
        let Some(next) = step_together(ratio, (rings, &models), &crowd) else {
            break;
        };
        (models, crowd) = next;
        any = true;
    }
    for (ring, model) in rings.iter_mut().zip(models) {
        if let Ok(fitted) = &mut ring.fitted {
            ring.model = model;
            fitted.model = model;
        }
    }
    any
}

/// One such step, to first order. Returns the models after it and their equations; `None` where rings would want more than before.
fn step_together(
    ratio: f64,
    (rings, before): (&[Under], &[RingModel]),
    crowd: &Crowd,
) -> Option<(Vec<RingModel>, Crowd)> {
    let steps = crowd.steps()?;
    let after = |share: f64| {
        let pairs = before.iter().zip(&steps);
        let models = pairs.map(|(model, step)| moved(model, &(step * share)).unwrap_or(*model));
        let models: Vec<RingModel> = models.collect();
        let crowd = Crowd::of(ratio, (rings, &models), Ends::Held)?;
        Some((models, crowd))
    };
    SHARES
        .into_iter()
        .filter_map(after)
        .find(|(_, next)| next.wants() < crowd.wants())
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
