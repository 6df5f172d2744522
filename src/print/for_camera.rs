//! The board for a camera: as many rings as can be told apart through the blur.
//!
//! A thin lens of focal length f and f-number N, focused at the distance F, has its sensor v = f F / (F - f) behind it. A point
//! at the distance Z appears as a disc of diameter
//!
//! ```text
//! c = (f / N) v |1 / F - 1 / Z|
//! ```
//!
//! on the sensor, and a length w at Z as w v / Z. The standard deviation of a disc along one axis is half its radius, c / 4. Rings are
//! found and measured well while that is at most [`MOST_BLUR`] of the width of the ring where it appears narrowest, so the widths
//! on the board follow. A board is tilted for a calibration: the one proposed keeps to the limit at its near and at its far end too.

use crate::board::{Board, BoardError, Polarity};
use crate::simulate::ThinLens;

/// The heaviest blur that a proposed board is made for: sigma over the narrowest width of a ring as it appears. The detector
/// calls blur too heavy from 0.5 on; on simulated boards it finds all up to 0.7 and misses some from 0.8 on (docs/boards.md).
/// Real lenses are less tidy.
pub const MOST_BLUR: f64 = 0.4;
/// Tilt of the board in the views of a calibration, rad.
const TILT: f64 = 40.0 * std::f64::consts::PI / 180.0;
/// Centre to centre, in outer radii; the inner radius is half the outer.
const PITCH: f64 = 3.0;
/// Rings along the longer and the shorter side: more make a view hardly better.
const MOST_LONG: u16 = 9;
const LEAST_LONG: u16 = 4;
const LEAST_SHORT: u16 = 3;
/// The smallest inner radius that docs/accuracy.md has figures for, px.
const LEAST_INNER_PX: f64 = 7.0;

/// A camera and where the board will be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraSetup {
    /// Focal length of the lens, mm.
    pub focal_length_mm: f64,
    /// Distance between neighbouring pixels, um.
    pub pixel_um: f64,
    /// Focal length over the aperture's diameter.
    pub f_number: f64,
    /// Distance that is in focus, m.
    pub focus_m: f64,
    /// Distance of the board, m.
    pub distance_m: f64,
    /// Width and height of the frame, px.
    pub frame_px: [u32; 2],
    /// Part of the frame's width and height that the rings may cover, 0 to 1.
    pub fill: f64,
    /// How the board will be printed.
    pub polarity: Polarity,
}

/// A board, and how the camera will see it.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// The board.
    pub board: Board,
    /// Diameter of the disc of light of a point at the board's distance, px.
    pub disc_px: f64,
    /// Width of a ring seen from the front, px.
    pub ring_px: f64,
    /// Sigma over a ring's narrowest width where that is worst on the tilted board.
    pub worst_blur: f64,
    /// Largest tilt looked at, rad.
    pub tilt_rad: f64,
    /// Width and height that the rings cover, mm.
    pub extent_mm: [f64; 2],
    /// The same as parts of the frame's width and height.
    pub filled: [f64; 2],
}

