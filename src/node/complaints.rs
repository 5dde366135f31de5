//! Complaints: what was refused goes to the log, one line each, and never floods it; all of it is
//! counted, whether or not it was shown.

use std::fmt::Display;
use std::time::{Duration, Instant};

use crate::receive::{Cause, Refused};

/// Lines in one period; what is beyond them is counted.
const LINES_PER_PERIOD: u32 = 50;
const PERIOD: Duration = Duration::from_secs(1);

/// Writes refusals to the log at a bounded rate.
#[derive(Debug)]
pub struct Complaints {
    period_start: Instant,
    lines: u32,
    held_back: u64,
    refused: Refused,
    unsent: u64,
}

impl Complaints {
    /// With a full allowance.
    pub fn new(now: Instant) -> Self {
        let refused = Refused::default();
        Self { period_start: now, lines: 0, held_back: 0, refused, unsent: 0 }
    }

    /// Input on a topic was refused.
    pub fn refuse(&mut self, topic: &str, cause: Cause, what: &dyn Display) {
        self.count(cause);
        self.say(topic, what);
    }

    /// Input was refused, of which everything is said.
    pub fn count(&mut self, cause: Cause) {
        self.refused.count(cause);
    }

    /// A message was not sent.
    pub fn unsent(&mut self, topic: &str, what: &dyn Display) {
        self.unsent += 1;
        self.say(topic, what);
    }

    /// Something is wrong with a topic.
    pub fn say(&mut self, topic: &str, what: &dyn Display) {
        let now = Instant::now();
        if now - self.period_start >= PERIOD {
            self.settle();
            (self.period_start, self.lines) = (now, 0);
        }
        if self.lines < LINES_PER_PERIOD {
            self.lines += 1;
            tracing::error!("{topic}: {what}");
        } else {
            self.held_back += 1;
        }
    }

    /// Input refused since the start.
    pub fn refused(&self) -> Refused {
        self.refused
    }

    /// Messages not sent since the start.
    pub fn unsent_count(&self) -> u64 {
        self.unsent
    }

    /// Says how many lines were held back.
    pub fn settle(&mut self) {
        if self.held_back > 0 {
            tracing::error!("{} more refusals, not shown", self.held_back);
            self.held_back = 0;
        }
    }
}
