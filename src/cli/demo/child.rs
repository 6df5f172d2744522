//! The node's process: started with the board file and nothing else, ended whatever happens.

use anyhow::Context;
use std::net::UdpSocket;
use std::process::{Child, Command};
use tempfile::TempDir;

/// Domains whose ports lie below the ephemeral ones of Linux.
const DOMAINS: u16 = 101;

/// A DDS domain in which nobody on this machine takes part, so that the demonstration is heard by nobody and hears nobody.
pub fn free_domain() -> Option<u16> {
    let first = u16::try_from(std::process::id() % u32::from(DOMAINS)).ok()?;
    let domains = (0..DOMAINS).map(|step| 1 + (first + step) % DOMAINS);
    // the port of the first participant's discovery, as DDS counts ports
    domains
        .into_iter()
        .find(|domain| UdpSocket::bind(("0.0.0.0", 7400 + 250 * domain + 10)).is_ok())
}

/// The running node.
pub struct NodeProcess {
    child: Child,
    /// Holds the board file.
    _folder: TempDir,
}

impl NodeProcess {
    /// Starts this program as `ringcal node` with a board file of this text.
    pub fn start(board: &str, domain: u16) -> anyhow::Result<Self> {
        let folder = tempfile::tempdir().context("a folder for the board file")?;
        let board_file = folder.path().join("board.yaml");
        std::fs::write(&board_file, board).context("the board file")?;
        let program = std::env::current_exe().context("the path of this program")?;
        let child = Command::new(program)
            .args(["node", "--ros-args", "--log-level", "warn", "-p"])
            .arg(format!("board_file:='{}'", board_file.display()))
            .env("ROS_DOMAIN_ID", domain.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .env_remove("ROS_LOCALHOST_ONLY")
            .spawn()
            .context("cannot start the node")?;
        Ok(Self {
            child,
            _folder: folder,
        })
    }

    /// Why something went wrong: that the node has ended, where it has.
    pub fn reason_for(&mut self, error: impl Into<anyhow::Error>) -> anyhow::Error {
        let error = error.into();
        match self.child.try_wait() {
            Ok(Some(status)) => error.context(format!("the node has ended with {status}")),
            _ => error,
        }
    }

    /// Ends the node.
    pub fn end(&mut self) -> anyhow::Result<()> {
        if self.child.try_wait()?.is_none() {
            self.child.kill().context("cannot end the node")?;
        }
        self.child.wait().context("the node's end")?;
        Ok(())
    }
}

impl Drop for NodeProcess {
    fn drop(&mut self) {
        // after end() there is nothing left to do
        let _ = self.end();
    }
}
