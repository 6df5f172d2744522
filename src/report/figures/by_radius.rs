//! The error over the distance from the middle of the lens.

use super::Figure;
use super::chart::Chart;
use crate::calibrate::Calibration;
use crate::session::View;
use nalgebra::Point2;

/// Rings of equal width that the frame is cut into.
const BINS: usize = 10;
/// Rings of the board below which a bin says nothing.
const FEWEST: usize = 10;

/// What a bin has seen.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Bin {
    pub rings: usize,
    /// Sum of the squared residuals, px^2.
    squares: f64,
    /// Sum of the components away from the principal point, px, ...
    outward: f64,
    /// ... and of their squares, px^2.
    outward_squares: f64,
}

/// What a bin says, px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Told {
    /// Root mean square of the residuals.
    pub rms: f64,
    /// Mean of their components outward.
    pub outward: f64,
    /// Twice the standard deviation of that mean: what chance explains.
    pub chance: f64,
}

impl Bin {
    /// `None` where too few rings were seen.
    pub fn told(&self) -> Option<Told> {
        let n = self.rings as f64;
        let outward = self.outward / n;
        let variance = (self.outward_squares / n - outward * outward).max(0.0);
        (self.rings >= FEWEST).then(|| Told {
            rms: (self.squares / n).sqrt(),
            outward,
            chance: 2.0 * (variance / (n - 1.0)).sqrt(),
        })
    }
}

/// The error, and its mean outward part, over the distance from the principal point.
pub(in crate::report) fn by_radius(views: &[View], calibration: &Calibration) -> Figure {
    let (bins, width_px) = bins(views, calibration);
    let told = || {
        bins.iter()
            .enumerate()
            .filter_map(|(at, bin)| Some((at, bin.told()?)))
    };
    let high = told().map(|(_, bin)| bin.rms.max(bin.outward + bin.chance));
    let low = told().map(|(_, bin)| bin.outward - bin.chance);
    let (low, high) = (low.fold(0.0, f64::min), high.fold(0.0, f64::max));
    let mut chart = Chart::new(
        (low, high),
        BINS,
        ("error, px", "distance from the principal point, px"),
        "Error over the distance from the principal point",
    );
    for (at, bin) in told() {
        let Told {
            rms,
            outward,
            chance,
        } = bin;
        let rings = bins[at].rings;
        let says = format!("{rms:.4} px rms, {outward:+.4} px outward, {rings} rings");
        chart.bar("bar", at, rms, &says);
        let x = chart.x(at);
        let ends = [chart.y(outward - chance), chart.y(outward + chance)];
        chart.svg.line("whisker", [x, ends[0]], [x, ends[1]]);
        let middle = [x, chart.y(outward)];
        chart.svg.circle("mean", middle, 4.0);
    }
    chart.names(|place| format!("{:.0}", (place as f64 + 0.5) * width_px));
    Figure {
        title: "Error by radius".to_owned(),
        svg: chart.svg,
        reading: "Bars: distance between measured and computed centres (rms). Dots: its mean part away from the middle, with a \
                  line for what chance explains. Lines that reach zero are good; dots that leave it more and more towards the \
                  border say that the lens model is too simple for this lens. Distances with fewer than 10 rings are empty."
            .to_owned(),
    }
}

/// The bins, and their width, px.
pub(super) fn bins(views: &[View], calibration: &Calibration) -> ([Bin; BINS], f64) {
    let camera = &calibration.camera;
    let principal = Point2::new(camera.intrinsics.cx, camera.intrinsics.cy);
    let (width, height) = (f64::from(camera.width), f64::from(camera.height));
    let corner = |x: f64, y: f64| (Point2::new(x, y) - principal).norm();
    let farthest = corner(0.0, 0.0)
        .max(corner(width, 0.0))
        .max(corner(0.0, height))
        .max(corner(width, height));
    let width_px = farthest / BINS as f64;
    let mut bins = [Bin::default(); BINS];
    for (view, fit) in views
        .iter()
        .zip(&calibration.views)
        .filter(|(_, fit)| fit.used())
    {
        let residuals = fit.residuals.iter().zip(&fit.rings_used);
        for (ring, (residual, used)) in view.rings.iter().zip(residuals) {
            let (Some(residual), true) = (residual, used) else {
                continue;
            };
            let from = ring.centre.point - principal;
            let radius = from.norm();
            let bin = &mut bins[((radius / width_px) as usize).min(BINS - 1)];
            bin.rings += 1;
            bin.squares += residual.norm_squared();
            let outward = residual.dot(&from) / radius.max(f64::EPSILON);
            bin.outward += outward;
            bin.outward_squares += outward * outward;
        }
    }
    (bins, width_px)
}
