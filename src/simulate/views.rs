//! Poses for a calibration: tilted every way, near and far, all over the frame, every ring inside it.

use super::outline::sheet_corners_m;
use super::scene::Light;
use crate::board::Board;
use crate::camera::{Camera, LensModel, Pose};
use nalgebra::{Point2, Rotation3, Vector2, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::f64::consts::{PI, TAU};

/// Space kept between the rings and the border of the frame, of its shorter side.
const MARGIN: f64 = 0.03;
/// Share of the frame that the rings fill along the side they fill first.
const FILL: std::ops::Range<f64> = 0.62..0.94;
/// Rotation about the optical axis goes up to this angle either way, rad.
const MAX_ROLL_RAD: f64 = 0.25;
/// Places tried for one view, each nearer to the middle of the frame and further away.
const ATTEMPTS: i32 = 60;
/// The golden angle: successive multiples spread evenly round the circle, rad.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// Why no views could be placed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ViewsError {
    /// Steeper than a board can be read.
    #[error("the largest tilt must be 0 to 80 degrees, not {degrees}")]
    Tilt {
        /// The tilt asked for, degrees.
        degrees: f64,
    },
    /// No place was found where this camera sees all rings.
    #[error("no place found for view {view} where the camera sees the whole board")]
    NoPlace {
        /// The number of the view.
        view: usize,
    },
}