/// Why no board will do.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoBoard {
    /// The lens cannot have its focus there.
    #[error(
        "a lens of {focal_length_mm} mm cannot be focused at {focus_m} m: that is not beyond its focal length"
    )]
    Focus {
        /// Focal length, mm.
        focal_length_mm: f64,
        /// Distance in focus, m.
        focus_m: f64,
    },
    /// The board would be inside the lens.
    #[error(
        "{distance_m} m are no distance for a lens of {focal_length_mm} mm: hold the board further away"
    )]
    Distance {
        /// Focal length, mm.
        focal_length_mm: f64,
        /// Distance of the board, m.
        distance_m: f64,
    },
    /// Even the largest rings are drowned.
    #[error(
        "too far out of focus: at {distance_m} m a point is a disc of {disc_px:.0} px, and the rings of even the coarsest board (3 x 4) that \
         fits into {percent:.0} % of the frame are {ring_px:.0} px wide; it takes f/{needed_f_number:.1} or more instead of \
         f/{f_number}, or a distance nearer to the focus"
    )]
    TooBlurred {
        /// Distance of the board, m.
        distance_m: f64,
        /// Diameter of the disc of a point, px.
        disc_px: f64,
        /// Width of the rings of the coarsest board, px.
        ring_px: f64,
        /// Part of the frame that may be covered, %.
        percent: f64,
        /// The f-number given.
        f_number: f64,
        /// The f-number that would do.
        needed_f_number: f64,
    },
    /// The frame has too few pixels for any board.
    #[error(
        "the frame is too small: in {percent:.0} % of {width} x {height} px the inner circles of even the coarsest board (3 x 4) have a radius \
         of {inner_px:.1} px, and {LEAST_INNER_PX} px are needed"
    )]
    FewPixels {
        /// Part of the frame that may be covered, %.
        percent: f64,
        /// Width of the frame, px.
        width: u32,
        /// Height of the frame, px.
        height: u32,
        /// Radius of the inner circles, px.
        inner_px: f64,
    },
    /// The sizes are beyond what can be printed.
    #[error("the board would be beyond all measure: {0}")]
    Board(BoardError),
}

/// The board with the most rings that this camera can use.
///
/// # Errors
/// [`NoBoard`] with what would have to change.
pub fn propose(setup: &CameraSetup) -> Result<Proposal, NoBoard> {
    let view = View::new(setup)?;
    let mut refusal = None;
    for long in (LEAST_LONG..=MOST_LONG).rev() {
        let grid = Grid::new(setup, &view, long);
        match view.refuses(&grid) {
            None => return view.proposal(&grid),
            Some(reason) => refusal = Some(reason),
        }
    }
    // the range is not empty, so that the coarsest board's reason is there
    Err(refusal.unwrap_or(NoBoard::Board(BoardError::Missing { name: "rows" })))
}

/// The camera's thin lens.
struct View<'a> {
    setup: &'a CameraSetup,
    lens: ThinLens,
    /// Distance of the sensor from the lens, px.
    focal_px: f64,
}

/// A number of rings, and how large they can then be.
struct Grid {
    /// Along the frame's width and height.
    counts: [u16; 2],
    outer_m: f64,
}

/// Length of so many rings in a row, in outer radii.
fn extent(count: u16) -> f64 {
    PITCH * f64::from(count - 1) + 2.0
}

impl Grid {
    /// So many rings along the frame's longer side, and fewer along the other one, so that a turned board is told from an upright one.
    fn new(setup: &CameraSetup, view: &View, long: u16) -> Self {
        let usable = setup.frame_px.map(|side| setup.fill * f64::from(side));
        let along = usize::from(usable[1] > usable[0]);
        let (longer, shorter) = (usable[along], usable[1 - along]);
        let outer_px = longer / extent(long);
        let room = (shorter / outer_px - 2.0) / PITCH + 1.0;
        let short = room.clamp(f64::from(LEAST_SHORT), f64::from(long - 1)) as u16;
        let outer_px = outer_px.min(shorter / extent(short));
        let mut counts = [short; 2];
        counts[along] = long;
        Self {
            counts,
            outer_m: rounded_down(outer_px * setup.distance_m / view.focal_px).0,
        }
    }

    fn ring_m(&self) -> f64 {
        0.5 * self.outer_m
    }

    fn extent_m(&self) -> [f64; 2] {
        self.counts.map(|count| extent(count) * self.outer_m)
    }
}

/// The length with three digits, and how many of them are behind the point.
fn rounded_down(length_m: f64) -> (f64, i32) {
    let decimals = 2 - length_m.log10().floor() as i32;
    let unit = 10_f64.powi(decimals);
    ((length_m * unit + 1e-6).floor() / unit, decimals)
}

