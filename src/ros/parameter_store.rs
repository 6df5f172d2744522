//! The parameters as the parameter services see them: values, descriptions, and changes that are checked before they count.

use super::calibrator::Configuration;
use super::declarations::declarations;
use super::parameters::{Declaration, ParameterValues};
use super::settings::Settings;
use crate::board::Board;
use ros2_client::ParameterValue;
use ros2_client::parameters::{
    NumericRange, Parameter, ParameterDescriptor, ParameterType, SetParametersResult,
};
use ros2_client::rcl_interfaces::ListParametersResult;
use std::path::Path;

/// The parameter that every ROS node has.
const USE_SIM_TIME: &str = "use_sim_time";

/// Reads a board file: from disk in the node, from memory in tests.
pub type ReadBoard = dyn Fn(&Path) -> Result<Board, String> + Send;

/// The parameters of the running node.
pub struct ParameterStore {
    declarations: Vec<Declaration>,
    values: ParameterValues,
    use_sim_time: bool,
    configuration: Configuration,
    read_board: Box<ReadBoard>,
}

impl ParameterStore {
    /// The declared parameters with `overrides` in place of their defaults. Names that are not declared are handed to
    /// `unknown` and otherwise left alone, as by rclcpp.
    ///
    /// # Errors
    /// A sentence that names the parameter and the reason.
    pub fn new(
        overrides: Vec<(String, ParameterValue)>,
        read_board: Box<ReadBoard>,
        mut unknown: impl FnMut(&str),
    ) -> Result<Self, String> {
        let declarations = declarations();
        let mut values = ParameterValues::default();
        let mut use_sim_time = false;
        for (name, value) in overrides {
            if name == USE_SIM_TIME {
                use_sim_time = boolean(&value)?;
            } else if declarations.iter().any(|d| d.name == name) {
                values.set(&name, value).map_err(|e| e.to_string())?;
            } else {
                unknown(&name);
            }
        }
        let settings = Settings::of(&values).map_err(|e| e.to_string())?;
        let board = read_board(&settings.board_file)?;
        Ok(Self {
            declarations,
            values,
            use_sim_time,
            configuration: Configuration { settings, board },
            read_board,
        })
    }

    /// What the parameters amount to.
    pub fn configuration(&self) -> &Configuration {
        &self.configuration
    }

    /// Every parameter with its value, sorted by name.
    pub fn all(&self) -> Vec<Parameter> {
        self.names()
            .into_iter()
            .map(|name| Parameter {
                value: self.get(&name),
                name,
            })
            .collect()
    }

    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = self
            .values
            .iter()
            .map(|(name, _)| name.to_owned())
            .collect();
        names.push(USE_SIM_TIME.to_owned());
        names.sort();
        names
    }

    /// The value of a parameter; not set where there is none of that name.
    pub fn get(&self, name: &str) -> ParameterValue {
        if name == USE_SIM_TIME {
            return ParameterValue::Boolean(self.use_sim_time);
        }
        self.values
            .get(name)
            .cloned()
            .unwrap_or(ParameterValue::NotSet)
    }

    /// What a parameter is for.
    pub fn describe(&self, name: &str) -> ParameterDescriptor {
        if name == USE_SIM_TIME {
            return ParameterDescriptor {
                name: name.to_owned(),
                param_type: ParameterType::Bool,
                description: "Part of every ROS node. Nothing here depends on the time of day: all stamps are those of \
                              the frames."
                    .to_owned(),
                additional_constraints: String::new(),
                read_only: false,
                dynamic_typing: false,
                range: NumericRange::NotSpecified,
            };
        }
        match self.declarations.iter().find(|d| d.name == name) {
            Some(declaration) => declaration.descriptor(),
            None => ParameterDescriptor::unknown(name),
        }
    }

    /// The names that equal a prefix, or all. No name here has a dot in it, so depth and separate prefixes play no part.
    pub fn list(&self, prefixes: &[String]) -> ListParametersResult {
        let wanted = |name: &String| prefixes.is_empty() || prefixes.contains(name);
        ListParametersResult {
            names: self.names().into_iter().filter(wanted).collect(),
            prefixes: Vec::new(),
        }
    }

    /// Sets all of `parameters` or, where one is refused, none. Answers with the values as they were taken.
    ///
    /// # Errors
    /// A sentence that names the parameter and the reason.
    pub fn set(&mut self, parameters: Vec<Parameter>) -> Result<Vec<Parameter>, String> {
        let mut values = self.values.clone();
        let mut use_sim_time = self.use_sim_time;
        let mut read_board_again = false;
        let mut names = Vec::new();
        for Parameter { name, value } in parameters {
            if matches!(value, ParameterValue::NotSet) {
                return Err(format!("{name} is declared and cannot be removed"));
            }
            if name == USE_SIM_TIME {
                use_sim_time = boolean(&value)?;
            } else {
                values.set(&name, value).map_err(|e| e.to_string())?;
            }
            // the same path again: the file may have changed
            read_board_again |= name == "board_file";
            names.push(name);
        }
        let settings = Settings::of(&values).map_err(|e| e.to_string())?;
        let board = if read_board_again {
            (self.read_board)(&settings.board_file)?
        } else {
            self.configuration.board.clone()
        };
        self.values = values;
        self.use_sim_time = use_sim_time;
        self.configuration = Configuration { settings, board };
        let taken = names.into_iter().map(|name| Parameter {
            value: self.get(&name),
            name,
        });
        Ok(taken.collect())
    }

    /// As [`ParameterStore::set`], one after the other, each on its own.
    pub fn set_each(
        &mut self,
        parameters: Vec<Parameter>,
    ) -> (Vec<SetParametersResult>, Vec<Parameter>) {
        let mut taken = Vec::new();
        let results = parameters.into_iter().map(|parameter| {
            taken.extend(self.set(vec![parameter])?);
            Ok(())
        });
        (results.collect(), taken)
    }
}

