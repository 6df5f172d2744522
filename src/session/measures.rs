//! Where a view shows the board, in the four measures that users of ROS's camera_calibration know as the bars X, Y, Size and Skew.
//!
//! They are computed as its `calibrator.py` does (`get_parameters`, `_get_skew`, `compute_goodenough`), with the centres of the outermost
//! rings in place of the chessboard's outermost corners. They say whether views differ enough, not whether they tell the
//! camera: that is the estimate's to say.

use super::View;
use crate::board::Board;
use crate::camera::homography::apply;
use nalgebra::{Point2, Vector2};

/// What camera_calibration asks for: the range of x, that of y, the largest size, the strongest skew.
const WANTED: [f64; 4] = [0.7, 0.7, 0.4, 0.5];

/// Where and how a view shows the board.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measures {
    /// Middle of the rings across the frame: 0 where the board touches the left border, 1 where it touches the right one, as if
    /// it were a square of its area.
    pub x: f64,
    /// The same down the frame.
    pub y: f64,
    /// Square root of the board's area over that of the frame.
    pub size: f64,
    /// By how much the upper right corner differs from a right angle: twice the difference in radians, 1 at most.
    pub skew: f64,
}

/// How far the ranges of the views reach towards those that are wanted, each 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Progress {
    /// Range of [`Measures::x`] over 0.7.
    pub x: f64,
    /// Range of [`Measures::y`] over 0.7.
    pub y: f64,
    /// Largest [`Measures::size`] over 0.4. A small board is no merit.
    pub size: f64,
    /// Largest [`Measures::skew`] over 0.5. Neither is a board without skew.
    pub skew: f64,
}

impl Measures {
    /// Of a view of this board; of the part that it shows.
    pub fn of(board: &Board, view: &View) -> Self {
        let (width, height) = (view.width as f64, view.height as f64);
        let [up_left, up_right, down_right, down_left] = corners(board, view);
        // half the cross product of the diagonals, of any quadrilateral
        let area = 0.5 * (down_right - up_left).perp(&(down_left - up_right)).abs();
        let side = area.sqrt();
        let count = view.rings.len().max(1) as f64;
        let sum: Vector2<f64> = view.rings.iter().map(|r| r.centre.point.coords).sum();
        let middle = sum / count;
        Self {
            x: along(middle.x, side, width),
            y: along(middle.y, side, height),
            size: (area / (width * height)).sqrt(),
            skew: skew(up_left, up_right, down_right),
        }
    }
}

impl Progress {
    /// Of all views kept; 0 without any.
    pub fn of(views: impl IntoIterator<Item = Measures>) -> Self {
        let mut views = views.into_iter();
        let Some(first) = views.next() else {
            return Self::default();
        };
        let (mut least, mut most) = (first, first);
        for view in views {
            least.x = least.x.min(view.x);
            least.y = least.y.min(view.y);
            most.x = most.x.max(view.x);
            most.y = most.y.max(view.y);
            most.size = most.size.max(view.size);
            most.skew = most.skew.max(view.skew);
        }
        let [x, y, size, skew] = WANTED;
        Self {
            x: ((most.x - least.x) / x).min(1.0),
            y: ((most.y - least.y) / y).min(1.0),
            size: (most.size / size).min(1.0),
            skew: (most.skew / skew).min(1.0),
        }
    }

    /// What to do about the measure that is farthest behind; `None` where all are complete.
    pub fn advice(&self) -> Option<&'static str> {
        let measures = [
            (self.x, "farther to the left and to the right"),
            (self.y, "farther up and down"),
            (self.size, "closer to the camera"),
            (self.skew, "more tilted"),
        ];
        let behind = measures.into_iter().filter(|(done, _)| *done < 1.0);
        behind
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, advice)| advice)
    }
}

/// Images of the outermost rings that the view shows: upper left, upper right, lower right, lower left on the board. Where such a
/// ring was not seen, the place that the view's homography gives it.
fn corners(board: &Board, view: &View) -> [Point2<f64>; 4] {
    let labels = || view.rings.iter().map(|ring| (ring.row, ring.column));
    let rows = (labels().map(|l| l.0).min(), labels().map(|l| l.0).max());
    let columns = (labels().map(|l| l.1).min(), labels().map(|l| l.1).max());
    let (Some(top), Some(bottom)) = rows else {
        return [Point2::origin(); 4];
    };
    let (left, right) = (columns.0.unwrap_or(0), columns.1.unwrap_or(0));
    let image = |row: u16, column: u16| {
        let seen = view
            .rings
            .iter()
            .find(|r| (r.row, r.column) == (row, column));
        seen.map(|ring| ring.centre.point)
            .or_else(|| apply(&view.homography, Point2::from(board.centre_m(row, column))))
            .unwrap_or_else(Point2::origin)
    };
    [
        image(top, left),
        image(top, right),
        image(bottom, right),
        image(bottom, left),
    ]
}

