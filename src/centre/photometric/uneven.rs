//! Blur that changes across a ring, taken out of its pixels.
//!
//! A tilted board is further out of focus on one side, and so is every ring a little. A model with one blur makes up for the rest by
//! moving the ring and tilting it: by about the blur's size times its change per pixel, 0.02 px where discs of 24 px
//! are seen on boards tilted by 40 degrees. All rings of a view are moved alike, so that no residual shows it. But they also tell how
//! the blur changes: in the picture of a plane the blur of a thin lens is linear, but for the lens's distortion.
//!
//! A lens sees the board from each point a of its aperture (a disc or a normal distribution of size 1) with the point x of the
//! picture at x - s(x) a, and the light at p is the mean over a of S(x), S the sharp ring, p = x - s(x) a. For
//! s(x) = s + g . (x - c), c the ring's centre, this is to first order in g
//!
//! ```text
//! I(p) = I_g=0(p) + mean over a of (g . (x - c)) (a . grad S(x)),  x = p + s a
//! ```
//!
//! S has gradients on its outlines only: with a = (x - p) / s the second term is an integral along them of the kernel times
//! g . (x - c) n . (x - p) / s, n the outward normal, times the step of light from inside to outside. That is how outlines are laid
//! for the derivatives by the shape (`coverage`): three such pictures, and p, make it. It is subtracted from the
//! pixels, and the rings are fitted again. What is left is of the second order: a fiftieth of it or less, where it
//! was measured (`tests/uneven`).

use super::around::{around, reaches};
use super::board::BoardStart;
use super::boundary::Node;
use super::fit::{Given, Known};
use super::fitted::RingFitted;
use super::jury::median;
use super::model::RingModel;
use super::problem::Workspace;
use super::ring::gate;
use super::rows::shades;
use super::sheet::{Edge, SheetRow};
use super::under::Under;
use super::window::{Grid, Window};
use nalgebra::{Matrix3, Point2, Vector2, Vector3};
use rayon::prelude::*;

/// Fewer rings do not tell how the blur changes.
const LEAST_RINGS: usize = 9;
/// Rings whose blur is so many times the median away from the plane do not count.
const FAR: f64 = 4.0;
/// The change of the blur is believed from so many standard deviations on. It need be no more: rings tell their blur about as well as
/// their place, and the board is far wider than the blur, so that what a wrong change moves is small against their noise.
const SIGNIFICANT: f64 = 4.0;
/// Size times change of the blur that matters, in standard deviations of a centre (the usual one): it moves them by less.
const WORTH: f64 = 0.03;
/// A smaller blur, sigma as a part of the outer minor semi-axis, is as good as none.
const LEAST_SIGMA: f64 = 0.02;

/// Takes what uneven blur does out of the pixels of the rings, and fits them again; does nothing where the blur is even, and says so.
pub(super) fn even_out(board: &BoardStart, rings: &mut [Under]) -> bool {
    let Some(slope) = slope(rings) else {
        return false;
    };
    let models: Vec<RingModel> = rings.iter().map(|ring| ring.model).collect();
    let work = rings.par_iter_mut().enumerate();
    work.for_each_init(Workspace::default, |room, (i, ring)| {
        let (Some(window), Ok(before)) = (ring.window.as_mut(), ring.fitted) else {
            return;
        };
        subtract(window, (i, &models), (board.ratio, slope), room);
        let around = match ring.crowded {
            true => around(&window.grid, board.ratio, (i, &models), room),
            false => None,
        };
        let known = Known {
            window,
            ratio: board.ratio,
            around: around.as_ref(),
            given: Given::NearStart,
        };
        let again = known.fit_with(&before.model, before.model.blur.psf, room);
        let again = again.ok().and_then(|again| gate(&ring.seen, again).ok());
        if let Some(again) = again {
            ring.model = again.model;
            // where strangers were left out, the covariance before knows more
            let covariance = match ring.masked {
                true => before.covariance,
                false => again.covariance,
            };
            ring.fitted = Ok(RingFitted {
                covariance,
                ..again
            });
        }
    });
    true
}

/// Change of the blur's size over the picture of the board, px per px; `None` where it is not known, or as good as none.
fn slope(rings: &[Under]) -> Option<Vector2<f64>> {
    let fitted: Vec<RingFitted> = rings.iter().filter_map(|ring| ring.fitted.ok()).collect();
    if fitted.len() < LEAST_RINGS {
        return None;
    }
    let blurred = |fitted: &&RingFitted| {
        let outer = fitted.model.shape.ellipse(1.0);
        outer.is_some_and(|outer| fitted.model.blur.sigma_px() > LEAST_SIGMA * outer.minor)
    };
    if 2 * fitted.iter().filter(blurred).count() < fitted.len() {
        return None;
    }
    let blurs: Vec<(Point2<f64>, f64)> = fitted
        .iter()
        .map(|fitted| (fitted.model.shape.centre, fitted.model.blur.size_px))
        .collect();
    let plane = Plane::through(&blurs)?;
    let most = FAR * median(blurs.iter().map(|blur| plane.off(blur).abs()))?;
    // once more without rings that are half covered, or have found an edge for another
    let used: Vec<_> = blurs
        .into_iter()
        .filter(|blur| plane.off(blur).abs() <= most)
        .collect();
    let plane = Plane::through(&used)?;
    let stds = fitted
        .iter()
        .map(|fitted| (0.5 * fitted.centre_covariance().trace()).sqrt());
    let sizes = used.iter().map(|(_, size)| *size);
    let matters = plane.slope.norm() * median(sizes)? > WORTH * median(stds)?;
    (matters && plane.deviations > SIGNIFICANT).then_some(plane.slope)
}

