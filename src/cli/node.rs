//! `ringcal node`: the ROS 2 node.

use crate::ros::{self, NodeError};
use clap::error::ErrorKind;

/// Arguments of `ringcal node`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
ROS arguments:
  -r, --remap [NODE:]FROM:=TO     rename a topic, a service, __node or __ns
  -p, --param [NODE:]NAME:=VALUE  set a parameter; board_file is required
      --params-file FILE          set the parameters of a file, see config/ringcal.yaml
      --log-level LEVEL           debug, info, warn, error or fatal
      --                          ends the ROS arguments")]
pub struct Arguments {
    /// `--ros-args` and what follows it
    #[arg(
        value_name = "--ros-args ...",
        trailing_var_arg = true,
        allow_hyphen_values = true
    )]
    arguments: Vec<String>,
}

/// Runs the node until Ctrl-C or SIGTERM.
pub fn run(arguments: Arguments) -> anyhow::Result<()> {
    ros::run(arguments.arguments).map_err(|error| match error {
        // wrong usage has an exit code of its own
        NodeError::Arguments(error) => {
            clap::Error::raw(ErrorKind::InvalidValue, format!("{error}\n")).into()
        }
        other => other.into(),
    })
}
