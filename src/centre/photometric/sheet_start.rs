//! Where the sheet may end beside a ring: the sides of the board it stands at, and the edge there that explains the residuals best.

use super::blur::Blur;
use super::board::{BoardPlace, BoardStart};
use super::fit::Known;
use super::fitted::RingFitted;
use super::model::RingModel;
use super::plane::PlaneView;
use super::problem::Workspace;
use super::sheet::{Edge, Profile, SheetEnd, SheetRow};
use super::window::{Grid, Window};
use crate::centre::Ellipse;
use nalgebra::{Point2, Vector2};

/// An edge sharper than so many pixels of the window is left out instead: nothing of the ring is near it.
const LEAST_SIGMA_PIXELS: f64 = 1.0;
/// Edges are looked for at these distances, blur sigmas, beyond the outline; up to the window's own reach.
const STEP_SIGMAS: f64 = 0.25;
const REACH_SIGMAS: f64 = 3.5;
/// The model is no better than this, of the contrast: without noise, whatever is left of a ring's bends would be taken for an edge.
const LEAST_NOISE: f64 = 1e-3;
/// An edge has to lower the sum of squares by this many of a pixel's variances.
const WORTH: f64 = 30.0;
/// A candidate is worth a fit from this on: a fit without the edge hides most of what it would explain.
const WORTH_A_FIT: f64 = 12.0;
/// An end that changes the window by less than this many of a pixel's variances is none: what it could move a ring by is less than its noise.
const SHOWS: f64 = 1.0;

/// The sides of the board (unit vectors of its plane, outwards) at which a ring stands.
pub(super) fn sides(board: &BoardStart, place: &BoardPlace) -> Vec<Vector2<f64>> {
    let near = board.outer_radius_m;
    [Vector2::x(), -Vector2::x(), Vector2::y(), -Vector2::y()]
        .into_iter()
        .filter(|side| {
            let out = |other: &BoardPlace| (other.plane_m - place.plane_m).dot(side);
            board.places.iter().all(|other| out(other) < near)
        })
        .collect()
}

/// The ring fitted with the end of the sheet, where that explains its window better.
///
/// `near` is a fit that the edge has not spoilt; `usual` is the one that knows no edge, and the last that was made in `room`.
pub(super) fn with_sheet(
    known: &Known,
    (board, place, view): (&BoardStart, &BoardPlace, &PlaneView),
    (near, usual): (&RingFitted, &RingFitted),
    room: &mut Workspace,
) -> Option<RingFitted> {
    let model = &usual.model;
    if model.blur.sigma_px() < LEAST_SIGMA_PIXELS * known.window.grid.pixel_px {
        return None;
    }
    let sides = sides(board, place);
    if sides.is_empty() {
        return None;
    }
    // those of the last fit are still there
    let mut residuals = if near.model == usual.model {
        room.residuals.clone()
    } else {
        room.residuals(known, &near.model).to_vec()
    };
    let least = LEAST_NOISE * (model.paper - model.ring).abs();
    let variance = near.noise.max(least).powi(2);
    let mut found: Vec<Candidate> = Vec::new();
    for side in &sides {
        let normal = view.outwards(&place.plane_m, side, board.outer_radius_m)?;
        let best = Candidate::best(known.window, near, normal, &residuals);
        if let Some(best) = best.filter(|c| c.gain > WORTH_A_FIT * variance) {
            best.explain(known.window, near, &mut residuals);
            found.push(best);
        }
    }
    found.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let first = found.first()?;
    let end = SheetEnd {
        beyond: near.model.paper + first.step,
        edge: first.edge,
        other: found.get(1).map(|second| second.edge),
    };
    // a second edge that is none runs into the ring
    let alone = end.other.map(|_| SheetEnd { other: None, ..end });
    [Some(end), alone].into_iter().flatten().find_map(|end| {
        let start = RingModel {
            sheet: Some(end),
            ..near.model
        };
        let fitted = known.fit_with(&start, model.blur.psf, room).ok()?;
        let variance = fitted.noise.max(least).powi(2);
        let is_worth = fitted.squares + WORTH * variance < usual.squares;
        let found = fitted.model.sheet.filter(|_| is_worth)?;
        is_beside(&fitted.model, &found).then_some(fitted)
    })
}

/// Whether the end of the sheet that a model knows shows in a window, by more than its noise: one that was found beside neighbours that
/// had not settled runs away or fades as they do, and then its place is anything. What is the same in all pixels does not count: it might as
/// well be the paper's light. Nor is it one that cuts through the ring.
pub(super) fn shows(window: &Window, model: &RingModel, noise: f64) -> bool {
    let Some(end) = model.sheet.filter(|end| is_beside(model, end)) else {
        return false;
    };
    let (mut pixels, mut sum, mut squares) = (0.0, 0.0, 0.0);
    for_each_missing(window, model, &end, |i, missing| {
        let (weight, missing) = (f64::from(window.weights[i]), f64::from(missing));
        pixels += weight;
        sum += weight * missing;
        squares += weight * missing * missing;
    });
    let uneven = squares - sum * sum / pixels.max(1.0);
    let least = LEAST_NOISE * (model.paper - model.ring).abs();
    (end.beyond - model.paper).powi(2) * uneven > SHOWS * noise.max(least).powi(2)
}

