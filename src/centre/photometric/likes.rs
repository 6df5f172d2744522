//! A juror among rings like itself.
//!
//! A jury is heard before anything is known of the other rings. Where their blurred skirts fall into its window, a ring that is fitted as
//! if it stood alone takes them for its own: blur and contrast are wrong by half and more, and all that starts from them ends in
//! valleys of the sum of squares that no step leads out of. But the others are rings of the same board in about the same blur: they are
//! drawn as the juror was fitted, where they were seen, and it is fitted again, until it stays.

use super::around::around;
use super::blur::Blur;
use super::board::{BoardPlace, BoardStart};
use super::fit::{Given, Known};
use super::fitted::{FitError, RingFitted};
use super::hearing::shape_of;
use super::jury::relative_size;
use super::model::RingModel;
use super::plane::PlaneView;
use super::problem::Workspace;
use super::psf::Both;
use super::window::Window;

/// Fits at most, and the relative change of its blur at which it stays.
const FITS: usize = 8;
const STAYS: f64 = 0.01;

/// The fits of a juror among the others; as they were where none is in reach.
pub(super) fn among_likes(
    board: &BoardStart,
    (place, view): (&BoardPlace, Option<&PlaneView>),
    window: &Window,
    mut both: Both,
    room: &mut Workspace,
) -> Both {
    let Some(own) = board.places.iter().position(|other| other == place) else {
        return both;
    };
    for _ in 0..FITS {
        let Ok(before) = both.likelier() else {
            return both;
        };
        let size = relative_size(place, &before);
        let models = likes(board, view, size, &before.model);
        let Some(around) = around(&window.grid, board.ratio, (own, &models), room) else {
            return both;
        };
        let known = Known {
            window,
            ratio: board.ratio,
            around: Some(&around),
            given: Given::NearStart,
        };
        let mut again = |fit: Result<RingFitted, FitError>| {
            fit.and_then(|f| known.fit_with(&f.model, f.model.blur.psf, room))
        };
        let next = Both {
            gaussian: again(both.gaussian),
            disc: again(both.disc),
        };
        let Ok(after) = next.likelier() else {
            return both;
        };
        both = next;
        let (old_px, new_px) = (before.model.blur.sigma_px(), after.model.blur.sigma_px());
        if (new_px - old_px).abs() < STAYS * old_px {
            break;
        }
    }
    both
}

/// Coverages of a ring's window by the others, all of them this large (over what was seen) and in this blur.
pub(super) fn alike(
    window: &Window,
    board: &BoardStart,
    (place, view): (&BoardPlace, Option<&PlaneView>),
    (size, blur): (f64, Blur),
    room: &mut Workspace,
) -> Option<[Vec<f32>; 2]> {
    let own = board.places.iter().position(|other| other == place)?;
    let like = RingModel {
        shape: shape_of(place, view),
        blur,
        paper: 1.0,
        ring: 0.0,
        inside: 1.0,
        shading: [0.0; 2],
        sheet: None,
    };
    let models = likes(board, view, size, &like);
    around(&window.grid, board.ratio, (own, &models), room)
}

/// All rings of the board like this one but for their shapes: each as it was seen, larger by a factor.
fn likes(
    board: &BoardStart,
    view: Option<&PlaneView>,
    size: f64,
    model: &RingModel,
) -> Vec<RingModel> {
    let like = |other: &BoardPlace| RingModel {
        shape: shape_of(other, view).scaled(size),
        sheet: None,
        ..*model
    };
    board.places.iter().map(like).collect()
}
