//! `--ros-args`: what rcl understands on a node's command line.
//!
//! Remapping rules, parameters and logging; pure text, nothing is read from disk here.

use super::names::{NameError, NodeIdentity};
use super::parameter_yaml::{ValueError, Yaml};
use super::remap::{RemapError, RemapRule};
use ros2_client::ParameterValue;
use std::path::PathBuf;
use tracing::Level;

/// What is wrong on the command line.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ArgumentsError {
    /// An argument outside `--ros-args` that the node does not know.
    #[error("unknown argument {0:?}: ROS arguments stand after --ros-args")]
    Unknown(String),
    /// An argument after `--ros-args` that ROS does not know.
    #[error("unknown ROS argument {0:?}")]
    UnknownRos(String),
    /// A flag at the end of the line whose value is missing.
    #[error("{0} needs a value after it")]
    MissingValue(String),
    /// A rule after `-r` that cannot be read.
    #[error("-r {rule}: {source}")]
    Remap {
        /// The rule as given.
        rule: String,
        /// What is wrong.
        source: RemapError,
    },
    /// A value after `-p` that cannot be read.
    #[error("-p {rule}: {reason}")]
    Parameter {
        /// The argument as given.
        rule: String,
        /// What is wrong.
        reason: String,
    },
    /// A level after `--log-level` that does not exist.
    #[error("--log-level {0}: a level is debug, info, warn, error or fatal")]
    LogLevel(String),
    /// The node's own name came out invalid.
    #[error(transparent)]
    Name(#[from] NameError),
}

/// One source of parameter values, in the order of the command line.
#[derive(Debug, Clone, PartialEq)]
pub enum ParameterSource {
    /// `--params-file`.
    File(PathBuf),
    /// `-p [node:]name:=value`.
    Value {
        /// Pattern of the nodes it is for.
        node: String,
        /// Name of the parameter.
        name: String,
        /// Its value.
        value: ParameterValue,
    },
}

/// The ROS part of a command line.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RosArguments {
    /// Remapping rules, in order.
    pub remaps: Vec<RemapRule>,
    /// Parameter files and values, in order.
    pub parameters: Vec<ParameterSource>,
    /// The last `--log-level` that concerns this node.
    pub log_level: Option<Level>,
    /// `--disable-rosout-logs` was given last.
    pub rosout_disabled: bool,
}

impl RosArguments {
    /// Reads the arguments that follow `ringcal node`.
    ///
    /// # Errors
    /// [`ArgumentsError`] for the first argument that cannot be used.
    pub fn parse<S: AsRef<str>>(
        arguments: impl IntoIterator<Item = S>,
    ) -> Result<Self, ArgumentsError> {
        let mut found = Self::default();
        let mut arguments = arguments.into_iter();
        let mut within = false;
        while let Some(argument) = arguments.next() {
            match (within, argument.as_ref()) {
                (_, "--ros-args") => within = true,
                (true, "--") => within = false,
                (true, flag) => {
                    let mut value = || {
                        arguments
                            .next()
                            .map(|value| value.as_ref().to_owned())
                            .ok_or_else(|| ArgumentsError::MissingValue(flag.to_owned()))
                    };
                    found.take(flag, &mut value)?;
                }
                (false, other) => return Err(ArgumentsError::Unknown(other.to_owned())),
            }
        }
        Ok(found)
    }

    /// One flag after `--ros-args`; `value` gives the argument that follows it.
    fn take(
        &mut self,
        flag: &str,
        value: &mut dyn FnMut() -> Result<String, ArgumentsError>,
    ) -> Result<(), ArgumentsError> {
        match flag {
            "-r" | "--remap" => {
                let rule = value()?;
                match rule.parse() {
                    Ok(parsed) => self.remaps.push(parsed),
                    Err(source) => return Err(ArgumentsError::Remap { rule, source }),
                }
            }
            "-p" | "--param" => self.parameters.push(parameter(&value()?)?),
            "--params-file" => self.parameters.push(ParameterSource::File(value()?.into())),
            "--log-level" => {
                if let Some(level) = log_level(&value()?)? {
                    self.log_level = Some(level);
                }
            }
            // DDS security and the C++ logging back end: accepted, as by every node, and without effect here
            "-e" | "--enclave" | "--log-config-file" => drop(value()?),
            "--enable-rosout-logs" => self.rosout_disabled = false,
            "--disable-rosout-logs" => self.rosout_disabled = true,
            "--enable-stdout-logs"
            | "--disable-stdout-logs"
            | "--enable-external-lib-logs"
            | "--disable-external-lib-logs" => {}
            other => return Err(ArgumentsError::UnknownRos(other.to_owned())),
        }
        Ok(())
    }

    /// Namespace and name of the node whose own name is `default`, in the root namespace unless remapped.
    ///
    /// # Errors
    /// [`ArgumentsError::Name`] where a rule gives an invalid name.
    pub fn node(&self, default: &str) -> Result<NodeIdentity, ArgumentsError> {
        let name = self
            .remaps
            .iter()
            .find_map(|rule| rule.node_name(default))
            .unwrap_or(default);
        let namespace = self
            .remaps
            .iter()
            .find_map(|rule| rule.namespace(name))
            .unwrap_or("/");
        Ok(NodeIdentity::new(namespace, name)?)
    }
}