impl<'a> View<'a> {
    fn new(setup: &'a CameraSetup) -> Result<Self, NoBoard> {
        let focal_m = 1e-3 * setup.focal_length_mm;
        let (focal_length_mm, focus_m, distance_m) =
            (setup.focal_length_mm, setup.focus_m, setup.distance_m);
        if focus_m <= focal_m {
            return Err(NoBoard::Focus {
                focal_length_mm,
                focus_m,
            });
        }
        if distance_m <= focal_m {
            return Err(NoBoard::Distance {
                focal_length_mm,
                distance_m,
            });
        }
        let pixel_m = 1e-6 * setup.pixel_um;
        Ok(Self {
            setup,
            lens: ThinLens {
                f_number: setup.f_number,
                focal_length_m: focal_m,
                pixel_m,
                focus_m,
            },
            focal_px: focal_m / (1.0 - focal_m / focus_m) / pixel_m,
        })
    }

    fn disc_px(&self, depth_m: f64) -> f64 {
        2.0 * self.lens.radius_px(depth_m).abs()
    }

    fn seen_px(&self, length_m: f64) -> f64 {
        length_m * self.focal_px / self.setup.distance_m
    }

    /// Sigma over the narrowest width, where that is worst on a board tilted about either of its sides.
    fn worst_blur(&self, grid: &Grid) -> f64 {
        let [width_m, height_m] = grid.extent_m();
        let reach_m = 0.5 * width_m.max(height_m) * TILT.sin();
        let at = |depth_m: f64| {
            let narrowest_px = grid.ring_m() * self.focal_px / depth_m * TILT.cos();
            0.25 * self.disc_px(depth_m) / narrowest_px
        };
        let near_m = self.setup.distance_m - reach_m;
        if near_m <= self.lens.focal_length_m {
            return f64::INFINITY;
        }
        at(near_m).max(at(self.setup.distance_m + reach_m))
    }

    /// Why these rings will not do.
    fn refuses(&self, grid: &Grid) -> Option<NoBoard> {
        let setup = self.setup;
        let (ring_px, percent) = (self.seen_px(grid.ring_m()), 100.0 * setup.fill);
        let [width, height] = setup.frame_px;
        // the inner radius is the ring's width
        if ring_px < LEAST_INNER_PX {
            return Some(NoBoard::FewPixels {
                percent,
                width,
                height,
                inner_px: ring_px,
            });
        }
        let blur = self.worst_blur(grid);
        if blur.is_infinite() {
            return Some(NoBoard::Distance {
                focal_length_mm: setup.focal_length_mm,
                distance_m: setup.distance_m,
            });
        }
        (blur > MOST_BLUR).then(|| NoBoard::TooBlurred {
            distance_m: setup.distance_m,
            disc_px: self.disc_px(setup.distance_m),
            ring_px,
            percent,
            f_number: setup.f_number,
            // rounded up to what is printed
            needed_f_number: (10.0 * setup.f_number * blur / MOST_BLUR).ceil() / 10.0,
        })
    }

