//! Maximum likelihood of the ring model on a window: Levenberg-Marquardt with analytic derivatives.

use super::model::{Circles, Matrix, PARAMETERS, PixelModel, RingModel, Vector};
use super::shape::SHAPE_PARAMETERS;
use super::window::Window;
use nalgebra::{Matrix2, SMatrix};

/// Steps at most, accepted or not.
const STEPS: usize = 40;
/// Converged where a step would lower the sum of squares by less than this fraction.
const CONVERGED: f64 = 1e-7;
/// Damping at the start, and how it changes.
const DAMPING: (f64, f64, f64) = (1e-3, 0.2, 8.0);

/// Where the blur stands among the parameters.
const BLUR: usize = SHAPE_PARAMETERS;
/// Keeps the blur determined where it is too small to show (the pixel's own box rules there); as much as a measurement of
/// 10 px uncertainty at 1 % of noise.
const BLUR_PRIOR: f64 = 1e-6;

/// A fitted ring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingFitted {
    /// The most likely parameters.
    pub model: RingModel,
    /// Covariance of the shape's parameters (centre x, y first, px^2), from the residuals' own noise.
    pub covariance: ShapeCovariance,
    /// Standard deviation of the residuals, grey 0..1.
    pub noise: f64,
    /// Sum of the squared residuals.
    pub squares: f64,
    /// Pixels it was fitted to.
    pub pixels: usize,
}

/// Covariance of centre x, y; affine xx, xy, yy; perspective x, y.
pub type ShapeCovariance = SMatrix<f64, SHAPE_PARAMETERS, SHAPE_PARAMETERS>;

impl RingFitted {
    /// Covariance of the projected centre, px^2.
    pub fn centre_covariance(&self) -> Matrix2<f64> {
        self.covariance.fixed_view::<2, 2>(0, 0).into_owned()
    }
}

/// Why a window has no fitted ring.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum FitError {
    /// More parameters than pixels.
    #[error("{pixels} pixels are too few to fit a ring to")]
    TooFewPixels {
        /// Pixels that count.
        pixels: usize,
    },
    /// The start is no ring, or the pixels determine none.
    #[error("the pixels determine no ring")]
    Undetermined,
    /// The steps did not settle.
    #[error("the fit did not converge in {steps} steps")]
    NotConverged {
        /// Steps made.
        steps: usize,
    },
}

/// Sum of squares, gradient and normal matrix at one point.
struct Normal {
    squares: f64,
    gradient: Vector,
    matrix: Matrix,
}

impl Normal {
    fn zero() -> Self {
        Self {
            squares: 0.0,
            gradient: Vector::zeros(),
            matrix: Matrix::zeros(),
        }
    }

    fn at(window: &Window, model: &RingModel, ratio: f64, circles: &mut Circles) -> Option<Self> {
        let mut normal = Self::zero();
        model.for_each_pixel(&window.grid, ratio, circles, |i, pixel| {
            if window.weights[i] > 0.0 {
                normal.add(window.values[i] - pixel.grey, pixel);
            }
        })?;
        let Self {
            squares, matrix, ..
        } = &mut normal;
        matrix.fill_upper_triangle_with_lower_triangle();
        matrix[(BLUR, BLUR)] += BLUR_PRIOR;
        (squares.is_finite() && matrix.iter().all(|v| v.is_finite())).then_some(normal)
    }

    /// Adds a pixel to the sums; of the matrix to its lower triangle.
    fn add(&mut self, residual: f64, pixel: &PixelModel) {
        self.squares += residual * residual;
        let derivatives = pixel.derivatives.as_slice();
        let columns = self.matrix.as_mut_slice().chunks_exact_mut(PARAMETERS);
        for (k, column) in columns.enumerate().skip(pixel.first) {
            let factor = derivatives[k];
            self.gradient[k] += residual * factor;
            for (sum, derivative) in column[k..].iter_mut().zip(&derivatives[k..]) {
                *sum += factor * derivative;
            }
        }
    }

    /// The damped step (Marquardt's scaling).
    fn step(&self, damping: f64) -> Option<Vector> {
        let mut damped = self.matrix;
        for k in 0..PARAMETERS {
            damped[(k, k)] *= 1.0 + damping;
        }
        damped.cholesky().map(|c| c.solve(&self.gradient))
    }
}

/// Fits a ring from a start; `ratio` is the board's inner over outer radius.
///
/// # Errors
/// [`FitError`] where the pixels are too few, determine no ring or the fit does not settle.
pub fn fit(window: &Window, start: &RingModel, ratio: f64) -> Result<RingFitted, FitError> {
    let pixels = window.count();
    if pixels < 2 * PARAMETERS {
        return Err(FitError::TooFewPixels { pixels });
    }
    let mut parameters = start.parameters();
    let mut circles = Circles::default();
    let mut normal =
        Normal::at(window, start, ratio, &mut circles).ok_or(FitError::Undetermined)?;
    let mut damping = DAMPING.0;
    for _ in 0..STEPS {
        let step = normal.step(damping).ok_or(FitError::Undetermined)?;
        let expected = step.dot(&normal.gradient);
        if expected < CONVERGED * normal.squares.max(f64::MIN_POSITIVE) && damping < 1.0 {
            return finish(start.with_parameters(&parameters), &normal, pixels);
        }
        let mut moved = parameters + step;
        // the blur enters by its square: its sign says nothing
        moved[BLUR] = moved[BLUR].abs();
        let model = start.with_parameters(&moved);
        match Normal::at(window, &model, ratio, &mut circles) {
            Some(next) if next.squares < normal.squares => {
                parameters = moved;
                normal = next;
                damping *= DAMPING.1;
            }
            _ if damping > 1e8 => {
                return finish(start.with_parameters(&parameters), &normal, pixels);
            }
            _ => damping *= DAMPING.2,
        }
    }
    Err(FitError::NotConverged { steps: STEPS })
}

fn finish(model: RingModel, normal: &Normal, pixels: usize) -> Result<RingFitted, FitError> {
    let variance = normal.squares / (pixels - PARAMETERS) as f64;
    let inverse = normal.matrix.try_inverse().ok_or(FitError::Undetermined)?;
    let covariance = inverse.fixed_view::<SHAPE_PARAMETERS, SHAPE_PARAMETERS>(0, 0) * variance;
    Ok(RingFitted {
        model,
        covariance,
        noise: variance.sqrt(),
        squares: normal.squares,
        pixels,
    })
}
