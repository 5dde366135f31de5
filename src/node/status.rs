//! The status line: how far, how fast, how exact. One line, rewritten on a terminal.

use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use crate::motion::arena::Arena;

/// How often the line is written to a file or a pipe; on a terminal once a second.
const LOG_PERIOD: Duration = Duration::from_secs(10);
const TERMINAL_PERIOD: Duration = Duration::from_secs(1);

/// Counts between two lines and since the start.
#[derive(Debug)]
pub struct Status {
    start: Instant,
    start_time: f64,
    start_contacts: u64,
    last: Instant,
    last_time: f64,
    last_contacts: u64,
    answered_contacts: u64,
    messages: u64,
    terminal: bool,
}

impl Status {
    /// Counting begins now.
    pub fn new(now: Instant) -> Self {
        Self {
            start: now,
            start_time: 0.0,
            start_contacts: 0,
            last: now,
            last_time: 0.0,
            last_contacts: 0,
            answered_contacts: 0,
            messages: 0,
            terminal: std::io::stderr().is_terminal(),
        }
    }

    /// Time between two lines.
    pub fn period(&self) -> Duration {
        if self.terminal { TERMINAL_PERIOD } else { LOG_PERIOD }
    }

    /// Counts from now on: the arena is another, or its time was set back.
    pub fn restart(&mut self, arena: Option<&Arena>, now: Instant) {
        (self.last, self.last_time) = (now, arena.map_or(0.0, Arena::now));
        self.last_contacts = self.contacts(arena);
        (self.start, self.start_time, self.start_contacts) =
            (self.last, self.last_time, self.last_contacts);
    }

    /// Counts an answered message.
    pub fn count_message(&mut self, contacts: usize) {
        self.messages += 1;
        self.answered_contacts += contacts as u64;
    }

    /// Writes the line about the time since the last one.
    pub fn write(&mut self, arena: Option<&Arena>, now: Instant) {
        let time = arena.map_or(0.0, Arena::now);
        let contacts = self.contacts(arena);
        let wall = (now - self.last).as_secs_f64();
        let line = self.line(
            arena,
            (time - self.last_time) / wall,
            (contacts - self.last_contacts) as f64 / wall,
        );
        (self.last, self.last_time, self.last_contacts) = (now, time, contacts);
        // Nobody may be reading: that is no reason to stop.
        let _ = if self.terminal {
            write!(std::io::stderr(), "\r\x1b[2K{line}")
        } else {
            writeln!(std::io::stderr(), "{line}")
        };
    }

    /// Writes the last line, about the whole run, or what was after the last beginning anew.
    pub fn finish(&mut self, arena: Option<&Arena>, now: Instant) {
        let time = arena.map_or(0.0, Arena::now);
        let wall = (now - self.start).as_secs_f64().max(1e-9);
        let contacts = self.contacts(arena).saturating_sub(self.start_contacts);
        let line = self.line(arena, (time - self.start_time) / wall, contacts as f64 / wall);
        let begin = if self.terminal { "\r\x1b[2K" } else { "" };
        let overlap = arena.map_or(String::new(), |arena| {
            format!(
                "   largest overlap {:.1e} radius   {} contacts in {wall:.1} s",
                // Not -0.
                arena.largest_overlap() + 0.0,
                contacts
            )
        });
        let unseen = arena.and_then(Arena::unseen).map_or(String::new(), |unseen| {
            let missed = unseen.missed + unseen.too_late;
            format!("   {} of them late, {missed} missed", unseen.late)
        });
        let _ = writeln!(std::io::stderr(), "{begin}{line}{overlap}{unseen}");
    }

    /// Contacts of the arena and of answers since the start.
    pub fn contacts(&self, arena: Option<&Arena>) -> u64 {
        self.answered_contacts + arena.map_or(0, Arena::contacts)
    }

    fn line(&self, arena: Option<&Arena>, factor: f64, rate: f64) -> String {
        match arena {
            Some(arena) => format!(
                "t = {:.1} s   real-time factor {factor:.2}   {rate:.0} contacts/s   energy drift \
                 {:+.1e}",
                arena.now(),
                arena.relative_energy_drift(),
            ),
            None => {
                format!("resolver   {} messages answered   {rate:.0} contacts/s", self.messages)
            }
        }
    }
}