fn boolean(value: &ParameterValue) -> Result<bool, String> {
    match value {
        ParameterValue::Boolean(value) => Ok(*value),
        _ => Err(format!("{USE_SIM_TIME} is a boolean")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::Polarity;

    fn board(path: &Path) -> Result<Board, String> {
        match path.to_str() {
            Some("/c4.yaml") => {
                Ok(Board::new(7, 7, 0.03, 0.003, 0.006, Polarity::DarkOnLight).unwrap())
            }
            Some("/c5.yaml") => {
                Ok(Board::new(5, 6, 0.03, 0.003, 0.006, Polarity::DarkOnLight).unwrap())
            }
            _ => Err(format!("cannot read {}", path.display())),
        }
    }

    fn parameter(name: &str, value: ParameterValue) -> Parameter {
        Parameter {
            name: name.to_owned(),
            value,
        }
    }

    fn word(text: &str) -> ParameterValue {
        ParameterValue::String(text.to_owned())
    }

    fn store() -> ParameterStore {
        let overrides = vec![("board_file".to_owned(), word("/c4.yaml"))];
        ParameterStore::new(overrides, Box::new(board), |name| panic!("{name}")).unwrap()
    }

    #[test]
    fn a_node_without_a_board_does_not_start() {
        let start = |overrides| ParameterStore::new(overrides, Box::new(board), |_| {}).err();
        assert!(start(vec![]).unwrap().contains("board_file"));
        let missing = vec![("board_file".to_owned(), word("/none.yaml"))];
        assert!(start(missing).unwrap().contains("/none.yaml"));
    }

    #[test]
    fn unknown_overrides_are_reported_and_left_alone() {
        let mut unknown = Vec::new();
        let overrides = vec![
            ("board_file".to_owned(), word("/c4.yaml")),
            ("bord_file".to_owned(), word("x")),
            ("use_sim_time".to_owned(), ParameterValue::Boolean(true)),
        ];
        let store = ParameterStore::new(overrides, Box::new(board), |name| {
            unknown.push(name.to_owned());
        })
        .unwrap();
        assert_eq!(unknown, ["bord_file"]);
        assert_eq!(store.get("bord_file"), ParameterValue::NotSet);
        assert_eq!(store.get("use_sim_time"), ParameterValue::Boolean(true));
    }

    #[test]
    fn a_refused_change_leaves_everything_as_it_was() {
        let mut store = store();
        let before = store
            .all()
            .iter()
            .map(|p| p.value.clone())
            .collect::<Vec<_>>();
        for (name, value) in [
            ("board_file", word("/none.yaml")),
            ("estimator", word("best")),
            ("min_views", ParameterValue::Integer(100)),
            ("jpeg_quality", ParameterValue::NotSet),
            ("use_sim_time", ParameterValue::Integer(1)),
            ("nothing", ParameterValue::Integer(1)),
        ] {
            let fine = parameter("camera_name", word("left"));
            let error = store.set(vec![fine, parameter(name, value)]).unwrap_err();
            assert!(!error.is_empty());
            let after = store
                .all()
                .iter()
                .map(|p| p.value.clone())
                .collect::<Vec<_>>();
            assert_eq!(before, after, "{name}");
        }
    }

    #[test]
    fn changes_reach_the_configuration() {
        let mut store = store();
        let taken = store
            .set(vec![
                parameter("board_file", word("/c5.yaml")),
                parameter("max_motion_px", ParameterValue::Integer(3)),
            ])
            .unwrap();
        assert_eq!(taken[1].value, ParameterValue::Double(3.0));
        assert_eq!(store.configuration().board.columns(), 6);
        assert_eq!(
            store.configuration().settings.rules.max_motion_px,
            Some(3.0)
        );
    }

    #[test]
    fn changes_one_by_one_are_refused_one_by_one() {
        let mut store = store();
        let (results, taken) = store.set_each(vec![
            parameter("estimator", word("best")),
            parameter("camera_name", word("left")),
        ]);
        assert!(results[0].is_err() && results[1].is_ok());
        assert_eq!(taken.len(), 1);
        assert_eq!(store.get("camera_name"), word("left"));
    }

    #[test]
    fn lists_and_descriptions_cover_every_parameter() {
        let store = store();
        let names = store.list(&[]).names;
        assert_eq!(names.len(), declarations().len() + 1);
        assert!(names.is_sorted());
        for name in &names {
            let descriptor = store.describe(name);
            assert_eq!(descriptor.param_type, store.get(name).to_parameter_type());
            assert!(!descriptor.description.is_empty());
        }
        assert_eq!(store.list(&["estimator".to_owned()]).names, ["estimator"]);
        assert_eq!(store.describe("none").param_type, ParameterType::NotSet);
    }
}
