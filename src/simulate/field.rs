//! How much of each pixel an outlined area covers, band by band.

use super::defocus::Psf;
use super::outline::Outline;
use super::{disc, gaussian, sharp};

/// Rows that are rendered together; each band sums its contributions in the same order whoever computes it.
pub(super) const BAND_ROWS: usize = 64;

/// Rows of the picture while outlines are added to it: differences along each row.
pub(super) struct Band {
    /// Width of the picture, px.
    pub(super) width: usize,
    /// The row of the picture it begins with.
    pub(super) first_row: usize,
    /// Rows in it.
    pub(super) rows: usize,
    /// First differences along the row.
    first: Vec<f64>,
    /// Second differences along the row; empty where nothing adds to them.
    second: Vec<f64>,
}

impl Band {
    /// Rows of the band within `reach` px of a height in the picture.
    pub(super) fn rows_near(&self, y: f64, reach: f64) -> std::ops::Range<usize> {
        let local = y - self.first_row as f64;
        let low = (local - reach).ceil().clamp(0.0, self.rows as f64) as usize;
        let high = ((local + reach).floor() + 1.0).clamp(0.0, self.rows as f64) as usize;
        low..high.max(low)
    }

    /// First differences of one row of the band.
    pub(super) fn first_differences(&mut self, row: usize) -> &mut [f64] {
        &mut self.first[row * self.width..(row + 1) * self.width]
    }

    /// Second differences of one row of the band.
    pub(super) fn second_differences(&mut self, row: usize) -> &mut [f64] {
        &mut self.second[row * self.width..(row + 1) * self.width]
    }

    /// Sums the differences up to the picture.
    fn sum(mut self) -> Vec<f64> {
        let bends = self.second.chunks_exact(self.width);
        for (row, bends) in self.first.chunks_exact_mut(self.width).zip(bends) {
            let mut slope = 0.0;
            for (pixel, bend) in row.iter_mut().zip(bends) {
                slope += bend;
                *pixel += slope;
            }
        }
        for row in self.first.chunks_exact_mut(self.width) {
            let mut value = 0.0;
            for pixel in row {
                value += *pixel;
                *pixel = value;
            }
        }
        self.first
    }
}

/// Blurred, pixel-integrated coverage 0..1 of some rows of the picture, row by row.
pub(super) fn coverage(outline: &Outline, width: usize, first_row: usize, rows: usize) -> Vec<f64> {
    let mut band = Band {
        width,
        first_row,
        rows,
        first: vec![0.0; width * rows],
        second: match outline.psf {
            Psf::Gaussian => Vec::new(),
            Psf::Disc => vec![0.0; width * rows],
        },
    };
    for segment in &outline.segments {
        sharp::add(&mut band, segment);
    }
    match outline.psf {
        Psf::Gaussian => {
            let mut kernel = gaussian::Kernel::default();
            outline
                .nodes
                .iter()
                .for_each(|node| kernel.add(&mut band, node));
        }
        Psf::Disc => outline
            .nodes
            .iter()
            .for_each(|node| disc::add(&mut band, node)),
    }
    band.sum()
}
