//! What must be true of every synthetic frame: symmetry, first moments, noise, reproducibility, truth, refusals, views.

use nalgebra::{Vector2, Vector3};
use ringcal::board::{Board, Polarity};
use ringcal::camera::{Camera, Intrinsics, PlumbBob, Pose};
use ringcal::frame::{Frame, Pixels, Plane};
use ringcal::simulate::{
    BitDepth, Defocus, Light, Psf, Rendering, Scene, SceneError, Sensor, ThinLens, ViewsError,
    irradiance, render, views,
};

fn camera(width: u32, height: u32, focal_px: f64) -> Camera {
    Camera {
        width,
        height,
        intrinsics: Intrinsics {
            fx: focal_px,
            fy: focal_px,
            cx: 0.5 * f64::from(width - 1),
            cy: 0.5 * f64::from(height - 1),
        },
        distortion: PlumbBob {
            k1: -0.25,
            k2: 0.08,
            ..PlumbBob::default()
        }
        .into(),
    }
}

fn grid() -> Board {
    Board::new(7, 7, 0.0269, 0.003, 0.006, Polarity::DarkOnLight).unwrap()
}

/// A single tilted ring in the middle of an endless sheet of paper.
fn ring() -> Scene {
    let board = Board::new(1, 1, 0.0, 0.01, 0.02, Polarity::DarkOnLight).unwrap();
    let pose = Pose::from_rotation_vector(
        Vector3::new(0.6, 0.3, 0.0),
        Vector3::new(0.002, -0.001, 0.2),
    );
    Scene {
        // levels that f32 holds exactly, so that moments of the whole frame can be compared
        light: Light {
            paper: 0.875,
            ring: 0.125,
            margin: f64::INFINITY,
            ..Light::default()
        },
        ..Scene::new(camera(240, 200, 260.0), board, pose)
    }
}

/// The whole grid, nearly frontal.
fn board_scene() -> Scene {
    let [x, y] = grid().middle_m();
    let pose = Pose::from_rotation_vector(Vector3::new(0.2, -0.1, 0.05), Vector3::new(-x, -y, 0.3));
    Scene::new(camera(320, 240, 320.0), grid(), pose)
}

/// Area (px) and centroid of what is darker than the paper.
fn moments(scene: &Scene) -> (f64, Vector2<f64>) {
    let plane = irradiance(scene).unwrap();
    let (mut area, mut sum) = (0.0, Vector2::zeros());
    for (i, light) in plane.data().iter().enumerate() {
        let dark = scene.light.paper - f64::from(*light);
        area += dark;
        sum += dark * Vector2::new((i % plane.width()) as f64, (i / plane.width()) as f64);
    }
    (area / (scene.light.paper - scene.light.ring), sum / area)
}

/// Area and centroid of a ring in the picture, from a polygon through its projected circles.
fn polygon_moments(scene: &Scene) -> (f64, Vector2<f64>) {
    let corners = 20_000;
    let (mut area, mut sum) = (0.0, Vector2::zeros());
    for (radius_m, sign) in [
        (scene.board.outer_radius_m(), 1.0),
        (scene.board.inner_radius_m(), -1.0),
    ] {
        let corner = |i: usize| {
            let (sin, cos) = (i as f64 / corners as f64 * std::f64::consts::TAU).sin_cos();
            let point = scene.pose.board_to_camera([radius_m * cos, radius_m * sin]);
            scene.camera.project(&point).unwrap().coords
        };
        for i in 0..corners {
            let (a, b) = (corner(i), corner(i + 1));
            let triangle = 0.5 * sign * a.perp(&b);
            area += triangle;
            sum += triangle * (a + b) / 3.0;
        }
    }
    (area, sum / area)
}

#[test]
fn no_symmetric_blur_moves_the_first_moments() {
    let (area, centroid) = polygon_moments(&ring());
    let (sharp_area, _) = moments(&ring());
    assert!(
        (sharp_area / area - 1.0).abs() < 1e-6,
        "{sharp_area} {area}"
    );
    for defocus in [
        Defocus::gaussian(0.5),
        Defocus::gaussian(2.0),
        Defocus::gaussian(7.0),
        Defocus::disc(3.3),
        Defocus::disc(6.0),
        Defocus::disc(15.0),
    ] {
        let (blurred_area, blurred) = moments(&Scene { defocus, ..ring() });
        let moved = (blurred - centroid).norm();
        assert!(
            moved < 4e-5,
            "{defocus:?} moved the centroid by {moved:.1e} px"
        );
        let growth = blurred_area / area - 1.0;
        assert!(growth.abs() < 3e-6, "{defocus:?}: area by {growth:.1e}");
    }
}

