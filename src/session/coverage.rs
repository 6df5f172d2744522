//! Which parts of the frame the rings have covered.

use super::View;
use crate::calibrate::MAP_CELLS;
use crate::detect::Ring;
use nalgebra::{Point2, Vector3};

/// Cells across the frame: those that the projection uncertainty is asked for in.
pub const COLUMNS: usize = MAP_CELLS.0;
/// Cells down the frame.
pub const ROWS: usize = MAP_CELLS.1;
/// Points of an ellipse that are looked at; a cell that a large ellipse enters between two of them is missed.
const ELLIPSE_POINTS: usize = 32;

/// The frame in 10 x 10 cells, each touched by a ring or not.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Coverage {
    cells: [[bool; COLUMNS]; ROWS],
}

impl Coverage {
    /// Adds the rings of a view: a cell is covered where a ring's centre or a part of its outer ellipse lies in it.
    pub fn add(&mut self, view: &View) {
        let size = (view.width as f64, view.height as f64);
        for ring in &view.rings {
            self.touch(ring.centre.point, size);
            for step in 0..ELLIPSE_POINTS {
                let t = std::f64::consts::TAU * step as f64 / ELLIPSE_POINTS as f64;
                self.touch(ring.ellipses.outer.point(t), size);
            }
            self.fill(ring, size);
        }
    }

    /// Covered cells over all cells, 0 to 1.
    pub fn fraction(&self) -> f64 {
        let covered = self.cells.iter().flatten().filter(|c| **c).count();
        covered as f64 / (ROWS * COLUMNS) as f64
    }

    /// Whether a cell is covered; `false` outside the grid.
    pub fn cell(&self, row: usize, column: usize) -> bool {
        self.cells
            .get(row)
            .and_then(|cells| cells.get(column))
            .copied()
            .unwrap_or(false)
    }

    fn touch(&mut self, point: Point2<f64>, (width, height): (f64, f64)) {
        // pixel 0 reaches from -0.5 to 0.5
        let column = ((point.x + 0.5) / width * COLUMNS as f64).floor();
        let row = ((point.y + 0.5) / height * ROWS as f64).floor();
        let inside = (0.0..COLUMNS as f64).contains(&column) && (0.0..ROWS as f64).contains(&row);
        if inside {
            self.cells[row as usize][column as usize] = true;
        }
    }

    /// Cells whose middle lies inside a large ring.
    fn fill(&mut self, ring: &Ring, (width, height): (f64, f64)) {
        let conic = ring.ellipses.outer.conic();
        for (row, cells) in self.cells.iter_mut().enumerate() {
            for (column, cell) in cells.iter_mut().enumerate() {
                let x = (column as f64 + 0.5) * width / COLUMNS as f64 - 0.5;
                let y = (row as f64 + 0.5) * height / ROWS as f64 - 0.5;
                let middle = Vector3::new(x, y, 1.0);
                *cell |= (middle.transpose() * conic * middle)[0] < 0.0;
            }
        }
    }
}