/// `[node:]name:=value`, the value YAML.
fn parameter(rule: &str) -> Result<ParameterSource, ArgumentsError> {
    let refuse = |reason: String| ArgumentsError::Parameter {
        rule: rule.to_owned(),
        reason,
    };
    let (left, right) = rule
        .split_once(":=")
        .ok_or_else(|| refuse("expected name:=value".to_owned()))?;
    let (node, name) = left.split_once(':').unwrap_or(("/**", left));
    if node.is_empty() || name.is_empty() || name.contains([':', ' ', '/']) {
        return Err(refuse("expected a parameter's name before :=".to_owned()));
    }
    let value = Yaml::parse(right)
        .and_then(Yaml::parameter)
        .map_err(|error: ValueError| refuse(error.to_string()))?;
    Ok(ParameterSource::Value {
        node: node.to_owned(),
        name: name.to_owned(),
        value,
    })
}

/// `level` or `logger:=level`; `None` where the logger is another's, as there is one logger here.
fn log_level(text: &str) -> Result<Option<Level>, ArgumentsError> {
    let (logger, level) = match text.split_once(":=") {
        Some((logger, level)) => (Some(logger), level),
        None => (None, text),
    };
    let level = match level.to_ascii_lowercase().as_str() {
        "debug" => Level::DEBUG,
        "info" => Level::INFO,
        "warn" => Level::WARN,
        "error" | "fatal" => Level::ERROR,
        _ => return Err(ArgumentsError::LogLevel(text.to_owned())),
    };
    Ok(match logger {
        None | Some("ringcal") => Some(level),
        Some(_) => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(line: &str) -> Result<RosArguments, ArgumentsError> {
        RosArguments::parse(line.split_whitespace())
    }

    #[test]
    fn every_flag_of_rcl_is_known() {
        let line = "--ros-args -r a:=b --remap c:=d -p x:=1 --param y:=two --params-file f.yaml \
                    --log-level debug -e /e --enclave /e --log-config-file l --enable-rosout-logs \
                    --disable-stdout-logs --enable-external-lib-logs --disable-rosout-logs --ros-args";
        let found = parse(line).unwrap();
        assert_eq!(found.remaps.len(), 2);
        assert_eq!(found.log_level, Some(Level::DEBUG));
        assert!(found.rosout_disabled);
        assert_eq!(
            found.parameters,
            [
                ParameterSource::Value {
                    node: "/**".into(),
                    name: "x".into(),
                    value: ParameterValue::Integer(1)
                },
                ParameterSource::Value {
                    node: "/**".into(),
                    name: "y".into(),
                    value: ParameterValue::String("two".into())
                },
                ParameterSource::File("f.yaml".into()),
            ]
        );
    }

    #[test]
    fn two_dashes_end_the_ros_arguments_and_others_are_unknown() {
        assert!(parse("--ros-args -r a:=b --").is_ok());
        assert!(parse("--ros-args -r a:=b -- --ros-args -p x:=1").is_ok());
        assert!(parse("").is_ok());
        assert!(parse("--ros-args").is_ok());
        assert_eq!(
            parse("--ros-args -- -r a:=b"),
            Err(ArgumentsError::Unknown("-r".into()))
        );
        assert_eq!(
            parse("image.png"),
            Err(ArgumentsError::Unknown("image.png".into()))
        );
        assert_eq!(
            parse("--ros-args --speed 3"),
            Err(ArgumentsError::UnknownRos("--speed".into()))
        );
        assert_eq!(
            parse("--ros-args -r"),
            Err(ArgumentsError::MissingValue("-r".into()))
        );
    }

    #[test]
    fn values_are_yaml_and_refusals_name_the_argument() {
        let value = |text: &str| match RosArguments::parse(["--ros-args", "-p", text])
            .unwrap()
            .parameters
            .remove(0)
        {
            ParameterSource::Value { node, name, value } => (node, name, value),
            other => panic!("{other:?}"),
        };
        assert_eq!(value("a:='7'").2, ParameterValue::String("7".into()));
        assert_eq!(value("a:=yes").2, ParameterValue::Boolean(true));
        assert_eq!(
            value("fixed:=[k3]").2,
            ParameterValue::StringArray(vec!["k3".into()])
        );
        assert_eq!(value("ringcal:a.b:=1").0, "ringcal");
        assert_eq!(value("a:=b:=c").2, ParameterValue::String("b:=c".into()));
        for bad in ["a", "a=1", ":=1", "a:=[1", "a:=", "n:a:b:=1"] {
            let error = RosArguments::parse(["--ros-args", "-p", bad]).unwrap_err();
            assert!(error.to_string().contains(bad), "{error}");
        }
    }

    #[test]
    fn log_levels_may_name_the_logger() {
        assert_eq!(
            parse("--ros-args --log-level ringcal:=WARN")
                .unwrap()
                .log_level,
            Some(Level::WARN)
        );
        assert_eq!(
            parse("--ros-args --log-level rcl:=debug")
                .unwrap()
                .log_level,
            None
        );
        assert!(parse("--ros-args --log-level loud").is_err());
    }

    #[test]
    fn the_node_is_renamed_and_moved() {
        let node = |line: &str| {
            parse(line)
                .unwrap()
                .node("ringcal")
                .unwrap()
                .fully_qualified()
        };
        assert_eq!(node(""), "/ringcal");
        assert_eq!(
            node("--ros-args -r __node:=left -r __ns:=/cams"),
            "/cams/left"
        );
        assert_eq!(node("--ros-args -r __name:=left"), "/left");
        // the first rule wins; a rule for another node is not ours
        assert_eq!(node("--ros-args -r __node:=a -r __node:=b"), "/a");
        assert_eq!(
            node("--ros-args -r other:__node:=a -r ringcal:__ns:=/x"),
            "/x/ringcal"
        );
        // the namespace rule looks at the new name
        assert_eq!(
            node("--ros-args -r __node:=a -r ringcal:__ns:=/x -r a:__ns:=/y"),
            "/y/a"
        );
        assert!(parse("--ros-args -r __node:=a/b").is_err());
    }
}
