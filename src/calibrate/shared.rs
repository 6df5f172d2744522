//! What all views share: the camera, and how the printed sheet departs from its board file; as named numbers, some of them free.

use super::{CalibrateOptions, FixedError};
use crate::board::Board;
use crate::camera::{Camera, LensModel, MOST_PARAMETERS};
use nalgebra::{DMatrix, DVector, Point3};

/// Names of the sheet's numbers, after those of the camera.
pub const SHEET_NAMES: [&str; 3] = ["bow_x", "bow_y", "pitch_ratio"];

/// Most numbers that views share.
pub(super) const MOST_SHARED: usize = MOST_PARAMETERS + SHEET_NAMES.len();

/// How the printed sheet departs from its board file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SheetShape {
    /// Curvature along the rows and along the columns, 1/m: the sheet lies at z = `bow_per_m[0]` x^2 + `bow_per_m[1]` y^2 about the
    /// middle of the board, z away from the camera.
    pub bow_per_m: [f64; 2],
    /// Pitch between rows over pitch between columns, times that of the board file: a printer's feed is not its
    /// carriage. What both have in common no camera can tell from a distance.
    pub pitch_ratio: f64,
}

impl Default for SheetShape {
    /// As the board file says.
    fn default() -> Self {
        Self {
            bow_per_m: [0.0; 2],
            pitch_ratio: 1.0,
        }
    }
}

impl SheetShape {
    /// A place of the board file in three dimensions, m; `middle_m` is the middle of the board.
    pub fn place_m(&self, [x, y]: [f64; 2], middle_m: [f64; 2]) -> Point3<f64> {
        let (dx, dy) = (x - middle_m[0], y - middle_m[1]);
        let z = self.bow_per_m[0] * dx * dx + self.bow_per_m[1] * dy * dy;
        Point3::new(x, y * self.pitch_ratio, z)
    }

    /// Derivatives of [`SheetShape::place_m`] by [`SHEET_NAMES`].
    pub(super) fn place_by(
        [x, y]: [f64; 2],
        middle_m: [f64; 2],
    ) -> [nalgebra::Vector3<f64>; SHEET_NAMES.len()] {
        let (dx, dy) = (x - middle_m[0], y - middle_m[1]);
        [
            nalgebra::Vector3::new(0.0, 0.0, dx * dx),
            nalgebra::Vector3::new(0.0, 0.0, dy * dy),
            nalgebra::Vector3::new(0.0, y, 0.0),
        ]
    }
}

/// Camera and sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shared {
    pub camera: Camera,
    pub sheet: SheetShape,
    /// Middle of the board, m.
    pub middle_m: [f64; 2],
}

impl Shared {
    /// The names, camera first.
    pub fn names(camera: &Camera) -> Vec<&'static str> {
        let camera = camera.parameter_names().iter();
        camera.copied().chain(SHEET_NAMES).collect()
    }

    fn values(&self) -> Vec<f64> {
        let mut values = self.camera.parameters();
        let [bow_x, bow_y] = self.sheet.bow_per_m;
        values.extend([bow_x, bow_y, self.sheet.pitch_ratio]);
        values
    }

    fn with_values(&self, values: &[f64]) -> Self {
        let (camera, sheet) = values.split_at(values.len() - SHEET_NAMES.len());
        Self {
            camera: self.camera.with_parameters(camera),
            sheet: SheetShape {
                bow_per_m: [sheet[0], sheet[1]],
                pitch_ratio: sheet[2],
            },
            ..*self
        }
    }

    /// Moved by a step of the free numbers.
    pub fn moved(&self, free: &Free, step: &DVector<f64>) -> Self {
        let mut values = self.values();
        for (column, by) in free.columns.iter().zip(step.iter()) {
            values[column.at] += by;
            if let Some((other, factor)) = column.tied {
                values[other] += factor * by;
            }
        }
        self.with_values(&values)
    }
}

/// A number that is estimated, and one that follows it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Column {
    /// Its place among [`Shared::names`].
    pub at: usize,
    /// The place of another number that changes by this factor times as much.
    pub tied: Option<(usize, f64)>,
    /// What the sum of squared residuals is charged for the square of the number.
    pub charge: f64,
}

