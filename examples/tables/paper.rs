//! What the paper says: its boards (Table 1), its results (Table 2), and the camera that is taken for the truth.

use anyhow::Result;
use ringcal::board::Board;
use ringcal::camera::{Camera, Intrinsics, PlumbBob};

/// Side of a pixel, mm.
pub const PIXEL_MM: f64 = 2.4e-3;
/// Distance at which the paper's lens is in focus, m.
pub const FOCUS_M: f64 = 7.5;

/// A line of Table 1.
pub struct Target {
    pub name: &'static str,
    board_file: &'static str,
    /// Side of the square sheet, m.
    side_m: f64,
    /// Distance from the camera, m.
    pub distance_m: f64,
}

/// Table 1.
pub const TARGETS: [Target; 4] = [
    Target {
        name: "C1",
        board_file: include_str!("../../config/paper_c1.yaml"),
        side_m: 0.700,
        distance_m: 7.5,
    },
    Target {
        name: "C2",
        board_file: include_str!("../../config/paper_c2.yaml"),
        side_m: 0.376,
        distance_m: 4.0,
    },
    Target {
        name: "C3",
        board_file: include_str!("../../config/paper_c3.yaml"),
        side_m: 0.282,
        distance_m: 3.0,
    },
    Target {
        name: "C4",
        board_file: include_str!("../../config/paper_c4.yaml"),
        side_m: 0.188,
        distance_m: 2.0,
    },
];

impl Target {
    pub fn board(&self) -> Result<Board> {
        Ok(Board::from_yaml(self.board_file)?)
    }

    /// Paper beyond the outermost rings, in outer radii.
    pub fn margin(&self, board: &Board) -> f64 {
        let rings_m = f64::from(board.columns() - 1) * board.pitch_m();
        0.5 * (self.side_m - rings_m) / board.outer_radius_m() - 1.0
    }

    /// The lines of Table 2 at this distance.
    pub fn printed(&self) -> impl Iterator<Item = &'static Printed> {
        let distance_m = self.distance_m;
        TABLE_2.iter().filter(move |p| p.distance_m == distance_m)
    }
}

/// A line of Table 2.
pub struct Printed {
    pub method: &'static str,
    pub distance_m: f64,
    /// f_u and f_v in mm, u0 and v0 in px, k1, k2.
    pub values: [f64; 6],
    pub error_px: f64,
}

const fn printed(
    method: &'static str,
    distance_m: f64,
    values: [f64; 6],
    error_px: f64,
) -> Printed {
    Printed {
        method,
        distance_m,
        values,
        error_px,
    }
}

/// Table 2: Zhang's is a checkerboard in focus, PC the paper's method, GCS the centres of the small ellipses.
#[rustfmt::skip]
pub const TABLE_2: [Printed; 9] = [
    printed("Zhang's", 7.5, [49.5818, 49.5070, 2942.133, 1655.325, -0.3428, 0.627], 0.2535),
    printed("PC", 7.5, [49.3818, 49.3070, 2939.054, 1649.173, -0.3559, 0.609], 0.1269),
    printed("GCS", 7.5, [49.4432, 49.4324, 2945.448, 1657.455, -0.3547, 0.630], 0.3088),
    printed("PC", 4.0, [50.2706, 50.2668, 2936.214, 1680.458, -0.3333, 0.651], 0.2311),
    printed("GCS", 4.0, [50.5632, 50.5426, 2955.651, 1687.659, -0.3384, 0.654], 0.3888),
    printed("PC", 3.0, [49.4923, 49.4740, 2928.518, 1648.164, -0.3523, 0.602], 0.2981),
    printed("GCS", 3.0, [49.2144, 49.2150, 2920.554, 1645.223, -0.3554, 0.609], 0.4654),
    printed("PC", 2.0, [49.8544, 49.8895, 2860.452, 1635.957, -0.3812, 0.644], 0.3306),
    printed("GCS", 2.0, [49.8450, 49.8420, 2889.317, 1642.231, -0.3954, 0.645], 0.7560),
];

/// The simulated camera: what the paper's checkerboard gave in focus, without tangential terms.
pub fn truth() -> Camera {
    let [fu_mm, fv_mm, u0, v0, k1, k2] = TABLE_2[0].values;
    Camera {
        width: 5496,
        height: 3672,
        intrinsics: Intrinsics {
            fx: fu_mm / PIXEL_MM,
            fy: fv_mm / PIXEL_MM,
            cx: u0,
            cy: v0,
        },
        distortion: PlumbBob {
            k1,
            k2,
            ..PlumbBob::default()
        }
        .into(),
    }
}
