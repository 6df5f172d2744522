//! Parameter files and which of their values are a node's.
//!
//! The rules are rclcpp's: entries of nodes stand in the order in which their patterns first appeared, over all files and `-p`
//! arguments; a later value for the same pattern replaces the earlier one; a node takes the values of every pattern that matches
//! it, in that order, the last one winning.

use super::parameter_yaml::{ValueError, Yaml};
use ros2_client::ParameterValue;

/// The key below which a node's parameters stand.
const PARAMETERS_KEY: &str = "ros__parameters";

/// Why a parameter file cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParamsFileError {
    /// The text is not YAML.
    #[error(transparent)]
    Syntax(ValueError),
    /// Something other than a mapping where node names should stand.
    #[error("{place} must be a mapping of node names, with {PARAMETERS_KEY} below them")]
    NotAMapping {
        /// Where in the file.
        place: String,
    },
    /// Parameters outside any node.
    #[error(
        "{PARAMETERS_KEY} stands at the top of the file: it belongs below a node name such as /**"
    )]
    NoNode,
    /// A value that no parameter can have.
    #[error("parameter {name} of {node}: {source}")]
    Value {
        /// Pattern of the node.
        node: String,
        /// Name of the parameter.
        name: String,
        /// What is wrong.
        source: ValueError,
    },
}

/// Parameter values for nodes, by pattern, in the order of their first appearance.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ParameterOverrides {
    nodes: Vec<(String, Vec<(String, ParameterValue)>)>,
}

impl ParameterOverrides {
    /// Adds a value for the nodes that `pattern` matches.
    pub fn set(&mut self, pattern: &str, name: &str, value: ParameterValue) {
        let pattern = absolute(pattern);
        let at = match self.nodes.iter().position(|(known, _)| *known == pattern) {
            Some(at) => at,
            None => {
                self.nodes.push((pattern, Vec::new()));
                self.nodes.len() - 1
            }
        };
        let values = &mut self.nodes[at].1;
        match values.iter_mut().find(|(known, _)| known == name) {
            Some((_, old)) => *old = value,
            None => values.push((name.to_owned(), value)),
        }
    }

    /// Adds everything in the text of a parameter file.
    ///
    /// # Errors
    /// [`ParamsFileError`] where the text is not one; nothing is added then.
    pub fn add_file(&mut self, text: &str) -> Result<(), ParamsFileError> {
        let mut found = Self::default();
        match Yaml::parse(text).map_err(ParamsFileError::Syntax)? {
            Yaml::Null => {}
            Yaml::Mapping(entries) => found.add_names("", entries)?,
            _ => return Err(not_a_mapping("")),
        }
        for (pattern, values) in found.nodes {
            for (name, value) in values {
                self.set(&pattern, &name, value);
            }
        }
        Ok(())
    }

    /// Node names may be nested: `ns: {node: {ros__parameters: ...}}` is `/ns/node`.
    fn add_names(
        &mut self,
        prefix: &str,
        entries: Vec<(String, Yaml)>,
    ) -> Result<(), ParamsFileError> {
        for (key, below) in entries {
            if key == PARAMETERS_KEY {
                if prefix.is_empty() {
                    return Err(ParamsFileError::NoNode);
                }
                match below {
                    Yaml::Mapping(values) => self.add_values(prefix, "", values)?,
                    Yaml::Null => {}
                    _ => return Err(not_a_mapping(&format!("{prefix}/{PARAMETERS_KEY}"))),
                }
                continue;
            }
            let name = format!("{prefix}/{}", key.trim_start_matches('/'));
            match below {
                Yaml::Mapping(inner) => self.add_names(&name, inner)?,
                _ => return Err(not_a_mapping(&name)),
            }
        }
        Ok(())
    }

    /// Nested keys are joined by dots: `a: {b: 1}` is the parameter `a.b`.
    fn add_values(
        &mut self,
        pattern: &str,
        prefix: &str,
        values: Vec<(String, Yaml)>,
    ) -> Result<(), ParamsFileError> {
        for (key, value) in values {
            let name = if prefix.is_empty() {
                key
            } else {
                format!("{prefix}.{key}")
            };
            match value {
                Yaml::Mapping(inner) => self.add_values(pattern, &name, inner)?,
                value => match value.parameter() {
                    Ok(value) => self.set(pattern, &name, value),
                    Err(source) => {
                        return Err(ParamsFileError::Value {
                            node: pattern.to_owned(),
                            name,
                            source,
                        });
                    }
                },
            }
        }
        Ok(())
    }

    /// The values meant for the node of this fully qualified name, each name once.
    pub fn of_node(&self, fully_qualified: &str) -> Vec<(String, ParameterValue)> {
        let mut found: Vec<(String, ParameterValue)> = Vec::new();
        let matching = self
            .nodes
            .iter()
            .filter(|(pattern, _)| matches(pattern, fully_qualified));
        for (name, value) in matching.flat_map(|(_, values)| values) {
            match found.iter_mut().find(|(known, _)| known == name) {
                Some((_, old)) => *old = value.clone(),
                None => found.push((name.clone(), value.clone())),
            }
        }
        found
    }
}

