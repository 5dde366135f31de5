//! Progress: one line on stderr that is rewritten, or a line a figure where nobody watches.
//!
//! It writes only when a percent is full, from the thread that measures, so that it disturbs no run
//! time: no thread and no clock of its own.

use std::io::{IsTerminal, Write, stderr};

/// Cells of the bar.
const CELLS: usize = 30;

/// How far the report is.
pub struct Bar {
    watched: bool,
    done: f64,
    all: f64,
    figure: String,
    share: f64,
    shown: Option<u32>,
}

impl Bar {
    /// At the start of figures with these shares of the time altogether.
    pub fn new(all: f64) -> Self {
        let watched = stderr().is_terminal();
        Self { watched, done: 0.0, all, figure: String::new(), share: 0.0, shown: None }
    }

    /// Of one thing alone, which is not announced where nobody watches.
    pub fn of_one(name: &str) -> Self {
        Self { share: 1.0, figure: name.to_owned(), ..Self::new(1.0) }
    }

    /// A figure begins; the one before has ended.
    pub fn begin(&mut self, number: usize, of: usize, name: &str, share: f64) {
        self.done += self.share;
        self.share = share;
        self.figure = format!("{name} ({number} of {of})");
        self.shown = None;
        if self.watched {
            self.tell(0.0);
        } else {
            // Nobody may be reading.
            let _ = writeln!(stderr(), "carom report: {}", self.figure);
        }
    }

    /// So much of the figure is done, 0 to 1.
    pub fn tell(&mut self, part: f64) {
        let percent = percent(self.done + self.share * part.clamp(0.0, 1.0), self.all);
        if !self.watched || self.shown == Some(percent) {
            return;
        }
        self.shown = Some(percent);
        let _ = write!(stderr(), "\r{}\x1b[K", line(percent, &self.figure));
        let _ = stderr().flush();
    }

    /// Leaves an empty line for whatever comes.
    pub fn end(self) {
        if self.watched {
            let _ = write!(stderr(), "\r\x1b[K");
        }
    }
}

fn percent(done: f64, all: f64) -> u32 {
    let part = if all > 0.0 { (done / all).clamp(0.0, 1.0) } else { 0.0 };
    // What is not a number becomes 0.
    (100.0 * part) as u32
}

fn line(percent: u32, figure: &str) -> String {
    let full = CELLS * percent as usize / 100;
    format!("[{}{}] {percent:3} %  {figure}", "=".repeat(full), " ".repeat(CELLS - full))
}
