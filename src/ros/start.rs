//! Starting the node: command line, environment, parameters, joining; and leaving in order.

use super::arguments::{ArgumentsError, ParameterSource, RosArguments};
use super::logging::{self, Rosout};
use super::network::{EnvironmentError, Network};
use super::newcomer::Newcomer;
use super::node::serve;
use super::parameter_store::ParameterStore;
use super::params_file::ParameterOverrides;
use super::publishers::{EntityError, dds_name};
use super::qos;
use super::remap::Names;
use super::shutdown::asked_to_end;
use crate::board::Board;
use crate::source;
use ros2_client::{CreateError, MessageTypeName, NodeCreateError, NodeName, NodeOptions};
use std::path::{Path, PathBuf};
use tracing::Level;

/// The node's name where nobody gives another.
const DEFAULT_NAME: &str = "ringcal";

/// Why the node does not start, or had to end.
#[derive(Debug, thiserror::Error)]
pub enum NodeError {
    /// The command line.
    #[error(transparent)]
    Arguments(#[from] ArgumentsError),
    /// A parameter file.
    #[error("--params-file {path}: {reason}", path = path.display())]
    ParamsFile {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A parameter.
    #[error("{0}")]
    Parameter(String),
    /// An environment variable.
    #[error(transparent)]
    Environment(#[from] EnvironmentError),
    /// A topic or service.
    #[error(transparent)]
    Entity(#[from] EntityError),
    /// DDS does not start.
    #[error("DDS: {0}")]
    Dds(#[from] CreateError),
    /// ros2-client does not make the node.
    #[error("{0}")]
    Node(#[from] NodeCreateError),
    /// The name, which rcl takes and ros2-client does not.
    #[error("node name {name}: {source}")]
    NodeName {
        /// The name.
        name: String,
        /// What ros2-client says.
        source: ros2_client::names::NameError,
    },
    /// Threads or signal handlers.
    #[error("the operating system refuses: {0}")]
    System(#[from] std::io::Error),
    /// The worker ended without being told to.
    #[error("the worker ended by itself; please report this as a bug")]
    Worker,
}

/// Runs the node with the arguments that follow `ringcal node` until SIGINT or SIGTERM.
///
/// # Errors
/// [`NodeError`] where it cannot start.
pub fn run<S: AsRef<str>>(arguments: impl IntoIterator<Item = S>) -> Result<(), NodeError> {
    let arguments = RosArguments::parse(arguments)?;
    let names = Names::new(arguments.node(DEFAULT_NAME)?, arguments.remaps.clone());
    let overrides = overrides(&arguments.parameters)?;
    let network = Network::from_environment(|name| std::env::var(name).ok())?;
    let rosout = logging::start(arguments.log_level.unwrap_or(Level::INFO));
    let of_node = overrides.of_node(&names.node().fully_qualified());
    let store = ParameterStore::new(of_node, Box::new(read_board), |name| {
        tracing::warn!("there is no parameter {name:?}: it is ignored");
    })
    .map_err(NodeError::Parameter)?;
    let asked_to_end = asked_to_end()?;
    let (context, mut manners) = network.join()?;
    manners.wait();
    let node = context.new_node(node_name(&names)?, options(&store))?;
    let mut node = Newcomer::new(node, manners);
    if !arguments.rosout_disabled {
        open_rosout(&mut node, &rosout)?;
    }
    let ended = serve(&context, &mut node, &names, store, asked_to_end);
    // The order matters: while anything is left that writes or reads, the node stays in the graph. serve() has
    // dropped the rest.
    rosout.close();
    drop(node);
    drop(context);
    ended
}

fn node_name(names: &Names) -> Result<NodeName, NodeError> {
    let node = names.node();
    NodeName::new(node.namespace(), node.name()).map_err(|source| NodeError::NodeName {
        name: node.fully_qualified(),
        source,
    })
}

/// ros2-client keeps the values too, for /parameter_events; it answers no services, see `parameter_services`.
fn options(store: &ParameterStore) -> NodeOptions {
    let options = NodeOptions::new()
        .enable_rosout(false)
        .start_parameter_services(false);
    store.all().into_iter().fold(options, |options, parameter| {
        options.declare_parameter(&parameter.name, parameter.value)
    })
}

fn overrides(sources: &[ParameterSource]) -> Result<ParameterOverrides, NodeError> {
    let mut overrides = ParameterOverrides::default();
    for source in sources {
        match source {
            ParameterSource::Value { node, name, value } => {
                overrides.set(node, name, value.clone());
            }
            ParameterSource::File(path) => {
                let refuse = |reason: String| NodeError::ParamsFile {
                    path: path.clone(),
                    reason,
                };
                let text = std::fs::read_to_string(path).map_err(|e| refuse(e.to_string()))?;
                overrides
                    .add_file(&text)
                    .map_err(|e| refuse(e.to_string()))?;
            }
        }
    }
    Ok(overrides)
}

fn read_board(path: &Path) -> Result<Board, String> {
    source::read_board(path).map_err(|error| error.to_string())
}

fn open_rosout(newcomer: &mut Newcomer, rosout: &Rosout) -> Result<(), NodeError> {
    let kind = MessageTypeName::new("rcl_interfaces", "Log");
    let node = newcomer.node();
    let topic = node.create_topic(&dds_name("/rosout")?, kind, &qos::rosout())?;
    let publisher = node.create_publisher(&topic, Some(qos::rosout()))?;
    rosout.open(&node.fully_qualified_name(), publisher);
    Ok(())
}