    fn proposal(&self, grid: &Grid) -> Result<Proposal, NoBoard> {
        let setup = self.setup;
        let [columns, rows] = grid.counts;
        // whole numbers of the last digit divided once, so that the lengths are short decimal numbers
        let (_, decimals) = rounded_down(grid.outer_m);
        let unit = 10_f64.powi(decimals);
        let digits = (grid.outer_m * unit).round();
        let pitch_m = PITCH * digits / unit;
        let inner_m = 5.0 * digits / (10.0 * unit);
        let board = Board::new(
            rows,
            columns,
            pitch_m,
            inner_m,
            grid.outer_m,
            setup.polarity,
        )
        .map_err(NoBoard::Board)?;
        let extent_m = grid.extent_m();
        let part = |axis: usize| self.seen_px(extent_m[axis]) / f64::from(setup.frame_px[axis]);
        Ok(Proposal {
            board,
            disc_px: self.disc_px(setup.distance_m),
            ring_px: self.seen_px(grid.ring_m()),
            worst_blur: self.worst_blur(grid),
            tilt_rad: TILT,
            extent_mm: extent_m.map(|side| 1e3 * side),
            filled: [part(0), part(1)],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SETUP: CameraSetup = CameraSetup {
        focal_length_mm: 25.0,
        pixel_um: 2.4,
        f_number: 4.0,
        focus_m: 5.0,
        distance_m: 0.6,
        frame_px: [5496, 3672],
        fill: 0.7,
        polarity: Polarity::DarkOnLight,
    };

    #[test]
    fn the_board_is_as_the_formulas_say() {
        let found = propose(&SETUP).unwrap();
        // c = f / N * v * |1 / F - 1 / Z|, over the pixel
        let v_mm = 25.0 * 5000.0 / 4975.0;
        let disc_um = 1e3 * 25.0 / 4.0 * v_mm * (1.0 / 5000.0 - 1.0 / 600.0_f64).abs();
        assert!((found.disc_px - disc_um / 2.4).abs() < 1e-9);
        let board = &found.board;
        let ring_px =
            1e3 * (board.outer_radius_m() - board.inner_radius_m()) * v_mm / 600.0 / 2.4e-3;
        assert!((found.ring_px - ring_px).abs() < 1e-9);
        assert_eq!((board.rows(), board.columns()), (5, 8));
        assert!(found.worst_blur <= MOST_BLUR && found.filled[0] <= 0.7);
        assert_eq!(board.to_yaml().lines().nth(2), Some("pitch: 0.02874"));
    }

    #[test]
    fn refusals_say_what_would_help() {
        let wide_open = CameraSetup {
            f_number: 0.7,
            ..SETUP
        };
        let Err(NoBoard::TooBlurred {
            needed_f_number, ..
        }) = propose(&wide_open)
        else {
            panic!("no blur");
        };
        let stopped = |f_number| CameraSetup { f_number, ..SETUP };
        assert!(propose(&stopped(needed_f_number)).is_ok());
        assert!(propose(&stopped(needed_f_number - 0.2)).is_err());
        let tiny = CameraSetup {
            frame_px: [64, 48],
            ..SETUP
        };
        assert!(matches!(propose(&tiny), Err(NoBoard::FewPixels { .. })));
        let inside = CameraSetup {
            distance_m: 0.02,
            ..SETUP
        };
        assert!(matches!(propose(&inside), Err(NoBoard::Distance { .. })));
        let unfocused = CameraSetup {
            focus_m: 0.025,
            ..SETUP
        };
        assert!(matches!(propose(&unfocused), Err(NoBoard::Focus { .. })));
    }

    proptest! {
        #[test]
        fn every_proposal_keeps_to_the_limits(
            (focal_length_mm, pixel_um, f_number) in (1.0..300.0_f64, 0.5..20.0_f64, 0.7..32.0_f64),
            (focus_m, distance_m, fill) in (0.01..1e3_f64, 0.01..50.0_f64, 0.1..=1.0_f64),
            frame_px in prop::array::uniform2(16..20_000_u32),
        ) {
            let setup = CameraSetup { focal_length_mm, pixel_um, f_number, focus_m, distance_m, frame_px, fill, ..SETUP };
            match propose(&setup) {
                Ok(found) => {
                    prop_assert!(found.worst_blur <= MOST_BLUR && found.ring_px >= LEAST_INNER_PX);
                    prop_assert!(found.filled.iter().all(|part| *part <= fill * (1.0 + 1e-5)));
                    prop_assert_ne!(found.board.rows(), found.board.columns());
                    prop_assert_eq!(Board::from_yaml(&found.board.to_yaml()).unwrap(), found.board);
                }
                Err(refusal) => prop_assert!(!refusal.to_string().contains("NaN")),
            }
        }
    }
}