/// The frame is shortened by the board's own size, or a large board could not move at all.
fn along(middle: f64, side: f64, length: f64) -> f64 {
    let room = length - side;
    if room > 0.0 {
        ((middle - 0.5 * side) / room).clamp(0.0, 1.0)
    } else {
        0.5
    }
}

fn skew(a: Point2<f64>, corner: Point2<f64>, b: Point2<f64>) -> f64 {
    let angle = (a - corner).angle(&(b - corner));
    let skew = 2.0 * (std::f64::consts::FRAC_PI_2 - angle).abs();
    // a line or a point has no corner
    if (a - corner).norm() * (b - corner).norm() > 0.0 {
        skew.min(1.0)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::synthetic::{board, detection, ordinary, pose_at};

    fn measures(pixel: [f64; 2], fill: f64, turn: [f64; 3]) -> Measures {
        let camera = ordinary();
        let pose = pose_at(&camera, &board(), pixel, fill, turn);
        let view = View::of_file("view", &detection(&camera, &board(), &pose, &mut || 0.0));
        Measures::of(&board(), &view)
    }

    #[test]
    fn a_board_in_the_middle_measures_as_camera_calibration_says() {
        let m = measures([640.0, 480.0], 0.5, [0.0; 3]);
        assert!(
            (m.x - 0.5).abs() < 0.01 && (m.y - 0.5).abs() < 0.01,
            "{m:?}"
        );
        // a square half as tall as the frame: 480 x 480 of 1280 x 960 px, but for the distortion
        let expected = (480.0_f64 * 480.0 / (1280.0 * 960.0)).sqrt();
        assert!((m.size - expected).abs() < 0.01 && m.skew < 0.01, "{m:?}");
        // turned in its plane it is as large and has no skew
        let turned = measures([640.0, 480.0], 0.5, [0.0, 0.0, 0.5]);
        assert!((turned.size - m.size).abs() < 0.01 && turned.skew < 0.02);
    }

    #[test]
    fn a_board_at_the_border_is_as_far_out_as_it_gets() {
        let m = measures([250.0, 480.0], 0.5, [0.0; 3]);
        assert!(m.x < 0.05 && (m.y - 0.5).abs() < 0.02, "{m:?}");
        assert!(measures([1030.0, 710.0], 0.5, [0.0; 3]).y > 0.95);
        assert!(measures([640.0, 480.0], 0.5, [0.5, 0.5, 0.0]).skew > 0.1);
    }

    #[test]
    fn progress_is_of_ranges_and_never_more_than_one() {
        assert_eq!(Progress::of([]), Progress::default());
        let view = |x, y, size, skew| Measures { x, y, size, skew };
        let one = Progress::of([view(0.3, 0.9, 0.2, 0.1)]);
        assert_eq!((one.x, one.y, one.size, one.skew), (0.0, 0.0, 0.5, 0.2));
        assert_eq!(one.advice(), Some("farther to the left and to the right"));
        let all = Progress::of([view(0.0, 0.1, 0.2, 0.1), view(0.9, 0.45, 0.5, 0.6)]);
        assert_eq!((all.x, all.size, all.skew), (1.0, 1.0, 1.0));
        assert!((all.y - 0.5).abs() < 1e-12);
        assert_eq!(all.advice(), Some("farther up and down"));
    }

    #[test]
    fn a_part_of_the_board_has_measures_too() {
        let camera = ordinary();
        let pose = pose_at(&camera, &board(), [640.0, 480.0], 0.5, [0.3, 0.2, 0.0]);
        let mut view = View::of_file("view", &detection(&camera, &board(), &pose, &mut || 0.0));
        let whole = Measures::of(&board(), &view);
        // without the ring in the corner its place is that of the homography
        view.rings.retain(|ring| (ring.row, ring.column) != (0, 6));
        let part = Measures::of(&board(), &view);
        assert!((part.skew - whole.skew).abs() < 0.05 && (part.size - whole.size).abs() < 0.02);
        view.rings.retain(|ring| ring.row == 0);
        assert_eq!(Measures::of(&board(), &view).size, 0.0);
        view.rings.clear();
        let none = Measures::of(&board(), &view);
        assert!(none.x.is_finite() && none.skew == 0.0);
    }
}
