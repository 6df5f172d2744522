//! The result of the demonstration: what was found beside the truth.

use crate::camera::Camera;
use crate::ros::messages::{CameraInfo, RingCentreArray};
use crate::simulate::Truth;
use std::fmt::Write;

/// Distances between the centres found and the true ones.
#[derive(Debug, Clone, Copy, Default)]
pub struct CentreErrors {
    sum_of_squares: f64,
    rings: usize,
    frames: usize,
    frames_found: usize,
}

impl CentreErrors {
    /// Takes in a frame. A ring found is compared with the true one that is nearest.
    pub fn add(&mut self, truth: &Truth, found: &RingCentreArray) {
        self.frames += 1;
        self.frames_found += usize::from(!found.centres.is_empty());
        for centre in &found.centres {
            let distances = truth
                .rings
                .iter()
                .map(|ring| (ring.centre.x - centre.x).hypot(ring.centre.y - centre.y));
            let nearest = distances.fold(f64::INFINITY, f64::min);
            self.sum_of_squares += nearest * nearest;
            self.rings += 1;
        }
    }

    /// Root mean square, px; NaN for no ring.
    pub fn rms_px(&self) -> f64 {
        (self.sum_of_squares / self.rings as f64).sqrt()
    }
}

/// Every parameter with truth and error, then the errors of the centres.
pub fn table(truth: &Camera, info: &CameraInfo, rms_px: f64, centres: &CentreErrors) -> String {
    let found = [info.k[0], info.k[4], info.k[2], info.k[5]]
        .into_iter()
        .chain(info.d.iter().copied());
    let names = truth.parameter_names();
    let rows = names.iter().zip(truth.parameters()).zip(found);
    let mut text = format!(
        "{:<10} {:>12} {:>12} {:>12}\n",
        "parameter", "truth", "calibrated", "difference"
    );
    for ((name, truth), found) in rows {
        let difference = found - truth;
        // writing to a String does not fail
        let _ = writeln!(
            text,
            "{name:<10} {truth:>12.5} {found:>12.5} {difference:>+12.5}"
        );
    }
    let _ = writeln!(text, "reprojection error {rms_px:.4} px (rms)");
    let _ = write!(
        text,
        "error of the centres {:.4} px (rms of {} rings; board found in {} of {} frames)",
        centres.rms_px(),
        centres.rings,
        centres.frames_found,
        centres.frames
    );
    text
}
