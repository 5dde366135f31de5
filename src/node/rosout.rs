//! `/rosout`: the lines of the log as messages, as every ROS node tells them.
//!
//! The log may be written by any thread and must never wait, so lines pass through a bounded queue;
//! what does not fit is left out here and stands on stderr all the same.

use std::fmt::{self, Write};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};
use tracing::field::{Field, Visit};
use tracing::{Event, Level, Subscriber};
use tracing_subscriber::Layer;
use tracing_subscriber::layer::Context;

use super::complaints::Complaints;
use super::dds::{DdsError, Publisher, Ros};
use crate::messages::Time;

/// Lines that wait for the loop.
const LINES: usize = 256;
/// The tracing targets of carom itself: what libraries say is not this node's.
const OWN: &str = "carom";

/// rcl_interfaces/msg/Log
#[derive(Clone, Debug, Serialize, Deserialize)]
#[allow(missing_docs, reason = "as in its .msg file")]
pub struct Log {
    pub stamp: Time,
    pub level: u8,
    pub name: String,
    pub msg: String,
    pub file: String,
    pub function: String,
    pub line: u32,
}

/// A part of the log that passes its lines on.
pub struct Tap(SyncSender<Log>);

/// The other end of a tap.
pub struct Lines(Receiver<Log>);

/// A tap for the log, and where its lines come out.
pub fn tap() -> (Tap, Lines) {
    let (sender, receiver) = sync_channel(LINES);
    (Tap(sender), Lines(receiver))
}

impl<S: Subscriber> Layer<S> for Tap {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let about = event.metadata();
        if !about.target().starts_with(OWN) {
            return;
        }
        let mut msg = Text(String::new());
        event.record(&mut msg);
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        // Full, or the node is over: the line is on stderr.
        let _ = self.0.try_send(Log {
            stamp: Time::from_seconds(since.as_secs_f64()),
            level: number(*about.level()),
            name: String::new(),
            msg: msg.0,
            file: about.file().unwrap_or_default().to_owned(),
            function: String::new(),
            line: about.line().unwrap_or_default(),
        });
    }
}

/// As rcl numbers the levels.
fn number(level: Level) -> u8 {
    match level {
        Level::ERROR => 40,
        Level::WARN => 30,
        Level::INFO => 20,
        Level::DEBUG | Level::TRACE => 10,
    }
}

/// The message of an event.
struct Text(String);

impl Visit for Text {
    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        if field.name() == "message" {
            // A string takes all that is written to it.
            let _ = write!(self.0, "{value:?}");
        }
    }
}

/// The topic.
pub struct Rosout {
    lines: Lines,
    publisher: Publisher<Log>,
    /// The node's whole name as loggers have it, with dots.
    name: String,
}

impl Rosout {
    /// Opens it for a node of this whole name.
    pub fn open(ros: &mut Ros, lines: Lines, node: &str) -> Result<Self, DdsError> {
        let name = node.trim_start_matches('/').replace('/', ".");
        Ok(Self { lines, publisher: ros.log_publisher()?, name })
    }

    /// Sends what was logged since the last time.
    pub fn tell(&self, complaints: &mut Complaints) {
        // What fails here is logged, and so comes here: once a turn, not for ever.
        let waiting: Vec<Log> = self.lines.0.try_iter().collect();
        for line in waiting {
            let line = Log { name: self.name.clone(), ..line };
            // Kept for those who come late, so sent though nobody listens.
            self.publisher.tap().inspect(|tap| tap.record(&line));
            if let Err(error) = self.publisher.publish(line) {
                complaints.unsent("/rosout", &error);
            }
        }
    }
}