fn not_a_mapping(place: &str) -> ParamsFileError {
    let place = if place.is_empty() { "the file" } else { place };
    ParamsFileError::NotAMapping {
        place: place.to_owned(),
    }
}

fn absolute(pattern: &str) -> String {
    format!("/{}", pattern.trim_start_matches('/'))
}

/// Whether a node's fully qualified name fits a pattern: `*` stands for one part of the name, `**` for any number of them.
fn matches(pattern: &str, fully_qualified: &str) -> bool {
    fn parts<'a>(mut pattern: impl Iterator<Item = &'a str> + Clone, name: &[&str]) -> bool {
        match pattern.next() {
            None => name.is_empty(),
            Some("**") => (0..=name.len()).any(|skip| parts(pattern.clone(), &name[skip..])),
            Some(part) => match name.split_first() {
                Some((first, rest)) => (part == "*" || part == *first) && parts(pattern, rest),
                None => false,
            },
        }
    }
    let name: Vec<&str> = fully_qualified.trim_start_matches('/').split('/').collect();
    parts(pattern.trim_start_matches('/').split('/'), &name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str, node: &str) -> Vec<(String, ParameterValue)> {
        let mut overrides = ParameterOverrides::default();
        overrides.add_file(text).unwrap();
        overrides.of_node(node)
    }

    fn one(name: &str, value: i64) -> Vec<(String, ParameterValue)> {
        vec![(name.to_owned(), ParameterValue::Integer(value))]
    }

    #[test]
    fn patterns_match_as_in_rcl() {
        for (pattern, node, expected) in [
            ("/**", "/ringcal", true),
            ("/**", "/a/b/ringcal", true),
            ("/*/ringcal", "/cam/ringcal", true),
            ("/*/ringcal", "/ringcal", false),
            ("/*/ringcal", "/a/b/ringcal", false),
            ("/**/ringcal", "/a/b/ringcal", true),
            ("/**/ringcal", "/ringcal", true),
            ("/cam/ringcal", "/cam/ringcal", true),
            ("cam/ringcal", "/cam/ringcal", true),
            ("ringcal", "/ringcal", true),
            ("ringcal", "/cam/ringcal", false),
            ("/ringcal", "/cam/ringcal", false),
            ("/*", "/ringcal", true),
            ("/other", "/ringcal", false),
        ] {
            let text = format!("\"{pattern}\": {{ros__parameters: {{a: 1}}}}");
            let expected = if expected { one("a", 1) } else { vec![] };
            assert_eq!(of(&text, node), expected, "{pattern} and {node}");
        }
    }

    #[test]
    fn namespaces_nest_and_nested_keys_are_joined_by_dots() {
        let text = "cam:\n  ringcal:\n    ros__parameters:\n      a:\n        b: 1\n";
        assert_eq!(of(text, "/cam/ringcal"), one("a.b", 1));
    }

    #[test]
    fn the_later_pattern_wins_and_a_pattern_keeps_its_place() {
        let mut overrides = ParameterOverrides::default();
        overrides
            .add_file("/**: {ros__parameters: {a: 1}}\nringcal: {ros__parameters: {a: 2}}")
            .unwrap();
        assert_eq!(overrides.of_node("/ringcal"), one("a", 2));
        // a -p argument is an entry for /**, which stood before
        overrides.set("/**", "a", ParameterValue::Integer(3));
        assert_eq!(overrides.of_node("/ringcal"), one("a", 2));
        assert_eq!(overrides.of_node("/other"), one("a", 3));
        overrides.set("/ringcal", "a", ParameterValue::Integer(4));
        assert_eq!(overrides.of_node("/ringcal"), one("a", 4));
    }

    #[test]
    fn an_argument_after_a_file_that_names_the_node_wins() {
        let mut overrides = ParameterOverrides::default();
        overrides
            .add_file("ringcal: {ros__parameters: {a: 2}}")
            .unwrap();
        overrides.set("/**", "a", ParameterValue::Integer(3));
        assert_eq!(overrides.of_node("/ringcal"), one("a", 3));
    }

    #[test]
    fn refusals_say_where() {
        let mut overrides = ParameterOverrides::default();
        let mut refuse = |text: &str| overrides.add_file(text).unwrap_err().to_string();
        assert!(refuse("ros__parameters: {a: 1}").contains("/**"));
        assert!(refuse("ringcal: 3").contains("/ringcal"));
        assert!(refuse("- 1").contains("the file"));
        assert!(refuse("ringcal: {ros__parameters: [1]}").contains("/ringcal/ros__parameters"));
        let error = refuse("ringcal: {ros__parameters: {a: {b: [1, x]}}}");
        assert!(
            error.contains("a.b") && error.contains("/ringcal"),
            "{error}"
        );
        assert!(refuse("a: [").contains("YAML"));
        assert_eq!(overrides, ParameterOverrides::default());
    }

    #[test]
    fn an_empty_file_or_node_sets_nothing() {
        assert_eq!(of("", "/ringcal"), vec![]);
        assert_eq!(of("# only a comment\n", "/ringcal"), vec![]);
        assert_eq!(of("ringcal: {ros__parameters: }", "/ringcal"), vec![]);
    }
}
