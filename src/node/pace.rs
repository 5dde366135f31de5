//! Pace: which simulated time belongs to which wall time.
//!
//! An arena that cannot keep up is not made to catch up later: the pace slips, and the status line
//! shows a real-time factor below what was asked.

use std::time::{Duration, Instant};

/// Lag that is made up for; beyond it the pace slips.
const LAG_MAX: Duration = Duration::from_millis(100);

/// Simulated time as a linear function of wall time.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    factor: f64,
    wall: Instant,
    simulated: f64,
}

impl Pace {
    /// Simulated time 0 is `start`; `factor` 0 = as fast as possible.
    pub fn new(factor: f64, start: Instant) -> Self {
        Self { factor, wall: start, simulated: 0.0 }
    }

    /// From now on another factor; how far the simulation has come stays.
    pub fn change(&mut self, factor: f64, simulated: f64, now: Instant) {
        *self = Self { factor, wall: now, simulated };
    }

    /// The simulated time due at an instant, s.
    pub fn due(&self, now: Instant) -> f64 {
        if self.factor == 0.0 {
            return f64::INFINITY;
        }
        self.simulated + (now - self.wall).as_secs_f64() * self.factor
    }

    /// When a simulated time is due; far away if that is beyond a day.
    pub fn instant_of(&self, simulated: f64) -> Instant {
        if self.factor == 0.0 {
            return self.wall;
        }
        let wait = ((simulated - self.simulated) / self.factor).clamp(0.0, 86_400.0);
        self.wall + Duration::from_secs_f64(wait)
    }

    /// Tells how far the simulation has come; slips if that is too far behind.
    pub fn reached(&mut self, simulated: f64, now: Instant) {
        let lag = (self.due(now) - simulated) / self.factor;
        if lag > LAG_MAX.as_secs_f64() {
            (self.wall, self.simulated) = (now, simulated);
        }
    }
}
