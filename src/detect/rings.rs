//! All rings of a frame, whatever their size: candidates of every pyramid level, measured on the frame itself.

use super::grid::DROWNED_SIZES;
use super::labelling::walks;
use super::nearby::Nearby;
use super::ring_fit::{Care, RingFit, measure, measure_disc};
use super::scales::Scales;
use crate::board::Board;
use crate::centre::{Ellipse, RingEllipses};
use rayon::prelude::*;

/// At most so many candidates are measured, or this many times the rings of the board: whatever a frame shows, that many are a
/// matter of milliseconds.
const MOST_MEASURED: usize = 192;
const MOST_PER_RING: usize = 4;
/// Discs among them that are measured at most, or this many times the rings of the board: they are looked at only where no board is seen.
const MOST_DISCS: usize = 96;
const MOST_DISCS_PER_RING: usize = 2;
/// How large discs look over the true size of their rings: a large blur leaves only the middle.
const LOOKS: [f64; 4] = [1.0, DROWNED_SIZES[0], DROWNED_SIZES[1], DROWNED_SIZES[2]];
/// Those that stand in a lattice go first, if it has at least this fraction of the board's rings.
const LEAST_IN_LATTICE: f64 = 0.15;

/// Every ring of dark or light that shows in the frame, each once, in no particular order but always the same.
/// Where the frame shows more candidates than can be measured, those that stand in a lattice as the board's go first.
pub(super) fn find_rings(scales: &mut Scales, board: &Board, care: Care) -> Vec<RingFit> {
    let ratio = board.radius_ratio();
    let levels: Vec<Vec<RingEllipses>> = (0..scales.count())
        .map(|level| scales.rings(level).to_vec())
        .collect();
    let spots = spots(levels.iter().map(Vec::as_slice));
    let outers: Vec<Ellipse> = spots.iter().map(|spot| spot[0].outer).collect();
    let (frame, sign) = (scales.frame, scales.sign);
    let measured = first_to_measure(board, &outers, &[1.0])
        .into_par_iter()
        .filter_map(|at| {
            spots[at]
                .iter()
                .find_map(|rough| measure(frame, rough, sign, ratio, care))
        })
        .collect();
    distinct(measured)
}

/// The rings given and, where none of them is, discs so blurred that they may be rings whose inner disc has drowned.
pub(super) fn add_drowned(
    scales: &mut Scales,
    board: &Board,
    rings: Vec<RingFit>,
    care: Care,
) -> Vec<RingFit> {
    let ratio = board.radius_ratio();
    let mut outlines: Vec<Ellipse> = rings.iter().map(|ring| ring.outer).collect();
    for level in 0..scales.count() {
        outlines.extend(scales.discs(level));
    }
    let (frame, sign) = (scales.frame, scales.sign);
    let most = MOST_DISCS.max(MOST_DISCS_PER_RING * board.ring_count());
    let mut chosen = first_to_measure(board, &outlines, &LOOKS);
    chosen.retain(|&at| at >= rings.len());
    chosen.truncate(most);
    let discs: Vec<RingFit> = chosen
        .into_par_iter()
        .filter_map(|at| {
            let outline = &outlines[at];
            let small = (outline.minor < SMALL_PX).then(|| small_ring(outline, ratio));
            small
                .and_then(|rough| measure(frame, &rough, sign, ratio, care))
                .or_else(|| measure_disc(frame, outline, sign, ratio, care))
        })
        .collect();
    let mut all = rings;
    for disc in distinct(discs) {
        if !all.iter().any(|ring| overlap(ring, &disc)) {
            all.push(disc);
        }
    }
    all
}

/// The candidates of all levels, those of one ring together: most rings show at two or three levels.
pub(super) fn spots<'a>(
    levels: impl Iterator<Item = &'a [RingEllipses]>,
) -> Vec<Vec<RingEllipses>> {
    let mut spots: Vec<Vec<RingEllipses>> = Vec::new();
    for level in levels {
        let known = Nearby::new(spots.iter().map(|spot| spot[0].outer.centre));
        for &ring in level {
            let mut near = known.within(ring.outer.centre, SAME_PLACE * ring.outer.major);
            let same = near.find(|&(at, _)| is_same(&spots[at][0].outer, &ring.outer));
            match same {
                Some((at, _)) => spots[at].push(ring),
                None => spots.push(vec![ring]),
            }
        }
    }
    spots
}

