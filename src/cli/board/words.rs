//! What a proposed board rests on, in plain words.

use crate::print::{CameraSetup, MOST_BLUR, Proposal};

/// Lines for people.
pub fn assumed(camera: &CameraSetup, proposal: &Proposal) -> String {
    let CameraSetup {
        focal_length_mm,
        pixel_um,
        f_number,
        focus_m,
        distance_m,
        frame_px: [width, height],
        fill,
        ..
    } = camera;
    let board = &proposal.board;
    let (rows, columns) = (board.rows(), board.columns());
    let tilt = proposal.tilt_rad.to_degrees();
    let [across, down] = proposal.extent_mm;
    let [filled_width, filled_height] = proposal.filled.map(|part| 100.0 * part);
    format!(
        "assumed: a thin lens of {focal_length_mm} mm at f/{f_number}, focused at {focus_m} m; {width} x {height} pixels, {pixel_um} um apart;\n\
         \x20        the board in the middle of the view, {distance_m} m away, tilted by up to {tilt:.0} degrees.\n\
         blur:    a point at {distance_m} m is a disc of {:.1} px, which is a sigma (half the radius) of {:.1} px.\n\
         limit:   sigma at most {MOST_BLUR} of a ring's width, where the tilted ring is narrowest; here at most {:.2}.\n\
         chosen:  {rows} x {columns} rings, {:.1} px wide seen from the front, the inner radius half the outer, 3 outer radii apart.\n\
         size:    the rings cover {across:.1} x {down:.1} mm, {filled_width:.0} % of the frame's width and {filled_height:.0} % of its height (at most {:.0} % was asked for).\n",
        proposal.disc_px,
        0.25 * proposal.disc_px,
        proposal.worst_blur,
        proposal.ring_px,
        100.0 * fill,
    )
}
