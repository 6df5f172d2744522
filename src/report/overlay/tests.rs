use super::*;
use crate::board::Polarity;
use crate::centre::{Centre, RingEllipses};
use crate::frame::Plane;
use nalgebra::Matrix3;

fn board() -> Board {
    Board::new(2, 3, 0.03, 0.005, 0.01, Polarity::DarkOnLight).unwrap()
}

/// A frontal board of 2 x 3 rings with 60 px pitch in a frame of 240 x 160.
fn detection() -> Detection {
    let ring = |(row, column): (u16, u16)| {
        let point = Point2::new(
            50.0 + 60.0 * f64::from(column),
            40.0 + 60.0 * f64::from(row),
        );
        let circle = |radius| Ellipse {
            centre: point,
            major: radius,
            minor: radius,
            angle: 0.0,
        };
        Ring {
            row,
            column,
            centre: Centre {
                point,
                covariance: None,
            },
            ellipses: RingEllipses {
                inner: circle(10.0),
                outer: circle(20.0),
            },
            blur_sigma_px: 3.06,
            kept: None,
        }
    };
    Detection {
        width: 240,
        height: 160,
        indices: Indices::Absolute,
        rings: board().indices().map(ring).collect(),
        homography: Matrix3::new(2000.0, 0.0, 50.0, 0.0, 2000.0, 40.0, 0.0, 0.0, 1.0),
        photometric: None,
        another: None,
    }
}

fn frame() -> Frame {
    Frame::from_u8(Plane::filled(240, 160, 90), "")
}

fn near(picture: &RgbImage, x: f64, y: f64, colour: Rgb<u8>) -> bool {
    let pixel = picture.get_pixel(x.round() as u32, y.round() as u32);
    let far = |(a, b): (&u8, u8)| a.abs_diff(b) > 110;
    !pixel.0.iter().zip(colour.0).any(far)
}

#[test]
fn every_ring_has_its_ellipses_and_its_cross() {
    let detection = detection();
    let picture = overlay(&frame(), &board(), Ok(&detection), &[], Scale::FULL);
    assert_eq!(picture.dimensions(), (240, 160));
    for ring in &detection.rings {
        let c = ring.centre.point;
        // up and to the left, where no arrow and no label comes
        let up_left = |radius: f64, colour| {
            let aside = radius * std::f64::consts::FRAC_1_SQRT_2;
            near(&picture, c.x - aside, c.y - aside, colour)
        };
        assert!(up_left(20.0, OUTER));
        assert!(up_left(10.0, INNER));
        assert!(up_left(15.0, Rgb([128, 128, 128])));
        assert!(near(&picture, c.x - 3.0, c.y, CENTRE));
    }
}

#[test]
fn arrows_point_along_the_row_and_the_column_of_ring_0_0() {
    let picture = overlay(&frame(), &board(), Ok(&detection()), &[], Scale::FULL);
    assert!(near(&picture, 50.0 + 28.0, 40.0, COLUMN_AXIS));
    assert!(near(&picture, 50.0, 40.0 + 16.0, ROW_AXIS));
    assert!(!near(&picture, 110.0 + 28.0, 40.0, COLUMN_AXIS));
}

#[test]
fn the_scale_keeps_pixel_centres_in_place() {
    let detection = detection();
    let scale = Scale::new(2.0).unwrap();
    let picture = overlay(&frame(), &board(), Ok(&detection), &[], scale);
    assert_eq!(picture.dimensions(), (480, 320));
    // (x + 0.5) * 2 - 0.5: the left end of a ring at 30 goes to 60.5, between two pixels
    for x in [60.0, 61.0] {
        assert!(near(&picture, x, 80.6, OUTER));
    }
    let half = overlay(
        &frame(),
        &board(),
        Ok(&detection),
        &[],
        Scale::new(0.5).unwrap(),
    );
    assert_eq!(half.dimensions(), (120, 80));
    assert_eq!(
        (Scale::new(0.0), Scale::new(f64::NAN), Scale::new(9.0)),
        (None, None, None)
    );
}

#[test]
fn captions_and_coverage_change_the_picture() {
    let miss = Miss::TooFewRings {
        found: 3,
        expected: 6,
    };
    let draw = |miss: &Miss, kept: &[Point2<f64>]| {
        overlay(&frame(), &board(), Err(miss), kept, Scale::FULL)
    };
    let plain = draw(&miss, &[]);
    assert_ne!(plain, draw(&Miss::NoRing, &[]));
    let covered = draw(&miss, &[Point2::new(120.0, 30.0)]);
    let changed = plain
        .enumerate_pixels()
        .filter(|(x, y, p)| covered.get_pixel(*x, *y) != *p);
    let at: Vec<_> = changed
        .map(|(x, y, _)| (x.abs_diff(120), y.abs_diff(30)))
        .collect();
    assert!(at.contains(&(0, 0)) && at.iter().all(|&(dx, dy)| dx <= 2 && dy <= 2));
    assert_eq!(
        found(&board(), &detection()),
        "2 x 3 board, 6 rings, blur 3.1 px"
    );
}

#[test]
fn no_size_makes_it_panic() {
    for (width, height) in [(0, 0), (1, 1), (3, 200), (200, 3)] {
        let frame = Frame::from_u16(Plane::filled(width, height, 7), "");
        for factor in [0.01, 1.0, 3.3] {
            let scale = Scale::new(factor).unwrap();
            let picture = overlay(&frame, &board(), Ok(&detection()), &[], scale);
            assert!(picture.width() >= 1 && picture.height() >= 1);
            overlay(&frame, &board(), Err(&Miss::NoRing), &[], scale);
        }
    }
    let mut broken = detection();
    broken.rings[0].ellipses.outer.major = f64::INFINITY;
    broken.rings[1].ellipses.outer.centre.y = f64::NAN;
    broken.rings[2].centre.point.x = f64::NAN;
    overlay(&frame(), &board(), Ok(&broken), &[], Scale::FULL);
}
