//! What blur that changes across a ring does to its centre.
//!
//! A tilted board is further out of focus on one side, every ring a little. The photometric fit has one blur for a ring, and makes
//! up for the rest by moving it: by about sigma times the change of sigma per pixel, which all rings of a view share, so that
//! no residual shows it. The fits of a view tell the change: in the picture of a plane, the blur of a thin lens is linear.
//!
//! A lens sees the board from each point a of its aperture (a disc or a normal distribution of size 1) with the point x of the picture at x - s(x) a. To
//! first order the change g of s adds to the picture
//! `dI(p) = mean over a of (g . (x - c)) (a . grad S(x))`, x = p + s a, S the sharp ring. As S has gradients on its outlines only, this is
//! an integral along them. Fitted with what a fit may do about it, dI tells the move of the centre.

use crate::centre::photometric::{Blur, Psf, RingModel};
use crate::session::View;
use nalgebra::{Matrix3, Point2, SMatrix, SVector, Vector2, Vector3};

/// Fewer rings do not tell how the blur changes.
const LEAST_RINGS: usize = 9;
/// A smaller blur, as a part of the outer radius, is not worth a correction.
const LEAST_SIGMA: f64 = 0.04;
/// Nodes of an outline.
const NODES: usize = 128;
/// Points across the window, at most.
const ACROSS: usize = 44;
/// The unknowns of a fit that an odd change of the picture can move: the centre and the shading.
const ODD: usize = 4;

/// Change of the blur's size over the picture of a view, px per px; `None` where it is not known.
pub(super) fn gradient(view: &View) -> Option<Vector2<f64>> {
    let fits = view.rings.iter().filter_map(|ring| ring.kept.as_deref());
    let blurs: Vec<(Point2<f64>, f64)> = fits
        .map(|kept| {
            let model = &kept.fitted.model;
            (model.shape.centre, model.blur.size_px)
        })
        .collect();
    if blurs.len() < LEAST_RINGS {
        return None;
    }
    let mut used = blurs.clone();
    let mut plane = plane_through(&used)?;
    // once more without those that are far off: rings at the sheet's edge, or half covered
    let off = |(place, size): &(Point2<f64>, f64), plane: &Vector3<f64>| {
        (size - plane.dot(&place.to_homogeneous())).abs()
    };
    let mut offs: Vec<f64> = blurs.iter().map(|blur| off(blur, &plane)).collect();
    offs.sort_by(f64::total_cmp);
    let most = 4.0 * offs[offs.len() / 2];
    used.retain(|blur| off(blur, &plane) <= most);
    plane = plane_through(&used)?;
    Some(plane.xy())
}

/// The linear function of the place through these values.
fn plane_through(values: &[(Point2<f64>, f64)]) -> Option<Vector3<f64>> {
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for (place, value) in values {
        let row = place.to_homogeneous();
        normal += row * row.transpose();
        right += row * *value;
    }
    normal.lu().solve(&right)
}

/// How far a fit with one blur moves the centre of this ring where its blur changes by `gradient`, px.
pub(super) fn displacement(
    model: &RingModel,
    ratio: f64,
    gradient: Vector2<f64>,
) -> Option<Vector2<f64>> {
    let outer = model.shape.ellipse(1.0)?;
    if model.blur.sigma_px() < LEAST_SIGMA * outer.minor {
        return None;
    }
    let outlines = outlines(model, ratio)?;
    let reach = outer.major + 2.0 * model.blur.sigma_px();
    let step = 2.0 * reach / ACROSS as f64;
    let mut normal = SMatrix::<f64, ODD, ODD>::zeros();
    let mut right = SVector::<f64, ODD>::zeros();
    for i in 0..ACROSS * ACROSS {
        let at = |k: usize| (k as f64 + 0.5) * step - reach;
        let from_centre = Vector2::new(at(i % ACROSS), at(i / ACROSS));
        let place = model.shape.centre + from_centre;
        let seen = seen(&outlines, &model.blur, model.shape.centre, gradient, place);
        let shaded = from_centre * ((model.paper + seen.light) / reach);
        let row = SVector::<f64, ODD>::new(seen.moved.x, seen.moved.y, shaded.x, shaded.y);
        normal += row * row.transpose();
        right += row * seen.uneven;
    }
    let moved = normal.cholesky()?.solve(&right);
    let moved = Vector2::new(moved[0], moved[1]);
    moved.iter().all(|v| v.is_finite()).then_some(moved)
}

/// A short piece of an outline.
struct Node {
    place: Point2<f64>,
    /// Outward normal times length times the step of light from inside to outside.
    step: Vector2<f64>,
}

fn outlines(model: &RingModel, ratio: f64) -> Option<Vec<Node>> {
    let mut nodes = Vec::with_capacity(2 * NODES);
    for (radius, jump) in [
        (1.0, model.paper - model.ring),
        (ratio, model.ring - model.inside),
    ] {
        let ellipse = model.shape.ellipse(radius)?;
        let (along, across) = (
            Vector2::new(ellipse.angle.cos(), ellipse.angle.sin()),
            Vector2::new(-ellipse.angle.sin(), ellipse.angle.cos()),
        );
        let turn = std::f64::consts::TAU / NODES as f64;
        nodes.extend((0..NODES).map(|i| {
            let (sin, cos) = (turn * i as f64).sin_cos();
            Node {
                place: ellipse.centre
                    + along * (ellipse.major * cos)
                    + across * (ellipse.minor * sin),
                step: (along * (ellipse.minor * cos) + across * (ellipse.major * sin))
                    * (turn * jump),
            }
        }));
    }
    Some(nodes)
}

