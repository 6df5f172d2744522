//! Logs: tracing events of this crate go to stderr and, once the node is there, to /rosout.

use ros2_client::builtin_interfaces::Time;
use ros2_client::{Log, Publisher};
use std::fmt::{self, Write};
use std::io::IsTerminal;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tracing::field::{Field, Visit};
use tracing::{Event, Level, Subscriber};
use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::{Context, Layer, SubscriberExt};
use tracing_subscriber::util::SubscriberInitExt;

/// Where the layer finds the publisher of /rosout; empty before the node is there and after it has left.
#[derive(Clone, Default)]
pub struct Rosout {
    outlet: Arc<Mutex<Option<Outlet>>>,
}

struct Outlet {
    /// The node's name with dots for slashes.
    logger: String,
    publisher: Publisher<Log>,
}

impl Rosout {
    /// From now on events go out under the node's logger name.
    pub fn open(&self, node: &str, publisher: Publisher<Log>) {
        let logger = node.trim_start_matches('/').replace('/', ".");
        *self.lock() = Some(Outlet { logger, publisher });
    }

    /// Gives the publisher up, so that the node can leave.
    pub fn close(&self) {
        *self.lock() = None;
    }

    fn lock(&self) -> MutexGuard<'_, Option<Outlet>> {
        self.outlet.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Starts logging events of this crate from `level` on; to be called once.
pub fn start(level: Level) -> Rosout {
    let rosout = Rosout::default();
    let ours = || Targets::new().with_target("ringcal", level);
    let stderr = tracing_subscriber::fmt::layer()
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .with_target(false);
    // where a program that uses the library logs already, its choice stands
    let _ = tracing_subscriber::registry()
        .with(stderr.with_filter(ours()))
        .with(RosoutLayer(rosout.clone()).with_filter(ours()))
        .try_init();
    rosout
}

struct RosoutLayer(Rosout);

impl<S: Subscriber> Layer<S> for RosoutLayer {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let outlet = self.0.lock();
        let Some(Outlet { logger, publisher }) = outlet.as_ref() else {
            return;
        };
        let mut text = Text::default();
        event.record(&mut text);
        let origin = event.metadata();
        // a log that cannot be sent has been written to stderr all the same
        let _ = publisher.publish(Log {
            stamp: Time::now(),
            level: severity(*origin.level()),
            name: logger.clone(),
            msg: text.0,
            file: origin.file().unwrap_or_default().to_owned(),
            function: origin.target().to_owned(),
            line: origin.line().unwrap_or_default(),
        });
    }
}

/// The number rcl_interfaces/msg/Log has for a level.
fn severity(level: Level) -> u8 {
    match level {
        Level::ERROR => Log::ERROR,
        Level::WARN => Log::WARN,
        Level::INFO => Log::INFO,
        _ => Log::DEBUG,
    }
}

/// The message of an event, its other fields behind it as `name=value`.
#[derive(Default)]
struct Text(String);

impl Visit for Text {
    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        // writing to a String does not fail
        let _ = if field.name() == "message" {
            self.0.insert_str(0, &format!("{value:?}"));
            Ok(())
        } else {
            write!(self.0, " {}={value:?}", field.name())
        };
    }
}
