//! Ctrl-C while frames are read: the first ends the reading, the second the process.

use signal_hook::consts::SIGINT;
use signal_hook::flag::{register, register_conditional_shutdown};
use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Exit code of a process that is ended by Ctrl-C, as shells have it.
const INTERRUPTED: i32 = 130;

/// A flag that the first Ctrl-C raises.
///
/// # Errors
/// Where the handlers cannot be installed.
pub fn stop_flag() -> io::Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    // in this order: the first signal finds the flag down and raises it
    register_conditional_shutdown(SIGINT, INTERRUPTED, Arc::clone(&stop))?;
    register(SIGINT, Arc::clone(&stop))?;
    Ok(stop)
}
