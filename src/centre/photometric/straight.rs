//! What a lens's bends do to a ring's centre, by the fit that gives it.
//!
//! The model's curves are those of a ring in perspective; a lens adds bends that no perspective makes, and the fit settles where grey values
//! agree best. Once the camera is known the bent outlines are. Two pictures of the ring are made, with these outlines and with those of
//! the model, and what they differ by is taken off the pixels. Of a ring without pixels the picture with the bent outlines is fitted, and
//! where that ends is what the bends have moved it by. (`bent` says the same for curves alone: without a blur that mixes the two.)

use super::bent::{Bent, Image};
use super::blur::Blur;
use super::boundary::{Node, trace};
use super::fit::{Given, Known, fit_closely};
use super::fitted::RingFitted;
use super::gaussian::{LEAST_SIGMA, SPACING};
use super::model::RingModel;
use super::problem::Workspace;
use super::rows::light;
use super::shape::{SHAPE_PARAMETERS, Shape};
use super::sheet::SheetRow;
use super::window::{Grid, Window};
use nalgebra::Vector2;
use std::f64::consts::TAU;

/// Pixels across the picture of a ring whose own were not kept.
const ACROSS: f64 = 40.0;
/// Such a picture reaches so many sigmas beyond the ring.
const MARGIN_SIGMAS: f64 = 3.0;
/// A picture is fitted until a step would gain less than this, in variances of the noise that the ring itself has.
const CLOSE: f64 = 0.01;
/// Fewest and most nodes of an outline.
const NODES: (f64, f64) = (24.0, 4000.0);
/// Half the turn (rad) over which the direction of a curve is taken.
const TURN: f64 = 1e-4;

/// Takes what the lens's bends do out of the pixels of a ring: what is left is the ring of `model` with its centre at that of `image`,
/// and its perspective. `None` where it has no image.
pub(super) fn straighten(
    window: &mut Window,
    model: &RingModel,
    image: impl Image,
    ratio: f64,
    room: &mut Workspace,
) -> Option<()> {
    let grid = window.grid;
    let shape = Bent::beside(model.shape, &image, ratio)?.as_large();
    let model = RingModel {
        shape,
        blur: soft(&model.blur, &grid, &shape)?,
        ..*model
    };
    let bent = picture_of_bent(&grid, &model, image, ratio, room)?;
    // drawn as the bent one is, so that they differ by the bends alone
    let nodes = |radius: f64, spacing: f64, nodes: &mut Vec<Node>| {
        trace(nodes, &grid, &shape, radius, spacing)
    };
    let straight = room.traced(&grid, &model.blur, ratio, nodes)?;
    let straight = picture(&grid, &model, straight);
    for (value, (bent, straight)) in window.values.iter_mut().zip(bent.iter().zip(&straight)) {
        *value -= bent - straight;
    }
    Some(())
}

/// The shape that a free fit finds of a ring of this light and blur that is bent so; `None` where it has no image.
pub(super) fn found_of_bent(
    fitted: &RingFitted,
    bent: &Bent,
    image: impl Image,
    ratio: f64,
    room: &mut Workspace,
) -> Option<Shape> {
    let light = fitted.model;
    let mut window = Window::blank(grid_about(&bent.straight, &light.blur)?);
    let grid = window.grid;
    let model = RingModel {
        shape: bent.as_large(),
        blur: soft(&light.blur, &grid, &bent.straight)?,
        ..light
    };
    window.values = picture_of_bent(&grid, &model, image, ratio, room)?;
    let known = Known {
        window: &window,
        ratio,
        around: None,
        given: Given::NearStart,
    };
    let close = CLOSE * fitted.noise.powi(2);
    Some(fit_closely(&known, &model, close, room).ok()?.model.shape)
}

/// The picture of a ring with the levels of `model` and bent outlines, in padded rows.
fn picture_of_bent(
    grid: &Grid,
    model: &RingModel,
    image: impl Image,
    ratio: f64,
    room: &mut Workspace,
) -> Option<Vec<f32>> {
    let nodes = |radius: f64, spacing: f64, nodes: &mut Vec<Node>| {
        trace_bent(nodes, grid, &model.shape, &image, (radius, spacing))
    };
    let circles = room.traced(grid, &model.blur, ratio, nodes)?;
    Some(picture(grid, model, circles))
}

