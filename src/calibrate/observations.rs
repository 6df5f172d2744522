//! The measurements of a calibration, checked: what the adjustment needs of each view and nothing it has to doubt.

use super::CalibrateError;
use crate::board::Board;
use crate::detect::Ring;
use crate::session::View;
use nalgebra::{Matrix2, Point2, Vector2};
use std::collections::HashSet;

/// One ring in one view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Observation {
    /// Its centre on the board, m.
    pub board_m: [f64; 2],
    /// Where it was measured, px.
    pub pixel: Point2<f64>,
    /// What its estimator measures less its projected centre, px, as camera and pose say.
    pub bias_px: Vector2<f64>,
    /// W with W^T W the inverse of the covariance: makes residuals of unit variance.
    pub whitening: Matrix2<f64>,
    /// Whether its own covariance is behind `whitening`.
    pub has_covariance: bool,
    /// Its weight: 1, or 0 where it is left out.
    pub share: f64,
}

/// Checks the views and pairs their rings with the board's.
pub(super) fn observations(
    board: &Board,
    views: &[View],
) -> Result<Vec<Vec<Observation>>, CalibrateError> {
    if board.is_single() {
        return Err(CalibrateError::SingleRing);
    }
    let Some(first) = views.first().map(|view| (view.width, view.height)) else {
        return Err(CalibrateError::TooFewViews { found: 0 });
    };
    let default_variance = typical_variance(views);
    views
        .iter()
        .map(|view| {
            check(board, view, first)?;
            view.rings
                .iter()
                .map(|ring| observation(board, view, ring, default_variance))
                .collect()
        })
        .collect()
}

fn check(board: &Board, view: &View, first: (usize, usize)) -> Result<(), CalibrateError> {
    let size = (view.width, view.height);
    if size != first {
        return Err(CalibrateError::Size {
            source_name: view.source.clone(),
            size,
            first,
        });
    }
    let mut seen = HashSet::new();
    for ring in &view.rings {
        let on_board = ring.row < board.rows() && ring.column < board.columns();
        let how = match (on_board, seen.insert((ring.row, ring.column))) {
            (false, _) => "outside",
            (_, false) => "twice in",
            _ => continue,
        };
        return Err(CalibrateError::Label {
            source_name: view.source.clone(),
            how,
            row: ring.row,
            column: ring.column,
            rows: board.rows(),
            columns: board.columns(),
        });
    }
    Ok(())
}

fn observation(
    board: &Board,
    view: &View,
    ring: &Ring,
    default_variance: f64,
) -> Result<Observation, CalibrateError> {
    let bad = |what| CalibrateError::BadRing {
        source_name: view.source.clone(),
        what,
        row: ring.row,
        column: ring.column,
    };
    let pixel = ring.centre.point;
    if !(pixel.x.is_finite() && pixel.y.is_finite()) {
        return Err(bad("position"));
    }
    let own = ring.centre.covariance;
    let covariance = own.unwrap_or_else(|| Matrix2::from_diagonal_element(default_variance));
    let whitening = covariance
        .cholesky()
        .and_then(|root| root.l().try_inverse())
        .filter(|w| w.iter().all(|value| value.is_finite()))
        .ok_or_else(|| bad("covariance"))?;
    Ok(Observation {
        board_m: board.centre_m(ring.row, ring.column),
        pixel,
        bias_px: Vector2::zeros(),
        whitening,
        has_covariance: own.is_some(),
        share: 1.0,
    })
}

/// How much less certain than the others a ring is that has no covariance among rings that have: its grey values could not be fitted, and
/// its centre is that of edges.
const EDGES_VARIANCE: f64 = 100.0;
/// And at least so uncertain, px^2: what blur and bends do to edges is there without noise.
const LEAST_EDGES_VARIANCE: f64 = 0.0025;

/// The variance of a coordinate for rings without a covariance, px^2: much more than the median of those that have one; 1 where
/// none has.
fn typical_variance(views: &[View]) -> f64 {
    let mut variances: Vec<f64> = views
        .iter()
        .flat_map(|view| &view.rings)
        .filter_map(|ring| ring.centre.covariance)
        .map(|covariance| 0.5 * covariance.trace())
        .filter(|variance| variance.is_finite() && *variance > 0.0)
        .collect();
    variances.sort_by(f64::total_cmp);
    variances.get(variances.len() / 2).map_or(1.0, |median| {
        (EDGES_VARIANCE * median).max(LEAST_EDGES_VARIANCE)
    })
}
