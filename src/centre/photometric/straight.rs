//! What a lens's bends do to a ring's centre, by the fit that gives it.
//!
//! The model's curves are those of a ring in perspective; a lens adds bends that no perspective makes, and the fit settles where grey values
//! agree best. Once the camera is known the bends are: where an outline lies outwards of the model's by d, the picture changes by the
//! step of light times d times the blur, all along it. That is added to the picture of the model, the model fitted to it, and where
//! it ends is what the bends have moved it by. (`bent` says the same for curves alone: without a blur that mixes the two.)

use super::bent::{implicit, laid};
use super::blur::{Blur, Psf};
use super::boundary::Node;
use super::fit::{Given, Known};
use super::kept::KeptRing;
use super::model::RingModel;
use super::problem::Workspace;
use super::shape::{SHAPE_PARAMETERS, Shape};
use super::sharp::MOST_SIGMA;
use super::window::{Grid, Window};
use nalgebra::{Point2, Vector2};
use std::f64::consts::TAU;

/// Pixels across the picture of a ring whose own were not kept.
const ACROSS: f64 = 40.0;
/// Such a picture reaches so many sigmas beyond the ring.
const MARGIN_SIGMAS: f64 = 3.0;
/// Fewest and most nodes of an outline.
const NODES: (f64, f64) = (24.0, 4000.0);
/// Half the turn (rad) over which the direction of a curve is taken.
const TURN: f64 = 1e-4;

/// The shape that a fit finds of a bent ring: `image` is the map from outer radii about its centre to the frame, `shape` the ring without its
/// bends. `None` where it has no image.
pub(super) fn found_of_bent(
    kept: &KeptRing,
    shape: &Shape,
    image: impl Fn(Vector2<f64>) -> Option<Point2<f64>>,
    (ratio, given): (f64, Given),
    room: &mut Workspace,
) -> Option<Shape> {
    let fitted = &kept.fitted.model;
    let mut window = match &kept.window {
        Some(window) => window.restore(),
        None => Window::blank(grid_about(shape, &fitted.blur)?),
    };
    let grid = window.grid;
    // as large as a fit makes it: what is left beside its curves has no part that a window's pixels could take for a move
    let shape = &Shape {
        centre: shape.centre,
        ..laid(&image, shape, ratio)?
    };
    let model = RingModel {
        shape: *shape,
        blur: soft(&fitted.blur, &grid),
        ..*fitted
    };
    window.censored.clear();
    window.values.fill(0.0);
    let mut picture: Vec<f32> = room.residuals(&known(&window, ratio), &model).to_vec();
    let nodes = |radius: f64, spacing: f64, nodes: &mut Vec<Node>| {
        trace_bends(nodes, &grid, shape, &image, (radius, spacing))
    };
    let added = room.displaced(&grid, &model, ratio, nodes)?;
    let stride = grid.stride();
    for (row, (picture, added)) in picture
        .chunks_exact_mut(stride)
        .zip(added.chunks_exact(stride))
        .enumerate()
    {
        for ((value, added), shade) in picture.iter_mut().zip(added).zip(model.shades(&grid, row)) {
            *value = added * shade - *value;
        }
    }
    window.values = picture;
    let again = Known {
        given,
        ..known(&window, ratio)
    }
    .fit_with(&model, model.blur.psf, room)
    .ok()?;
    Some(again.model.shape)
}

/// The picture as a fit of known shape sees it.
fn known(window: &Window, ratio: f64) -> Known<'_> {
    Known {
        window,
        ratio,
        around: None,
        given: Given::Shape,
    }
}

/// A grid about a ring, coarser where it is larger.
fn grid_about(shape: &Shape, blur: &Blur) -> Option<Grid> {
    let outer = shape.ellipse(1.0)?;
    let reach = outer.major + MARGIN_SIGMAS * blur.sigma_px() + 1.0;
    let pixel_px = (2.0 * reach / ACROSS).max(1.0);
    let size = (2.0 * reach / pixel_px).ceil() as usize + 1;
    let half = 0.5 * (size as f64 - 1.0) * pixel_px;
    Some(Grid {
        left_px: outer.centre.x - half,
        top_px: outer.centre.y - half,
        pixel_px,
        width: size,
        height: size,
    })
}

/// A blur that nodes can lay: what bends do to a sharper ring is the same.
fn soft(blur: &Blur, grid: &Grid) -> Blur {
    let least = MOST_SIGMA * grid.pixel_px;
    match blur.psf {
        Psf::Gaussian if blur.size_px < least => Blur::gaussian(least),
        Psf::Disc if blur.sigma_px() < least => Blur::of_sigma(Psf::Disc, least),
        _ => *blur,
    }
}

/// The nodes of a bent circle, at most `spacing` pixels of the grid apart; their first sweep is how far they lie outside the model's.
fn trace_bends(
    nodes: &mut Vec<Node>,
    grid: &Grid,
    shape: &Shape,
    image: &impl Fn(Vector2<f64>) -> Option<Point2<f64>>,
    (radius, spacing): (f64, f64),
) -> Option<()> {
    let scale = 1.0 / grid.pixel_px;
    let length_px = TAU * shape.ellipse(radius)?.major;
    let count = (length_px * scale / spacing).ceil().clamp(NODES.0, NODES.1);
    let at = |turn: f64| {
        let (sin, cos) = turn.sin_cos();
        image(Vector2::new(cos, sin) * radius)
    };
    nodes.clear();
    for i in 0..count as usize {
        let turn = TAU * i as f64 / count;
        let place = at(turn)?;
        let along = (at(turn + TURN)? - at(turn - TURN)?) * (TAU / count / (2.0 * TURN));
        let (value, _, slope) = implicit(shape, &place, radius);
        let outwards = value / slope.norm();
        let mut sweep = [0.0; SHAPE_PARAMETERS];
        sweep[0] = (outwards * along.norm() * scale * scale) as f32;
        nodes.push(Node {
            x: ((place.x - grid.left_px) * scale) as f32,
            y: ((place.y - grid.top_px) * scale) as f32,
            rise: 0.0,
            sweep,
        });
    }
    Some(())
}