/// Whether the sheet ends outside the ring's outline.
fn is_beside(model: &RingModel, end: &SheetEnd) -> bool {
    let Some(outline) = model.shape.ellipse(1.0) else {
        return false;
    };
    let is_outside = |edge: &Edge| {
        let normal = edge.normal();
        let away = edge.offset_px + normal.dot(&(edge.anchor - outline.centre));
        away > extent(&outline, &normal)
    };
    is_outside(&end.edge) && end.other.is_none_or(|other| is_outside(&other))
}

/// How far an outline reaches from its middle in a direction, px.
fn extent(outline: &Ellipse, normal: &Vector2<f64>) -> f64 {
    let (sin, cos) = outline.angle.sin_cos();
    let (major, minor) = (Vector2::new(cos, sin), Vector2::new(-sin, cos));
    (outline.major * normal.dot(&major)).hypot(outline.minor * normal.dot(&minor))
}

/// An edge that may be there.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    edge: Edge,
    /// Light beyond less the paper's.
    step: f64,
    /// By how much it lowers the sum of squares.
    gain: f64,
}

impl Candidate {
    /// The edge across a direction that explains most of the residuals of a fit.
    fn best(
        window: &Window,
        fitted: &RingFitted,
        normal: Vector2<f64>,
        residuals: &[f32],
    ) -> Option<Self> {
        let model = &fitted.model;
        let outline = model.shape.ellipse(1.0)?;
        let extent = extent(&outline, &normal);
        let step_px = STEP_SIGMAS * model.blur.sigma_px();
        let across = Across::of(window, (outline.centre, normal, extent), step_px, residuals);
        let steps = step_of(&model.blur, &window.grid, step_px);
        (0..=(REACH_SIGMAS / STEP_SIGMAS) as usize)
            .filter_map(|k| {
                let (product, square) = across.against(&steps, k);
                let edge = Edge {
                    anchor: outline.centre,
                    offset_px: extent + k as f64 * step_px,
                    angle: normal.y.atan2(normal.x),
                    bend: 0.0,
                };
                (square > 1.0).then(|| Self {
                    edge,
                    step: product / square,
                    gain: product * product / square,
                })
            })
            .max_by(|a, b| a.gain.total_cmp(&b.gain))
    }

    /// Takes what this edge explains out of the residuals.
    fn explain(&self, window: &Window, fitted: &RingFitted, residuals: &mut [f32]) {
        let end = SheetEnd {
            beyond: 0.0,
            edge: self.edge,
            other: None,
        };
        for_each_missing(window, &fitted.model, &end, |i, missing| {
            residuals[i] -= self.step as f32 * missing * window.weights[i];
        });
    }
}

/// Residuals by how far out of the ring they are, in bins; the first bin begins `INWARDS` bins inside the outline.
struct Across {
    /// Sum of the residuals, and pixels.
    bins: Vec<(f64, f64)>,
}

/// Bins inside the outline, and in all.
const INWARDS: usize = 16;
const BINS: usize = 48;

impl Across {
    fn of(
        window: &Window,
        (centre, normal, extent): (Point2<f64>, Vector2<f64>, f64),
        step_px: f64,
        residuals: &[f32],
    ) -> Self {
        let (grid, stride) = (&window.grid, window.grid.stride());
        let mut bins = vec![(0.0, 0.0); BINS];
        let first = extent - INWARDS as f64 * step_px;
        let along = normal.x * grid.pixel_px / step_px;
        for row in 0..grid.height {
            let begin = Point2::new(grid.x(0), grid.y(row)) - centre;
            let begin = (begin.dot(&normal) - first) / step_px;
            let span = row * stride..row * stride + grid.width;
            let pixels = residuals[span.clone()].iter().zip(&window.weights[span]);
            for (column, (residual, weight)) in pixels.enumerate() {
                let at = begin + along * column as f64;
                if at >= 0.0 {
                    let bin = &mut bins[(at as usize).min(BINS - 1)];
                    bin.0 += f64::from(*residual);
                    bin.1 += f64::from(*weight);
                }
            }
        }
        Self { bins }
    }

    /// Sums of products of the residuals with what is missing beyond the edge `k` bins out of the outline, and of its squares.
    fn against(&self, steps: &[f64], k: usize) -> (f64, f64) {
        let missing = steps[BINS - INWARDS - k..].iter();
        let bins = self.bins.iter().zip(missing);
        bins.fold((0.0, 0.0), |(product, square), ((sum, pixels), missing)| {
            (product + missing * sum, square + missing * missing * pixels)
        })
    }
}

/// The blurred step at the middles of bins, from `BINS` bins before it to as many behind.
fn step_of(blur: &Blur, grid: &Grid, step_px: f64) -> Vec<f64> {
    let profile = Profile::new(blur, grid);
    (0..2 * BINS)
        .map(|bin| {
            let distance = (bin as f64 + 0.5 - BINS as f64) * step_px;
            f64::from(profile.at(distance as f32).0)
        })
        .collect()
}

/// What is missing of the sheet in each pixel of a window.
fn for_each_missing(
    window: &Window,
    model: &RingModel,
    end: &SheetEnd,
    mut visit: impl FnMut(usize, f32),
) {
    let (grid, stride) = (&window.grid, window.grid.stride());
    let mut missing = SheetRow::default();
    for row in 0..grid.height {
        missing.fill(end, &model.blur, grid, row);
        let pixels = missing.missing[..grid.width].iter().enumerate();
        pixels.for_each(|(column, &part)| visit(row * stride + column, part));
    }
}
