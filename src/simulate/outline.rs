//! The outlines of rings and paper in the picture, cut into pieces fine enough for the blur along them.

use super::defocus::Psf;
use super::scene::{MAX_SIZE_PX, Scene, SceneError};
use crate::board::Board;
use nalgebra::{Point2, Vector2, Vector3};

/// A smaller blur is rendered as none, px: it moves no edge and changes the grey of a pixel whose border lies on the
/// edge by at most 0.004 of the contrast.
pub const SHARP_SIZE_PX: f64 = 0.01;

/// Nodes and weights of the Gauss-Legendre rule of four points on (-1, 1).
pub(super) const GAUSS_LEGENDRE: [(f64, f64); 4] = [
    (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
];

/// A piece of a blurred outline, drawn together into one place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    /// Where it is, px.
    pub(super) place: Point2<f64>,
    /// Height of the piece, signed: positive where the inside lies to its left, px.
    pub(super) rise: f64,
    /// Size of the blur, px.
    pub(super) size: f64,
    /// Growth of the blur along the piece, in the same direction as `rise`, px.
    pub(super) growth: f64,
}

/// A straight piece of a sharp outline, far shorter than a pixel; the inside lies to the left of a piece that goes
/// down the picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment {
    /// Where it begins, px.
    pub(super) from: Point2<f64>,
    /// Where it ends, px.
    pub(super) to: Point2<f64>,
}

/// Outlines of pieces of one brightness.
#[derive(Debug, Default)]
pub(super) struct Outline {
    /// Parts in focus.
    pub(super) segments: Vec<Segment>,
    /// Parts out of focus.
    pub(super) nodes: Vec<Node>,
    /// The shape of the blur.
    pub(super) psf: Psf,
}

/// Outlines of all rings of the scene.
pub(super) fn rings(scene: &Scene) -> Result<Outline, SceneError> {
    let board = &scene.board;
    let mut tracer = Tracer::new(scene)?;
    for (row, column) in board.indices() {
        let centre_m = board.centre_m(row, column);
        let inner = (!board.is_mark(row, column)).then_some((board.inner_radius_m(), -1.0));
        let circles = std::iter::once((board.outer_radius_m(), 1.0)).chain(inner);
        for (radius_m, inside) in circles {
            tracer.closed(8, |part, t| {
                let (sin, cos) = (std::f64::consts::FRAC_PI_4 * (part as f64 + t)).sin_cos();
                let speed = inside * radius_m * std::f64::consts::FRAC_PI_4;
                // an inner circle runs the other way round, its inside is no ring
                OnBoard {
                    point_m: [
                        centre_m[0] + radius_m * cos,
                        centre_m[1] + inside * radius_m * sin,
                    ],
                    step_m: Vector2::new(
                        -radius_m * std::f64::consts::FRAC_PI_4 * sin,
                        speed * cos,
                    ),
                }
            })?;
        }
    }
    Ok(tracer.outline)
}

/// Outline of the paper; `None` where it fills the frame.
pub(super) fn paper(scene: &Scene) -> Result<Option<Outline>, SceneError> {
    let board = &scene.board;
    if scene.light.margin.is_infinite() {
        return Ok(None);
    }
    let corners = sheet_corners_m(board, scene.light.margin);
    let mut tracer = Tracer::new(scene)?;
    tracer.closed(4, |side, t| {
        let (a, b) = (corners[side], corners[(side + 1) % 4]);
        let step_m = Vector2::new(b[0] - a[0], b[1] - a[1]);
        OnBoard {
            point_m: [a[0] + t * step_m.x, a[1] + t * step_m.y],
            step_m,
        }
    })?;
    Ok(Some(tracer.outline))
}

/// Corners of a sheet whose paper reaches so many outer radii beyond the outermost rings, in order round it, m.
pub(super) fn sheet_corners_m(board: &Board, margin: f64) -> [[f64; 2]; 4] {
    let beyond = (1.0 + margin) * board.outer_radius_m();
    let last = board.centre_m(board.rows() - 1, board.columns() - 1);
    let (left, right, top, bottom) = (-beyond, last[0] + beyond, -beyond, last[1] + beyond);
    [[left, top], [right, top], [right, bottom], [left, bottom]]
}

/// A place on a curve on the board.
struct OnBoard {
    /// The place, m.
    point_m: [f64; 2],
    /// Its derivative with the parameter of the curve, m.
    step_m: Vector2<f64>,
}

/// A place on a curve in the picture.
struct InPicture {
    place: Point2<f64>,
    /// Derivative of `place` with the parameter of the curve, px.
    step: Vector2<f64>,
    size: f64,
    /// Derivative of `size` with the parameter of the curve, px.
    growth: f64,
}

/// Follows curves on the board through the camera.
struct Tracer<'a> {
    scene: &'a Scene,
    outline: Outline,
}

