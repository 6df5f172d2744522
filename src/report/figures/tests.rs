//! The figures as structure: how many of what, and whether values stand where they belong.

use super::*;
use crate::calibrate::{CalibrateOptions, Calibration, Range, calibrate, synthetic};
use crate::camera::PlumbBob;
use crate::session::View;
use nalgebra::Point2;

fn solved() -> (Vec<View>, Calibration) {
    let (camera, board) = (synthetic::ordinary(), synthetic::board());
    let views = synthetic::views(&camera, &board, &synthetic::poses(&camera, &board), 0.1, 1);
    let calibration = calibrate(&board, &views, &CalibrateOptions::default()).unwrap();
    (views, calibration)
}

/// Numbers of an attribute of the elements of a class.
fn numbers(svg: &str, class: &str, attribute: &str) -> Vec<f64> {
    svg.split('<')
        .filter(|element| element.contains(&format!("class=\"{class}\"")))
        .filter_map(|element| {
            let (_, rest) = element.split_once(&format!(" {attribute}=\""))?;
            rest.split_once('"')?.0.parse().ok()
        })
        .collect()
}

#[test]
fn there_is_a_vector_for_every_ring_and_a_cross_for_one_left_out() {
    let (views, mut calibration) = solved();
    calibration.views[0].rings_used[3] = false;
    let figure = residuals(&views, &calibration);
    assert!(figure.reading.contains("The cross is a ring"));
    let svg = figure.svg.finish();
    // all in one path; the second one is the legend
    let path = svg.split("<path class=\"vector\"").nth(1).unwrap();
    let path = path.split_once("/>").unwrap().0;
    assert_eq!(path.matches('M').count(), 12 * 49 - 1);
    assert_eq!(svg.matches("<path class=\"cross\"").count(), 1);
    // the first begins at its ring, at 478 units for 1280 px
    let at = views[0].rings[0].centre.point;
    let scale = 478.0 / 1280.0;
    let start = format!(
        "d=\"M{:.1} {:.1}l",
        1.0 + (at.x + 0.5) * scale,
        1.0 + (at.y + 0.5) * scale
    );
    assert!(path.contains(&start), "{start} in {}", &path[..60]);
}

#[test]
fn residuals_are_magnified_by_round_numbers() {
    assert_eq!(magnification(0.1, 1.0), 100.0);
    assert_eq!(magnification(0.05, 1.0), 200.0);
    assert_eq!(magnification(0.02, 0.5), 1000.0);
    assert_eq!(magnification(50.0, 1.0), 1.0);
    assert!(magnification(0.0, 1.0).is_finite());
}

#[test]
fn every_cell_of_the_coverage_is_seen_or_not() {
    let (views, _) = solved();
    let all: Vec<&View> = views.iter().collect();
    let figure = coverage(&all, (1280.0, 960.0));
    let svg = figure.svg.finish();
    let (seen, unseen) = (
        numbers(&svg, "seen", "x").len(),
        numbers(&svg, "unseen", "x").len(),
    );
    assert_eq!(seen + unseen, 100);
    assert!(
        figure.title.contains(&format!("{seen} %")),
        "{}",
        figure.title
    );
    let dots = svg.split("<path class=\"dots\"").nth(1).unwrap();
    assert_eq!(
        dots.split_once("/>").unwrap().0.matches("l0 0").count(),
        12 * 49
    );
}

#[test]
fn cells_of_the_uncertainty_have_their_class_and_say_their_number() {
    use super::uncertainty::class;
    assert_eq!(
        [0.005, 0.01, 0.011, 0.1, 1.5, 2.5, f64::NAN].map(class),
        [0, 0, 1, 3, 7, 8, 8]
    );
    let (_, calibration) = solved();
    let svg = uncertainty(&calibration, Range::Infinity).svg.finish();
    assert_eq!(svg.matches("<text class=\"on").count(), 100);
    let corner = calibration
        .projection_std_px(&Point2::new(63.5, 47.5), Range::Infinity)
        .unwrap();
    let first = svg.split("<rect").nth(2).unwrap();
    assert!(
        first.contains(&format!("class=\"s{}\"", class(corner))),
        "{first}"
    );
    assert!(first.contains(&format!(">{corner:.3}</text>")), "{first}");
    assert_eq!(svg.matches("class=\"worst\"").count(), 1);
    for word in [">good<", ">usable<", ">not enough<", ">px<"] {
        assert!(svg.contains(word), "{word}");
    }
}

