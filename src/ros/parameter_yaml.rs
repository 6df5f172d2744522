//! YAML as rcl reads it: YAML 1.1 scalars typed as ROS parameters.
//!
//! `yes`, `no`, `on` and `off` are booleans, `0x10` is 16, quoted values are strings, and the elements of a sequence are of one
//! type.

use ros2_client::ParameterValue;
use serde::de::{Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use std::fmt;

/// Why a piece of YAML is not a parameter.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ValueError {
    /// The text is not YAML.
    #[error("not YAML: {0}")]
    Syntax(String),
    /// Nothing stands where a value should.
    #[error("it has no value")]
    Missing,
    /// A mapping where one value should stand.
    #[error("it is a mapping, not a value")]
    Mapping,
    /// A sequence within a sequence, or elements of more than one type.
    #[error("the elements of a list must be single values of one type")]
    Mixed,
}

/// A YAML node; the keys of mappings in the order of the text.
#[derive(Debug, Clone, PartialEq)]
pub enum Yaml {
    /// Nothing.
    Null,
    /// A boolean, YAML 1.1.
    Bool(bool),
    /// An integer that fits 64 bits.
    Integer(i64),
    /// Any other number.
    Double(f64),
    /// Text.
    String(String),
    /// A sequence.
    Sequence(Vec<Yaml>),
    /// A mapping.
    Mapping(Vec<(String, Yaml)>),
}

impl Yaml {
    /// Reads one document.
    ///
    /// # Errors
    /// [`ValueError::Syntax`] with the place in the text.
    pub fn parse(text: &str) -> Result<Self, ValueError> {
        let options = serde_saphyr::options! {
            // rcl reads numbers with strtoll in base 0 and strtod
            legacy_octal_numbers: true,
            underscored_numbers_as_strings: true,
            non_finite_float_policy: serde_saphyr::options::NonFiniteFloatPolicy::PassThrough,
            with_snippet: false,
        };
        if text.trim().is_empty() {
            return Ok(Self::Null);
        }
        serde_saphyr::from_str_with_options(text, options)
            .map_err(|e| ValueError::Syntax(e.to_string()))
    }

    /// The value as a ROS parameter; an empty sequence is taken for a list of strings.
    ///
    /// # Errors
    /// [`ValueError`] where it is not one of the types that parameters have.
    pub fn parameter(self) -> Result<ParameterValue, ValueError> {
        Ok(match self {
            Self::Null => return Err(ValueError::Missing),
            Self::Mapping(_) => return Err(ValueError::Mapping),
            Self::Bool(b) => ParameterValue::Boolean(b),
            Self::Integer(i) => ParameterValue::Integer(i),
            Self::Double(d) => ParameterValue::Double(d),
            Self::String(s) => ParameterValue::String(s),
            Self::Sequence(elements) => list(elements)?,
        })
    }
}

/// A list parameter of the type of its first element.
fn list(elements: Vec<Yaml>) -> Result<ParameterValue, ValueError> {
    fn all<T>(elements: Vec<Yaml>, pick: impl Fn(Yaml) -> Option<T>) -> Result<Vec<T>, ValueError> {
        elements
            .into_iter()
            .map(|e| pick(e).ok_or(ValueError::Mixed))
            .collect()
    }
    Ok(match elements.first() {
        None => ParameterValue::StringArray(Vec::new()),
        Some(Yaml::Bool(_)) => ParameterValue::BooleanArray(all(elements, |e| match e {
            Yaml::Bool(b) => Some(b),
            _ => None,
        })?),
        Some(Yaml::Integer(_)) => ParameterValue::IntegerArray(all(elements, |e| match e {
            Yaml::Integer(i) => Some(i),
            _ => None,
        })?),
        Some(Yaml::Double(_)) => ParameterValue::DoubleArray(all(elements, |e| match e {
            Yaml::Double(d) => Some(d),
            _ => None,
        })?),
        Some(Yaml::String(_)) => ParameterValue::StringArray(all(elements, |e| match e {
            Yaml::String(s) => Some(s),
            _ => None,
        })?),
        Some(Yaml::Null | Yaml::Sequence(_) | Yaml::Mapping(_)) => return Err(ValueError::Mixed),
    })
}

impl<'de> Deserialize<'de> for Yaml {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(YamlVisitor)
    }
}

struct YamlVisitor;

