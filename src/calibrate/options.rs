//! What is asked of a calibration.

use crate::camera::Camera;

/// How to calibrate.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CalibrateOptions {
    /// Parameters of the camera that are not estimated.
    pub fixed: Fixed,
}

/// Parameters that keep a value instead of being estimated.
///
/// Without a value of its own a fixed distortion coefficient is 0, a fixed coordinate of the principal point is the
/// middle of the frame, and a fixed focal length is the closed-form guess, which neglects the distortion: give its value.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Fixed {
    holds: [Option<Hold>; Camera::PARAMETER_COUNT],
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Hold {
    AtStart,
    At(f64),
}

/// A list of fixed parameters that cannot be understood.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FixedError {
    /// No such parameter.
    #[error("unknown parameter {0:?}; known are {known}", known = Camera::PARAMETER_NAMES.join(", "))]
    Name(String),
    /// The value is not a finite number.
    #[error("{0:?} is not NAME or NAME=NUMBER")]
    Value(String),
}

impl Fixed {
    /// Reads entries such as `k3` or `cx=639.5`.
    ///
    /// # Errors
    /// [`FixedError`] names the entry, and the parameters known.
    pub fn from_entries<S: AsRef<str>>(
        entries: impl IntoIterator<Item = S>,
    ) -> Result<Self, FixedError> {
        let mut fixed = Self::default();
        for entry in entries {
            let entry = entry.as_ref().trim();
            let (name, hold) = match entry.split_once('=') {
                None => (entry, Hold::AtStart),
                Some((name, value)) => {
                    let value: f64 = value
                        .trim()
                        .parse()
                        .map_err(|_| FixedError::Value(entry.to_owned()))?;
                    if !value.is_finite() {
                        return Err(FixedError::Value(entry.to_owned()));
                    }
                    (name.trim(), Hold::At(value))
                }
            };
            let at = Camera::PARAMETER_NAMES
                .iter()
                .position(|known| *known == name)
                .ok_or_else(|| FixedError::Name(name.to_owned()))?;
            fixed.holds[at] = Some(hold);
        }
        Ok(fixed)
    }

    /// Whether the parameter at this place of [`Camera::PARAMETER_NAMES`] is fixed.
    pub fn is_fixed(&self, at: usize) -> bool {
        self.holds.get(at).is_some_and(Option::is_some)
    }

    /// Names of the fixed parameters, in the order of [`Camera::PARAMETER_NAMES`].
    pub fn names(&self) -> Vec<&'static str> {
        (0..Camera::PARAMETER_COUNT)
            .filter(|at| self.is_fixed(*at))
            .map(|at| Camera::PARAMETER_NAMES[at])
            .collect()
    }

    /// Places of the parameters that are estimated.
    pub(super) fn free(&self) -> Vec<usize> {
        (0..Camera::PARAMETER_COUNT)
            .filter(|at| !self.is_fixed(*at))
            .collect()
    }

    /// A guess of the camera with the fixed parameters where they are held.
    pub(super) fn hold(&self, guess: &Camera) -> Camera {
        let mut values = guess.parameters();
        let middle = [
            0.5 * (f64::from(guess.width) - 1.0),
            0.5 * (f64::from(guess.height) - 1.0),
        ];
        for (at, hold) in self.holds.iter().enumerate() {
            match (hold, Camera::PARAMETER_NAMES[at]) {
                (Some(Hold::At(value)), _) => values[at] = *value,
                (Some(Hold::AtStart), "cx") => values[at] = middle[0],
                (Some(Hold::AtStart), "cy") => values[at] = middle[1],
                _ => {}
            }
        }
        guess.with_parameters(&values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_name_parameters_and_may_carry_a_value() {
        let fixed = Fixed::from_entries(["k3", " cx = 12.5"]).unwrap();
        assert_eq!(fixed.names(), ["cx", "k3"]);
        let camera = Camera {
            width: 640,
            height: 480,
            intrinsics: crate::camera::Intrinsics {
                fx: 500.0,
                fy: 500.0,
                cx: 300.0,
                cy: 200.0,
            },
            distortion: crate::camera::PlumbBob::default(),
        };
        assert_eq!(fixed.hold(&camera).intrinsics.cx, 12.5);
        assert_eq!(fixed.hold(&camera).intrinsics.cy, 200.0);
        let centred = Fixed::from_entries(["cx", "cy"]).unwrap().hold(&camera);
        assert_eq!(
            (centred.intrinsics.cx, centred.intrinsics.cy),
            (319.5, 239.5)
        );
    }

    #[test]
    fn unknown_names_are_refused_with_the_known_ones() {
        let error = Fixed::from_entries(["k4"]).unwrap_err().to_string();
        assert!(
            error.contains("\"k4\"") && error.contains("fx, fy, cx, cy, k1"),
            "{error}"
        );
        for wrong in ["k1=", "k1=one", "k1=inf"] {
            let error = Fixed::from_entries([wrong]).unwrap_err();
            assert_eq!(error, FixedError::Value(wrong.to_owned()));
        }
    }
}
