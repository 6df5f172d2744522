//! What is told from noise, and where.
//!
//! A sheet of paper before grass or gravel is the quietest part of its frame. By the noise of the whole frame its faint rings would be
//! lost; so every tile of the picture has a margin of its own, where it is quieter than the whole. (Never a larger one: in the midst of
//! a board the differences are those of its rings.)

use super::band_pass::smooth_row;
use crate::frame::{Pixel, Plane};
use std::ops::Range;

/// Side of a tile, px of the level: a multiple of the pixels that are looked at together (`blobs`).
pub(super) const TILE: usize = 32;
/// How far above the noise a difference must be, in standard deviations.
const NOISE_FACTOR: f32 = 2.5;
/// The least difference that counts, as a fraction of the picture's range.
const RANGE_FRACTION: f32 = 0.008;
/// Every how many pixels, each way, a tile is sampled.
const TILE_SAMPLING: usize = 4;
/// The noise of a tile comes from few samples: so much above what they say it may be.
const TILE_CAUTION: f32 = 1.25;

/// The least difference that counts, everywhere in a picture.
#[derive(Debug, Clone)]
pub(super) struct Margins {
    /// By row, then column, of tiles.
    tiles: Vec<f32>,
    columns: usize,
}

/// The margin of a picture as a whole.
#[derive(Debug, Clone, Copy)]
pub(super) struct Usual {
    /// Standard deviation of the noise that smoothing leaves.
    noise: f32,
    /// The least difference that counts however little noise there is.
    least: f32,
}

impl Usual {
    /// Of some thousand of a picture's pixels, smoothed.
    pub(super) fn of<T: Pixel>(picture: &Plane<T>) -> Self {
        let every = sampling(picture);
        let (mut room, mut row) = (Vec::new(), vec![0.0; picture.width()]);
        let (mut differences, mut greys) = (Vec::new(), Vec::new());
        for y in (0..picture.height()).step_by(every) {
            smooth_row(picture, y, &mut room, &mut row);
            differences.extend(row.windows(7).step_by(every).map(second));
            greys.extend(row.iter().step_by(every));
        }
        Self {
            noise: of_differences(&mut differences),
            least: RANGE_FRACTION * range(&mut greys),
        }
    }
}

/// The margins of the tiles in some rows of a smoothed picture, by row, then column.
pub(super) fn tile_margins(smooth: &Plane<f32>, rows: Range<usize>, usual: &Usual) -> Vec<f32> {
    let columns = smooth.width().div_ceil(TILE);
    let corners = rows
        .clone()
        .step_by(TILE)
        .flat_map(|y| (0..columns).map(move |column| (column * TILE, y)));
    corners
        .map(|(x, y)| {
            let own = (y + TILE <= rows.end).then(|| tile_noise(smooth, x, y));
            let quiet = own
                .flatten()
                .map_or(usual.noise, |noise| usual.noise.min(TILE_CAUTION * noise));
            (NOISE_FACTOR * quiet).max(usual.least)
        })
        .collect()
}

impl Margins {
    /// Of no rows yet, so wide, px.
    pub(super) fn new(width: usize) -> Self {
        Self {
            tiles: Vec::new(),
            columns: width.div_ceil(TILE),
        }
    }

    /// Adds rows of tiles.
    pub(super) fn extend(&mut self, tiles: Vec<f32>) {
        self.tiles.extend(tiles);
    }

    /// The same everywhere, for a picture of this size.
    #[cfg(test)]
    pub(super) fn everywhere(margin: f32, width: usize, height: usize) -> Self {
        let columns = width.div_ceil(TILE);
        Self {
            tiles: vec![margin; columns * height.div_ceil(TILE)],
            columns,
        }
    }

    /// Those of the tiles along a row of pixels.
    #[cfg(test)]
    pub(super) fn of_row(&self, y: usize) -> &[f32] {
        let first = y / TILE * self.columns;
        &self.tiles[first..first + self.columns]
    }

