//! The image of one circle of a ring: its horizontal chords, and how they move with the ring's parameters.
//!
//! Where the conic Q of `shape` changes with a parameter p, a point of the outline moves along x by -Q_p / Q_x. Each Q_p
//! is a quadratic in the place, so that six [moments](MOMENTS) of the outline hold the derivatives by all parameters.

use super::shape::{SHAPE_PARAMETERS, Shape};
use nalgebra::Point2;

/// Monomials of a place x, y about the projected centre: 1, x, y, x^2, xy, y^2.
pub(super) const MOMENTS: usize = 6;
/// Where each monomial is found when x and y are exchanged.
pub(super) const TRANSPOSED: [usize; MOMENTS] = [0, 2, 1, 5, 4, 3];

/// The image of one circle; an ellipse.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outline {
    centre: Point2<f64>,
    /// xx, xy, yy of the quadratic form, about the centre.
    matrix: [f64; 3],
    /// Half the linear part.
    vector: [f64; 2],
    /// Square of the circle's radius in outer radii: Q = x'^T M x' + 2 m . x' - a^2.
    square: f64,
    perspective: [f64; 2],
    rows: (f64, f64),
    columns: (f64, f64),
}

/// One end of a chord.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct End {
    /// Where it is, px.
    pub(super) x: f64,
    /// The monomials there over |Q_x|.
    pub(super) moments: [f64; MOMENTS],
}

impl Outline {
    /// The image of the circle of `radius` (in outer radii); `None` where it is no ellipse.
    pub(super) fn new(shape: &Shape, radius: f64) -> Option<Self> {
        let (m, l) = shape.quadric(radius);
        Some(Self {
            centre: shape.centre,
            matrix: [m[(0, 0)], m[(0, 1)], m[(1, 1)]],
            vector: [l.x, l.y],
            square: radius * radius,
            perspective: [shape.perspective.x, shape.perspective.y],
            rows: shape.rows(radius)?,
            columns: shape.transposed().rows(radius)?,
        })
    }

    /// The outline with x and y exchanged.
    pub(super) fn transposed(&self) -> Self {
        let ([xx, xy, yy], [lx, ly], [qx, qy]) = (self.matrix, self.vector, self.perspective);
        Self {
            centre: Point2::new(self.centre.y, self.centre.x),
            matrix: [yy, xy, xx],
            vector: [ly, lx],
            square: self.square,
            perspective: [qy, qx],
            rows: self.columns,
            columns: self.rows,
        }
    }

    /// First and last y, px.
    pub(super) fn rows(&self) -> (f64, f64) {
        self.rows
    }

    /// The left and the right end of the chord at height `y`; `None` beside the outline.
    pub(super) fn chord(&self, y: f64) -> Option<[End; 2]> {
        let v = y - self.centre.y;
        let [xx, xy, yy] = self.matrix;
        // xx x'^2 + 2 B x' + C = 0
        let b = xy * v + self.vector[0];
        let c = (yy * v + 2.0 * self.vector[1]) * v - self.square;
        let discriminant = b * b - xx * c;
        if !(discriminant > 0.0 && xx > 0.0) {
            return None;
        }
        let root = discriminant.sqrt();
        let (inverse, slope) = (1.0 / xx, 0.5 / root);
        Some([-root, root].map(|side| {
            let x = (side - b) * inverse;
            End {
                x: x + self.centre.x,
                moments: [1.0, x, v, x * x, x * v, v * v].map(|monomial| slope * monomial),
            }
        }))
    }

    /// The derivatives by the parameters of a shape of whatever has these moments as its own: rows are parameters.
    pub(super) fn derivatives(&self) -> [[f64; MOMENTS]; SHAPE_PARAMETERS] {
        let [xx, xy, yy] = self.matrix;
        let [lx, ly] = self.vector;
        let [qx, qy] = self.perspective;
        let depth = -2.0 * self.square;
        [
            [2.0 * lx, 2.0 * xx, 2.0 * xy, 0.0, 0.0, 0.0],
            [2.0 * ly, 2.0 * xy, 2.0 * yy, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, -1.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, -2.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, 0.0, -1.0],
            [0.0, depth, 0.0, -depth * qx, -depth * qy, 0.0],
            [0.0, 0.0, depth, 0.0, -depth * qx, -depth * qy],
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPE: [f64; SHAPE_PARAMETERS] = [31.2, 28.9, 0.0031, 0.0004, 0.0042, 0.002, -0.0015];

    fn chord(p: &[f64; SHAPE_PARAMETERS], radius: f64, y: f64) -> [End; 2] {
        let outline = Outline::new(&Shape::from_parameters(p), radius).unwrap();
        outline.chord(y).unwrap()
    }

    #[test]
    fn the_ends_of_a_chord_move_as_the_moments_say() {
        for (radius, y) in [(1.0, 22.0), (0.5, 30.0)] {
            let outline = Outline::new(&Shape::from_parameters(&SHAPE), radius).unwrap();
            for (k, row) in outline.derivatives().iter().enumerate() {
                let h = 1e-6 * SHAPE[k].abs();
                let moved = |h: f64| {
                    let mut p = SHAPE;
                    p[k] += h;
                    chord(&p, radius, y).map(|end| end.x)
                };
                let (up, down) = (moved(h), moved(-h));
                for (i, end) in chord(&SHAPE, radius, y).iter().enumerate() {
                    let slope = (up[i] - down[i]) / (2.0 * h);
                    // coverage grows where the left end moves left and the right end right
                    let grows = if i == 0 { -slope } else { slope };
                    let told: f64 = row.iter().zip(&end.moments).map(|(a, b)| a * b).sum();
                    assert!(
                        (told - grows).abs() < 1e-4 * slope.abs().max(1.0),
                        "{k} {i}: {slope} {told}"
                    );
                }
            }
        }
    }

    #[test]
    fn chords_end_on_the_ellipse() {
        let shape = Shape::from_parameters(&SHAPE);
        for radius in [1.0, 0.5] {
            let ellipse = shape.ellipse(radius).unwrap();
            let outline = Outline::new(&shape, radius).unwrap();
            for k in 0..12 {
                let p = ellipse.point(0.3 + 0.5 * f64::from(k));
                let ends = outline.chord(p.y).unwrap();
                let near = (ends[0].x - p.x).abs().min((ends[1].x - p.x).abs());
                assert!(near < 1e-6, "{near}");
            }
        }
    }
}