#[test]
fn a_small_circle_has_the_area_of_its_ellipse() {
    // an affine view from far away: area = pi (R^2 - r^2) (f / z)^2 cos(tilt), up to (R / z)^2
    let mut scene = ring();
    scene.camera.distortion = PlumbBob::default().into();
    scene.camera.intrinsics.fx = 260e4;
    scene.camera.intrinsics.fy = 260e4;
    scene.pose.translation_m = Vector3::new(0.0, 0.0, 0.2e4);
    let (area, centroid) = moments(&scene);
    let px_per_m = 260.0 / 0.2;
    let circles = 0.02_f64.powi(2) - 0.01_f64.powi(2);
    let expected =
        std::f64::consts::PI * circles * px_per_m * px_per_m * scene.pose.tilt_rad().cos();
    assert!((area / expected - 1.0).abs() < 1e-5, "{area} {expected}");
    assert!(
        (centroid - Vector2::new(119.5, 99.5)).norm() < 1e-3,
        "{centroid}"
    );
}

#[test]
fn a_board_cut_off_at_left_and_top_is_the_mirror_of_one_cut_off_at_right_and_bottom() {
    let [x, y] = grid().middle_m();
    for defocus in [Defocus::None, Defocus::gaussian(3.0), Defocus::disc(6.0)] {
        let at = |sign: f64| {
            let to = Vector3::new(sign * 0.12 - x, sign * 0.09 - y, 0.3);
            let mut scene = Scene {
                pose: Pose::from_rotation_vector(Vector3::zeros(), to),
                defocus,
                ..board_scene()
            };
            scene.light.texture = 0.0;
            irradiance(&scene).unwrap()
        };
        let (cut_left, cut_right) = (at(-1.0), at(1.0));
        let mirrored = cut_right.data().iter().rev();
        let pairs = cut_left.data().iter().zip(mirrored);
        let worst = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(worst < 5e-5, "{defocus:?}: {worst:.1e}");
    }
}

