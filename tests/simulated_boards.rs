//! Detection against the simulator's truth: every ring of every board, in order, where the truth says.

use ringcal::board::{Board, Polarity};
use ringcal::camera::{Camera, Intrinsics, PlumbBob};
use ringcal::centre::Estimator;
use ringcal::detect::{DetectOptions, Detection, Detector, Miss};
use ringcal::frame::{Frame, Plane};
use ringcal::simulate::{Defocus, Light, Rendering, Scene, render, views};

fn camera() -> Camera {
    Camera {
        width: 1280,
        height: 960,
        intrinsics: Intrinsics {
            fx: 1400.0,
            fy: 1395.0,
            cx: 652.0,
            cy: 471.0,
        },
        distortion: PlumbBob {
            k1: -0.18,
            k2: 0.09,
            p1: 0.0008,
            p2: -0.0006,
            k3: 0.0,
        }
        .into(),
    }
}

/// The paper's board C4, or the same with light rings.
fn board(polarity: Polarity) -> Board {
    Board::new(7, 7, 0.0269, 0.003, 0.006, polarity).unwrap()
}

fn detect(board: &Board, frame: &Frame, estimator: Estimator) -> Result<Detection, Miss> {
    let options = DetectOptions {
        estimator,
        ..DetectOptions::default()
    };
    Detector::new(board.clone(), options).detect(frame)
}

/// Root mean square distance of the centres from the truth, px. The labels must be the truth's.
fn rms_error_px(detection: &Detection, rendering: &Rendering) -> f64 {
    let truth = &rendering.truth.rings;
    assert_eq!(detection.rings.len(), truth.len());
    let sum: f64 = detection
        .rings
        .iter()
        .zip(truth)
        .map(|(found, truth)| {
            assert_eq!((found.row, found.column), (truth.row, truth.column));
            (found.centre.point - truth.centre).norm_squared()
        })
        .sum();
    (sum / truth.len() as f64).sqrt()
}

/// Frames of one board under a blur, at tilts up to 40 degrees.
fn renderings(board: &Board, defocus: Defocus, count: usize, seed: u64) -> Vec<Rendering> {
    views(&camera(), board, count, 40_f64.to_radians(), seed)
        .unwrap()
        .into_iter()
        .enumerate()
        .map(|(i, pose)| {
            let mut scene = Scene::new(camera(), board.clone(), pose);
            scene.defocus = defocus;
            scene.light = Light::on(board.polarity());
            scene.light.shading = [0.2, -0.1];
            scene.sensor.read_noise = 0.01;
            render(&scene, seed + i as u64).unwrap()
        })
        .collect()
}

#[test]
fn every_ring_is_found_at_every_blur_and_tilt() {
    let board = board(Polarity::DarkOnLight);
    // edges of a blurred ring are displaced by their neighbours: the errors of this construction grow with blur
    for (sigma_px, most_px) in [
        (0.0, 0.05),
        (1.0, 0.05),
        (2.0, 0.06),
        (4.0, 0.2),
        (6.0, 0.6),
    ] {
        for rendering in renderings(&board, Defocus::gaussian(sigma_px), 5, 11) {
            let detection = detect(&board, &rendering.frame, Estimator::Cross).unwrap();
            let rms = rms_error_px(&detection, &rendering);
            let blur = detection.blur_sigma_px();
            eprintln!("sigma {sigma_px} px: rms {rms:.4} px, blur found {blur:.2} px");
            assert!(rms < most_px, "sigma {sigma_px} px: {rms} px");
            assert!(
                (blur - sigma_px).abs() < 0.7 + 0.3 * sigma_px,
                "sigma {sigma_px} px: {blur} px"
            );
        }
    }
}

#[test]
fn disc_blur_and_light_rings_are_no_different() {
    let board = board(Polarity::LightOnDark);
    for rendering in renderings(&board, Defocus::disc(6.0), 3, 5) {
        let rms = rms_error_px(
            &detect(&board, &rendering.frame, Estimator::Cross).unwrap(),
            &rendering,
        );
        assert!(rms < 0.2, "{rms} px");
    }
}

