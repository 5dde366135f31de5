//! Beginning again: the same motion told in other time, for [drag](crate::motion::drag).

use super::{Laws, Plain};
use crate::motion::clock::Clock;

impl Plain {
    /// The laws of its arena.
    pub(in crate::motion) fn laws(&self) -> &Laws {
        &self.laws
    }

    /// Whether an advance has come so far.
    pub(in crate::motion) fn has_reached(&self, until: f64) -> bool {
        self.now >= until
    }

    /// Gaps at contacts are not told.
    pub(in crate::motion) fn largest_gap(&self) -> f64 {
        0.0
    }

    /// When the next event comes, s; infinite = never.
    pub(in crate::motion) fn next_event(&self) -> f64 {
        self.earliest().map_or(f64::INFINITY, |first| self.clock.time(self.next[first].time))
    }

    /// Takes the present for the time `at`, s, and all discs for slower by `slowed`, a power of two
    /// or 0. What discs remember of each other stays.
    pub(in crate::motion) fn begin_again(&mut self, at: f64, slowed: f64) {
        let offset = self.clock.offset(self.now);
        let mut remembered = std::mem::take(&mut self.remembered);
        if slowed > 0.0 {
            let state = |k: usize| self.bodies[k].state_at(offset);
            let sight = |i: usize, j: usize| self.sight(i, &state(i), j, &state(j));
            remembered.begin_again(offset, at, slowed, sight);
            self.remembered = remembered;
        }
        for k in 0..self.bodies.len() {
            self.move_to(k, offset);
            self.bodies[k].begin_again(at, slowed);
            self.bodies[k].collapse.begin_again(offset, at, slowed);
        }
        self.doubt.velocity *= slowed;
        self.energy.scale(slowed * slowed);
        self.momentum.scale(slowed);
        (self.clock, self.now) = (Clock::new(self.clock.epoch()), at);
        (self.instant, self.events_at_instant) = (at, 0);
        self.predict_all();
    }
}
