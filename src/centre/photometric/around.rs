//! The blurred skirts of the rings around one.

use super::model::RingModel;
use super::problem::Workspace;
use super::window::Grid;

/// A ring's light is seen as far as this many blur sigmas from its outline.
const REACH_SIGMAS: f64 = 4.0;

/// The coverages of a window by the rings around one of them; `None` where none is in reach.
pub(super) fn around(
    grid: &Grid,
    ratio: f64,
    (own, models): (usize, &[RingModel]),
    room: &mut Workspace,
) -> Option<[Vec<f32>; 2]> {
    let size = grid.stride() * grid.height;
    let mut planes = None;
    for (i, model) in models.iter().enumerate() {
        if i != own && reaches(model, grid) {
            let planes = planes.get_or_insert_with(|| [vec![0.0; size], vec![0.0; size]]);
            room.add_coverage(planes, grid, model, ratio);
        }
    }
    planes
}

/// Whether a ring's light falls into a window.
pub(super) fn reaches(model: &RingModel, grid: &Grid) -> bool {
    let [xx, xy, yy] = model.shape.affine;
    let determinant = xx * yy - xy * xy;
    let reach = REACH_SIGMAS * model.blur.sigma_px() + 1.0;
    let (half_x, half_y) = (
        (yy / determinant).max(0.0).sqrt() + reach,
        (xx / determinant).max(0.0).sqrt() + reach,
    );
    let centre = model.shape.centre;
    let (right, bottom) = (grid.x(grid.width), grid.y(grid.height));
    centre.x + half_x > grid.left_px
        && centre.x - half_x < right
        && centre.y + half_y > grid.top_px
        && centre.y - half_y < bottom
}