/// An outline longer than this many frames is refused, because it would take memory without end.
const MAX_FRAMES: f64 = 100.0;

/// Halvings of one part of a curve: enough for pieces of 1e-7 of it.
const MAX_HALVINGS: u32 = 24;

impl<'a> Tracer<'a> {
    fn new(scene: &'a Scene) -> Result<Self, SceneError> {
        let normal = scene.pose.rotation * Vector3::z();
        if normal.dot(&scene.pose.translation_m) <= 0.0 {
            return Err(SceneError::FromBehind);
        }
        let outline = Outline {
            psf: scene.defocus.psf(),
            ..Outline::default()
        };
        Ok(Self { scene, outline })
    }

    /// Follows a closed curve of some smooth parts, each with a parameter from 0 to 1.
    fn closed(
        &mut self,
        parts: usize,
        curve: impl Fn(usize, f64) -> OnBoard,
    ) -> Result<(), SceneError> {
        let mut length_px = 0.0;
        for part in 0..parts {
            length_px += self.picture(&curve(part, 0.5))?.step.norm();
        }
        let frame = f64::from(self.scene.camera.width) + f64::from(self.scene.camera.height);
        if length_px > MAX_FRAMES * frame {
            return Err(SceneError::TooNear { length_px });
        }
        (0..parts).try_for_each(|part| self.piece(&|t| curve(part, t), 0.0, 1.0, MAX_HALVINGS))
    }

    /// Adds the piece of a curve between two parameters, halving it while it is too long for its blur.
    fn piece(
        &mut self,
        curve: &impl Fn(f64) -> OnBoard,
        start: f64,
        end: f64,
        halvings: u32,
    ) -> Result<(), SceneError> {
        let half = 0.5 * (end - start);
        let middle = start + half;
        let at_middle = self.picture(&curve(middle))?;
        let longest = longest_piece(self.outline.psf, at_middle.size);
        if at_middle.step.norm() * 2.0 * half > longest && halvings > 0 {
            self.piece(curve, start, middle, halvings - 1)?;
            return self.piece(curve, middle, end, halvings - 1);
        }
        if at_middle.size < SHARP_SIZE_PX {
            let from = self.picture(&curve(start))?.place;
            let to = self.picture(&curve(end))?.place;
            // the triangle that has the area of the arc: a parabola's is two thirds of its height, a triangle's half
            let chord = nalgebra::center(&from, &to);
            let apex = chord + (at_middle.place - chord) * (4.0 / 3.0);
            self.outline.segments.push(Segment { from, to: apex });
            self.outline.segments.push(Segment { from: apex, to });
            return Ok(());
        }
        for (node, weight) in GAUSS_LEGENDRE {
            let at = self.picture(&curve(middle + half * node))?;
            self.outline.nodes.push(Node {
                place: at.place,
                rise: weight * half * at.step.y,
                size: at.size,
                growth: weight * half * at.growth,
            });
        }
        Ok(())
    }

    /// Where a place on the board is in the picture, and how blurred.
    fn picture(&self, at: &OnBoard) -> Result<InPicture, SceneError> {
        let [x_m, y_m] = at.point_m;
        let rotation = self.scene.pose.rotation;
        let point = self.scene.pose.board_to_camera(at.point_m);
        let step = rotation * Vector3::new(at.step_m.x, at.step_m.y, 0.0);
        let seen = self.scene.camera.project_with_derivatives(&point);
        let seen = seen.ok_or(SceneError::BehindCamera { x_m, y_m })?;
        // the board is seen from its front, so that only a lens that folds turns its axes round
        let axes = seen.wrt_point * rotation.matrix().fixed_columns::<2>(0);
        if axes.determinant() <= 0.0 {
            return Err(SceneError::Folded { x_m, y_m });
        }
        let (size, slope) = self.scene.defocus.size_px(point.z);
        if size > MAX_SIZE_PX {
            let depth_m = point.z;
            return Err(SceneError::Blur {
                depth_m,
                size_px: size,
            });
        }
        Ok(InPicture {
            place: seen.pixel,
            step: seen.wrt_point * step,
            size,
            growth: slope * step.z,
        })
    }
}

/// Longest piece that four nodes (or two straight lines) follow well enough, px.
fn longest_piece(psf: Psf, size: f64) -> f64 {
    match psf {
        // two straight lines over an arc of 0.2 px
        _ if size < SHARP_SIZE_PX => 0.2,
        // four nodes in two sigmas leave 1e-6 of a Gaussian
        Psf::Gaussian => 2.0 * size,
        // the rim of a disc is a step, softened only by the pixels: the smaller the disc, the more each piece weighs
        Psf::Disc => (0.06 * size).clamp(0.2, 1.0).min(0.25 * size),
    }
}
