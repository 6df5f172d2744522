//! The stages together, on pictures whose answer is known.

use super::*;
use proptest::prelude::*;

const ONCE: NonZeroU32 = NonZeroU32::MIN;

/// Every row the same, so that the 3 x 3 mean is the mean of three columns.
fn rows_of<T: Grey>(profile: &[T], height: usize) -> Plane<T> {
    Plane::from_vec(profile.len(), height, profile.repeat(height)).unwrap()
}

fn eight(enhanced: &Enhanced) -> &Plane<u8> {
    match &enhanced.frame.pixels {
        Pixels::U8(plane) => plane,
        Pixels::U16(_) => panic!("8-bit frames stay 8 bit"),
    }
}

fn choices(enhanced: &Enhanced) -> &Choices {
    match &enhanced.outcome {
        Outcome::Restored(choices) => choices,
        Outcome::Unchanged(reason) => panic!("unchanged: {reason}"),
    }
}

/// An edge from 40 to 210 blurred by a Gaussian of 4 px (its logistic approximation, to 1 %), `scale` times as bright.
fn blurred_edge(scale: f64) -> impl Iterator<Item = f64> {
    (0..60).map(move |x| {
        let z = (f64::from(x) - 29.7) / 4.0;
        scale * (40.0 + 170.0 / (1.0 + (-1.702 * z).exp()))
    })
}

fn steepest<T: Grey>(row: &[T]) -> i32 {
    let steps = row
        .windows(2)
        .map(|p| Into::<u32>::into(p[1]) as i32 - Into::<u32>::into(p[0]) as i32);
    steps.max().unwrap()
}

// Columns 20 20 20 20 80 140 200 200 200 200 have the means 20 20 20 40 80 140 180 200 200 200, and the picture's mean is
// (110, 110). With both middle columns in neither class each class holds 4 columns at 90 from the mean in grey and 85 in
// mean: 2 * 4 * (90^2 + 85^2) = 122600. With both in a class (s = t = 80): 2 * 5 * (78^2 + 74^2) = 115600; with one:
// 119100; with the columns of mean 40 and 180 left out too: 2 * 3 * 2 * 90^2 = 97200. So s lies in 20..=79 and t in
// 140..=179, or s in 140..=199 and t in 40..=79; |s - t| = 61 is the smallest, at (79, 140) and (140, 79): the smaller s.
const STAIR: [u8; 10] = [20, 20, 20, 20, 80, 140, 200, 200, 200, 200];

#[test]
fn dark_target_by_hand() {
    let frame = Frame::from_u8(rows_of(&STAIR, 3), "stair");
    let enhanced = enhance(&frame, Target::Dark, ONCE);
    let expected = Choices {
        s: 79,
        t: 140,
        v1: 20,
        v2: 20,
        rounds: vec![Round {
            th: 80,
            v3: 80,
            v4: 80,
            median: 140,
        }],
    };
    assert_eq!(*choices(&enhanced), expected);
    let row = [20, 20, 20, 20, 20, 140, 200, 200, 200, 200];
    assert_eq!(*eight(&enhanced), rows_of(&row, 3));
    assert_eq!(
        (enhanced.frame.stamp, enhanced.frame.source.as_str()),
        (frame.stamp, "stair")
    );
}

#[test]
fn light_target_by_hand() {
    let enhanced = enhance(&Frame::from_u8(rows_of(&STAIR, 3), ""), Target::Light, ONCE);
    let expected = Round {
        th: 80,
        v3: 140,
        v4: 140,
        median: 80,
    };
    assert_eq!(choices(&enhanced).rounds, [expected]);
    assert_eq!((choices(&enhanced).v1, choices(&enhanced).v2), (200, 200));
    let row = [20, 20, 20, 20, 80, 200, 200, 200, 200, 200];
    assert_eq!(*eight(&enhanced), rows_of(&row, 3));
}

#[test]
fn sixteen_bits_are_handled_in_their_own_values() {
    let deep = STAIR.map(|v| 1000 + u16::from(v) * 13);
    let enhanced = enhance(&Frame::from_u16(rows_of(&deep, 3), ""), Target::Dark, ONCE);
    let expected = [20, 20, 20, 20, 20, 140, 200, 200, 200, 200].map(|v| 1000 + v * 13);
    assert_eq!(enhanced.frame.pixels, Pixels::U16(rows_of(&expected, 3)));
    // levels are 2341 / 256 = 9.1 values wide, so the thresholds lie that close to where the classes part
    let found = choices(&enhanced);
    assert!(found.s < 2040 && found.s > 2040 - 10, "{found:?}");
    assert!(found.t >= 2820 && found.t < 2820 + 10, "{found:?}");
    assert_eq!((found.rounds[0].th, found.rounds[0].median), (2040, 2820));
}

#[test]
fn a_blurred_edge_gets_steeper_for_both_polarities_and_depths() {
    for target in [Target::Dark, Target::Light] {
        let profile: Vec<u8> = blurred_edge(1.0).map(|v| v.round() as u8).collect();
        let enhanced = enhance(&Frame::from_u8(rows_of(&profile, 20), ""), target, ONCE);
        let (before, after) = (steepest(&profile), steepest(eight(&enhanced).row(10)));
        assert!(after >= 2 * before, "{target:?}: {before} -> {after}");

        let profile: Vec<u16> = blurred_edge(16.0).map(|v| v.round() as u16).collect();
        let enhanced = enhance(&Frame::from_u16(rows_of(&profile, 20), ""), target, ONCE);
        let Pixels::U16(plane) = &enhanced.frame.pixels else {
            panic!("16-bit frames stay 16 bit");
        };
        let (before, after) = (steepest(&profile), steepest(plane.row(10)));
        assert!(after >= 2 * before, "{target:?}: {before} -> {after}");
    }
}