    /// That of a place, px; of the nearest tile where it lies outside.
    pub(super) fn at(&self, x: f64, y: f64) -> f32 {
        let tile = |v: f64, count: usize| (v.max(0.0) as usize / TILE).min(count.saturating_sub(1));
        let rows = self.tiles.len() / self.columns.max(1);
        let at = tile(y, rows) * self.columns + tile(x, self.columns);
        self.tiles.get(at).copied().unwrap_or(0.0)
    }
}

/// Every how many pixels the statistics of a picture are sampled at least, and how many samples are enough.
const SAMPLING: usize = 7;
const SAMPLES: usize = 6000;

/// Every how many pixels, each way.
fn sampling<T: Pixel>(picture: &Plane<T>) -> usize {
    let pixels = picture.width() * picture.height();
    SAMPLING.max((pixels / SAMPLES).isqrt())
}

/// Standard deviation of the noise that smoothing left of one tile, by its upper left corner: the median of second differences over three
/// pixels, which structure hardly moves. `None` where the picture ends within it.
fn tile_noise(smooth: &Plane<f32>, x: usize, y: usize) -> Option<f32> {
    if x + TILE > smooth.width() || y + TILE > smooth.height() {
        return None;
    }
    const EACH_WAY: usize = TILE / TILE_SAMPLING;
    let mut differences = [0.0_f32; EACH_WAY * EACH_WAY];
    let mut count = 0;
    for row in (y..y + TILE).step_by(TILE_SAMPLING) {
        let pixels = &smooth.row(row)[x..x + TILE];
        for window in pixels.windows(7).step_by(TILE_SAMPLING) {
            differences[count] = second(window);
            count += 1;
        }
    }
    Some(of_differences(&mut differences[..count]))
}

/// Second difference over a window of seven pixels: three of them that share no noise.
fn second(window: &[f32]) -> f32 {
    (window[3] - 0.5 * (window[0] + window[6])).abs()
}

/// Standard deviation of the noise from second differences.
fn of_differences(differences: &mut [f32]) -> f32 {
    // three independent pixels with weights 1, 1/2, 1/2: variance 1.5; the median of |normal| is 0.6745 sigma
    quantile(differences, 0.5) / (0.6745 * 1.5_f32.sqrt())
}

/// From the 2nd to the 98th percentile of the grey values.
fn range(greys: &mut [f32]) -> f32 {
    quantile(greys, 0.98) - quantile(greys, 0.02)
}

fn quantile(values: &mut [f32], fraction: f32) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let at = ((values.len() - 1) as f32 * fraction) as usize;
    *values.select_nth_unstable_by(at, f32::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detect::band_pass::BandPass;
    use rand::{RngExt, SeedableRng};

    fn margins(picture: &Plane<f32>) -> Margins {
        BandPass::of(picture).margins
    }

    #[test]
    fn a_quiet_part_has_a_smaller_margin_than_the_rest() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let (width, height) = (320, 256);
        let data = (0..width * height)
            .map(|i| {
                let (x, y) = (i % width, i / width);
                let quiet = (96..192).contains(&x) && (96..192).contains(&y);
                0.5 + if quiet { 0.01 } else { 0.3 } * (random.random::<f32>() - 0.5)
            })
            .collect();
        let margins = margins(&Plane::from_vec(width, height, data).unwrap());
        assert!(margins.at(140.0, 140.0) < 0.1 * margins.at(20.0, 20.0));
        assert_eq!(margins.at(140.0, 140.0), margins.of_row(140)[4]);
        assert_eq!(margins.at(-5.0, 1e4), margins.of_row(255)[0]);
    }

    #[test]
    fn even_noise_has_nearly_one_margin() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(4);
        let data = (0..640 * 480).map(|_| random.random()).collect();
        let margins = margins(&Plane::from_vec(640, 480, data).unwrap());
        let usual = margins.tiles.iter().copied().fold(0.0, f32::max);
        let lower = margins.tiles.iter().filter(|&&m| m < 0.9 * usual);
        assert!(lower.count() * 5 < margins.tiles.len());
    }
}
