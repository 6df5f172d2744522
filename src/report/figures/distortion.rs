//! By how much the lens bends the picture.

use super::Figure;
use super::chart::round_step;
use super::frame_plot::FramePlot;
use crate::camera::{Camera, Distortion};
use crate::report::svg::Anchor;
use nalgebra::{Point2, Point3, Vector2};

/// Arrows across and down, about.
const ACROSS: usize = 13;
const DOWN: usize = 10;
/// The longest arrow, as a part of the distance between two.
const LONGEST: f64 = 0.9;

/// Arrows from where a lens without distortion would show a point to where this one shows it.
pub(in crate::report) fn distortion(camera: &Camera) -> Figure {
    let frame_px = (f64::from(camera.width), f64::from(camera.height));
    let mut plot = FramePlot::new(frame_px, 1.0, "Distortion of the lens over the frame");
    let shifts: Vec<(Point2<f64>, Vector2<f64>)> = shifts(camera);
    let most_px = shifts.iter().map(|s| s.1.norm()).fold(0.0, f64::max);
    let room = LONGEST * frame_px.0 / ACROSS as f64;
    let times = if most_px * 1e6 > room {
        times(room / most_px)
    } else {
        1.0
    };
    let arrows: Vec<[[f64; 2]; 2]> = shifts
        .iter()
        .map(|(at, shift)| [plot.at(at - shift * times), plot.at(*at)])
        .collect();
    for [from, to] in &arrows {
        plot.svg.strokes("vector", [[*from, *to]]);
        plot.svg.circle("head", *to, 2.2);
    }
    plot.outline();
    plot.say_size(frame_px);
    legend(&mut plot, times);
    let drawn = match times {
        1.0 => "to scale".to_owned(),
        times if times > 1.0 => format!("{times} times as long as it is"),
        times => format!("at {times} of its length"),
    };
    Figure {
        title: format!("Distortion: {most_px:.1} px at most"),
        svg: plot.svg,
        reading: format!(
            "Each line leads to a dot, where this lens shows a point, from where the same camera without distortion would \
             show it; {drawn}. Lines towards the middle are barrel distortion, lines away from it pincushion. It should \
             change smoothly and be much the same on all sides; a corner that breaks away was not measured."
        ),
    }
}

/// Pixels over the frame and by how much distortion moved what is seen there; not where the camera has no ray.
fn shifts(camera: &Camera) -> Vec<(Point2<f64>, Vector2<f64>)> {
    let zeros = vec![0.0; camera.model().coefficient_count()];
    let ideal = Camera {
        distortion: Distortion::new(camera.model(), &zeros).unwrap_or(camera.distortion),
        ..*camera
    };
    let along = |at: usize, count: usize, side: u32| {
        (at as f64 + 0.5) * f64::from(side) / count as f64 - 0.5
    };
    (0..ACROSS * DOWN)
        .filter_map(|cell| {
            let x = along(cell % ACROSS, ACROSS, camera.width);
            let y = along(cell / ACROSS, DOWN, camera.height);
            let pixel = Point2::new(x, y);
            let ray = camera.ray(&pixel)?;
            let without = ideal.project(&Point3::from(ray))?;
            Some((pixel, pixel - without))
        })
        .collect()
}

/// 1, 2 or 5 times a power of ten, the next below.
fn times(exact: f64) -> f64 {
    1.0 / round_step(1.0 / exact)
}

fn legend(plot: &mut FramePlot, times: f64) {
    let units = times * plot.scale;
    let px = round_step(30.0 / units);
    let [x, y] = plot.legend(0.0);
    let length = px * units;
    plot.svg
        .strokes("vector", [[[x, y - 5.0], [x + length, y - 5.0]]]);
    plot.svg.circle("head", [x + length, y - 5.0], 2.2);
    plot.svg.text(
        "label",
        [x + length + 8.0, y],
        Anchor::Start,
        &format!("{px} px"),
    );
}