/// A linear function of the place through values.
struct Plane {
    middle: Point2<f64>,
    at_middle: f64,
    slope: Vector2<f64>,
    /// How far the slope is from none, in standard deviations that the values' scatter gives it.
    deviations: f64,
}

impl Plane {
    fn through(values: &[(Point2<f64>, f64)]) -> Option<Self> {
        let count = values.len() as f64;
        let sum: Vector2<f64> = values.iter().map(|(place, _)| place.coords).sum();
        let middle = Point2::from(sum / count);
        let row = |place: &Point2<f64>| Vector3::new(place.x - middle.x, place.y - middle.y, 1.0);
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for (place, value) in values {
            normal += row(place) * row(place).transpose();
            right += row(place) * *value;
        }
        let inverse = normal.try_inverse()?;
        let found = inverse * right;
        let mut plane = Self {
            middle,
            at_middle: found.z,
            slope: found.xy(),
            deviations: 0.0,
        };
        let squares: f64 = values.iter().map(|value| plane.off(value).powi(2)).sum();
        let variance = squares / (count - 3.0).max(1.0);
        let certainty = inverse.fixed_view::<2, 2>(0, 0).try_inverse()?;
        let square = plane.slope.dot(&(certainty * plane.slope));
        plane.deviations = (square / variance.max(f64::MIN_POSITIVE)).sqrt();
        Some(plane)
    }

    /// A value less the plane's.
    fn off(&self, (place, value): &(Point2<f64>, f64)) -> f64 {
        value - self.at_middle - self.slope.dot(&(place - self.middle))
    }
}

/// Subtracts what uneven blur adds to a window: of its own ring, of those around it, and of the sheet's end.
fn subtract(
    window: &mut Window,
    (own, models): (usize, &[RingModel]),
    (ratio, slope): (f64, Vector2<f64>),
    room: &mut Workspace,
) {
    let grid = window.grid;
    for (i, model) in models.iter().enumerate() {
        if i != own && !reaches(model, &grid) {
            continue;
        }
        if let Some(added) = room.uneven(&grid, model, ratio, slope) {
            for row in 0..grid.height {
                let span = row * grid.stride()..(row + 1) * grid.stride();
                let values = &mut window.values[span.clone()];
                let shades = shades(&models[own], &grid, row);
                for ((value, added), shade) in values.iter_mut().zip(&added[span]).zip(shades) {
                    *value -= added * shade;
                }
            }
        }
    }
    subtract_sheet(window, &models[own], slope);
}

/// The same of the sheet's end: along a straight edge every place has the blur of its foot on the edge.
fn subtract_sheet(window: &mut Window, model: &RingModel, slope: Vector2<f64>) {
    let Some(end) = &model.sheet else { return };
    let grid = window.grid;
    let mut sheet = SheetRow::default();
    let step = end.beyond - model.paper;
    for row in 0..grid.height {
        sheet.fill(end, &model.blur, &grid, row);
        let values = &mut window.values[row * grid.stride()..(row + 1) * grid.stride()];
        let changes = sheet.by_blur.iter().zip(shades(model, &grid, row));
        for (column, (value, (by_square, shade))) in values.iter_mut().zip(changes).enumerate() {
            let place = Point2::new(grid.x(column), grid.y(row));
            let distance = |edge: &Edge| (place - edge.anchor).dot(&edge.normal()) - edge.offset_px;
            let nearest = match &end.other {
                Some(other) if distance(other).abs() < distance(&end.edge).abs() => other,
                _ => &end.edge,
            };
            let foot = place - nearest.normal() * distance(nearest);
            let more = 2.0 * model.blur.size_px * slope.dot(&(foot - model.shape.centre));
            *value -= (step * more) as f32 * by_square * shade;
        }
    }
}

/// What the nodes of an outline lay for this: g . x times x . n, n_x and n_y, x from the ring's centre. (They come with n as the
/// derivatives by the centre.)
pub(super) fn resweep(nodes: &mut [Node], grid: &Grid, centre: Point2<f64>, slope: Vector2<f64>) {
    let [left, top] = [grid.left_px - centre.x, grid.top_px - centre.y];
    for node in nodes {
        let x = left + f64::from(node.x) * grid.pixel_px;
        let y = top + f64::from(node.y) * grid.pixel_px;
        let [nx, ny] = [f64::from(node.sweep[0]), f64::from(node.sweep[1])];
        let growth = slope.x * x + slope.y * y;
        node.sweep = Default::default();
        node.sweep[0] = (growth * (x * nx + y * ny)) as f32;
        node.sweep[1] = (growth * nx) as f32;
        node.sweep[2] = (growth * ny) as f32;
    }
}