impl Column {
    fn at(at: usize) -> Self {
        Self {
            at,
            tied: None,
            charge: 0.0,
        }
    }
}

/// The numbers that are estimated.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Free {
    pub columns: Vec<Column>,
}

impl Free {
    /// What the options leave free for a camera that starts here.
    ///
    /// # Errors
    /// [`FixedError`] where a parameter is fixed that the lens model does not have.
    pub fn of(
        options: &CalibrateOptions,
        camera: &Camera,
        board: &Board,
    ) -> Result<Self, FixedError> {
        let fixed = options.fixed.in_model(camera.model())?;
        let names = camera.parameter_names();
        let place = |name: &str| names.iter().position(|n| *n == name);
        let mut columns: Vec<Column> = (0..names.len())
            .filter(|at| !fixed.contains(&names[*at]))
            .map(|at| Column::at(at))
            .collect();
        if let (true, Some(x), Some(y)) = (options.fixed.keeps_aspect(), place("fx"), place("fy")) {
            let ratio = camera.intrinsics.fy / camera.intrinsics.fx;
            columns.retain(|column| column.at != y);
            for column in columns.iter_mut().filter(|column| column.at == x) {
                column.tied = Some((y, ratio));
            }
        }
        let first = names.len();
        if options.sheet.bow {
            // a square board without marks may be seen at any quarter turn, and its two curvatures would be mixed up
            let turned = board.rows() == board.columns() && board.marks().is_empty();
            let tied = turned.then_some((first + 1, 1.0));
            columns.push(Column {
                tied,
                ..Column::at(first)
            });
            if !turned {
                columns.push(Column::at(first + 1));
            }
        }
        if options.sheet.pitch_ratio {
            columns.push(Column::at(first + 2));
        }
        Ok(Self { columns })
    }

    /// Charges the numbers below the line of the rational model for their squares. Where the lens needs fewer of them, the
    /// two polynomials share a factor that nothing tells, and without a charge the solution may have a pole anywhere.
    pub fn charge(&mut self, camera: &Camera, charge: f64) {
        if camera.model() != LensModel::RationalPolynomial {
            return;
        }
        let names = Shared::names(camera);
        for column in &mut self.columns {
            // the highest power first: it is the one that a lens can do without
            column.charge = match names[column.at] {
                "k6" => charge,
                "k5" => 1e-2 * charge,
                "k4" => 1e-4 * charge,
                _ => 0.0,
            };
        }
    }

    /// Whether [`Free::charge`] charges anything.
    pub fn is_charged(&self) -> bool {
        self.columns.iter().any(|column| column.charge > 0.0)
    }

    /// Cost, and its half derivatives by the free numbers, of what is charged.
    pub fn charged(&self, shared: &Shared) -> (f64, Vec<f64>) {
        if !self.is_charged() {
            return (0.0, vec![0.0; self.columns.len()]);
        }
        let values = shared.values();
        let slopes = |column: &Column| column.charge * values[column.at];
        let columns = self.columns.iter();
        let cost = columns.clone().map(|c| slopes(c) * values[c.at]).sum();
        (cost, columns.map(slopes).collect())
    }

    /// Those of them with one of these names.
    pub fn only(&self, names: &[&str], camera: &Camera) -> Self {
        let all = Shared::names(camera);
        let columns = self.columns.iter();
        Self {
            columns: columns
                .filter(|column| names.contains(&all[column.at]))
                .copied()
                .collect(),
        }
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// The name of the number at a place.
    pub fn name(&self, place: usize, camera: &Camera) -> &'static str {
        Shared::names(camera)[self.columns[place].at]
    }

    /// A covariance of the free numbers as one of all `count` first numbers.
    pub fn spread(&self, covariance: &DMatrix<f64>, count: usize) -> DMatrix<f64> {
        let mut to_all = DMatrix::zeros(count, self.len());
        for (place, column) in self.columns.iter().enumerate() {
            if column.at < count {
                to_all[(column.at, place)] = 1.0;
            }
            if let Some((other, factor)) = column.tied.filter(|tied| tied.0 < count) {
                to_all[(other, place)] = factor;
            }
        }
        &to_all * covariance * to_all.transpose()
    }
}
