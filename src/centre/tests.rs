//! The constructions against circles projected by a known homography.

use super::*;
use nalgebra::{Matrix3, Point2};
use proptest::prelude::*;

/// The images of the circles of radius 1 and `ratio` about (0, 0), and of their centre.
fn ring_under(homography: &Matrix3<f64>, ratio: f64) -> Option<(RingEllipses, Point2<f64>)> {
    let inverse = homography.try_inverse()?;
    let image = |r: f64| {
        let circle = Matrix3::from_diagonal(&[1.0, 1.0, -r * r].into());
        Ellipse::from_conic(&(inverse.transpose() * circle * inverse))
    };
    let centre = homography.column(2);
    Some((
        RingEllipses {
            inner: image(ratio)?,
            outer: image(1.0)?,
        },
        Point2::new(centre[0] / centre[2], centre[1] / centre[2]),
    ))
}

fn tilted() -> Matrix3<f64> {
    Matrix3::new(80.0, 12.0, 320.0, -9.0, 61.0, 240.0, 0.11, -0.07, 1.0)
}

fn estimate(estimator: Estimator, ring: &RingEllipses) -> Point2<f64> {
    estimator
        .construction()
        .unwrap()
        .estimate(ring)
        .unwrap()
        .point
}

#[test]
fn three_constructions_find_the_projected_centre_and_two_do_not() {
    let (ring, truth) = ring_under(&tilted(), 0.5).unwrap();
    for exact in [Estimator::Cross, Estimator::OneSided, Estimator::PolePolar] {
        let error = (estimate(exact, &ring) - truth).norm();
        assert!(error < 1e-7, "{} {error}", exact.name());
    }
    let big = (estimate(Estimator::BigEllipse, &ring) - truth).norm();
    let small = (estimate(Estimator::SmallEllipse, &ring) - truth).norm();
    // the bias grows with the square of the radius, to first order
    assert!(
        small > 1.0 && (big / small - 4.0).abs() < 0.3,
        "{big} {small}"
    );
}

#[test]
fn a_frontal_ring_has_its_centre_at_the_common_ellipse_centre() {
    let frontal = Matrix3::new(50.0, 5.0, 99.5, -5.0, 40.0, 80.25, 0.0, 0.0, 1.0);
    let (ring, truth) = ring_under(&frontal, 0.4).unwrap();
    for estimator in Estimator::ALL
        .into_iter()
        .filter(|e| e.construction().is_some())
    {
        assert!(
            (estimate(estimator, &ring) - truth).norm() < 1e-6,
            "{}",
            estimator.name()
        );
    }
}

#[test]
fn delta_switches_to_the_mean_of_three_points() {
    let (mut ring, _) = ring_under(&tilted(), 0.5).unwrap();
    ring.outer.angle += 0.05;
    ring.outer.centre.y += 1.0;
    let point = |delta_px| Cross { delta_px }.estimate(&ring).unwrap().point;
    let (crossing, mean) = (point(f64::INFINITY), point(0.0));
    assert!((crossing - mean).norm() > 1e-3);
    let line = line::Line::through(&ring.inner.centre, &ring.outer.centre).unwrap();
    // two of the three points lie on the line of centres, so the mean is three times nearer to it
    let ratio = line.distance(&crossing) / line.distance(&mean);
    assert!((ratio - 3.0).abs() < 1e-6, "{ratio}");
}

#[test]
fn ellipses_that_are_not_nested_are_refused() {
    let (mut ring, _) = ring_under(&tilted(), 0.5).unwrap();
    std::mem::swap(&mut ring.inner, &mut ring.outer);
    for estimator in [Estimator::Cross, Estimator::OneSided] {
        assert_eq!(
            estimator.construction().unwrap().estimate(&ring),
            Err(CentreError::NotNested)
        );
    }
}

#[test]
fn names_are_read_back() {
    for estimator in Estimator::ALL {
        assert_eq!(estimator.name().parse(), Ok(estimator));
    }
    assert!("circle".parse::<Estimator>().unwrap_err().contains("cross"));
}

proptest! {
    /// Whatever the view and the radius ratio, the exact constructions agree with the homography.
    #[test]
    fn exact_for_every_view(
        sx in 20.0..200.0, sy in 20.0..200.0, shear in -0.3..0.3, turn in -3.1..3.1_f64,
        g in -0.3..0.3, h in -0.3..0.3, ratio in 0.2..0.8,
    ) {
        let (sin, cos) = turn.sin_cos();
        let affine = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
            * Matrix3::new(sx, shear * sx, 0.0, 0.0, sy, 0.0, 0.0, 0.0, 1.0);
        let view = Matrix3::new(1.0, 0.0, 700.0, 0.0, 1.0, 500.0, 0.0, 0.0, 1.0) * affine
            * Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, g, h, 1.0);
        let (ring, truth) = ring_under(&view, ratio).unwrap();
        for estimator in [Estimator::Cross, Estimator::OneSided, Estimator::PolePolar] {
            let error = (estimate(estimator, &ring) - truth).norm();
            prop_assert!(error < 1e-4, "{} {error}", estimator.name());
        }
    }
}
