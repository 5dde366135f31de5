//! Repeated runs and what their times come to, for the figures whose abscissa is a run time.
//!
//! Never tell the time of a single run: others may be using the processor.

use crate::bench::seconds;

/// Times of one thing that was run again and again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// The median, s.
    pub median_s: f64,
    /// The shortest, s.
    pub least_s: f64,
    /// The longest, s.
    pub most_s: f64,
    /// How many there were.
    pub repeats: usize,
}

/// Runs something so many times, after one run that is not timed.
pub fn repeat(runs: usize, mut run: impl FnMut()) -> Timing {
    run();
    let mut times: Vec<f64> = (0..runs.max(1)).map(|_| seconds(&mut run).0).collect();
    times.sort_by(f64::total_cmp);
    Timing {
        median_s: times[times.len() / 2],
        least_s: times[0],
        most_s: times[times.len() - 1],
        repeats: times.len(),
    }
}
