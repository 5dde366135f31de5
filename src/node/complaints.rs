//! Complaints: what was refused goes to the log, one line each, and never floods it.

use std::fmt::Display;
use std::time::{Duration, Instant};

/// Lines in one period; what is beyond them is counted.
const LINES_PER_PERIOD: u32 = 50;
const PERIOD: Duration = Duration::from_secs(1);

/// Writes refusals to the log at a bounded rate.
#[derive(Debug)]
pub struct Complaints {
    period_start: Instant,
    lines: u32,
    held_back: u64,
}

impl Complaints {
    /// With a full allowance.
    pub fn new(now: Instant) -> Self {
        Self { period_start: now, lines: 0, held_back: 0 }
    }

    /// Something on a topic was refused.
    pub fn refuse(&mut self, topic: &str, what: &dyn Display) {
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

    /// Says how many lines were held back.
    pub fn settle(&mut self) {
        if self.held_back > 0 {
            tracing::error!("{} more refusals, not shown", self.held_back);
            self.held_back = 0;
        }
    }
}
