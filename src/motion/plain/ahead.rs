//! A first look at many others at once: when a body would meet them if all fly straight.
//!
//! Most of them come too late or never, and a look at all side by side says so in a fraction of the
//! time. Who may come first is then looked at properly. Never decide here what happens: only what
//! need not be looked at.

use glam::DVec2;

use super::Plain;
use crate::detect::impact::{Relative, pair_impacts};

/// Bodies in one look: enough to share its cost, few enough to stay close at hand.
const LENGTH: usize = 32;

/// What a body sees of the others, one stretch of them after the other.
pub(super) struct Ahead {
    pairs: [Relative; LENGTH],
    times: [f64; LENGTH],
    /// Largest relative velocity seen, m/s, in a periodic box.
    pub fastest: DVec2,
    /// Largest reach seen, m, in a periodic box.
    pub widest: f64,
}

impl Ahead {
    /// Has seen nothing yet.
    pub fn new() -> Self {
        let pairs = [Relative::default(); LENGTH];
        Self { pairs, times: [0.0; LENGTH], fastest: DVec2::ZERO, widest: 0.0 }
    }

    /// Time until body `k` of an arena meets body `l` if both fly straight from an offset on, s;
    /// infinite = never, 0 = now, or it is not known. To be asked for every `l` in order.
    #[inline(always)]
    pub fn time(&mut self, arena: &Plain, k: usize, l: usize, offset: f64) -> f64 {
        if l.is_multiple_of(LENGTH) {
            self.look(arena, k, l, offset);
        }
        self.times[l % LENGTH]
    }

    /// Looks at the bodies from `start` on.
    fn look(&mut self, arena: &Plain, k: usize, start: usize, offset: f64) {
        let (laws, body) = (&arena.laws, &arena.bodies[k]);
        if laws.gravity.is_some() {
            // Falling discs come back, and the times stay at 0.
            return;
        }
        let disc = body.at(offset);
        let others = &arena.bodies[start..arena.bodies.len().min(start + LENGTH)];
        for (l, (pair, other)) in (start..).zip(self.pairs.iter_mut().zip(others)) {
            // At rest as seen from the body: it never comes.
            *pair = Relative::default();
            if l == k || !body.can_collide_with(other) {
                continue;
            }
            let other = laws.near(disc.position, other.at(offset));
            let (d, w) = (other.position - disc.position, other.velocity - disc.velocity);
            *pair = Relative { d, w, s: disc.radius + other.radius };
            if laws.periodic.is_some() {
                self.fastest = self.fastest.max(w.abs());
                self.widest = self.widest.max(pair.s);
            }
        }
        if !laws.extreme_units {
            pair_impacts(&self.pairs[..others.len()], &mut self.times[..others.len()]);
        }
    }
}
