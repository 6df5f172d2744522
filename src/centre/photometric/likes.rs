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
use nalgebra::Vector2;

/// Fits at most, and the relative change of its size and its blur at which it stays.
const FITS: usize = 12;
const STAYS: f64 = 0.002;
/// The next drawing leads on from a fit by this many times the last change of the fits at most.
const FARTHEST: f64 = 6.0;

/// The fits of a juror among the others, each among others in its own kind of blur: beside rings in the wrong one the right one cannot win.
/// As they were where none is in reach.
pub(super) fn among_likes(
    board: &BoardStart,
    (place, view): (&BoardPlace, Option<&PlaneView>),
    window: &Window,
    both: Both,
    room: &mut Workspace,
) -> Both {
    let Some(own) = board.places.iter().position(|other| other == place) else {
        return both;
    };
    let mut settle = |fit: Result<RingFitted, FitError>| {
        let before = fit?;
        let standing = (board, (place, view), own);
        Ok(settle_among(standing, window, before, room).unwrap_or(before))
    };
    Both {
        gaussian: settle(both.gaussian),
        disc: settle(both.disc),
    }
}

/// A juror's fit among rings drawn as it was fitted, until it stays; `None` where none is in reach or one of the fits fails.
fn settle_among(
    (board, (place, view), own): (&BoardStart, (&BoardPlace, Option<&PlaneView>), usize),
    window: &Window,
    mut fitted: RingFitted,
    room: &mut Workspace,
) -> Option<RingFitted> {
    // logarithms of size and blur sigma; the last fit's, and how far they were from what had been drawn
    let looks = |fitted: &RingFitted| {
        let sigma_px = fitted.model.blur.sigma_px().max(f64::MIN_POSITIVE);
        Vector2::new(relative_size(place, fitted).ln(), sigma_px.ln())
    };
    let mut drawn = looks(&fitted);
    let mut last: Option<(Vector2<f64>, Vector2<f64>)> = None;
    for _ in 0..FITS {
        let like = RingModel {
            blur: Blur::of_sigma(fitted.model.blur.psf, drawn.y.exp()),
            ..fitted.model
        };
        let models = likes(board, view, drawn.x.exp(), &like);
        let around = around(&window.grid, board.ratio, (own, &models), room)?;
        let known = Known {
            window,
            ratio: board.ratio,
            around: Some(&around),
            given: Given::NearStart,
        };
        fitted = known
            .fit_with(&fitted.model, fitted.model.blur.psf, room)
            .ok()?;
        let fits = looks(&fitted);
        let apart = fits - drawn;
        if apart.amax() < STAYS {
            break;
        }
        drawn = fits + onwards(last, fits, apart);
        last = Some((fits, apart));
    }
    Some(fitted)
}

/// How far beyond a fit the others are drawn next: fits that follow one another creep to where they end, each by a part of the change
/// before, and two of them tell where that is (Anderson 1965, of the last two).
fn onwards(
    last: Option<(Vector2<f64>, Vector2<f64>)>,
    fits: Vector2<f64>,
    apart: Vector2<f64>,
) -> Vector2<f64> {
    let Some((fits_before, apart_before)) = last else {
        return Vector2::zeros();
    };
    let turned = apart - apart_before;
    let share = apart.dot(&turned) / turned.norm_squared().max(f64::MIN_POSITIVE);
    (fits_before - fits) * share.clamp(-FARTHEST, 0.9)
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
