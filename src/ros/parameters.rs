//! Parameters: how one is declared, and values of the declared types within the declared ranges.

use super::declarations::declarations;
use ros2_client::ParameterValue;
use ros2_client::parameters::{NumericRange, ParameterDescriptor, ParameterType};
use std::collections::BTreeMap;

/// Where a number must lie, both ends allowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Range {
    /// Anything of the type.
    Any,
    /// Integers from .. to.
    Integers(i64, i64),
    /// Numbers from .. to.
    Doubles(f64, f64),
}

/// One parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Declaration {
    /// Its name.
    pub name: &'static str,
    /// Its value where nobody sets it; its type is the parameter's.
    pub default: ParameterValue,
    /// What it is for.
    pub description: &'static str,
    /// What its values must be, in words; empty where type and range say it.
    pub constraints: String,
    /// Where a number must lie.
    pub range: Range,
    /// Whether a string also takes a number, as its text: `-p NAME:=2.2` without quotes is a number to ROS.
    pub number_as_text: bool,
}

/// Why a parameter cannot have a value.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParameterError {
    /// The node has no such parameter.
    #[error("there is no parameter {0:?}")]
    Unknown(String),
    /// A value of another type.
    #[error("{name} is {expected}, not {found}")]
    Type {
        /// The parameter.
        name: &'static str,
        /// Its type.
        expected: &'static str,
        /// The type given.
        found: &'static str,
    },
    /// A number outside its range.
    #[error("{name} must lie between {from} and {to}, not {value}")]
    Range {
        /// The parameter.
        name: &'static str,
        /// Lowest value.
        from: f64,
        /// Highest value.
        to: f64,
        /// The value given.
        value: f64,
    },
    /// A value that means nothing, or not together with another.
    #[error("{name}: {reason}")]
    Meaning {
        /// The parameter.
        name: &'static str,
        /// What is wrong.
        reason: String,
    },
}

impl Declaration {
    /// `value` as this parameter's type. An integer is taken where a number with a fraction is asked for, and a number where
    /// the declaration allows it as text.
    fn typed(&self, value: ParameterValue) -> Result<ParameterValue, ParameterError> {
        match (&self.default, value) {
            (ParameterValue::Double(_), ParameterValue::Integer(i)) => {
                Ok(ParameterValue::Double(i as f64))
            }
            (ParameterValue::String(_), ParameterValue::Double(d)) if self.number_as_text => {
                Ok(ParameterValue::String(format!("{d:?}")))
            }
            (ParameterValue::String(_), ParameterValue::Integer(i)) if self.number_as_text => {
                Ok(ParameterValue::String(format!("{:?}", i as f64)))
            }
            (default, value) if default.to_parameter_type() == value.to_parameter_type() => {
                Ok(value)
            }
            (default, value) => Err(ParameterError::Type {
                name: self.name,
                expected: type_word(default.to_parameter_type()),
                found: type_word(value.to_parameter_type()),
            }),
        }
    }

    fn check_range(&self, value: &ParameterValue) -> Result<(), ParameterError> {
        let (from, to, value) = match (self.range, value) {
            (Range::Integers(from, to), ParameterValue::Integer(i)) if *i < from || *i > to => {
                (from as f64, to as f64, *i as f64)
            }
            (Range::Doubles(from, to), ParameterValue::Double(d)) if !(*d >= from && *d <= to) => {
                (from, to, *d)
            }
            _ => return Ok(()),
        };
        Err(ParameterError::Range {
            name: self.name,
            from,
            to,
            value,
        })
    }

    /// What `ros2 param describe` shows.
    pub fn descriptor(&self) -> ParameterDescriptor {
        ParameterDescriptor {
            name: self.name.to_owned(),
            param_type: self.default.to_parameter_type(),
            description: self.description.to_owned(),
            additional_constraints: self.constraints.clone(),
            read_only: false,
            dynamic_typing: false,
            // a step of 0 is any step
            range: match self.range {
                Range::Any => NumericRange::NotSpecified,
                Range::Integers(from_value, to_value) => NumericRange::IntegerRange {
                    from_value,
                    to_value,
                    step: 0,
                },
                Range::Doubles(from_value, to_value) => NumericRange::FloatingPointRange {
                    from_value,
                    to_value,
                    step: 0.0,
                },
            },
        }
    }
}

fn type_word(kind: ParameterType) -> &'static str {
    match kind {
        ParameterType::NotSet => "nothing",
        ParameterType::Bool => "a boolean",
        ParameterType::Integer => "an integer",
        ParameterType::Double => "a double",
        ParameterType::String => "a string",
        ParameterType::ByteArray => "a list of bytes",
        ParameterType::BoolArray => "a list of booleans",
        ParameterType::IntegerArray => "a list of integers",
        ParameterType::DoubleArray => "a list of doubles",
        ParameterType::StringArray => "a list of strings",
    }
}

