//! The camera's response from the profiles of blurred rings.
//!
//! With the wrong gamma the model cannot follow a blurred edge from light to dark, and the residuals show it. They are compared as grey
//! values: there the noise is the same whatever gamma is tried, so that it does not favour any. Sharp rings have hardly any grey between
//! their levels and say nothing of gamma.

use super::board::BoardStart;
use super::fit::Known;
use super::hearing::hear;
use super::jury::jurors;
use super::problem::Workspace;
use super::response::ResponseGamma;
use crate::frame::{Frame, Linear, Pixels};
use rayon::prelude::*;

/// Gammas that are tried first.
const TRIED: [f64; 6] = [0.6, 1.0, 1.5, 2.0, 2.6, 3.4];
/// Steps of the search between them.
const STEPS: usize = 5;
/// Twice the logarithm of the likelihood that another gamma than 1 has to gain.
const WORTH: f64 = 25.0;
/// Light below this is dark: the slope of the response there is not trusted.
const LEAST_LIGHT: f64 = 0.02;

/// The gamma under which the rings' grey values follow the model best; 1 where they do not tell.
pub fn estimate_gamma(frame: &Frame, board: &BoardStart) -> f64 {
    let cost = |gamma: f64| cost(frame, board, gamma);
    let mut tried: Vec<(f64, f64)> = TRIED
        .iter()
        .filter_map(|&gamma| Some((gamma.ln(), cost(gamma)?)))
        .collect();
    let Some(straight) = tried.iter().find(|t| t.0 == 0.0).map(|t| t.1) else {
        return 1.0;
    };
    for _ in 0..STEPS {
        let Some(next) = between(&mut tried) else {
            break;
        };
        let Some(found) = cost(next.exp()) else { break };
        tried.push((next, found));
    }
    let best = tried.iter().min_by(|a, b| a.1.total_cmp(&b.1));
    best.filter(|best| straight - best.1 > WORTH)
        .map_or(1.0, |best| best.0.exp())
        .clamp(ResponseGamma::LEAST, ResponseGamma::GREATEST)
}

/// The lowest point of the parabola through the best and its neighbours; `None` where the best stands at an end or it is found.
fn between(tried: &mut [(f64, f64)]) -> Option<f64> {
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    let best = (0..tried.len()).min_by(|&a, &b| tried[a].1.total_cmp(&tried[b].1))?;
    let [(x0, y0), (x1, y1), (x2, y2)] = [
        *tried.get(best.checked_sub(1)?)?,
        tried[best],
        *tried.get(best + 1)?,
    ];
    let (left, right) = ((y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1));
    let bend = (right - left) / (x2 - x0);
    let lowest = 0.5 * (x0 + x1) - left / (2.0 * bend);
    let inside = lowest > x0 && lowest < x2 && (lowest - x1).abs() > 1e-3;
    (bend > 0.0 && inside).then_some(lowest)
}

/// Minus twice the logarithm of the likelihood of a few rings' grey values; `None` where none can be fitted.
fn cost(frame: &Frame, board: &BoardStart, gamma: f64) -> Option<f64> {
    let linear = Linear::new(gamma, matches!(frame.pixels, Pixels::U16(_)));
    let board = BoardStart {
        linear: &linear,
        ..*board
    };
    let view = board.view();
    let costs: Vec<Option<f64>> = jurors(board.places)
        .par_iter()
        .map_init(Workspace::default, |room, &i| {
            let place = board.places[i];
            let (both, window) = hear(frame, &board, (&place, view.as_ref()), true, room)?;
            let fitted = both.likelier().ok()?;
            let known = Known {
                window: &window,
                ratio: board.ratio,
                around: None,
                given: Default::default(),
            };
            let residuals = room.residuals(&known, &fitted.model);
            let mut squares = 0.0;
            for (value, residual) in window.values.iter().zip(residuals) {
                let light = f64::from(value - residual).max(LEAST_LIGHT);
                let slope = light.powf(1.0 / gamma - 1.0) / gamma;
                squares += (f64::from(*residual) * slope).powi(2);
            }
            let pixels = window.count() as f64;
            Some(pixels * (squares / pixels).max(f64::MIN_POSITIVE).ln())
        })
        .collect();
    // a gamma is judged by the same rings as the others
    costs
        .into_iter()
        .try_fold(0.0, |sum, cost| Some(sum + cost?))
}

#[cfg(test)]
mod tests {
    use super::between;

    #[test]
    fn the_lowest_point_of_a_parabola_is_found_at_once() {
        let f = |x: f64| 3.0 + 2.0 * (x - 0.7) * (x - 0.7);
        let mut tried = [(-0.5, f(-0.5)), (2.0, f(2.0)), (0.5, f(0.5))];
        assert!((between(&mut tried).unwrap() - 0.7).abs() < 1e-9);
        assert!(between(&mut tried[..2]).is_none());
    }
}
