//! What the rings of a board say together: the perspective they share, the map through them, and what its bends do to each.

use super::bent::Bent;
use super::board::BoardStart;
use super::fitted::RingFitted;
use super::law::{CentreAndCovariance, share_perspective};
use super::lens_map::LensMap;
use super::unbent::unbent;
use super::under::Under;
use crate::camera::Camera;
use rayon::prelude::*;

/// What the rings of a board say together.
pub(super) struct Shared {
    /// The centres of those that were measured.
    pub(super) centres: Vec<CentreAndCovariance>,
    pub(super) map: Option<LensMap>,
    /// What its bends do to each ring of the board.
    pub(super) bent: Vec<Option<Bent>>,
    /// That is taken off the centres already.
    pub(super) straight: bool,
}

impl Shared {
    /// The centres of the rings that were measured, with the perspective they share, and the map through them.
    pub(super) fn of(board: &BoardStart, rings: &[Under], camera: &Camera) -> Self {
        let size = (board.outer_radius_m, board.ratio);
        let measured = rings.iter().zip(board.places);
        let (fitted, places): (Vec<RingFitted>, Vec<_>) = measured
            .filter_map(|(ring, place)| Some((ring.fitted.ok()?, place.plane_m)))
            .unzip();
        let share = |fitted: &[RingFitted]| share_perspective(fitted, &places, size.0, camera);
        let (centres, map) = share(&fitted);
        let mut shared = Self {
            centres,
            map,
            bent: vec![None; rings.len()],
            straight: false,
        };
        let Some(map) = map else {
            return shared;
        };
        let bent = board.places.par_iter();
        shared.bent = bent.map(|place| map.bent(place.plane_m, size)).collect();
        // rings whose pixels were flattened have no bends left
        let measured = rings.iter().zip(&shared.bent);
        let bent: Vec<_> = measured
            .filter(|(ring, _)| ring.fitted.is_ok())
            .map(|(ring, bent)| bent.filter(|_| ring.bends.is_none()))
            .collect();
        if let Some(straight) = unbent(&fitted, (&places, &bent), &map, size) {
            (shared.centres, shared.map) = share(&straight);
            shared.straight = true;
        }
        shared
    }
}
