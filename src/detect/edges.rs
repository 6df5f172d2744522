//! Sub-pixel edges of one ring: where its grey profile passes half-way between the levels on either side.
//!
//! Rays from the ring's middle cross both edges. Each ray has its own levels (inside, ring, outside), smoothed over the
//! neighbouring rays, so that a shadow across the ring moves no edge; rays on the shadow's border are left to the
//! robust fit. Under blur the levels are the extrema of the profile: the best edges a construction on ellipses can get.

use super::profile::{Profile, Rays};
use crate::centre::RingEllipses;
use crate::frame::{Pixel, Plane};
use nalgebra::{Matrix3, Point2, Vector2};

/// Fewest and most rays of a ring; between, one for each pixel of the outer edge.
pub(super) const RAYS: (usize, usize) = (48, 192);
/// Rays on either side over which levels are smoothed, as a fraction of all.
const LEVEL_SMOOTHING: f64 = 1.0 / 24.0;
const MOST_REACH: usize = RAYS.1 / 24;
/// Fraction of the rays that must show an edge.
const LEAST_RAYS: f64 = 0.6;

/// Where an edge is taken to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LevelRule {
    /// Half-way between the extrema of its own profile: there is one wherever the ring shows at all.
    Extrema,
    /// Half-way between the levels of the print: the paper as it is around the ring, and the ring as dark as it is where it is
    /// widest. Blur fills a narrow part of a ring, and its extrema displace the edges there.
    Print,
}

/// The edge points of a ring.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct RingEdges {
    /// On the inner circle's image, px; empty where too few rays show it.
    pub(super) inner: Vec<Point2<f64>>,
    /// On the outer circle's image, px.
    pub(super) outer: Vec<Point2<f64>>,
    /// Blur of the outer edge along the rays that show it whole, px (standard deviation of a Gaussian).
    pub(super) blur_sigma_px: Vec<f64>,
    /// Median grey difference across the outer edge, 0..1.
    pub(super) contrast: f64,
}

/// Grey levels along one ray.
#[derive(Clone, Copy)]
struct Levels {
    inside: f64,
    ring: f64,
    outside: f64,
}

/// Finds the edges near rough ellipses, on [`RAYS`] or less; `sign` is 1 where the ring is dark, -1 where it is light. `None` where fewer than
/// [`LEAST_RAYS`] of the rays stay in the picture and show the outer edge.
pub(super) fn ring_edges<T: Pixel>(
    picture: &Plane<T>,
    rough: &RingEllipses,
    sign: f64,
    (rule, most_rays): (LevelRule, usize),
) -> Option<RingEdges> {
    let count = ((std::f64::consts::TAU * rough.outer.major) as usize).clamp(RAYS.0, most_rays);
    let mut rays = Rays::default();
    for i in 0..count {
        let t = std::f64::consts::TAU * i as f64 / count as f64;
        rays.sample(picture, rough, t, sign);
    }
    let profiles = rays.profiles();
    let least = (LEAST_RAYS * count as f64) as usize;
    if profiles.len() < least {
        return None;
    }
    let mut levels = smoothed_levels(&profiles);
    if rule == LevelRule::Print {
        print_levels(&mut levels);
    }
    let mut edges = RingEdges::default();
    let outline = rough.outer.conic();
    for (profile, level) in profiles.iter().zip(&levels) {
        let Some(outer) = outer_crossing(profile, level) else {
            continue;
        };
        edges.outer.push(profile.point(outer));
        edges
            .inner
            .extend(inner_crossing(profile, level).map(|inner| profile.point(inner)));
        let across = normal_at(&outline, &profile.point(outer))
            .dot(&profile.direction)
            .abs();
        let along = profile.blur_sigma_px(level.ring, level.outside, outer);
        edges
            .blur_sigma_px
            .extend(along.map(|sigma| sigma * across));
    }
    let mut contrasts: Vec<f64> = levels.iter().map(|l| l.outside - l.ring).collect();
    edges.contrast = median(&mut contrasts);
    if edges.inner.len() < least {
        edges.inner.clear();
    }
    (edges.outer.len() >= least).then_some(edges)
}

/// The mid-level crossing next to the ring's extremum, inwards, px from the profile's origin.
fn inner_crossing(profile: &Profile, level: &Levels) -> Option<f64> {
    let wanted = 0.5 * (level.inside + level.ring);
    let (values, limit) = (profile.values, wanted as f32);
    let at = (1..=profile.darkest)
        .rev()
        .find(|&i| values[i] <= limit && values[i - 1] > limit)?;
    (level.inside > level.ring).then(|| profile.radius_px(at, wanted))
}