/// The light of these coverages, in padded rows.
fn picture(grid: &Grid, model: &RingModel, circles: &[Vec<f32>; 2]) -> Vec<f32> {
    let (stride, mut sheet) = (grid.stride(), SheetRow::default());
    let mut picture = vec![0.0; stride * grid.height];
    for (row, out) in picture.chunks_exact_mut(stride).enumerate() {
        light((model, grid), row, circles, None, (&mut sheet, out));
    }
    picture
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

/// The blur, or one that nodes can lay along so long an outline; what bends do to a sharper one is nearly the same. `None` where there is no
/// outline.
fn soft(blur: &Blur, grid: &Grid, shape: &Shape) -> Option<Blur> {
    let length_px = TAU * shape.ellipse(1.0)?.major;
    let least_px = (length_px / (NODES.1 * SPACING)).max(LEAST_SIGMA * grid.pixel_px);
    Some(if blur.sigma_px() < least_px {
        Blur::of_sigma(blur.psf, least_px)
    } else {
        *blur
    })
}

/// The nodes of a bent circle, at most `spacing` pixels of the grid apart.
fn trace_bent(
    nodes: &mut Vec<Node>,
    grid: &Grid,
    shape: &Shape,
    image: &impl Image,
    (radius, spacing): (f64, f64),
) -> Option<()> {
    let scale = 1.0 / grid.pixel_px;
    let length_px = TAU * shape.ellipse(radius)?.major;
    let count = (length_px * scale / spacing).ceil().clamp(NODES.0, NODES.1);
    let at = |turn: f64| {
        let (sin, cos) = turn.sin_cos();
        image(Vector2::new(cos, sin) * radius)
    };
    // the outline has to run the way of an ellipse's angle, whichever way up the board is
    let quarter = [at(0.0)? - shape.centre, at(0.25 * TAU)? - shape.centre];
    let way = quarter[0].perp(&quarter[1]).signum();
    nodes.clear();
    for i in 0..count as usize {
        let turn = way * TAU * i as f64 / count;
        let place = at(turn)?;
        let fall = (at(turn - TURN)? - at(turn + TURN)?).y * (way * TAU / count / (2.0 * TURN));
        nodes.push(Node {
            x: ((place.x - grid.left_px) * scale) as f32,
            y: ((place.y - grid.top_px) * scale) as f32,
            rise: (fall * scale) as f32,
            sweep: [0.0; SHAPE_PARAMETERS],
        });
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::super::fitted::ShapeCovariance;
    use super::super::lens_map::shape_under;
    use super::*;
    use nalgebra::Point2;

    fn fitted(shape: Shape, sigma_px: f64, noise: f64) -> RingFitted {
        let model = RingModel {
            shape,
            blur: Blur::gaussian(sigma_px),
            paper: 0.85,
            ring: 0.1,
            inside: 0.85,
            shading: [0.0; 2],
            sheet: None,
        };
        RingFitted {
            model,
            covariance: ShapeCovariance::identity(),
            noise,
            squares: 0.0,
            pixels: 0,
            darkest: 0.0,
        }
    }

    /// Steep rings are narrow ellipses, and most pixels of a coarse picture are far from their edges.
    #[test]
    fn a_steep_ring_that_nothing_bends_is_found_where_it_is() {
        let mut room = Workspace::default();
        for turn in (0..72).map(|i| TAU * f64::from(i) / 72.0) {
            for (tilt, radius_px) in [(0.3_f64, 20.0), (0.8, 35.0), (1.0, 45.0), (1.0, 70.0)] {
                let (s, c) = turn.sin_cos();
                let image = |d: Vector2<f64>| {
                    // outer radii about the ring's centre, 20 of them away from a pinhole, tilted about the direction of the turn
                    let (along, across) = (c * d.x + s * d.y, c * d.y - s * d.x);
                    let depth = 1.0 + across * tilt.sin() / 20.0;
                    let (x, y) = (along / depth, across * tilt.cos() / depth);
                    Some(Point2::new(
                        400.3 + radius_px * (c * x - s * y),
                        300.7 + radius_px * (s * x + c * y),
                    ))
                };
                let shape = shape_under(image).unwrap();
                let fitted = fitted(shape, 2.0, 0.005);
                let bent = Bent::beside(shape, &image, 0.5).unwrap();
                let found = found_of_bent(&fitted, &bent, image, 0.5, &mut room);
                let off = (found.unwrap().centre - shape.centre).norm();
                assert!(
                    off < 5e-3,
                    "turn {turn}, tilt {tilt}, {radius_px} px: {off}"
                );
            }
        }
    }

    /// Where blur is small against the ring, the curves alone say what a fit finds; what it is otherwise off by is within what is told.
    #[test]
    fn a_fit_finds_of_a_bent_ring_what_its_curves_say_the_more_so_the_less_blur() {
        let mut room = Workspace::default();
        for radius_px in [24.0, 60.0] {
            let image = |d: Vector2<f64>| {
                let at = Vector2::new(420.0, 250.0) + d * radius_px;
                Some(Point2::from(at * (1.0 - 6e-7 * at.norm_squared())))
            };
            let bent = Bent::of(&image, 0.5).unwrap();
            for sigma_px in [0.02 * radius_px, 0.06 * radius_px, 0.2 * radius_px] {
                let fitted = fitted(bent.straight, sigma_px, 1e-4);
                let found = found_of_bent(&fitted, &bent, image, 0.5, &mut room).unwrap();
                let off = (found.centre - bent.free().unwrap().centre).norm();
                let most = bent.unlike_px(sigma_px);
                assert!(off < most, "{radius_px} px, {sigma_px} px: {off}, {most}");
            }
        }
    }
}