/// The picture at one place, and how it changes.
struct Seen {
    /// Light less that of the paper.
    light: f64,
    /// Its derivative with the centre, px^-1.
    moved: Vector2<f64>,
    /// What the change of blur adds.
    uneven: f64,
}

fn seen(
    outlines: &[Node],
    blur: &Blur,
    centre: Point2<f64>,
    gradient: Vector2<f64>,
    place: Point2<f64>,
) -> Seen {
    let size = blur.size_px;
    let mut seen = Seen {
        light: 0.0,
        moved: Vector2::zeros(),
        uneven: 0.0,
    };
    for node in outlines {
        let a = (node.place - place) / size;
        let square = a.norm_squared();
        let density = density(blur.psf, square) / (size * size);
        seen.moved -= node.step * density;
        seen.uneven += density * gradient.dot(&(node.place - centre)) * a.dot(&node.step);
        // the outline's flux through the blur's own potential: the share of the blur inside the outline
        seen.light -= a.dot(&node.step) * potential(blur.psf, square) / size;
    }
    seen
}

/// Density of a blur of size 1 at this squared distance.
fn density(psf: Psf, square: f64) -> f64 {
    match psf {
        Psf::Disc if square < 1.0 => std::f64::consts::FRAC_1_PI,
        Psf::Disc => 0.0,
        Psf::Gaussian => (-0.5 * square).exp() / std::f64::consts::TAU,
    }
}

/// The share of a blur of size 1 within this squared distance, over 2 pi times it: a field whose divergence is the density.
fn potential(psf: Psf, square: f64) -> f64 {
    let within = match psf {
        Psf::Disc => square.min(1.0),
        Psf::Gaussian => 1.0 - (-0.5 * square).exp(),
    };
    within / (std::f64::consts::TAU * square.max(1e-12))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::{Board, Polarity};
    use crate::calibrate::synthetic::{ordinary, pose_at};
    use crate::detect::{DetectOptions, Detector};
    use crate::simulate::{BitDepth, Defocus, Psf as Shape, Scene, ThinLens, render};

    /// A board that is tilted by 40 degrees before a lens out of focus, without noise, its camera known.
    fn tilted(shape: Shape) -> (View, Vector2<f64>) {
        let board = Board::new(5, 5, 0.0269, 0.004, 0.008, Polarity::DarkOnLight).unwrap();
        let camera = ordinary();
        let middle = [640.0, 480.0];
        let mut scene = Scene::new(
            camera,
            board.clone(),
            pose_at(&camera, &board, middle, 0.7, [0.0, 0.7, 0.1]),
        );
        let lens = ThinLens {
            f_number: 1.0,
            focal_length_m: 0.012,
            pixel_m: 1e-5,
            focus_m: 0.6,
        };
        // as far out of focus as makes discs of 9 px
        let depth_m = scene.pose.board_to_camera(board.middle_m()).z;
        let f_number = lens.radius_px(depth_m).abs() / 9.0;
        scene.defocus = Defocus::ThinLens {
            psf: shape,
            lens: ThinLens { f_number, ..lens },
        };
        scene.light.margin = f64::INFINITY;
        scene.sensor.depth = BitDepth::Sixteen;
        let rendering = render(&scene, 0).unwrap();
        let options = DetectOptions {
            camera: Some(camera),
            ..DetectOptions::default()
        };
        let detection = Detector::new(board, options)
            .detect(&rendering.frame)
            .unwrap();
        let errors = detection.rings.iter().map(|ring| {
            let truth = rendering
                .truth
                .rings
                .iter()
                .map(|t| ring.centre.point - t.centre);
            truth.min_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap()
        });
        let mean = errors.sum::<Vector2<f64>>() / detection.rings.len() as f64;
        (View::of_file("tilted", &detection), mean)
    }

    #[test]
    fn the_displacement_is_what_a_fit_with_one_blur_shows() {
        for shape in [Shape::Disc, Shape::Gaussian] {
            let (view, error) = tilted(shape);
            let gradient = gradient(&view).unwrap();
            let moved = view.rings.iter().map(|ring| {
                let model = &ring.kept.as_ref().unwrap().fitted.model;
                displacement(model, 0.5, gradient).unwrap()
            });
            let moved = moved.sum::<Vector2<f64>>() / view.rings.len() as f64;
            println!("{shape:?}: error {error:?}, predicted {moved:?}, gradient {gradient:?}");
            assert!(
                error.norm() > 0.004,
                "{shape:?}: nothing to explain: {error}"
            );
            assert!(
                (error - moved).norm() < 0.25 * error.norm(),
                "{shape:?}: {error} {moved}"
            );
        }
    }
}
