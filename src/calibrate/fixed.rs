//! Parameters of the camera that are not estimated.

use crate::camera::{Camera, LensModel};

/// Parameters that keep a value instead of being estimated.
///
/// Without a value of its own a fixed parameter keeps that of the guess; without a guess a fixed distortion coefficient is 0, a
/// fixed coordinate of the principal point is the middle of the frame, and a fixed focal length is the closed-form guess, which
/// neglects the distortion: give its value.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Fixed {
    /// In the order given.
    holds: Vec<(&'static str, Hold)>,
    /// fy over fx stays as it is at the start.
    aspect: bool,
    /// Radial coefficients beyond so many are 0.
    radial: Option<usize>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Hold {
    AtStart,
    At(f64),
}

/// Names that stand for several parameters.
const GROUPS: [(&str, &[&str]); 2] = [
    ("principal_point", &["cx", "cy"]),
    ("tangential", &["p1", "p2"]),
];

/// A list of fixed parameters that cannot be understood.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FixedError {
    /// No such parameter.
    #[error("unknown parameter {0:?}; known are {known}", known = known().join(", "))]
    Name(String),
    /// The value is not a finite number.
    #[error("{0:?} is not NAME or NAME=NUMBER")]
    Value(String),
    /// A focal length that no camera has.
    #[error("{0:?}: a focal length is more than 0 px")]
    Focal(String),
    /// Two values for the same parameter.
    #[error("{name} is fixed at {first} and at {second}: give one of them")]
    Twice {
        /// The parameter.
        name: &'static str,
        /// The value given first.
        first: f64,
        /// The value given later.
        second: f64,
    },
    /// More radial coefficients than the lens model has.
    #[error("radial={count}, but {model} has {} radial coefficients: {}", model.radial_names().len(), model.radial_names().join(", "))]
    Radial {
        /// How many were asked for.
        count: usize,
        /// The lens model.
        model: LensModel,
    },
    /// The lens model has no such parameter.
    #[error("{name} is fixed, but {model} has no {name}; it has {}", model.parameter_names().join(", "))]
    NotInModel {
        /// The parameter.
        name: &'static str,
        /// The lens model.
        model: LensModel,
    },
}

/// Every entry that has a meaning, without values.
fn known() -> Vec<&'static str> {
    let mut names = LensModel::RationalPolynomial.parameter_names().to_vec();
    names.extend(GROUPS.map(|(name, _)| name));
    names.extend(["aspect_ratio", "radial=NUMBER"]);
    names
}

fn parameter(name: &str) -> Option<&'static str> {
    // the rational model has the parameters of all
    let all = LensModel::RationalPolynomial.parameter_names();
    all.iter().find(|known| **known == name).copied()
}

impl Fixed {
    /// Reads entries such as `k3`, `cx=639.5`, `principal_point`, `tangential`, `aspect_ratio` and `radial=2` (only the first two
    /// radial coefficients are estimated).
    ///
    /// # Errors
    /// [`FixedError`] names the entry, and the parameters known.
    pub fn from_entries<S: AsRef<str>>(
        entries: impl IntoIterator<Item = S>,
    ) -> Result<Self, FixedError> {
        let mut fixed = Self::default();
        for entry in entries {
            fixed.add(entry.as_ref().trim())?;
        }
        Ok(fixed)
    }

    fn add(&mut self, entry: &str) -> Result<(), FixedError> {
        let bad = || FixedError::Value(entry.to_owned());
        let (name, value) = match entry.split_once('=') {
            None => (entry, None),
            Some((name, value)) => {
                let value: f64 = value.trim().parse().map_err(|_| bad())?;
                if !value.is_finite() {
                    return Err(bad());
                }
                (name.trim(), Some(value))
            }
        };
        let group = GROUPS.iter().find(|(group, _)| *group == name);
        match (name, value, group) {
            ("aspect_ratio", None, _) => self.aspect = true,
            ("radial", Some(count), _) if count >= 0.0 && count.fract() == 0.0 => {
                self.add_radial(count as usize)?;
            }
            (_, None, Some((_, members))) => {
                for member in *members {
                    self.hold(member, Hold::AtStart)?;
                }
            }
            ("aspect_ratio" | "radial", _, _) | (_, Some(_), Some(_)) => return Err(bad()),
            _ => {
                let name = parameter(name).ok_or_else(|| FixedError::Name(name.to_owned()))?;
                if matches!(name, "fx" | "fy") && value.is_some_and(|value| value <= 0.0) {
                    return Err(FixedError::Focal(entry.to_owned()));
                }
                self.hold(name, value.map_or(Hold::AtStart, Hold::At))?;
            }
        }
        Ok(())
    }

