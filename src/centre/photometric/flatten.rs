//! Rings fitted to pixels that the lens's bends have been taken out of.
//!
//! Large rings before a wide lens are bent by tenths of a pixel, which no perspective explains. What is left over beside the outline looks
//! like the end of a sheet, or like something that covers the ring: it was fitted as such, or the ring was not believed. But the map
//! through the centres of a board's rings knows the bends to a few per cent, even where each centre is off by some hundredths. So
//! the bends it says are subtracted, as the second pass subtracts those of a known camera, and what stands around the ring is judged
//! without them. In the end they are put back ([`bend_back`]): whoever knows the camera takes off the true ones.

use super::bent::Bent;
use super::board::{BoardPlace, BoardStart};
use super::fitted::RingFitted;
use super::lens_map::LensMap;
use super::model::RingModel;
use super::plane::PlaneView;
use super::problem::Workspace;
use super::shape::Shape;
use super::shared::Shared;
use super::start::Cut;
use super::straight::{found_of_bent, straighten};
use super::under::Under;
use crate::frame::Frame;
use nalgebra::Vector2;
use rayon::prelude::*;

/// Bends (root mean square) b change the light at an edge by 0.4 b / s of the contrast, s the blur with the pixel's own. They show from this
/// part of the contrast on, and from this part of the noise.
const SHOWN: f64 = 8e-4;
const SHOWN_BESIDE_NOISE: f64 = 0.4;
/// What a pixel blurs, sigma px.
const PIXEL_SIGMA: f64 = 0.3;
/// Times that a ring's bends are taken off: first where the ring seems to be, then where it was found.
const TIMES: usize = 2;

/// What was taken out of a ring's pixels, and what that does to a fit of them.
#[derive(Debug, Clone)]
pub(super) struct Bends {
    /// Light, in padded rows like the window's.
    light: Vec<f32>,
    /// A free fit of the bent ring less that of the straight one: centre, px, and perspective, px^-1.
    centre: Vector2<f64>,
    perspective: Vector2<f64>,
}

/// Fits the rings again that the lens bends, without their bends, as the map through all says them; says whether there was any.
pub(super) fn flatten(
    frame: &Frame,
    (board, view): (&BoardStart, Option<&PlaneView>),
    rings: &mut [Under],
    shared: &Shared,
) -> bool {
    let Some(map) = &shared.map else {
        return false;
    };
    let models: Vec<RingModel> = rings.iter().map(|ring| ring.model).collect();
    let work = rings.par_iter_mut().zip(board.places).zip(&shared.bent);
    let work = work.enumerate();
    let flattened = work.map_init(Workspace::default, |room, (i, ((ring, place), bent))| {
        let Some(bent) = bent.filter(|bent| shows((ring, *bent))) else {
            return false;
        };
        let standing = (board, place, view);
        let flat = flat(frame, standing, (ring, map, &bent), (i, &models), room);
        flat.map(|flat| *ring = flat).is_some()
    });
    flattened.reduce(|| false, |a, b| a || b)
}

/// Whether bends show in the pixels of a ring.
fn shows((ring, bent): (&Under, Bent)) -> bool {
    let model = &ring.model;
    let contrast = (model.paper - model.ring).abs();
    let noise = ring.fitted.map_or(0.0, |fitted| fitted.noise);
    let light = 0.4 * bent.beside_px / model.blur.sigma_px().hypot(PIXEL_SIGMA);
    light > SHOWN && light * contrast > SHOWN_BESIDE_NOISE * noise
}

/// One ring without its bends; `None` where it is no ring without them either.
fn flat(
    frame: &Frame,
    standing: (&BoardStart, &BoardPlace, Option<&PlaneView>),
    (ring, map, bent): (&Under, &LensMap, &Bent),
    others: (usize, &[RingModel]),
    room: &mut Workspace,
) -> Option<Under> {
    let (board, place, _) = standing;
    let image = |d: Vector2<f64>| map.place(place.plane_m + d * board.outer_radius_m);
    let shape = bent.straight;
    let mut start = RingModel {
        shape: Shape {
            centre: ring
                .fitted
                .map_or(shape.centre, |fitted| fitted.model.shape.centre),
            ..shape
        },
        // what was taken for the sheet's end may have been the bends
        sheet: None,
        ..ring.model
    };
    let mut flat = None;
    for _ in 0..TIMES {
        let mut again = Under::at(frame, board, (ring.seen, Cut::OF_BOARD), start);
        let window = again.window.as_mut()?;
        let bent = window.values.clone();
        let off = start.shape.centre - shape.centre;
        straighten(window, &start, |d| Some(image(d)? + off), board.ratio, room)?;
        let pairs = bent.iter().zip(&window.values);
        let light = pairs.map(|(bent, straight)| bent - straight).collect();
        again.fit(standing, others, room);
        let fitted = again.fitted.ok()?;
        start = RingModel {
            shape: Shape {
                perspective: shape.perspective,
                ..fitted.model.shape
            },
            sheet: None,
            ..fitted.model
        };
        flat = Some((again, light));
    }
    let (mut flat, light) = flat?;
    let fitted = RingFitted {
        model: start,
        ..flat.fitted.ok()?
    };
    let found = found_of_bent(&fitted, bent, image, board.ratio, room)?;
    flat.bends = Some(Bends {
        light,
        centre: found.centre - shape.centre,
        perspective: found.perspective - shape.perspective,
    });
    Some(flat)
}

/// Puts back what was taken out of the rings' pixels: windows as they were seen, and fits as a free one would be; says whether there was any.
pub(super) fn bend_back(rings: &mut [Under]) -> bool {
    let mut any = false;
    for ring in rings {
        let Some(bends) = ring.bends.take() else {
            continue;
        };
        any = true;
        if let Some(window) = &mut ring.window {
            let pairs = window.values.iter_mut().zip(&bends.light);
            pairs.for_each(|(value, light)| *value += light);
        }
        if let Ok(fitted) = &mut ring.fitted {
            fitted.model.shape.centre += bends.centre;
            fitted.model.shape.perspective += bends.perspective;
            ring.model = fitted.model;
        }
    }
    any
}
