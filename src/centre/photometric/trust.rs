//! Which pixels around a ring show what the model knows: paper.
//!
//! The edge of the sheet, a hand, print or an unknown ring within the window would pull the fit. They come from beyond the ring, so
//! the surroundings are taken in blocks, eight directions by layers of half a blur sigma; a block whose mean residual is
//! more than noise is strange. A fit that they have pulled hides some of it, so once a direction is suspected the ring is
//! fitted without it, and only what is strange to that fit is left out, with the layer before it and all behind it.

use super::coverage::LANES;
use super::fitted::RingFitted;
use super::shape::Shape;
use super::window::{Grid, Window};
use crate::frame::widest;
use nalgebra::Vector2;
use std::ops::Range;

const DIRECTIONS: usize = 8;
/// Layers from one blur sigma inside the outer circle outwards; the last has no end.
const LAYERS: usize = 7;
const INSIDE_LAYERS: usize = 2;
/// The first layer that anything beyond the ring reaches; those before are its own.
const FIRST_SUSPECT: usize = 1;
/// Thickness of a layer, blur sigmas; and at least this many pixels of the window.
const LAYER_SIGMAS: f64 = 0.5;
const LEAST_LAYER_PIXELS: f64 = 1.0;
/// A block's mean residual may be so many of its standard deviations, and this fraction of the contrast more. Residuals of a real
/// picture (sharpened, compressed) are alike from pixel to pixel: more than this number of them does not make a mean better.
const MOST_DEVIATIONS: f64 = 3.8;
const INDEPENDENT: f64 = 4.0;
const MODEL_ERROR: f64 = 4e-3;
/// The same beside the outer circle, up to two sigmas out: a lens bends the edge by a few hundredths of a pixel.
const BENT_ERROR: f64 = 1.5e-2;
const BENT_LAYERS: usize = INSIDE_LAYERS + 2;
/// Directions that are suspected at most, and that must be left in the end.
const MOST_SUSPECTS: usize = 5;
const LEAST_DIRECTIONS: usize = 3;

/// The blocks around one ring.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surroundings {
    shape: Shape,
    /// Layers for each unit of the radius, in outer radii.
    layers_per_radius: f64,
}

/// For each direction the first layer that is not trusted.
pub(super) type Trusted = [usize; DIRECTIONS];

/// Everything is trusted.
const ALL: Trusted = [LAYERS; DIRECTIONS];

/// What the surroundings look like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Judgement {
    trusted: Trusted,
    /// The strangest block of each direction, in what noise allows.
    strangeness: [f64; DIRECTIONS],
}

impl Judgement {
    /// Whether nothing is strange.
    pub(super) fn is_clean(&self) -> bool {
        self.trusted == ALL
    }

    /// The strangest directions, and those beside them, trusted no farther than the ring itself; half of them at most.
    pub(super) fn without_suspects(&self) -> Trusted {
        let mut order: [usize; DIRECTIONS] = std::array::from_fn(|direction| direction);
        order.sort_by(|&a, &b| self.strangeness[b].total_cmp(&self.strangeness[a]));
        let mut left = ALL;
        let mut masked = 0;
        for direction in order.into_iter().filter(|&d| self.strangeness[d] > 1.0) {
            // directions that share a border differ in one bit
            let around = (0..3).map(|bit| direction ^ (1 << bit));
            for one in std::iter::once(direction).chain(around) {
                if masked < MOST_SUSPECTS && left[one] == LAYERS {
                    left[one] = FIRST_SUSPECT;
                    masked += 1;
                }
            }
        }
        left
    }

    /// How far each direction is trusted in the end. Where hardly any is left nothing can be said of the paper, and whatever
    /// stands there has to be believed.
    pub(super) fn verdict(&self) -> Trusted {
        let whole = self.trusted.iter().filter(|&&layers| layers == LAYERS);
        if whole.count() < LEAST_DIRECTIONS {
            ALL
        } else {
            self.trusted
        }
    }
}