    /// Of several mentions of a parameter the one with a value counts.
    fn hold(&mut self, name: &'static str, hold: Hold) -> Result<(), FixedError> {
        let known = self.holds.iter_mut().find(|(other, _)| *other == name);
        let Some((_, known)) = known else {
            self.holds.push((name, hold));
            return Ok(());
        };
        match (*known, hold) {
            (Hold::At(first), Hold::At(second)) if first != second => {
                return Err(FixedError::Twice {
                    name,
                    first,
                    second,
                });
            }
            (Hold::AtStart, _) => *known = hold,
            (Hold::At(_), _) => {}
        }
        Ok(())
    }

    fn add_radial(&mut self, count: usize) -> Result<(), FixedError> {
        let model = LensModel::RationalPolynomial;
        if count > model.radial_names().len() {
            return Err(FixedError::Radial { count, model });
        }
        match self.radial.replace(count) {
            Some(first) if first != count => Err(FixedError::Twice {
                name: "radial",
                first: first as f64,
                second: count as f64,
            }),
            _ => Ok(()),
        }
    }

    /// Whether every entry means something for a lens model that was asked for. One that is tried among others may have fewer
    /// radial coefficients than are let free.
    ///
    /// # Errors
    /// [`FixedError::Radial`], and those of [`Fixed::in_model`].
    pub fn suits(&self, model: LensModel) -> Result<(), FixedError> {
        let most = model.radial_names().len();
        if let Some(count) = self.radial.filter(|count| *count > most) {
            return Err(FixedError::Radial { count, model });
        }
        self.in_model(model).map(|_| ())
    }

