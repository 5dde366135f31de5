//! Beginning again: the same motion told in other time, for [drag](crate::motion::drag).

use super::{Due, Events, Laws};

impl Events {
    /// The laws of its arena.
    pub(in crate::motion) fn laws(&self) -> &Laws {
        &self.laws
    }

    /// When the next event comes, s; infinite = never. Never later than it is.
    pub(in crate::motion) fn next_event(&self) -> f64 {
        self.base + self.dues.iter().map(Due::time).fold(f64::INFINITY, f64::min)
    }

    /// Whether an advance has come so far.
    pub(in crate::motion) fn has_reached(&self, until: f64) -> bool {
        self.now >= until - self.base || self.now() >= until
    }

    /// Takes the present for the time `at`, s, and all discs for slower by `slowed`, a power of two
    /// or 0. They are predicted again before time goes on.
    pub(in crate::motion) fn begin_again(&mut self, at: f64, slowed: f64) {
        self.carry_on(self.now);
        self.base = at;
        for flight in &mut self.flights {
            (flight.vx, flight.vy) = (flight.vx * slowed, flight.vy * slowed);
        }
        self.last.iter_mut().for_each(|last| last.time /= slowed);
        self.energy.scale(slowed * slowed);
        self.momentum.scale(slowed);
        (self.events, self.events_before_today) = (0, 0);
        (self.instant, self.events_at_instant) = (0.0, 0);
        self.outdated = true;
    }
}