impl Surroundings {
    pub(super) fn of(fitted: &RingFitted, grid: &Grid) -> Option<Self> {
        let shape = fitted.model.shape;
        let outer = shape.ellipse(1.0)?;
        let radius_px = outer.mean_radius();
        let sigma_px = fitted.model.blur.sigma_px();
        let layer_px = (LAYER_SIGMAS * sigma_px).max(LEAST_LAYER_PIXELS * grid.pixel_px);
        Some(Self {
            shape,
            layers_per_radius: radius_px / layer_px,
        })
    }

    /// Direction and layer of a place; `None` well inside the outer circle.
    fn block(&self, x: f64, y: f64) -> Option<(usize, usize)> {
        let at = Vector2::new(x - self.shape.centre.x, y - self.shape.centre.y);
        let [xx, xy, yy] = self.shape.affine;
        let depth = 1.0 - self.shape.perspective.dot(&at);
        let square = xx * at.x * at.x + 2.0 * xy * at.x * at.y + yy * at.y * at.y;
        let beyond = square.sqrt() / depth.abs() - 1.0;
        let layer = beyond * self.layers_per_radius + INSIDE_LAYERS as f64;
        if layer < 0.0 {
            return None;
        }
        Some((self.direction((x, y)), (layer as usize).min(LAYERS - 1)))
    }

    /// Direction of a place.
    fn direction(&self, (x, y): (f64, f64)) -> usize {
        let (x, y) = (x - self.shape.centre.x, y - self.shape.centre.y);
        usize::from(x > 0.0) | usize::from(y > 0.0) << 1 | usize::from(x.abs() > y.abs()) << 2
    }

    /// The columns of a row in runs that have one direction each.
    fn alike(&self, grid: &Grid, row: usize) -> [Range<usize>; 4] {
        let aside = (grid.y(row) - self.shape.centre.y).abs();
        let x = self.shape.centre.x;
        // the first column beyond a place, and the first that is not before it
        let place = |x: f64| ((x - grid.left_px) / grid.pixel_px).clamp(-1.0, grid.width as f64);
        let beyond = |x: f64| (place(x).floor() + 1.0) as usize;
        let from = |x: f64| place(x).ceil().max(0.0) as usize;
        let ends = [from(x - aside), beyond(x), beyond(x + aside), grid.width];
        let mut start = 0;
        ends.map(|end| {
            let run = start..end.clamp(start, grid.width);
            start = run.end;
            run
        })
    }

    /// Layers of the pixels of a row, with their fractions.
    fn layers(&self, grid: &Grid, row: usize, out: &mut [f32]) {
        let y = (grid.y(row) - self.shape.centre.y) as f32;
        let left = (grid.left_px - self.shape.centre.x) as f32;
        let pixel = grid.pixel_px as f32;
        let [xx, xy, yy] = self.shape.affine.map(|v| v as f32);
        let (qx, qy) = (
            self.shape.perspective.x as f32,
            self.shape.perspective.y as f32,
        );
        let (per_radius, inside) = (self.layers_per_radius as f32, INSIDE_LAYERS as f32);
        widest(
            #[inline(always)]
            || {
                for (column, layer) in out.iter_mut().enumerate() {
                    let x = left + column as f32 * pixel;
                    let square = (xx * x + 2.0 * xy * y) * x + yy * y * y;
                    let depth = (1.0 - qx * x - qy * y).abs();
                    *layer = (square.max(0.0).sqrt() / depth - 1.0) * per_radius + inside;
                }
            },
        );
    }

