//! The synthetic camera against brute force: rays from points in each pixel (and in the aperture) to the board,
//! summed directly. Nothing of the renderer's method is used here: no outlines, no kernels in closed form.

use nalgebra::{Point2, Vector3};
use rayon::prelude::*;
use ringcal::board::{Board, Polarity};
use ringcal::camera::{Camera, Intrinsics, PlumbBob, Pose};
use ringcal::simulate::{Defocus, Light, Psf, Scene, ThinLens, irradiance};

const WIDTH: usize = 160;
const HEIGHT: usize = 120;

/// A tilted 2 x 2 board before a camera with a strongly distorting lens.
fn scene(defocus: Defocus) -> Scene {
    let camera = Camera {
        width: WIDTH as u32,
        height: HEIGHT as u32,
        intrinsics: Intrinsics {
            fx: 170.0,
            fy: 163.0,
            cx: 77.3,
            cy: 61.8,
        },
        distortion: PlumbBob {
            k1: -0.31,
            k2: 0.11,
            p1: 0.002,
            p2: -0.003,
            k3: 0.02,
        }
        .into(),
    };
    let board = Board::new(2, 2, 0.05, 0.009, 0.02, Polarity::DarkOnLight).unwrap();
    let pose = Pose::from_rotation_vector(
        Vector3::new(0.5, -0.45, 0.2),
        Vector3::new(-0.021, -0.026, 0.16),
    );
    Scene {
        defocus,
        light: Light {
            texture: 0.0,
            margin: 0.5,
            ..Light::default()
        },
        ..Scene::new(camera, board, pose)
    }
}

/// Depth and place on the board of the ray through a pixel, m.
fn on_board(scene: &Scene, pixel: &Point2<f64>) -> (f64, [f64; 2]) {
    let ray = scene.camera.unproject(pixel).unwrap();
    let ray = Vector3::new(ray.x, ray.y, 1.0);
    let normal = scene.pose.rotation * Vector3::z();
    let depth = normal.dot(&scene.pose.translation_m) / normal.dot(&ray);
    let point = scene.pose.rotation.inverse() * (ray * depth - scene.pose.translation_m);
    (depth, [point.x, point.y])
}

/// Light of the board where the ray through a pixel meets it, edges softened over `soft_px` pixels.
fn light_at(scene: &Scene, pixel: &Point2<f64>, soft_px: f64) -> f64 {
    let (depth, [x, y]) = on_board(scene, pixel);
    let board = &scene.board;
    let nearest = |v: f64, count: u16| {
        (v / board.pitch_m())
            .round()
            .clamp(0.0, f64::from(count - 1))
            * board.pitch_m()
    };
    let ring = [nearest(x, board.columns()), nearest(y, board.rows())];
    let radius = (x - ring[0]).hypot(y - ring[1]);
    let beyond = (1.0 + scene.light.margin) * board.outer_radius_m();
    let last = board.pitch_m() + beyond;
    // signed distances on the board, m: positive inside
    let in_ring = (board.outer_radius_m() - radius).min(radius - board.inner_radius_m());
    let on_paper = (x + beyond).min(last - x).min(y + beyond).min(last - y);
    let metres_per_px = depth / scene.camera.intrinsics.fx;
    let inside = |distance: f64| {
        if soft_px == 0.0 {
            f64::from(distance > 0.0)
        } else {
            (0.5 + distance / (soft_px * metres_per_px)).clamp(0.0, 1.0)
        }
    };
    let light = &scene.light;
    light.background
        + inside(on_paper) * (light.paper - light.background)
        + inside(in_ring) * (light.ring - light.paper)
}

/// Places of the middles of an n x n grid in the unit square about 0.
fn grid(n: usize) -> impl Iterator<Item = [f64; 2]> {
    let at = move |i: usize| (i as f64 + 0.5) / n as f64 - 0.5;
    (0..n * n).map(move |i| [at(i % n), at(i / n)])
}

/// Light on a pixel in focus: the mean of the rays through it.
fn in_focus(scene: &Scene, x: usize, y: usize, n: usize) -> f64 {
    let rays = grid(n).map(|[dx, dy]| Point2::new(x as f64 + dx, y as f64 + dy));
    rays.map(|p| light_at(scene, &p, 0.0)).sum::<f64>() / (n * n) as f64
}

/// Points about a pixel, n x n per pixel, with the light that reaches the pixel from each: the point-spread function summed
/// over n x n points of the pixel.
fn spread(psf: Psf, size_px: f64, n: usize) -> Vec<([f64; 2], f64)> {
    let step = 1.0 / n as f64;
    let reach = if psf == Psf::Disc { 1.0 } else { 5.5 } * size_px + 1.0;
    let points = (2.0 * reach / step) as usize;
    let at = |i: usize| (i as f64 + 0.5) * step - 0.5 * points as f64 * step;
    let light = |u: f64, v: f64| -> f64 {
        let from = |[dx, dy]: [f64; 2]| {
            let distance = (u - dx).hypot(v - dy);
            match psf {
                Psf::Gaussian => (-0.5 * (distance / size_px).powi(2)).exp(),
                Psf::Disc => (0.5 + (size_px - distance) / step).clamp(0.0, 1.0),
            }
        };
        grid(n).map(from).sum()
    };
    let places = (0..points * points).map(|i| [at(i % points), at(i / points)]);
    let spread = places.map(|[u, v]| ([u, v], light(u, v)));
    spread.filter(|(_, weight)| *weight > 0.0).collect()
}