#[test]
fn auto_polarity_finds_both() {
    for polarity in [Polarity::DarkOnLight, Polarity::LightOnDark] {
        let rendering = &renderings(&board(polarity), Defocus::gaussian(2.0), 1, 3)[0];
        let unknown = board(Polarity::Auto);
        assert!(
            rms_error_px(
                &detect(&unknown, &rendering.frame, Estimator::Cross).unwrap(),
                rendering
            ) < 0.06
        );
    }
}

#[test]
fn ellipse_centres_carry_the_perspective_bias_and_the_constructions_do_not() {
    // close to a wide lens: strong perspective within one ring
    let board = Board::new(3, 3, 0.06, 0.0125, 0.025, Polarity::DarkOnLight).unwrap();
    let mut wide = camera();
    wide.intrinsics = Intrinsics {
        fx: 700.0,
        fy: 700.0,
        cx: 640.0,
        cy: 480.0,
    };
    wide.distortion = PlumbBob::default().into();
    let pose = views(&wide, &board, 3, 40_f64.to_radians(), 2).unwrap()[0];
    let scene = Scene::new(wide, board.clone(), pose);
    let rendering = render(&scene, 0).unwrap();
    let rms = |e| rms_error_px(&detect(&board, &rendering.frame, e).unwrap(), &rendering);
    let (big, small) = (rms(Estimator::BigEllipse), rms(Estimator::SmallEllipse));
    assert!(big > 2.0 * small && small > 0.2, "{big} {small}");
    for exact in [Estimator::Cross, Estimator::OneSided, Estimator::PolePolar] {
        assert!(rms(exact) < 0.1 * small, "{}: {}", exact.name(), rms(exact));
    }
}

#[test]
fn a_single_ring_is_a_board_too() {
    let single = Board::new(1, 1, 0.0, 0.05, 0.1, Polarity::DarkOnLight).unwrap();
    for (sigma_px, most_px) in [(0.0, 0.1), (5.0, 0.15)] {
        let pose = views(&camera(), &single, 1, 0.6, 4).unwrap()[0];
        let mut scene = Scene::new(camera(), single.clone(), pose);
        scene.defocus = Defocus::gaussian(sigma_px);
        let rendering = render(&scene, 1).unwrap();
        let rms = rms_error_px(
            &detect(&single, &rendering.frame, Estimator::Cross).unwrap(),
            &rendering,
        );
        assert!(rms < most_px, "sigma {sigma_px} px: {rms} px");
    }
}

#[test]
fn sixteen_bit_frames_of_little_range_are_found() {
    let board = board(Polarity::DarkOnLight);
    let rendering = &renderings(&board, Defocus::gaussian(2.0), 1, 8)[0];
    let ringcal::frame::Pixels::U8(plane) = &rendering.frame.pixels else {
        panic!("the simulator's default is 8 bit");
    };
    let dim: Vec<u16> = plane
        .data()
        .iter()
        .map(|&v| 800 + 4 * u16::from(v))
        .collect();
    let plane = Plane::from_vec(plane.width(), plane.height(), dim).unwrap();
    let detection = detect(&board, &Frame::from_u16(plane, "dim"), Estimator::Cross).unwrap();
    assert!(rms_error_px(&detection, rendering) < 0.06);
}

#[test]
fn the_same_frame_gives_the_same_bits_on_one_thread_and_on_four() {
    let board = board(Polarity::DarkOnLight);
    let rendering = &renderings(&board, Defocus::gaussian(3.0), 1, 21)[0];
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| detect(&board, &rendering.frame, Estimator::Cross))
            .unwrap()
    };
    assert_eq!(with(1), with(4));
}