fn eight_bit(frame: &Frame) -> &Plane<u8> {
    match &frame.pixels {
        Pixels::U8(plane) => plane,
        Pixels::U16(_) => panic!("16 bit"),
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let mut scene = board_scene();
    scene.sensor = Sensor {
        depth: BitDepth::Sixteen,
        read_noise: 0.01,
        full_well_electrons: Some(20_000.0),
        gamma: 1.0,
    };
    let on = |threads: usize, defocus: Defocus, seed: u64| -> Rendering {
        let scene = Scene {
            defocus,
            ..scene.clone()
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build()
            .unwrap()
            .install(|| render(&scene, seed).unwrap())
    };
    for defocus in [Defocus::None, Defocus::gaussian(2.0), Defocus::disc(4.0)] {
        let one = on(1, defocus, 7);
        assert_eq!(one, on(2, defocus, 7));
        assert_eq!(one, on(5, defocus, 7));
        assert_ne!(one.frame, on(1, defocus, 8).frame);
    }
}

/// Mean and standard deviation of the left half of a frame of even paper, as fractions of full scale.
fn grey_statistics(light: Light, sensor: Sensor) -> (f64, f64) {
    let mut scene = ring();
    scene.light = Light {
        ring: light.paper,
        ..light
    };
    scene.sensor = sensor;
    let frame = render(&scene, 3).unwrap().frame;
    let grey: Vec<f64> = match &frame.pixels {
        Pixels::U8(plane) => plane.data().iter().map(|v| f64::from(*v) / 255.0).collect(),
        Pixels::U16(plane) => plane
            .data()
            .iter()
            .map(|v| f64::from(*v) / 65535.0)
            .collect(),
    };
    let mean = grey.iter().sum::<f64>() / grey.len() as f64;
    let variance = grey.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / grey.len() as f64;
    (mean, variance.sqrt())
}

#[test]
fn noise_has_the_statistics_asked_for() {
    let light = Light {
        paper: 0.4,
        margin: f64::INFINITY,
        ..Light::default()
    };
    let quiet = Sensor {
        depth: BitDepth::Sixteen,
        ..Sensor::default()
    };
    let (mean, deviation) = grey_statistics(light, quiet);
    assert!((mean - 0.4).abs() < 1e-5 && deviation < 1e-9);
    let read = Sensor {
        read_noise: 0.02,
        ..quiet
    };
    let (mean, deviation) = grey_statistics(light, read);
    // 48,000 pixels: the mean is known to 1e-4, the deviation to 0.3 %
    assert!((mean - 0.4).abs() < 4e-4, "{mean}");
    assert!((deviation / 0.02 - 1.0).abs() < 0.015, "{deviation}");
    let shot = Sensor {
        full_well_electrons: Some(1000.0),
        ..quiet
    };
    let (mean, deviation) = grey_statistics(light, shot);
    assert!((mean - 0.4).abs() < 4e-4, "{mean}");
    assert!(
        (deviation / (0.4_f64 / 1000.0).sqrt() - 1.0).abs() < 0.015,
        "{deviation}"
    );
}

#[test]
fn light_above_full_scale_saturates_and_gamma_bends_the_response() {
    let paper = |paper| Light {
        paper,
        margin: f64::INFINITY,
        ..Light::default()
    };
    assert_eq!(grey_statistics(paper(1.3), Sensor::default()), (1.0, 0.0));
    let sensor = Sensor {
        gamma: 2.2,
        depth: BitDepth::Sixteen,
        ..Sensor::default()
    };
    let (grey, _) = grey_statistics(paper(0.5), sensor);
    assert!((grey - 0.5_f64.powf(1.0 / 2.2)).abs() < 1e-5, "{grey}");
    // a pixel of 0.5 is 128 in 8 bits (0.5 * 255 rounded)
    let mut scene = ring();
    scene.light = Light {
        ring: 0.5,
        ..paper(0.5)
    };
    let frame = render(&scene, 0).unwrap().frame;
    assert!(eight_bit(&frame).data().iter().all(|v| *v == 128));
}

#[test]
fn shading_is_linear_across_the_frame_and_one_in_the_middle() {
    let mut scene = ring();
    scene.light.ring = scene.light.paper;
    scene.light.shading = [0.3, -0.1];
    let plane = irradiance(&scene).unwrap();
    for (x, y) in [(0, 0), (239, 0), (120, 100), (17, 190)] {
        let across = (x as f64 + 0.5) / 240.0 - 0.5;
        let down = (y as f64 + 0.5) / 200.0 - 0.5;
        let expected = 0.875 * (1.0 + 0.3 * across - 0.1 * down);
        assert!((f64::from(plane.at(x, y)) - expected).abs() < 1e-6);
    }
}

#[test]
fn polarity_sets_which_is_darker() {
    let dark = board_scene();
    let light_board = Board::new(7, 7, 0.0269, 0.003, 0.006, Polarity::LightOnDark).unwrap();
    let light = Scene::new(dark.camera, light_board, dark.pose);
    let centre = render(&dark, 0).unwrap().truth.rings[24].centre;
    let (x, y) = (centre.x.round() as usize, centre.y.round() as usize);
    assert!((irradiance(&dark).unwrap().at(x, y) - 0.85).abs() < 1e-6);
    assert!((irradiance(&light).unwrap().at(x, y) - 0.10).abs() < 1e-6);
}

#[test]
fn the_truth_is_the_projection_of_each_common_centre_and_its_blur() {
    let lens = ThinLens {
        f_number: 2.8,
        focal_length_m: 0.004,
        pixel_m: 1.2e-5,
        focus_m: 2.0,
    };
    let scene = Scene {
        defocus: Defocus::ThinLens {
            psf: Psf::Disc,
            lens,
        },
        ..board_scene()
    };
    let truth = render(&scene, 0).unwrap().truth;
    assert_eq!(truth.rings.len(), 49);
    for ring in &truth.rings {
        let point = scene
            .pose
            .board_to_camera(scene.board.centre_m(ring.row, ring.column));
        assert_eq!(scene.camera.project(&point).unwrap(), ring.centre);
        // radius = aperture / 2 * image distance * |1 / focus - 1 / depth| / pixel
        let image_m = 1.0 / (1.0 / lens.focal_length_m - 1.0 / lens.focus_m);
        let aperture_m = lens.focal_length_m / lens.f_number;
        let spread_m = 0.5 * aperture_m * image_m * (1.0 / lens.focus_m - 1.0 / point.z).abs();
        assert!((ring.blur_sigma_px - 0.5 * spread_m / lens.pixel_m).abs() < 1e-9);
    }
}

#[test]
fn nonsense_is_refused_with_its_name() {
    let refused = |change: fn(&mut Scene)| {
        let mut scene = board_scene();
        change(&mut scene);
        render(&scene, 0).unwrap_err()
    };
    let name = |error: SceneError| match error {
        SceneError::Value { name, .. } => name,
        other => panic!("{other}"),
    };
    assert_eq!(
        name(refused(|s| s.defocus = Defocus::gaussian(-1.0))),
        "size of the blur"
    );
    assert_eq!(
        name(refused(|s| s.defocus = Defocus::disc(f64::NAN))),
        "size of the blur"
    );
    assert_eq!(name(refused(|s| s.light.paper = f64::INFINITY)), "paper");
    assert_eq!(name(refused(|s| s.sensor.gamma = 0.0)), "gamma");
    assert_eq!(name(refused(|s| s.sensor.read_noise = -0.1)), "read noise");
    assert_eq!(name(refused(|s| s.camera.width = 0)), "width");
    let behind = refused(|s| s.pose.translation_m.z = -0.3);
    assert_eq!(behind, SceneError::FromBehind);
    let through = refused(|s| {
        s.pose =
            Pose::from_rotation_vector(Vector3::new(0.0, 1.3, 0.0), Vector3::new(0.3, 0.0, 0.05));
    });
    assert!(
        matches!(through, SceneError::BehindCamera { .. }),
        "{through}"
    );
    let near = refused(|s| {
        s.pose = Pose::from_rotation_vector(Vector3::zeros(), Vector3::new(0.0, 0.0, 1e-4));
        s.camera.distortion = PlumbBob::default().into();
    });
    assert!(matches!(near, SceneError::TooNear { .. }), "{near}");
}

#[test]
fn views_show_the_whole_board_tilted_in_many_directions() {
    let board = grid();
    for camera in [
        camera(1280, 960, 1200.0),
        camera(640, 480, 420.0),
        camera(480, 800, 700.0),
    ] {
        let max_tilt = 40_f64.to_radians();
        let poses = views(&camera, &board, 20, max_tilt, 5).unwrap();
        assert_eq!(poses, views(&camera, &board, 20, max_tilt, 5).unwrap());
        assert_ne!(poses, views(&camera, &board, 20, max_tilt, 6).unwrap());
        let mut quadrants = [0; 4];
        let mut widest: f64 = 0.0;
        let shorter = f64::from(camera.width.min(camera.height));
        for pose in &poses {
            assert!(pose.tilt_rad() <= max_tilt + 1e-12);
            let pixel = |row, column| {
                let point = pose.board_to_camera(board.centre_m(row, column));
                camera.project(&point).unwrap()
            };
            for (row, column) in board.indices() {
                let p = pixel(row, column);
                assert!(p.x > 10.0 && p.x < f64::from(camera.width) - 11.0);
                assert!(p.y > 10.0 && p.y < f64::from(camera.height) - 11.0);
            }
            let along = pixel(3, 4) - pixel(3, 2);
            assert!(along.x > 0.0 && along.y.abs() < along.x * 35_f64.to_radians().tan());
            let normal = pose.rotation * Vector3::z();
            quadrants[usize::from(normal.x > 0.0) + 2 * usize::from(normal.y > 0.0)] += 1;
            widest = widest.max((pixel(3, 6) - pixel(3, 0)).norm() / shorter);
        }
        assert!(quadrants.iter().all(|n| *n >= 2), "{quadrants:?}");
        assert!(widest > 0.65, "{widest}");
        for pair in poses.windows(2) {
            let turned = pair[0].rotation.angle_to(&pair[1].rotation);
            assert!(turned > 5_f64.to_radians(), "{turned}");
        }
    }
    let steep = views(&camera(640, 480, 420.0), &board, 3, 1.5, 0);
    assert!(matches!(steep, Err(ViewsError::Tilt { .. })));
}

#[test]
fn views_before_a_lens_that_folds_within_the_frame_can_be_drawn() {
    let board = grid();
    for (k1, focal_px) in [(-0.3, 600.0), (-0.5, 600.0), (-0.2, 500.0)] {
        // -0.3 at 600 px: no image beyond 422 px, where the frame's corners are 800 px out
        let mut camera = camera(1280, 960, focal_px);
        camera.distortion = PlumbBob {
            k1,
            ..PlumbBob::default()
        }
        .into();
        for seed in 0..4 {
            for pose in views(&camera, &board, 12, 0.6, seed).unwrap() {
                let truth = render(&Scene::new(camera, board.clone(), pose), 0).unwrap();
                let inside = |ring: &ringcal::simulate::RingTruth| {
                    let p = ring.centre;
                    p.x > 0.0 && p.y > 0.0 && p.x < 1279.0 && p.y < 959.0
                };
                assert!(truth.truth.rings.iter().all(inside));
            }
        }
    }
}