/// The mid-level crossing next to the ring's extremum, outwards, px from the profile's origin.
fn outer_crossing(profile: &Profile, level: &Levels) -> Option<f64> {
    let wanted = 0.5 * (level.outside + level.ring);
    let (values, limit) = (profile.values, wanted as f32);
    let at = (profile.darkest + 1..values.len())
        .find(|&i| values[i] >= limit && values[i - 1] < limit)?;
    (level.outside > level.ring).then(|| profile.radius_px(at, wanted))
}

/// Levels of every ray, each the median over its neighbours.
fn smoothed_levels(profiles: &[Profile]) -> Vec<Levels> {
    let reach = ((profiles.len() as f64 * LEVEL_SMOOTHING) as usize).clamp(1, MOST_REACH);
    let smooth = |of: fn(&Profile) -> f64| -> Vec<f64> {
        let raw: Vec<f64> = profiles.iter().map(of).collect();
        running_median(&raw, reach)
    };
    let (inside, ring, outside) = (
        smooth(|p| p.inside),
        smooth(|p| p.ring),
        smooth(|p| p.outside),
    );
    (0..profiles.len())
        .map(|i| Levels {
            inside: inside[i],
            ring: ring[i],
            outside: outside[i],
        })
        .collect()
}

/// Around a closed curve, the median of every value and `reach` of its neighbours to either side, [`MOST_REACH`] at most. They are kept in
/// order while one comes and one goes.
fn running_median(raw: &[f64], reach: usize) -> Vec<f64> {
    let n = raw.len();
    let mut room = [0.0; 2 * MOST_REACH + 1];
    let around = &mut room[..2 * reach + 1];
    for (k, value) in around.iter_mut().enumerate() {
        *value = raw[(n + k - reach) % n];
    }
    around.sort_unstable_by(f64::total_cmp);
    let mut medians = Vec::with_capacity(n);
    for i in 0..n {
        medians.push(around[reach]);
        let (goes, comes) = (raw[(i + n - reach) % n], raw[(i + 1 + reach) % n]);
        let gone = around.iter().position(|v| v.total_cmp(&goes).is_eq());
        let mut at = gone.unwrap_or(0);
        around[at] = comes;
        while at > 0 && around[at - 1] > comes {
            around.swap(at - 1, at);
            at -= 1;
        }
        while at + 1 < around.len() && around[at + 1] < comes {
            around.swap(at, at + 1);
            at += 1;
        }
    }
    medians
}

/// The rays that show the ring as dark as it is printed: this fraction, so that noise does not choose.
const PRINT: f64 = 0.15;

fn quantile(values: impl Iterator<Item = f64>, fraction: f64) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let at = (values.len().saturating_sub(1)) as f64 * fraction;
    values.get(at as usize).copied().unwrap_or(0.0)
}

/// The levels of the print on every ray: light falls on ring and paper alike, so that the darkest ratio of the two is the print's.
/// (Values of light rings are negated, and so are differences taken: there the contrast's largest is the print's.)
fn print_levels(levels: &mut [Levels]) {
    let light = levels.iter().all(|l| l.outside > 0.0 && l.ring >= 0.0);
    if light {
        let ratio = |l: &Levels| l.ring / l.outside;
        let darkest = quantile(levels.iter().map(ratio), PRINT);
        for level in levels {
            level.ring = darkest * level.outside;
            level.inside = level.outside;
        }
    } else {
        let contrast = |l: &Levels| l.outside - l.ring;
        let largest = quantile(levels.iter().map(contrast), 1.0 - PRINT);
        for level in levels {
            level.ring = level.outside - largest;
            level.inside = level.outside;
        }
    }
}

fn normal_at(conic: &Matrix3<f64>, point: &Point2<f64>) -> Vector2<f64> {
    let gradient = conic * point.to_homogeneous();
    gradient.xy().try_normalize(0.0).unwrap_or_else(Vector2::x)
}

/// The middle value; 0 for none.
pub(super) fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_running_median_is_the_median_of_every_window() {
        for (n, reach) in [(48, 2), (30, 8), (29, 1), (5, 2)] {
            let raw: Vec<f64> = (0..n).map(|i| f64::from((i * 37) % 11)).collect();
            let found = running_median(&raw, reach);
            for i in 0..raw.len() {
                let window = (0..=2 * reach).map(|k| raw[(i + raw.len() + k - reach) % raw.len()]);
                assert_eq!(found[i], median(&mut window.collect::<Vec<_>>()));
            }
        }
    }
}
