//! Views that show what another view shows: they add weight and no information.

use crate::session::{View, motion};
use nalgebra::{Point2, Vector2};

/// Average motion of the rings, over the width of the frame, below which a view repeats another.
const SAME: f64 = 1e-4;

/// For each view the `source` of an earlier one that it repeats.
pub(super) fn repeats(views: &[View]) -> Vec<Option<String>> {
    let middles: Vec<Point2<f64>> = views.iter().map(middle).collect();
    // sorted along x, so that each view is compared with its neighbours alone
    let mut order: Vec<usize> = (0..views.len()).collect();
    order.sort_by(|a, b| middles[*a].x.total_cmp(&middles[*b].x).then(a.cmp(b)));
    let mut repeated: Vec<Option<usize>> = vec![None; views.len()];
    for (rank, &at) in order.iter().enumerate() {
        let same_px = SAME * views[at].width as f64;
        let near = order[rank + 1..]
            .iter()
            .take_while(|other| middles[**other].x - middles[at].x <= same_px);
        for &other in near {
            let (early, late) = (at.min(other), at.max(other));
            let known = repeated[late].is_some_and(|of| of <= early);
            if known || (middles[other].y - middles[at].y).abs() > same_px {
                continue;
            }
            let moved = motion(&views[early], &views[late]);
            if moved.is_some_and(|m| m.mean_px <= same_px) {
                repeated[late] = Some(early);
            }
        }
    }
    repeated
        .into_iter()
        .map(|of| of.map(|of| views[of].source.clone()))
        .collect()
}

fn middle(view: &View) -> Point2<f64> {
    let sum: Vector2<f64> = view.rings.iter().map(|r| r.centre.point.coords).sum();
    Point2::from(sum / view.rings.len().max(1) as f64)
}