/// `count` poses in which the camera sees the whole board, tilted by up to `max_tilt_rad` against the optical axis (before a fisheye,
/// against the ray to the board); the same
/// seed gives the same poses. Columns run roughly along image +x.
///
/// # Errors
/// [`ViewsError`] where the tilt is out of range or the lens cannot see the board.
pub fn views(
    camera: &Camera,
    board: &Board,
    count: usize,
    max_tilt_rad: f64,
    seed: u64,
) -> Result<Vec<Pose>, ViewsError> {
    if !(0.0..=80_f64.to_radians()).contains(&max_tilt_rad) {
        return Err(ViewsError::Tilt {
            degrees: max_tilt_rad.to_degrees(),
        });
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let first_direction = random.random_range(0.0..TAU);
    let outline = Outline::of(board);
    let place = |view: usize| {
        let direction = first_direction + GOLDEN_ANGLE * view as f64;
        // every third of the range of tilts in turn
        let third = (view % 3) as f64;
        let tilt = max_tilt_rad * (1.0 - (third + random.random_range(0.0..1.0)) / 3.6);
        let roll = random.random_range(-MAX_ROLL_RAD..MAX_ROLL_RAD);
        let wish = Wish {
            rotation: Rotation3::new(Vector3::z() * roll)
                * Rotation3::new(Vector3::new(direction.cos(), direction.sin(), 0.0) * tilt),
            fill: random.random_range(FILL),
            offset: Vector2::new(
                random.random_range(-1.0..1.0),
                random.random_range(-1.0..1.0),
            ),
        };
        wish.place(camera, board, &outline)
            .ok_or(ViewsError::NoPlace { view })
    };
    (0..count).map(place).collect()
}

/// What one view should be like.
struct Wish {
    rotation: Rotation3<f64>,
    /// Share of the frame the rings fill.
    fill: f64,
    /// Where in the free space the board stands, -1 to 1 in x and y.
    offset: Vector2<f64>,
}

impl Wish {
    /// The pose nearest to the wish at which all rings are inside the frame.
    fn place(&self, camera: &Camera, board: &Board, outline: &Outline) -> Option<Pose> {
        let frame = Vector2::new(f64::from(camera.width), f64::from(camera.height));
        let inside = frame.add_scalar(-2.0 * MARGIN * frame.min());
        let middle = Point2::from(0.5 * frame.add_scalar(-1.0));
        let mut fill = self.fill;
        for attempt in 0..ATTEMPTS {
            let depth_m = self.depth_m(camera, board, outline, inside * fill)?;
            // the first attempts move the board to the middle, the later ones also away
            let pull = (1.0 - 0.1 * f64::from(attempt)).max(0.0);
            let free = 0.5 * (frame - self.extent_px(camera, board, outline, depth_m)?);
            let target = middle + self.offset.component_mul(&free) * pull;
            if let Some(pose) = self.towards(camera, board, &target, depth_m)
                && outline.rings_fit(camera, &pose)
                && outline.sheet_has_image(camera, &pose)
            {
                return Some(pose);
            }
            if pull < 0.5 {
                fill *= 0.95;
            }
        }
        None
    }

    /// The pose at which the middle of the board is seen at a pixel. Before a fisheye the board is turned towards the camera first:
    /// far from the axis one that is frontal to the axis is seen edge on.
    fn towards(
        &self,
        camera: &Camera,
        board: &Board,
        target: &Point2<f64>,
        depth_m: f64,
    ) -> Option<Pose> {
        if camera.model() != LensModel::Equidistant {
            let ray = camera.unproject(target)?;
            return Some(self.with_middle_at(board, Vector3::new(ray.x, ray.y, 1.0) * depth_m));
        }
        let ray = camera.ray(target)?;
        let turned = Self {
            rotation: Rotation3::rotation_between(&Vector3::z(), &ray)? * self.rotation,
            ..*self
        };
        Some(turned.with_middle_at(board, ray * depth_m))
    }

    /// The pose at which the middle of the board is there.
    fn with_middle_at(&self, board: &Board, to_middle_m: Vector3<f64>) -> Pose {
        let [x, y] = board.middle_m();
        Pose {
            rotation: self.rotation,
            translation_m: to_middle_m - self.rotation * Vector3::new(x, y, 0.0),
        }
    }

    /// Width and height of the rings in the picture with the board on the optical axis, px, without distortion.
    fn extent_px(
        &self,
        camera: &Camera,
        board: &Board,
        outline: &Outline,
        depth_m: f64,
    ) -> Option<Vector2<f64>> {
        let pose = self.with_middle_at(board, Vector3::z() * depth_m);
        let mut low = Vector2::repeat(f64::INFINITY);
        let mut high = -low;
        for point_m in &outline.rings_m {
            let point = pose.board_to_camera(*point_m);
            if point.z <= 0.1 * depth_m {
                return None;
            }
            let k = &camera.intrinsics;
            let pixel = Vector2::new(k.fx * point.x, k.fy * point.y) / point.z;
            low = low.inf(&pixel);
            high = high.sup(&pixel);
        }
        Some(high - low)
    }

    /// Depth at which the rings just fit into a rectangle of this size, by bisection, m.
    fn depth_m(
        &self,
        camera: &Camera,
        board: &Board,
        outline: &Outline,
        size_px: Vector2<f64>,
    ) -> Option<f64> {
        let fits = |depth_m| {
            let extent = self.extent_px(camera, board, outline, depth_m);
            extent.is_some_and(|e| e.x <= size_px.x && e.y <= size_px.y)
        };
        let mut near = 0.0;
        let mut far = outline
            .rings_m
            .iter()
            .flatten()
            .fold(board.outer_radius_m(), |most, v| most.max(v.abs()));
        let mut doublings = 0;
        while !fits(far) {
            doublings += 1;
            if doublings > 60 {
                return None;
            }
            near = far;
            far *= 2.0;
        }
        for _ in 0..40 {
            let middle = 0.5 * (near + far);
            if fits(middle) {
                far = middle;
            } else {
                near = middle;
            }
        }
        Some(far)
    }
}

/// What of a board has to have an image, by points, m.
struct Outline {
    /// On the outer circles of the rings at the edge of the board.
    rings_m: Vec<[f64; 2]>,
    /// Along the edge of the sheet, with the usual margin.
    sheet_m: Vec<[f64; 2]>,
}

/// Points on each side of the sheet: where it crosses the fold of a lens it does so over more than the gap between two.
const SIDE_POINTS: usize = 64;

impl Outline {
    fn of(board: &Board) -> Self {
        let radius_m = board.outer_radius_m();
        let at_edge = |(row, column): &(u16, u16)| {
            *row == 0 || *column == 0 || *row + 1 == board.rows() || *column + 1 == board.columns()
        };
        let around = |(row, column)| {
            let [x, y] = board.centre_m(row, column);
            (0..16).map(move |i| {
                let (sin, cos) = (f64::from(i) * PI / 8.0).sin_cos();
                [x + radius_m * cos, y + radius_m * sin]
            })
        };
        let corners = sheet_corners_m(board, Light::default().margin);
        let side = |side: usize| {
            let (a, b) = (corners[side], corners[(side + 1) % 4]);
            (0..SIDE_POINTS).map(move |i| {
                let t = i as f64 / SIDE_POINTS as f64;
                [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
            })
        };
        Self {
            rings_m: board.indices().filter(at_edge).flat_map(around).collect(),
            sheet_m: (0..4).flat_map(side).collect(),
        }
    }

    /// Whether the camera sees all rings, with a margin, where its lens model is one-to-one.
    fn rings_fit(&self, camera: &Camera, pose: &Pose) -> bool {
        let (width, height) = (f64::from(camera.width), f64::from(camera.height));
        let margin = MARGIN * width.min(height);
        self.rings_m.iter().all(|point_m| {
            one_to_one(camera, pose, *point_m).is_some_and(|pixel| {
                pixel.x >= margin
                    && pixel.y >= margin
                    && pixel.x <= width - 1.0 - margin
                    && pixel.y <= height - 1.0 - margin
            })
        })
    }

    /// Whether the whole sheet can be drawn, inside the frame or not: before a lens that folds over in it it cannot.
    fn sheet_has_image(&self, camera: &Camera, pose: &Pose) -> bool {
        let axes = pose.rotation.matrix().fixed_columns::<2>(0).into_owned();
        self.sheet_m.iter().all(|point_m| {
            let seen = camera.project_with_derivatives(&pose.board_to_camera(*point_m));
            seen.is_some_and(|seen| (seen.wrt_point * axes).determinant() > 0.0)
        })
    }
}

/// The image of a place on the board; `None` where it has none, or where the lens model has folded over.
fn one_to_one(camera: &Camera, pose: &Pose, point_m: [f64; 2]) -> Option<Point2<f64>> {
    let point = pose.board_to_camera(point_m);
    if point.z <= 0.0 {
        return None;
    }
    let jacobian = camera
        .distortion
        .jacobian(&Point2::new(point.x / point.z, point.y / point.z));
    let kept = jacobian.determinant() > 0.0 && jacobian.trace() > 0.0;
    camera.project(&point).filter(|_| kept)
}
