//! What ROS and OpenCV files have in common: the camera matrix and the row of coefficients.
//!
//! Every format here counts pixels from 0 in the middle of the first one, so that no number has to be shifted between
//! them, and orders the coefficients alike: k1, k2, p1, p2, k3, k4, k5, k6.

use super::camera_file_error::CameraFileError;
use crate::camera::{Camera, Distortion, Intrinsics, LensModel};
use serde::Deserialize;

/// The identity by rows.
pub(super) const IDENTITY: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];

/// A matrix as YAML files have it.
#[derive(Deserialize)]
pub(super) struct Matrix {
    #[serde(default)]
    rows: usize,
    #[serde(default)]
    cols: usize,
    /// In place of rows and columns where OpenCV 5 writes a list.
    #[serde(default)]
    sizes: Vec<usize>,
    data: Vec<f64>,
}

impl Matrix {
    /// The numbers by rows, of a matrix of this size.
    pub(super) fn values<const N: usize>(
        &self,
        name: &'static str,
        expected: &'static str,
    ) -> Result<[f64; N], CameraFileError> {
        let size = format!("{} x {}", self.rows, self.cols);
        let values = <[f64; N]>::try_from(self.data.as_slice())
            .ok()
            .filter(|_| size == expected)
            .ok_or_else(|| self.wrong_size(name, expected))?;
        finite(name, &values)?;
        Ok(values)
    }

    /// The numbers of a single row or column.
    pub(super) fn vector(
        &self,
        name: &'static str,
        expected: &'static str,
    ) -> Result<&[f64], CameraFileError> {
        let count = self.data.len();
        let one_row = (self.rows, self.cols) == (1, count);
        if !one_row && (self.rows, self.cols) != (count, 1) && self.sizes != [count] {
            return Err(self.wrong_size(name, expected));
        }
        finite(name, &self.data)?;
        Ok(&self.data)
    }

    pub(super) fn wrong_size(&self, name: &'static str, expected: &'static str) -> CameraFileError {
        CameraFileError::Size {
            name,
            rows: self.rows,
            columns: self.cols,
            values: self.data.len(),
            expected,
        }
    }
}

/// Refuses NaN and infinities.
pub(super) fn finite(name: &'static str, values: &[f64]) -> Result<(), CameraFileError> {
    match values.iter().all(|value| value.is_finite()) {
        true => Ok(()),
        false => Err(CameraFileError::NotFinite { name }),
    }
}

/// The camera matrix by rows.
pub(super) fn camera_matrix(camera: &Camera) -> [f64; 9] {
    let k = &camera.intrinsics;
    [k.fx, 0.0, k.cx, 0.0, k.fy, k.cy, 0.0, 0.0, 1.0]
}

/// Focal lengths and principal point of a camera matrix. One with a skew is refused: dropping the skew would be another camera.
pub(super) fn intrinsics(matrix: &[f64; 9]) -> Result<Intrinsics, CameraFileError> {
    let [fx, _, cx, _, fy, cy, ..] = *matrix;
    // first, because a file of zeros is the usual sign of a camera that is not calibrated
    if !(fx > 0.0 && fy > 0.0) {
        return Err(CameraFileError::Uncalibrated { fx, fy });
    }
    for (at, (value, fixed)) in matrix.iter().zip(IDENTITY).enumerate() {
        if !matches!(at, 0 | 2 | 4 | 5) && *value != fixed {
            return Err(CameraFileError::NotPinhole {
                row: at / 3 + 1,
                column: at % 3 + 1,
                value: *value,
            });
        }
    }
    Ok(Intrinsics { fx, fy, cx, cy })
}

/// A camera of numbers from a file.
pub(super) fn camera(
    (width, height): (u32, u32),
    intrinsics: Intrinsics,
    distortion: Distortion,
) -> Result<Camera, CameraFileError> {
    let Intrinsics { fx, fy, cx, cy } = intrinsics;
    if width == 0 || height == 0 {
        return Err(CameraFileError::NoPixels { width, height });
    }
    if !(fx > 0.0 && fy > 0.0) {
        return Err(CameraFileError::Uncalibrated { fx, fy });
    }
    finite("the camera matrix", &[fx, fy, cx, cy])?;
    finite("the lens distortion", &distortion.coefficients())?;
    Ok(Camera {
        width,
        height,
        intrinsics,
        distortion,
    })
}

/// The lens of OpenCV's coefficients, whose number is the model: none, 4 and 5 are plumb_bob, 8 are rational_polynomial, and
/// so are 12 and 14 whose last ones are zero. `None` for another number.
pub(super) fn lens_by_count(
    name: &'static str,
    values: &[f64],
) -> Result<Option<Distortion>, CameraFileError> {
    if matches!(values.len(), 12 | 14) && values[8..].iter().any(|value| *value != 0.0) {
        return Err(CameraFileError::BeyondRational {
            name,
            values: values[8..].to_vec(),
        });
    }
    let zeros = [0.0; 5];
    Ok(match values {
        [] => Distortion::new(LensModel::PlumbBob, &zeros),
        [k1, k2, p1, p2] => Distortion::new(LensModel::PlumbBob, &[*k1, *k2, *p1, *p2, 0.0]),
        five if five.len() == 5 => Distortion::new(LensModel::PlumbBob, five),
        more if matches!(more.len(), 8 | 12 | 14) => {
            Distortion::new(LensModel::RationalPolynomial, &more[..8])
        }
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_of_coefficients_is_the_model() {
        let values: Vec<f64> = (1..=14).map(|i| f64::from(i) / 100.0).collect();
        let lens = |values: &[f64]| lens_by_count("d", values).unwrap();
        assert_eq!(lens(&[]), Some(Distortion::default()));
        assert_eq!(
            lens(&values[..4]).unwrap().coefficients(),
            [0.01, 0.02, 0.03, 0.04, 0.0]
        );
        assert_eq!(lens(&values[..5]).unwrap().coefficients(), values[..5]);
        let mut long = values.clone();
        long[8..].fill(0.0);
        for count in [8, 12, 14] {
            assert_eq!(lens(&long[..count]).unwrap().coefficients(), values[..8]);
        }
        for count in [1, 2, 3, 6, 7, 9, 10, 11, 13] {
            assert_eq!(lens(&long[..count]), None);
        }
        let said = lens_by_count("d", &values[..12]).unwrap_err().to_string();
        assert!(said.contains("[0.09, 0.1, 0.11, 0.12]"), "{said}");
    }

    #[test]
    fn a_matrix_with_a_skew_is_refused_by_its_place() {
        let mut matrix = [500.0, 0.0, 320.0, 0.0, 510.0, 240.0, 0.0, 0.0, 1.0];
        assert_eq!(intrinsics(&matrix).unwrap().fy, 510.0);
        matrix[1] = 0.25;
        let said = intrinsics(&matrix).unwrap_err().to_string();
        assert!(said.contains("row 1 column 2 is 0.25"), "{said}");
    }
}