#[test]
fn a_board_of_another_size_is_named() {
    let six = Board::new(6, 7, 0.0269, 0.003, 0.006, Polarity::DarkOnLight).unwrap();
    let rendering = &renderings(&board(Polarity::DarkOnLight), Defocus::gaussian(1.0), 1, 9)[0];
    let miss = detect(&six, &rendering.frame, Estimator::Cross).unwrap_err();
    assert_eq!(miss.to_string(), "found 7 x 7, the board file says 6 x 7");
}

#[test]
fn frames_without_a_board_say_so() {
    let board = board(Polarity::DarkOnLight);
    let flat = Frame::from_u8(Plane::filled(1280, 960, 128_u8), "flat");
    assert!(matches!(
        detect(&board, &flat, Estimator::Cross),
        Err(Miss::NoContrast { .. })
    ));
    let tiny = Frame::from_u8(Plane::filled(30, 20, 128_u8), "tiny");
    assert!(matches!(
        detect(&board, &tiny, Estimator::Cross),
        Err(Miss::FrameTooSmall { .. })
    ));
    let mut state = 1_u32;
    let noise: Vec<u8> = std::iter::repeat_with(|| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    })
    .take(640 * 480)
    .collect();
    let noise = Frame::from_u8(Plane::from_vec(640, 480, noise).unwrap(), "noise");
    assert!(detect(&board, &noise, Estimator::Cross).is_err());
}

/// Noise smoothed to blobs of a few px stands in rows here and there; it is no board.
#[test]
fn texture_is_no_board() {
    let boards = [
        board(Polarity::DarkOnLight),
        Board::new(4, 5, 0.029, 0.0053, 0.01, Polarity::DarkOnLight).unwrap(),
    ];
    for (seed, sigma) in [(1, 2.0_f32), (2, 4.0), (3, 6.0), (4, 8.0)] {
        let mut state = seed;
        let noise: Vec<u8> = std::iter::repeat_with(|| {
            state = 1_664_525_u32
                .wrapping_mul(state)
                .wrapping_add(1_013_904_223);
            (state >> 24) as u8
        })
        .take(1280 * 960)
        .collect();
        let picture = image::GrayImage::from_raw(1280, 960, noise).unwrap();
        let smooth = image::imageops::blur(&picture, sigma);
        // stretch what smoothing has left of the contrast
        let gain = 2.4 * f64::from(sigma);
        let grey = smooth
            .into_raw()
            .into_iter()
            .map(|v| ((f64::from(v) - 127.5) * gain + 127.5) as u8);
        let frame = Frame::from_u8(
            Plane::from_vec(1280, 960, grey.collect()).unwrap(),
            "texture",
        );
        for board in &boards {
            let found = detect(board, &frame, Estimator::Cross);
            assert!(
                found.is_err(),
                "sigma {sigma}: {} rings",
                found.unwrap().rings.len()
            );
        }
    }
}

#[test]
fn a_strong_wide_lens_keeps_the_corners_of_the_board() {
    let mut wide = camera();
    wide.intrinsics.fx = 700.0;
    wide.intrinsics.fy = 700.0;
    wide.distortion = PlumbBob {
        k1: -0.25,
        k2: 0.06,
        p1: 0.0,
        p2: 0.0,
        k3: 0.0,
    }
    .into();
    let board = board(Polarity::DarkOnLight);
    for pose in views(&wide, &board, 6, 0.4, 3).unwrap() {
        let mut scene = Scene::new(wide, board.clone(), pose);
        scene.defocus = Defocus::gaussian(2.0);
        let rendering = render(&scene, 0).unwrap();
        let detection = detect(&board, &rendering.frame, Estimator::Cross).unwrap();
        assert!(detection.rings.len() >= 47, "{}", detection.rings.len());
        for found in &detection.rings {
            let truth = rendering
                .truth
                .rings
                .iter()
                .find(|t| (t.row, t.column) == (found.row, found.column));
            assert!((found.centre.point - truth.unwrap().centre).norm() < 0.3);
        }
    }
}
