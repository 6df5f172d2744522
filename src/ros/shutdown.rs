//! Ctrl-C and SIGTERM: the first asks the node to leave, the second ends the process at once.

use futures::channel::oneshot;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Exit code where the node was not given the time to leave.
const IMPATIENT: i32 = 130;

/// A future that is done when the process is asked to end.
///
/// # Errors
/// Where the handlers cannot be installed.
pub fn asked_to_end() -> io::Result<oneshot::Receiver<()>> {
    let asked = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // in this order: the first signal finds the flag down and raises it
        signal_hook::flag::register_conditional_shutdown(signal, IMPATIENT, Arc::clone(&asked))?;
        signal_hook::flag::register(signal, Arc::clone(&asked))?;
    }
    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    let (sender, receiver) = oneshot::channel();
    std::thread::Builder::new()
        .name("signals".to_owned())
        .spawn(move || {
            signals.forever().next();
            // nobody waits any more where the node has ended by itself
            let _ = sender.send(());
        })?;
    Ok(receiver)
}
