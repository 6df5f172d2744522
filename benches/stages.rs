//! Every stage on a simulated frame of 1280 x 960 px: `cargo bench`.

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::Point2;
use ringcal::board::{Board, Polarity};
use ringcal::calibrate::{CalibrateOptions, calibrate};
use ringcal::camera::{Camera, Intrinsics, PlumbBob};
use ringcal::centre::Estimator;
use ringcal::centre::photometric::{BoardPlace, BoardStart, PsfChoice, measure_board};
use ringcal::detect::{DetectOptions, Detection, Detector};
use ringcal::enhance::{Target, enhance};
use ringcal::frame::{Frame, Linear, half_of_frame};
use ringcal::session::View;
use ringcal::simulate::{Defocus, Scene, render, views};
use std::hint::black_box;
use std::num::NonZeroU32;

/// What could not be set up has nothing to measure.
const SET_UP: &str = "the benchmark's own scene is in range";

fn board() -> Board {
    Board::new(7, 7, 0.0269, 0.003, 0.006, Polarity::DarkOnLight).expect(SET_UP)
}

fn camera() -> Camera {
    Camera {
        width: 1280,
        height: 960,
        intrinsics: Intrinsics {
            fx: 1200.0,
            fy: 1205.0,
            cx: 645.0,
            cy: 472.0,
        },
        distortion: PlumbBob {
            k1: -0.2,
            k2: 0.08,
            ..PlumbBob::default()
        }
        .into(),
    }
}

fn frames(defocus: Defocus, count: usize) -> Vec<Frame> {
    let poses = views(&camera(), &board(), count, 0.5, 11).expect(SET_UP);
    let frames = poses.into_iter().enumerate().map(|(i, pose)| {
        let mut scene = Scene::new(camera(), board(), pose);
        scene.defocus = defocus;
        scene.light.margin = f64::INFINITY;
        scene.sensor.read_noise = 0.01;
        render(&scene, i as u64).expect(SET_UP).frame
    });
    frames.collect()
}

fn detector(estimator: Estimator) -> Detector {
    let options = DetectOptions {
        estimator,
        ..DetectOptions::default()
    };
    Detector::new(board(), options)
}

fn places(detection: &Detection) -> Vec<BoardPlace> {
    let place = |ring: &ringcal::detect::Ring| BoardPlace {
        plane_m: Point2::from(board().centre_m(ring.row, ring.column)),
        outline: ring.ellipses.outer,
        sigma_px: ring.blur_sigma_px,
    };
    detection.rings.iter().map(place).collect()
}

fn stages(criterion: &mut Criterion) {
    let blurs = [
        ("gaussian 2 px", Defocus::gaussian(2.0)),
        ("gaussian 6 px", Defocus::gaussian(6.0)),
        ("disc 8 px", Defocus::disc(8.0)),
    ];
    for (name, defocus) in blurs {
        let Some(frame) = frames(defocus, 1).pop() else {
            continue;
        };
        let cross = detector(Estimator::Cross);
        let found = cross.detect(&frame).expect(SET_UP);
        let mut bench = |stage: &str, work: &dyn Fn()| {
            let id = format!("{stage}, {name}");
            criterion.bench_function(&id, |bencher| bencher.iter(work));
        };
        bench("frame: first halving", &|| {
            black_box(half_of_frame(&frame));
        });
        bench("enhance", &|| {
            black_box(enhance(&frame, Target::Dark, NonZeroU32::MIN));
        });
        bench("detect, cross", &|| {
            let _ = black_box(cross.detect(&frame));
        });
        let photometric = detector(Estimator::Photometric);
        bench("detect, photometric", &|| {
            let _ = black_box(photometric.detect(&frame));
        });
        let (places, linear) = (places(&found), Linear::new(1.0, false));
        let start = BoardStart {
            places: &places,
            outer_radius_m: board().outer_radius_m(),
            ratio: board().radius_ratio(),
            sign: 1.0,
            psf: PsfChoice::Auto,
            camera: None,
            linear: &linear,
        };
        bench("photometric fit of 49 rings", &|| {
            black_box(measure_board(&frame, &start));
        });
        for estimator in Estimator::ALL {
            let Some(construction) = estimator.construction() else {
                continue;
            };
            bench(&format!("49 centres, {}", estimator.name()), &|| {
                for ring in &found.rings {
                    let _ = black_box(construction.estimate(&ring.ellipses));
                }
            });
        }
    }
}

fn calibration(criterion: &mut Criterion) {
    let detector = detector(Estimator::Cross);
    let found = frames(Defocus::gaussian(2.0), 20);
    let views: Vec<View> = found
        .iter()
        .filter_map(|frame| Some(View::of_file("bench", &detector.detect(frame).ok()?)))
        .collect();
    let options = CalibrateOptions::default();
    criterion.bench_function("calibrate, 20 views of 49 rings", |bencher| {
        bencher.iter(|| calibrate(&board(), black_box(&views), &options).is_ok());
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = stages, calibration
}
criterion_main!(benches);