/// Which candidates are to be measured: those of lattices, the fullest first, then the largest. They may look so large, over their true
/// `sizes`.
fn first_to_measure(board: &Board, outers: &[Ellipse], sizes: &[f64]) -> Vec<usize> {
    let most = MOST_MEASURED.max(MOST_PER_RING * board.ring_count());
    if outers.len() <= most {
        return (0..outers.len()).collect();
    }
    let mut order: Vec<usize> = if board.is_single() {
        Vec::new()
    } else {
        let spacing = board.pitch_m() / board.outer_radius_m();
        let least = (LEAST_IN_LATTICE * board.ring_count() as f64) as usize;
        // those of the true size first: at other sizes texture has more of them
        let found = sizes
            .iter()
            .map(|size| walks(outers, spacing / size, least).concat());
        found.collect::<Vec<_>>().concat()
    };
    let mut chosen = vec![false; outers.len()];
    order.retain(|&at| !std::mem::replace(&mut chosen[at], true));
    let mut rest: Vec<usize> = (0..outers.len()).filter(|&at| !chosen[at]).collect();
    let area = |at: usize| outers[at].major * outers[at].minor;
    rest.sort_by(|&a, &b| area(b).total_cmp(&area(a)));
    order.extend(rest);
    order.truncate(most);
    order
}

/// Keeps the best of the rings that lie on one another (a ring shows at two or three levels).
fn distinct(mut rings: Vec<RingFit>) -> Vec<RingFit> {
    let quality = |r: &RingFit| r.stray_px / r.outer.mean_radius();
    rings.sort_by(|a, b| quality(a).total_cmp(&quality(b)));
    let mut kept: Vec<RingFit> = Vec::new();
    for ring in rings {
        if !kept.iter().any(|other| overlap(other, &ring)) {
            kept.push(ring);
        }
    }
    kept
}

/// Of outlines with less than this minor semi-axis the inner discs are smoothed away before candidates are sought, px.
const SMALL_PX: f64 = 8.0;

/// A ring as the board has it within an outline.
fn small_ring(outline: &Ellipse, ratio: f64) -> RingEllipses {
    RingEllipses {
        inner: Ellipse {
            major: ratio * outline.major,
            minor: ratio * outline.minor,
            ..*outline
        },
        outer: *outline,
    }
}

/// Outlines so near and alike belong to one ring.
const SAME_PLACE: f64 = 0.2;
const SAME_SIZE: f64 = 0.25;

fn is_same(a: &Ellipse, b: &Ellipse) -> bool {
    (a.centre - b.centre).norm() < SAME_PLACE * a.minor
        && (a.mean_radius() / b.mean_radius()).ln().abs() < SAME_SIZE
}

fn overlap(a: &RingFit, b: &RingFit) -> bool {
    (a.outer.centre - b.outer.centre).norm() < 0.7 * (a.outer.minor + b.outer.minor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::Polarity;
    use nalgebra::Point2;
    use proptest::prelude::*;
    use rand::{RngExt, SeedableRng};

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn however_many_candidates_there_are_so_many_are_measured(
            places in prop::collection::vec((0.0..4e3_f64, 0.0..3e3_f64, 3.0..40.0_f64), 0..1500),
            single in any::<bool>(),
        ) {
            let (rows, columns) = if single { (1, 1) } else { (5, 6) };
            let board = Board::new(rows, columns, 0.03, 0.005, 0.01, Polarity::Auto).unwrap();
            let outers: Vec<Ellipse> = places
                .iter()
                .map(|&(x, y, r)| Ellipse { centre: Point2::new(x, y), major: r, minor: 0.8 * r, angle: 0.3 })
                .collect();
            let mut chosen = first_to_measure(&board, &outers, &LOOKS);
            prop_assert_eq!(chosen.len(), outers.len().min(MOST_MEASURED));
            chosen.sort_unstable();
            chosen.dedup();
            prop_assert_eq!(chosen.len(), outers.len().min(MOST_MEASURED));
        }
    }

    #[test]
    fn those_in_a_lattice_are_measured_whatever_stands_around() {
        let board = Board::new(5, 6, 0.03, 0.005, 0.01, Polarity::Auto).unwrap();
        let disc = |x: f64, y: f64, r: f64| Ellipse {
            centre: Point2::new(x, y),
            major: r,
            minor: r,
            angle: 0.0,
        };
        // 2000 larger ones anywhere, then the board
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let mut place = |size: f64| 500.0 + size * random.random::<f64>();
        let mut outers: Vec<Ellipse> = (0..2000)
            .map(|i| disc(place(8e3), place(6e3), f64::from(15 + i % 7)))
            .collect();
        outers.extend((0..30).map(|i| {
            disc(
                f64::from(100 + i % 6 * 30),
                f64::from(100 + i / 6 * 30),
                10.0,
            )
        }));
        let chosen = first_to_measure(&board, &outers, &[1.0]);
        assert!((2000..2030).all(|at| chosen.contains(&at)));
    }
}