    /// How far each direction is to be trusted, by the residuals of a fit (padded rows like the window's).
    pub(super) fn judge(
        &self,
        window: &Window,
        residuals: &[f32],
        fitted: &RingFitted,
    ) -> Judgement {
        let (grid, stride) = (&window.grid, window.grid.stride());
        let mut blocks = [[Block::default(); LAYERS]; DIRECTIONS];
        let mut own = Own::default();
        let mut layers = vec![0.0_f32; stride];
        for row in 0..grid.height {
            let span = row * stride..(row + 1) * stride;
            let (residuals, weights) = (&residuals[span.clone()], &window.weights[span]);
            self.layers(grid, row, &mut layers);
            own.add_inside(&layers, residuals, weights);
            for columns in self.alike(grid, row) {
                let Some(first) = columns.clone().next() else {
                    continue;
                };
                let blocks = &mut blocks[self.direction((grid.x(first), grid.y(row)))];
                for column in columns {
                    if layers[column] >= FIRST_SUSPECT as f32 && weights[column] > 0.0 {
                        let layer = (layers[column] as usize).min(LAYERS - 1);
                        blocks[layer].add(residuals[column]);
                    }
                }
            }
        }
        let noise = (own.squares / own.pixels.max(1.0)).sqrt();
        let contrast = (fitted.model.paper - fitted.model.ring).abs();
        let strange = blocks.map(|layers| {
            let error = |layer| {
                if layer < BENT_LAYERS {
                    BENT_ERROR
                } else {
                    MODEL_ERROR
                }
            };
            std::array::from_fn(|layer| layers[layer].strangeness(noise, error(layer) * contrast))
        });
        let trusted = strange.map(|layers: [f64; LAYERS]| {
            (FIRST_SUSPECT..LAYERS)
                .find(|&layer| layers[layer] > 1.0)
                .map_or(LAYERS, |first| (first - 1).max(FIRST_SUSPECT))
        });
        Judgement {
            trusted,
            strangeness: strange.map(|layers| layers.into_iter().fold(0.0, f64::max)),
        }
    }

    /// Leaves the untrusted pixels out of a window.
    pub(super) fn mask(&self, window: &mut Window, trusted: &Trusted) {
        window.keep(|x, y| {
            self.block(x, y)
                .is_none_or(|(direction, layer)| layer < trusted[direction])
        });
    }
}

/// Pixels of one direction and layer.
#[derive(Debug, Clone, Copy, Default)]
struct Block {
    sum: f64,
    pixels: f64,
}

/// The ring's own pixels.
#[derive(Debug, Clone, Copy, Default)]
struct Own {
    squares: f64,
    pixels: f64,
}

impl Own {
    /// Adds the pixels of a row that are the ring's own.
    fn add_inside(&mut self, layers: &[f32], residuals: &[f32], weights: &[f32]) {
        let (mut squares, mut pixels) = (0.0, 0.0);
        widest(
            #[inline(always)]
            || {
                let (mut sums, mut counts) = ([0.0_f32; LANES], [0.0_f32; LANES]);
                let layers = layers.chunks_exact(LANES);
                let residuals = residuals.chunks_exact(LANES);
                let rows = layers.zip(residuals).zip(weights.chunks_exact(LANES));
                for ((layers, residuals), weights) in rows {
                    for l in 0..LANES {
                        let own = layers[l] < FIRST_SUSPECT as f32;
                        let weight = if own { weights[l] } else { 0.0 };
                        sums[l] += weight * residuals[l] * residuals[l];
                        counts[l] += weight;
                    }
                }
                squares = f64::from(sums.iter().sum::<f32>());
                pixels = f64::from(counts.iter().sum::<f32>());
            },
        );
        self.squares += squares;
        self.pixels += pixels;
    }
}

impl Block {
    fn add(&mut self, residual: f32) {
        self.sum += f64::from(residual);
        self.pixels += 1.0;
    }

    /// The mean residual over what noise allows.
    fn strangeness(&self, noise: f64, error: f64) -> f64 {
        let mean = self.sum / self.pixels.max(1.0);
        let independent = self.pixels.clamp(1.0, INDEPENDENT);
        mean.abs() / (MOST_DEVIATIONS * noise / independent.sqrt() + error)
    }
}