#[test]
fn a_lens_without_distortion_has_no_arrows_and_a_barrel_s_point_inwards() {
    let mut camera = synthetic::ordinary();
    camera.distortion = PlumbBob::default().into();
    let none = distortion(&camera);
    assert_eq!(none.title, "Distortion: 0.0 px at most");
    camera.distortion = PlumbBob {
        k1: -0.1,
        ..PlumbBob::default()
    }
    .into();
    let svg = distortion(&camera).svg.finish();
    assert_eq!(svg.matches("class=\"head\"").count(), 13 * 10 + 1);
    // the first arrow is at the upper left, and leads down and to the right to its dot
    let (_, path) = svg.split_once("<path class=\"vector\" d=\"M").unwrap();
    let (_, step) = path.split_once('l').unwrap();
    let step: Vec<f64> = step
        .split_once('"')
        .unwrap()
        .0
        .split(' ')
        .map(|n| n.parse().unwrap())
        .collect();
    assert!(step[0] > 1.0 && step[1] > 1.0, "{step:?}");
}

#[test]
fn bars_are_as_high_as_the_errors() {
    let (_, mut calibration) = solved();
    calibration.views[2].rms_px = 2.0 * calibration.views[1].rms_px;
    let figure = by_view(&calibration);
    let svg = figure.svg.finish();
    let heights = numbers(&svg, "bar", "height");
    assert_eq!(heights.len(), 12);
    assert!((heights[2] / heights[1] - 2.0).abs() < 0.01, "{heights:?}");
    assert!(svg.contains(&format!("view 3: {:.4} px", calibration.views[2].rms_px)));
    assert_eq!(svg.matches("class=\"level\"").count(), 1);
}

#[test]
fn errors_that_grow_outward_are_seen_by_radius() {
    use super::by_radius::bins;
    let (views, mut calibration) = solved();
    let k = calibration.camera.intrinsics;
    let principal = Point2::new(k.cx, k.cy);
    for (view, fit) in views.iter().zip(&mut calibration.views) {
        for (ring, residual) in view.rings.iter().zip(&mut fit.residuals) {
            *residual = Some(1e-3 * (ring.centre.point - principal));
        }
    }
    let (bins, width_px) = bins(&views, &calibration);
    assert_eq!(bins.iter().map(|bin| bin.rings).sum::<usize>(), 12 * 49);
    for (at, bin) in bins.iter().enumerate() {
        let Some(told) = bin.told() else { continue };
        let range = 1e-3 * width_px * at as f64..=1e-3 * width_px * (at + 1) as f64;
        assert!(
            range.contains(&told.rms) && range.contains(&told.outward),
            "{at}: {told:?}"
        );
        // they are not all at the same distance, and hardly scatter
        assert!(told.chance < 0.3 * told.rms, "{told:?}");
    }
    let told = bins.iter().filter(|bin| bin.told().is_some()).count();
    let svg = by_radius(&views, &calibration).svg.finish();
    assert_eq!(svg.matches("class=\"mean\"").count(), told);
    assert_eq!(svg.matches("class=\"bar\"").count(), told);
}

#[test]
fn the_blur_of_a_view_is_a_dot_on_its_range() {
    let (mut views, _) = solved();
    views[4].rings[0].blur_sigma_px = 6.0;
    views[5].rings.clear();
    let svg = blur(&views).svg.finish();
    assert_eq!(svg.matches("class=\"dot\"").count(), 11);
    let ends = [numbers(&svg, "range", "y1"), numbers(&svg, "range", "y2")];
    let length = |view: usize| ends[0][view] - ends[1][view];
    assert!(length(3) == 0.0 && length(4) > 50.0, "{ends:?}");
}
