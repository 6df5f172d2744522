//! Connected patches that are lighter or darker than their surroundings: inner discs and whole blurred rings are among
//! them.

use super::band_pass::BandPass;
use super::runs::{Run, Side};
use nalgebra::{Matrix2, Point2};

/// A connected patch by its moments, px of its level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Blob {
    /// Centre of gravity.
    pub(super) centre: Point2<f64>,
    /// Second central moments over the area: a quarter of the squared semi-axes for an ellipse.
    pub(super) spread: Matrix2<f64>,
    /// Number of pixels.
    pub(super) area: f64,
}

impl Blob {
    /// How far the area is from that of the ellipse with the same second moments, 0 for an ellipse.
    pub(super) fn ellipse_misfit(&self) -> f64 {
        let ellipse = 4.0 * std::f64::consts::PI * self.spread.determinant().max(0.0).sqrt();
        (self.area / ellipse - 1.0).abs()
    }

    /// Minor over major axis.
    pub(super) fn aspect(&self) -> f64 {
        let eigen = self.spread.symmetric_eigenvalues();
        let (low, high) = (eigen.min(), eigen.max());
        if high > 0.0 {
            (low.max(0.0) / high).sqrt()
        } else {
            0.0
        }
    }
}

/// A run of the row above, in the patch `label`.
struct Labelled {
    run: Run,
    label: u32,
}

/// Sums over the pixels of one patch.
#[derive(Clone, Copy, Default)]
struct Sums {
    n: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Sums {
    fn add_run(&mut self, y: f64, begin: f64, end: f64) {
        let n = end - begin;
        let x = 0.5 * n * (begin + end - 1.0);
        // sum of squares up to k is k (k + 1) (2 k + 1) / 6
        let squares = |k: f64| k * (k + 1.0) * (2.0 * k + 1.0) / 6.0;
        self.n += n;
        self.x += x;
        self.y += n * y;
        self.xx += squares(end - 1.0) - squares(begin - 1.0);
        self.xy += x * y;
        self.yy += n * y * y;
    }

    fn merge(&mut self, other: &Self) {
        self.n += other.n;
        self.x += other.x;
        self.y += other.y;
        self.xx += other.xx;
        self.xy += other.xy;
        self.yy += other.yy;
    }

    fn blob(&self) -> Blob {
        let (x, y) = (self.x / self.n, self.y / self.n);
        // a pixel is a unit square, not a point: 1/12 each way
        let xx = self.xx / self.n - x * x + 1.0 / 12.0;
        let yy = self.yy / self.n - y * y + 1.0 / 12.0;
        let xy = self.xy / self.n - x * y;
        Blob {
            centre: Point2::new(x, y),
            spread: Matrix2::new(xx, xy, xy, yy),
            area: self.n,
        }
    }
}

/// All 4-connected patches beyond the margin, in the order of their first pixel (a union-find over runs, one pass).
pub(super) fn blobs(band: &BandPass, side: Side) -> Vec<Blob> {
    let mut parents: Vec<u32> = Vec::new();
    let mut sums: Vec<Sums> = Vec::new();
    let mut above: Vec<Labelled> = Vec::new();
    let mut here: Vec<Labelled> = Vec::new();
    for (y, runs) in band.runs(side).rows().enumerate() {
        here.clear();
        let mut first = 0;
        for &run in runs {
            while above.get(first).is_some_and(|a| a.run.end <= run.begin) {
                first += 1;
            }
            let mut label = None;
            for touching in above[first..].iter().take_while(|a| a.run.begin < run.end) {
                let root = find(&mut parents, touching.label);
                label = Some(label.map_or(root, |l| union(&mut parents, &mut sums, l, root)));
            }
            let label = label.unwrap_or_else(|| {
                parents.push(parents.len() as u32);
                sums.push(Sums::default());
                parents.len() as u32 - 1
            });
            sums[label as usize].add_run(y as f64, f64::from(run.begin), f64::from(run.end));
            here.push(Labelled { run, label });
        }
        std::mem::swap(&mut above, &mut here);
    }
    (0..parents.len())
        .filter(|&i| parents[i] as usize == i)
        .map(|i| sums[i].blob())
        .collect()
}

fn find(parents: &mut [u32], mut label: u32) -> u32 {
    while parents[label as usize] != label {
        let grandparent = parents[parents[label as usize] as usize];
        parents[label as usize] = grandparent;
        label = grandparent;
    }
    label
}

fn union(parents: &mut [u32], sums: &mut [Sums], a: u32, b: u32) -> u32 {
    let (a, b) = (find(parents, a), find(parents, b));
    let (keep, give) = (a.min(b), a.max(b));
    if keep != give {
        parents[give as usize] = keep;
        let given = sums[give as usize];
        sums[keep as usize].merge(&given);
    }
    keep
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Plane;

    fn blobs_of(band: &BandPass) -> Vec<Blob> {
        blobs(band, Side::Light)
    }

    fn band(rows: &[&str]) -> BandPass {
        let data = rows
            .iter()
            .flat_map(|r| r.bytes().map(|b| if b == b'#' { 1.0 } else { 0.0 }))
            .collect();
        let plane = Plane::from_vec(rows[0].len(), rows.len(), data).unwrap();
        BandPass::of_differences(plane, 0.5)
    }

    #[test]
    fn patches_that_join_late_are_one() {
        let blobs = blobs_of(&band(&["#.#.#", "#.###", "###..", "....#"]));
        let areas: Vec<f64> = blobs.iter().map(|b| b.area).collect();
        assert_eq!(areas, [10.0, 1.0]);
        assert_eq!(blobs[1].centre, Point2::new(4.0, 3.0));
    }

    #[test]
    fn moments_are_those_of_the_rectangle() {
        let blob = blobs_of(&band(&["......", ".####.", ".####.", "......"]))[0];
        assert_eq!(blob.centre, Point2::new(2.5, 1.5));
        assert!((blob.spread[(0, 0)] - 16.0 / 12.0).abs() < 1e-12);
        assert!((blob.spread[(1, 1)] - 4.0 / 12.0).abs() < 1e-12);
        assert!((blob.aspect() - 0.5).abs() < 1e-12);
    }

    #[test]
    fn a_disc_is_an_ellipse_and_a_cross_is_not() {
        let disc = |x: i32, y: i32| x * x + y * y <= 100;
        let cross = |x: i32, y: i32| x.abs().min(y.abs()) <= 1 && x.abs().max(y.abs()) <= 10;
        let misfit = |inside: &dyn Fn(i32, i32) -> bool| {
            let data = (0..625)
                .map(|i| {
                    if inside(i % 25 - 12, i / 25 - 12) {
                        1.0
                    } else {
                        0.0
                    }
                })
                .collect();
            let plane = Plane::from_vec(25, 25, data).unwrap();
            blobs_of(&BandPass::of_differences(plane, 0.5))[0].ellipse_misfit()
        };
        assert!(misfit(&disc) < 0.02);
        assert!(misfit(&cross) > 0.4);
    }
}
