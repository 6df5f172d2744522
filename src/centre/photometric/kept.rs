//! What a view keeps of a ring: its fit, and its pixels where they are few.
//!
//! Under blur a ring's pixels are few, because they were binned; there a fit is far from linear and its neighbours' skirts
//! reach into it, so that a second pass wants the pixels. A sharp ring has many, and there its fit with the covariance
//! says nearly all that they say: least where a lens bends it, and those are kept as long as there is room.

use super::fitted::RingFitted;
use super::window::{End, Grid, Window};
use nalgebra::{Matrix2, Point2};

/// Windows of so many pixels are always kept: 49 rings of two bytes a pixel stay under 200 kB.
const FEW_PIXELS: usize = 1900;
/// Larger ones are kept, the most bent rings first, as long as those of a view have no more than this together; none has more
/// than its index has bits for.
const MOST_PIXELS: usize = 49 * FEW_PIXELS;
const MOST_OF_ONE: usize = 1 << 16;
/// Light is kept in steps of 2^-15 of full scale, up to twice that; the highest value stands for a pixel that does not count.
const STEPS: f32 = 32_768.0;
const MASKED: u16 = u16::MAX;

/// A ring as a view keeps it.
#[derive(Debug, Clone, PartialEq)]
pub struct KeptRing {
    /// Its own fit.
    pub fitted: RingFitted,
    /// The pixels it was fitted to, where they are few.
    pub window: Option<KeptWindow>,
}

/// A window in two bytes a pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct KeptWindow {
    grid: Grid,
    light: Vec<u16>,
    censored: Vec<(u16, End)>,
}

/// A ring measured.
#[derive(Debug, Clone, PartialEq)]
pub struct RingMeasured {
    /// The projected centre with what the board knows, px.
    pub centre: Point2<f64>,
    /// The centre's covariance, px^2.
    pub covariance: Matrix2<f64>,
    /// Its own fit and its pixels.
    pub kept: KeptRing,
}

impl KeptRing {
    /// What it takes of memory, bytes.
    pub fn bytes(&self) -> usize {
        let window = self.window.as_ref();
        size_of::<Self>() + window.map_or(0, |w| 2 * w.light.len() + size_of_val(&w.censored[..]))
    }
}

/// Which of a view's windows are kept, from the size of each (`None` where there is none) and how far a lens bends its ring, px.
pub(super) fn worth_keeping(windows: &[(Option<Grid>, f64)]) -> Vec<bool> {
    let pixels = |at: usize| windows[at].0.map_or(0, |grid| grid.width * grid.height);
    // what a pixel of room is worth
    let worth = |at: usize| windows[at].1.powi(2) / pixels(at).max(1) as f64;
    let mut order: Vec<usize> = (0..windows.len()).filter(|at| pixels(*at) > 0).collect();
    order.sort_by(|a, b| {
        let few = |at: usize| pixels(at) <= FEW_PIXELS;
        few(*b).cmp(&few(*a)).then(worth(*b).total_cmp(&worth(*a)))
    });
    let (mut keep, mut taken) = (vec![false; windows.len()], 0);
    for at in order {
        let size = pixels(at);
        let fits = taken + size <= MOST_PIXELS && size < MOST_OF_ONE;
        if size <= FEW_PIXELS || fits {
            keep[at] = true;
            taken += size;
        }
    }
    keep
}

impl KeptWindow {
    /// Keeps a window.
    pub(super) fn of(window: &Window) -> Self {
        let (grid, stride) = (window.grid, window.grid.stride());
        // half more, cut off: the nearest step
        let steps = |value: f32| (value * STEPS + 0.5).clamp(0.0, f32::from(MASKED - 1)) as u16;
        let mut light = Vec::with_capacity(grid.width * grid.height);
        for row in 0..grid.height {
            let span = row * stride..row * stride + grid.width;
            let pixels = window.values[span.clone()]
                .iter()
                .zip(&window.weights[span]);
            light.extend(pixels.map(
                |(value, weight)| {
                    if *weight > 0.0 { steps(*value) } else { MASKED }
                },
            ));
        }
        for &(index, _) in &window.censored {
            light[index / stride * grid.width + index % stride] = steps(window.values[index]);
        }
        let censored = window.censored.iter().filter_map(|&(index, end)| {
            let i = index / stride * grid.width + index % stride;
            Some((u16::try_from(i).ok()?, end))
        });
        Self {
            grid,
            light,
            censored: censored.collect(),
        }
    }

    /// The window again.
    pub fn restore(&self) -> Window {
        let (grid, stride) = (self.grid, self.grid.stride());
        let at = |i: usize| (i / grid.width) * stride + i % grid.width;
        let mut window = Window {
            grid,
            values: vec![0.0; stride * grid.height],
            weights: vec![0.0; stride * grid.height],
            censored: self
                .censored
                .iter()
                .map(|&(i, end)| (at(usize::from(i)), end))
                .collect(),
        };
        for (i, &light) in self.light.iter().enumerate() {
            if light != MASKED {
                window.values[at(i)] = f32::from(light) / STEPS;
                window.weights[at(i)] = 1.0;
            }
        }
        for &(i, _) in &window.censored {
            window.weights[i] = 0.0;
        }
        window
    }
}

#[cfg(test)]
mod tests {
    use super::super::window::Rectangle;
    use super::*;
    use crate::frame::{Frame, Linear, Plane};

    #[test]
    fn a_kept_window_comes_back() {
        let data = (0..60 * 50).map(|i| ((i * 37) % 256) as u8).collect();
        let frame = Frame::from_u8(Plane::from_vec(60, 50, data).unwrap(), "x");
        let cut = |side| {
            let rectangle = Rectangle {
                x: 3,
                y: 4,
                width: side,
                height: side - 1,
            };
            Window::cut(&frame, rectangle, 1, &Linear::new(1.0, false)).unwrap()
        };
        let mut window = cut(40);
        window.keep(|x, y| x + y > 30.0);
        let again = KeptWindow::of(&window).restore();
        assert_eq!(again.grid, window.grid);
        assert_eq!(again.weights, window.weights);
        assert_eq!(again.censored, window.censored);
        assert!(!window.censored.is_empty());
        for (i, (a, b)) in again.values.iter().zip(&window.values).enumerate() {
            assert!(window.weights[i] == 0.0 || (a - b).abs() < 1e-4);
        }
    }

    #[test]
    fn small_windows_are_kept_and_of_the_large_ones_those_of_the_most_bent_rings() {
        let grid = |side: usize| Grid {
            left_px: 0.0,
            top_px: 0.0,
            pixel_px: 1.0,
            width: side,
            height: side,
        };
        let bent = |i: usize| 0.001 * i as f64;
        let small: Vec<_> = (0..80).map(|i| (Some(grid(40)), bent(i))).collect();
        assert!(worth_keeping(&small).iter().all(|keep| *keep));
        let mut large: Vec<_> = (0..49).map(|i| (Some(grid(60)), bent(i))).collect();
        large[48].0 = None;
        let keep = worth_keeping(&large);
        let kept = keep.iter().filter(|keep| **keep).count();
        assert!(
            kept == 25 && keep[23..48].iter().all(|keep| *keep),
            "{keep:?}"
        );
    }
}