impl<'de> Visitor<'de> for YamlVisitor {
    type Value = Yaml;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a YAML node")
    }

    fn visit_bool<E>(self, value: bool) -> Result<Yaml, E> {
        Ok(Yaml::Bool(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Yaml, E> {
        Ok(Yaml::Integer(value))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Yaml, E> {
        // what does not fit an integer is a double, as where strtoll fails and strtod succeeds
        Ok(i64::try_from(value).map_or(Yaml::Double(value as f64), Yaml::Integer))
    }

    fn visit_i128<E>(self, value: i128) -> Result<Yaml, E> {
        Ok(i64::try_from(value).map_or(Yaml::Double(value as f64), Yaml::Integer))
    }

    fn visit_u128<E>(self, value: u128) -> Result<Yaml, E> {
        Ok(i64::try_from(value).map_or(Yaml::Double(value as f64), Yaml::Integer))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Yaml, E> {
        Ok(Yaml::Double(value))
    }

    fn visit_str<E>(self, value: &str) -> Result<Yaml, E> {
        Ok(Yaml::String(value.to_owned()))
    }

    fn visit_unit<E>(self) -> Result<Yaml, E> {
        Ok(Yaml::Null)
    }

    fn visit_none<E>(self) -> Result<Yaml, E> {
        Ok(Yaml::Null)
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<Yaml, D::Error> {
        Yaml::deserialize(deserializer)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut access: A) -> Result<Yaml, A::Error> {
        let mut elements = Vec::new();
        while let Some(element) = access.next_element()? {
            elements.push(element);
        }
        Ok(Yaml::Sequence(elements))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut access: A) -> Result<Yaml, A::Error> {
        let mut entries = Vec::new();
        while let Some(entry) = access.next_entry()? {
            entries.push(entry);
        }
        Ok(Yaml::Mapping(entries))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> ParameterValue {
        Yaml::parse(text).and_then(Yaml::parameter).unwrap()
    }

    #[test]
    fn scalars_are_typed_as_rcl_types_them() {
        for text in ["true", "True", "TRUE", "yes", "Yes", "on", "ON"] {
            assert_eq!(value(text), ParameterValue::Boolean(true), "{text}");
        }
        for text in ["false", "no", "NO", "off", "Off"] {
            assert_eq!(value(text), ParameterValue::Boolean(false), "{text}");
        }
        for (text, expected) in [
            ("7", 7),
            ("-3", -3),
            ("+5", 5),
            ("0x10", 16),
            ("010", 8),
            ("0", 0),
        ] {
            assert_eq!(value(text), ParameterValue::Integer(expected), "{text}");
        }
        for (text, expected) in [
            ("1.5", 1.5),
            ("1e3", 1000.0),
            (".5", 0.5),
            ("2.", 2.0),
            (".inf", f64::INFINITY),
            ("-.inf", f64::NEG_INFINITY),
            ("99999999999999999999", 1e20),
        ] {
            assert_eq!(value(text), ParameterValue::Double(expected), "{text}");
        }
        assert!(matches!(value(".nan"), ParameterValue::Double(d) if d.is_nan()));
        for (text, expected) in [
            ("cross", "cross"),
            ("\"7\"", "7"),
            ("'yes'", "yes"),
            ("/a/b.yaml", "/a/b.yaml"),
            ("1_000", "1_000"),
            ("''", ""),
            ("a b", "a b"),
        ] {
            assert_eq!(
                value(text),
                ParameterValue::String(expected.into()),
                "{text}"
            );
        }
    }

    #[test]
    fn lists_are_of_one_type() {
        assert_eq!(
            value("[k3, cx]"),
            ParameterValue::StringArray(vec!["k3".into(), "cx".into()])
        );
        assert_eq!(value("[1, 2]"), ParameterValue::IntegerArray(vec![1, 2]));
        assert_eq!(
            value("[1.0, 2.5]"),
            ParameterValue::DoubleArray(vec![1.0, 2.5])
        );
        assert_eq!(
            value("[yes, off]"),
            ParameterValue::BooleanArray(vec![true, false])
        );
        assert_eq!(value("[]"), ParameterValue::StringArray(vec![]));
        for text in ["[1, a]", "[1, 2.0]", "[[1]]", "[{a: 1}]"] {
            let refused = Yaml::parse(text).and_then(Yaml::parameter);
            assert_eq!(refused, Err(ValueError::Mixed), "{text}");
        }
    }

    #[test]
    fn what_is_no_value_is_refused() {
        assert_eq!(
            Yaml::parse("").and_then(Yaml::parameter),
            Err(ValueError::Missing)
        );
        assert_eq!(
            Yaml::parse("{a: 1}").and_then(Yaml::parameter),
            Err(ValueError::Mapping)
        );
        assert!(matches!(Yaml::parse("[1"), Err(ValueError::Syntax(_))));
    }
}