/// Light on a pixel out of focus: the sharp picture, edges softened over `soft_px`, summed with the spread.
fn out_of_focus(
    scene: &Scene,
    spread: &[([f64; 2], f64)],
    x: usize,
    y: usize,
    soft_px: f64,
) -> f64 {
    let total: f64 = spread.iter().map(|(_, weight)| weight).sum();
    let light = |([u, v], weight): &([f64; 2], f64)| {
        weight * light_at(scene, &Point2::new(x as f64 + u, y as f64 + v), soft_px)
    };
    spread.iter().map(light).sum::<f64>() / total
}

/// Points of the aperture in circles, with their weights: a unit disc, or a normal with unit variance.
fn aperture(psf: Psf, circles: usize) -> Vec<([f64; 2], f64)> {
    let mut points = Vec::new();
    for circle in 0..circles {
        let share = (circle as f64 + 0.5) / circles as f64;
        let (radius, weight) = match psf {
            Psf::Disc => (share, share),
            Psf::Gaussian => (5.0 * share, share * (-12.5 * share * share).exp()),
        };
        let count = 6 * circle + 6;
        for i in 0..count {
            let turn = (i as f64 + 0.37 * circle as f64) / count as f64;
            let (sin, cos) = (turn * std::f64::consts::TAU).sin_cos();
            points.push(([radius * cos, radius * sin], weight / count as f64));
        }
    }
    let total: f64 = points.iter().map(|(_, weight)| weight).sum();
    points.iter_mut().for_each(|(_, weight)| *weight /= total);
    points
}

/// Light on a pixel through a thin lens: rays through points of the pixel and of the aperture. A ray meets the board where
/// its image is shifted by the blur at that depth.
fn through_lens(
    scene: &Scene,
    lens: &ThinLens,
    x: usize,
    y: usize,
    n: usize,
    circles: usize,
) -> f64 {
    let psf = scene.defocus.psf();
    let size_over_radius = if psf == Psf::Gaussian { 0.5 } else { 1.0 };
    let aperture = aperture(psf, circles);
    let mut sum = 0.0;
    for [dx, dy] in grid(n) {
        let on_sensor = Point2::new(x as f64 + dx, y as f64 + dy);
        let (first_depth, _) = on_board(scene, &on_sensor);
        for (a, weight) in &aperture {
            let mut image = on_sensor;
            let mut depth = first_depth;
            // blur changes by about a hundredth of a pixel per pixel: three steps leave 1e-6 px
            for _ in 0..3 {
                let size = size_over_radius * lens.radius_px(depth);
                image = Point2::new(on_sensor.x + size * a[0], on_sensor.y + size * a[1]);
                depth = on_board(scene, &image).0;
            }
            sum += weight * light_at(scene, &image, 0.1);
        }
    }
    sum / (n * n) as f64
}

/// Pixels on and beside outlines of rings and paper, in all parts of the frame.
const PIXELS: [[usize; 2]; 8] = [
    [57, 65],
    [59, 98],
    [96, 56],
    [100, 27],
    [94, 23],
    [21, 76],
    [64, 38],
    [95, 87],
];

/// Largest difference between the renderer and a slow path over some pixels, as a share of the contrast.
fn worst(scene: &Scene, slow: impl Fn(usize, usize) -> f64 + Sync) -> f64 {
    let plane = irradiance(scene).unwrap();
    let contrast = scene.light.paper - scene.light.ring;
    let error = |[x, y]: &[usize; 2]| (f64::from(plane.at(*x, *y)) - slow(*x, *y)).abs() / contrast;
    PIXELS.par_iter().map(error).reduce(|| 0.0, f64::max)
}

#[test]
fn in_focus_a_pixel_is_the_mean_of_its_rays() {
    let scene = scene(Defocus::None);
    let error = worst(&scene, |x, y| in_focus(&scene, x, y, 256));
    assert!(error < 2e-5, "{error:.1e}");
}

#[test]
fn uniform_blur_is_the_sharp_picture_summed_with_the_point_spread() {
    for (psf, size_px, n) in [
        (Psf::Gaussian, 0.3, 40),
        (Psf::Gaussian, 1.0, 28),
        (Psf::Gaussian, 3.0, 12),
        (Psf::Disc, 0.6, 60),
        (Psf::Disc, 2.0, 36),
        (Psf::Disc, 7.0, 16),
    ] {
        let scene = scene(Defocus::Uniform { psf, size_px });
        let spread = spread(psf, size_px, n);
        let error = worst(&scene, |x, y| {
            out_of_focus(&scene, &spread, x, y, 1.5 / n as f64)
        });
        assert!(error < 1e-4, "{psf:?} {size_px}: {error:.1e}");
    }
}

/// A lens that blurs the scene's board by radii of about 5 px (near edge) to 2 px, focused behind it.
const LENS: ThinLens = ThinLens {
    f_number: 2.0,
    focal_length_m: 0.0085,
    pixel_m: 2.5e-5,
    focus_m: 0.5,
};

#[test]
fn a_thin_lens_sees_the_board_from_all_points_of_its_aperture() {
    for psf in [Psf::Gaussian, Psf::Disc] {
        let scene = scene(Defocus::ThinLens { psf, lens: LENS });
        let error = worst(&scene, |x, y| through_lens(&scene, &LENS, x, y, 6, 40));
        assert!(error < 3e-4, "{psf:?}: {error:.1e}");
    }
}

#[test]
fn a_board_may_reach_through_the_plane_in_focus() {
    let lens = ThinLens {
        focus_m: 0.15,
        ..LENS
    };
    let scene = scene(Defocus::ThinLens {
        psf: Psf::Disc,
        lens,
    });
    let error = worst(&scene, |x, y| through_lens(&scene, &lens, x, y, 20, 12));
    assert!(error < 3e-4, "{error:.1e}");
}