    /// Names of the parameters of a lens model that are fixed, in the model's order.
    ///
    /// # Errors
    /// [`FixedError::NotInModel`] where one is fixed that the model does not have.
    pub fn in_model(&self, model: LensModel) -> Result<Vec<&'static str>, FixedError> {
        let names = model.parameter_names();
        // tangential terms that a fisheye does not have are zero in it
        let zero = |(name, hold): &(&str, Hold)| {
            matches!(*name, "p1" | "p2") && matches!(hold, Hold::AtStart | Hold::At(0.0))
        };
        let mut others = self.holds.iter().filter(|(name, _)| !names.contains(name));
        if let Some((name, _)) = others.find(|held| !zero(held)) {
            return Err(FixedError::NotInModel { name, model });
        }
        let not_radial = model.radial_names().iter().skip(self.radial.unwrap_or(8));
        let not_radial: Vec<_> = not_radial.collect();
        Ok(names
            .iter()
            .filter(|name| {
                let focal = matches!(**name, "fx" | "fy") && self.holds_focal();
                focal || self.holds(name) || not_radial.contains(name)
            })
            .copied()
            .collect())
    }

    /// Whether fy over fx stays as it is at the start.
    pub fn keeps_aspect(&self) -> bool {
        self.aspect
    }

    /// Whether both focal lengths are fixed.
    pub(super) fn holds_focal(&self) -> bool {
        let (x, y) = (self.holds("fx"), self.holds("fy"));
        (x && y) || (self.aspect && (x || y))
    }

    fn holds(&self, name: &str) -> bool {
        self.holds.iter().any(|(held, _)| *held == name)
    }

    /// A guess of the camera with the fixed parameters where they are held; `given` says that the guess is the user's, whose values
    /// are kept.
    pub(super) fn hold_at(&self, guess: &Camera, given: bool) -> Camera {
        let mut values = guess.parameters();
        let names = guess.parameter_names();
        let middle = [
            0.5 * (f64::from(guess.width) - 1.0),
            0.5 * (f64::from(guess.height) - 1.0),
        ];
        for (at, name) in names.iter().enumerate() {
            let hold = self.holds.iter().find(|(held, _)| held == name);
            match (hold.map(|hold| hold.1), *name) {
                (Some(Hold::At(value)), _) => values[at] = value,
                (Some(Hold::AtStart), "cx") if !given => values[at] = middle[0],
                (Some(Hold::AtStart), "cy") if !given => values[at] = middle[1],
                _ => {}
            }
        }
        if self.aspect {
            let ratio = if given {
                guess.intrinsics.fy / guess.intrinsics.fx
            } else {
                1.0
            };
            // values that are given for both have a ratio of their own
            match (self.holds("fx"), self.holds("fy")) {
                (true, true) => {}
                (false, true) => values[0] = values[1] / ratio,
                (_, false) => values[1] = values[0] * ratio,
            }
        }
        guess.with_parameters(&values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Distortion, Intrinsics};

    #[test]
    fn entries_name_parameters_and_may_carry_a_value() {
        let fixed = Fixed::from_entries(["k3", " cx = 12.5"]).unwrap();
        assert_eq!(fixed.in_model(LensModel::PlumbBob).unwrap(), ["cx", "k3"]);
        let camera = Camera {
            width: 640,
            height: 480,
            intrinsics: Intrinsics {
                fx: 500.0,
                fy: 500.0,
                cx: 300.0,
                cy: 200.0,
            },
            distortion: Distortion::default(),
        };
        assert_eq!(fixed.hold_at(&camera, false).intrinsics.cx, 12.5);
        assert_eq!(fixed.hold_at(&camera, false).intrinsics.cy, 200.0);
        let centred = Fixed::from_entries(["principal_point"]).unwrap();
        let intrinsics = centred.hold_at(&camera, false).intrinsics;
        assert_eq!((intrinsics.cx, intrinsics.cy), (319.5, 239.5));
        assert_eq!(centred.hold_at(&camera, true), camera);
    }

    #[test]
    fn groups_and_counts_stand_for_parameters_of_the_model() {
        let fixed = Fixed::from_entries(["tangential", "radial=2", "aspect_ratio"]).unwrap();
        let names = |model| fixed.in_model(model).unwrap();
        assert_eq!(names(LensModel::PlumbBob), ["p1", "p2", "k3"]);
        assert_eq!(
            names(LensModel::RationalPolynomial),
            ["p1", "p2", "k3", "k4", "k5", "k6"]
        );
        assert_eq!(names(LensModel::Equidistant), ["k3", "k4"]);
        assert!(fixed.keeps_aspect() && !fixed.holds_focal());
        let of_another = Fixed::from_entries(["k5"]).unwrap();
        let error = of_another.in_model(LensModel::PlumbBob).unwrap_err();
        assert!(error.to_string().contains("plumb_bob has no k5"), "{error}");
    }

    #[test]
    fn unknown_names_are_refused_with_the_known_ones() {
        let error = Fixed::from_entries(["k9"]).unwrap_err().to_string();
        assert!(
            error.contains("\"k9\"") && error.contains("fx, fy, cx, cy, k1"),
            "{error}"
        );
        for wrong in [
            "k1=",
            "k1=one",
            "k1=inf",
            "radial=1.5",
            "radial",
            "tangential=0",
            "radial=-1",
        ] {
            let error = Fixed::from_entries([wrong]).unwrap_err();
            assert_eq!(error, FixedError::Value(wrong.to_owned()));
        }
    }

    #[test]
    fn what_would_do_nothing_is_refused_with_the_names_of_the_model() {
        let error = |entries: &[&str]| Fixed::from_entries(entries).unwrap_err().to_string();
        assert_eq!(
            error(&["k1=0", "k1=1"]),
            "k1 is fixed at 0 and at 1: give one of them"
        );
        assert!(error(&["radial=2", "radial=1"]).contains("at 2 and at 1"));
        assert!(error(&["radial=9"]).ends_with("k1, k2, k3, k4, k5, k6"));
        for impossible in ["fx=-5", "fy=0"] {
            assert!(error(&[impossible]).contains("more than 0 px"));
        }
        let fixed = |entries: &[&str]| Fixed::from_entries(entries).unwrap();
        let unsuited = |entries: &[&str], model| fixed(entries).suits(model).unwrap_err();
        let error = unsuited(&["p1=1"], LensModel::Equidistant).to_string();
        assert!(
            error.ends_with("it has fx, fy, cx, cy, k1, k2, k3, k4"),
            "{error}"
        );
        let error = unsuited(&["radial=4"], LensModel::PlumbBob).to_string();
        assert!(
            error.ends_with("3 radial coefficients: k1, k2, k3"),
            "{error}"
        );
        assert_eq!(fixed(&["radial=4"]).suits(LensModel::Equidistant), Ok(()));
        assert_eq!(fixed(&["p1=0", "p2"]).suits(LensModel::Equidistant), Ok(()));
        // the same twice is no contradiction, and a value says more than none
        assert_eq!(
            fixed(&["k1=1", "k1=1", "radial=2", "radial=2"]),
            fixed(&["k1=1", "radial=2"])
        );
        assert_eq!(fixed(&["cx=3", "cx"]), fixed(&["cx", "cx=3"]));
    }
}