/// A value for every parameter, each of its declared type and within its range.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterValues {
    values: BTreeMap<&'static str, ParameterValue>,
}

impl Default for ParameterValues {
    fn default() -> Self {
        let values = declarations().into_iter().map(|d| (d.name, d.default));
        Self {
            values: values.collect(),
        }
    }
}

impl ParameterValues {
    /// Puts `value` in place of the old one.
    ///
    /// # Errors
    /// [`ParameterError`] where the name, the type or the range is wrong; nothing is changed then.
    pub fn set(&mut self, name: &str, value: ParameterValue) -> Result<(), ParameterError> {
        let declaration = declarations()
            .into_iter()
            .find(|d| d.name == name)
            .ok_or_else(|| ParameterError::Unknown(name.to_owned()))?;
        let value = declaration.typed(value)?;
        declaration.check_range(&value)?;
        self.values.insert(declaration.name, value);
        Ok(())
    }

    /// The value of a parameter.
    pub fn get(&self, name: &str) -> Option<&ParameterValue> {
        self.values.get(name)
    }

    /// Every name with its value, sorted by name.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, &ParameterValue)> {
        self.values.iter().map(|(name, value)| (*name, value))
    }
}

#[cfg(test)]
mod tests {
    use super::super::params_file::ParameterOverrides;
    use super::*;

    #[test]
    fn every_default_lies_within_its_own_range() {
        let mut values = ParameterValues::default();
        for declaration in declarations() {
            values
                .set(declaration.name, declaration.default.clone())
                .unwrap();
            assert!(!declaration.description.is_empty());
        }
        assert_eq!(values, ParameterValues::default());
    }

    #[test]
    fn the_example_file_holds_every_parameter_with_its_default() {
        let mut overrides = ParameterOverrides::default();
        let text = include_str!("../../config/ringcal.yaml");
        overrides.add_file(text).unwrap();
        let mut found = overrides.of_node("/any/ringcal");
        // an empty board_file would undo one that was given before the file
        assert!(text.contains("# board_file: "));
        let mut expected: Vec<_> = declarations()
            .into_iter()
            .filter(|d| d.name != "board_file")
            .map(|d| (d.name.to_owned(), d.default))
            .collect();
        expected.push(("use_sim_time".to_owned(), ParameterValue::Boolean(false)));
        let by_name = |list: &mut Vec<(String, _)>| list.sort_by(|a, b| a.0.cmp(&b.0));
        by_name(&mut found);
        by_name(&mut expected);
        assert_eq!(found, expected);
    }

    #[test]
    fn types_and_ranges_are_held() {
        let mut values = ParameterValues::default();
        let mut refuse = |name: &str, value| values.set(name, value).unwrap_err().to_string();
        let error = refuse("min_views", ParameterValue::Double(3.0));
        assert_eq!(error, "min_views is an integer, not a double");
        let error = refuse("jpeg_quality", ParameterValue::Integer(101));
        assert_eq!(error, "jpeg_quality must lie between 1 and 100, not 101");
        for outside in [f64::NAN, -0.1, f64::INFINITY] {
            refuse("max_motion_px", ParameterValue::Double(outside));
        }
        refuse("fixed", ParameterValue::String("k3".into()));
        let error = refuse("bord_file", ParameterValue::String(String::new()));
        assert!(error.contains("bord_file"));
        assert_eq!(values, ParameterValues::default());
    }

    #[test]
    fn an_integer_will_do_for_a_double() {
        let mut values = ParameterValues::default();
        values
            .set("max_motion_px", ParameterValue::Integer(3))
            .unwrap();
        assert_eq!(
            values.get("max_motion_px"),
            Some(&ParameterValue::Double(3.0))
        );
    }

    #[test]
    fn a_number_will_do_where_its_text_does() {
        let mut values = ParameterValues::default();
        for (number, text) in [
            (ParameterValue::Double(2.2), "2.2"),
            (ParameterValue::Integer(2), "2.0"),
            (ParameterValue::Double(f64::NAN), "NaN"),
        ] {
            values.set("response_gamma", number).unwrap();
            let text = ParameterValue::String(text.to_owned());
            assert_eq!(values.get("response_gamma"), Some(&text));
        }
        values
            .set("response_gamma", ParameterValue::Boolean(true))
            .unwrap_err();
        values
            .set("camera_name", ParameterValue::Double(2.2))
            .unwrap_err();
    }

    #[test]
    fn descriptors_carry_type_and_range() {
        let quality = declarations()
            .into_iter()
            .find(|d| d.name == "jpeg_quality")
            .unwrap();
        let descriptor = quality.descriptor();
        assert_eq!(descriptor.param_type, ParameterType::Integer);
        assert!(matches!(
            descriptor.range,
            NumericRange::IntegerRange {
                from_value: 1,
                to_value: 100,
                ..
            }
        ));
    }
}