#[test]
fn the_edge_region_takes_exactly_the_target_s_range() {
    let profile: Vec<u8> = blurred_edge(1.0).map(|v| v.round() as u8).collect();
    let enhanced = enhance(
        &Frame::from_u8(rows_of(&profile, 20), ""),
        Target::Dark,
        ONCE,
    );
    let found = choices(&enhanced);
    let round = found.rounds[0];
    let after = |value: u16| {
        let x = profile.iter().position(|&v| u16::from(v) == value).unwrap();
        u16::from(eight(&enhanced).at(x, 10))
    };
    assert!(found.v1 < found.v2 && round.v3 < round.v4 && round.v4 == round.th);
    assert_eq!((after(round.v3), after(round.v4)), (found.v1, found.v2));
    assert_eq!(after(round.median), round.median);
    assert_eq!(u16::from(profile[0]), found.v1);
}

#[test]
fn a_repeat_keeps_the_first_thresholds_and_works_on_the_new_picture() {
    let profile: Vec<u8> = blurred_edge(1.0).map(|v| v.round() as u8).collect();
    let frame = Frame::from_u8(rows_of(&profile, 20), "");
    let once = enhance(&frame, Target::Light, ONCE);
    let often = enhance(&frame, Target::Light, NonZeroU32::new(5).unwrap());
    let (first, all) = (choices(&once), choices(&often));
    assert_eq!(
        (first.s, first.t, first.v1, first.v2),
        (all.s, all.t, all.v1, all.v2)
    );
    assert_eq!(first.rounds[0], all.rounds[0]);
    assert!(all.rounds.len() > 1 && all.rounds.len() <= 5, "{all:?}");
}

#[test]
fn nothing_to_restore_comes_back_with_the_reason() {
    let same = |plane: Plane<u8>, reason: Reason| {
        for target in [Target::Dark, Target::Light] {
            let frame = Frame::from_u8(plane.clone(), "x");
            let enhanced = enhance(&frame, target, ONCE);
            assert_eq!(enhanced.frame, frame);
            assert_eq!(enhanced.outcome, Outcome::Unchanged(reason));
        }
    };
    same(Plane::filled(0, 0, 0), Reason::OneLevel);
    same(Plane::filled(1, 1, 200), Reason::OneLevel);
    same(Plane::filled(9, 7, 0), Reason::OneLevel);
    same(Plane::filled(9, 7, 255), Reason::OneLevel);
    same(
        Plane::from_vec(2, 2, vec![0, 255, 0, 255]).unwrap(),
        Reason::NoEdges,
    );
    same(rows_of(&[20, 20, 20, 200, 200, 200], 6), Reason::NoEdges);
    let flat = Frame::from_u16(Plane::filled(4, 4, 65_535), "");
    assert_eq!(enhance(&flat, Target::Dark, ONCE).frame, flat);
}

#[test]
fn the_number_of_threads_makes_no_difference() {
    let data = (0..300 * 400_u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 20) as u16);
    let frame = Frame::from_u16(Plane::from_vec(300, 400, data.collect()).unwrap(), "");
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
            .install(|| enhance(&frame, Target::Dark, ONCE))
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn the_target_follows_the_board() {
    assert_eq!(Target::of(Polarity::DarkOnLight), Some(Target::Dark));
    assert_eq!(Target::of(Polarity::LightOnDark), Some(Target::Light));
    assert_eq!(Target::of(Polarity::Auto), None);
}

proptest! {
    #[test]
    fn no_picture_makes_it_panic_and_only_the_off_diagonal_changes(
        (width, height, data) in (1_usize..8, 1_usize..8).prop_flat_map(|(w, h)| {
            (Just(w), Just(h), proptest::collection::vec(any::<u8>(), w * h))
        }),
        light: bool, rounds in 1_u32..4,
    ) {
        let target = if light { Target::Light } else { Target::Dark };
        let plane = Plane::from_vec(width, height, data).unwrap();
        let rounds = NonZeroU32::new(rounds).unwrap();
        let enhanced = enhance(&Frame::from_u8(plane.clone(), ""), target, rounds);
        match &enhanced.outcome {
            Outcome::Unchanged(_) => prop_assert_eq!(eight(&enhanced), &plane),
            Outcome::Restored(found) if found.rounds.len() == 1 => {
                let at = Thresholds { s: found.s as u8, t: found.t as u8 };
                let means = neighbourhood::map(&plane, |_, mean| mean);
                for y in 0..height {
                    for x in 0..width {
                        let off = at.off_diagonal(plane.at(x, y), means.at(x, y));
                        prop_assert!(off || plane.at(x, y) == eight(&enhanced).at(x, y));
                    }
                }
            }
            Outcome::Restored(found) => prop_assert!(found.rounds.len() > 1),
        }
    }
}
