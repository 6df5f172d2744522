//! The ROS 2 node.
//!
//! Without DDS, and tested so:
//! - what the command line asks for: `arguments`, `remap`, `names`, `params_file`, `parameter_yaml`;
//! - the parameters: `declarations`, `parameters`, `settings`, `parameter_store`;
//! - what waits for the worker (`inbox`), what the node knows and says (`calibrator`, `job`), what it writes (`save`);
//! - the messages: `messages`, `camera_info`, `pictures`.
//!
//! With DDS: `start` joins the `network` and leaves it again on `shutdown`; `node` serves topics and services
//! (`publishers`, `parameter_services`, `qos`); `worker` looks at the frames on a thread of its own; `logging` goes to
//! stderr and /rosout. `client` is the other side: a camera and its user.

pub mod arguments;
mod calibrator;
mod camera_info;
pub mod client;
pub mod declarations;
mod inbox;
mod job;
mod logging;
pub mod messages;
pub mod names;
pub mod network;
pub mod newcomer;
mod node;
mod parameter_services;
mod parameter_store;
mod parameter_yaml;
pub mod parameters;
pub mod params_file;
mod pictures;
mod publishers;
mod qos;
pub mod remap;
mod save;
mod settings;
mod shutdown;
mod start;
mod worker;

pub use start::{NodeError, run};
