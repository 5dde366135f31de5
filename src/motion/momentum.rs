//! The momentum account: what the momentum of an arena's discs ought to be.
//!
//! Two discs of the arena exchange momentum and nothing is booked, so that the account costs
//! nothing where most contacts are. Booked is what comes from outside: impulses of walls, of fixed
//! and of observed discs, commands, gravity. Without any of these it is the initial momentum. What
//! is left between the account and the discs is error.
//!
//! It is kept only once somebody asked: before, nothing is booked, and nothing is told.

use glam::DVec2;

use crate::exact::{RunningSum, two_product};
use crate::world::Disc;

/// Initial momentum plus all impulses from outside, N s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MomentumAccount {
    kept: bool,
    x: RunningSum,
    y: RunningSum,
    /// What gravity does to the discs that fall, N.
    pull: DVec2,
    /// Until when that is booked, s.
    booked_until: f64,
}

impl MomentumAccount {
    /// Whether it is kept.
    #[inline(always)]
    pub fn is_kept(&self) -> bool {
        self.kept
    }

    /// Begins with these discs; a second beginning changes nothing.
    pub fn begin(&mut self, discs: impl Iterator<Item = Disc>) {
        if !self.kept {
            *self = Self { kept: true, ..Self::default() };
            discs.for_each(|disc| self.add(&disc, 1.0));
        }
    }

    /// Books an impulse from outside on the arena's discs, N s.
    #[inline]
    pub fn book(&mut self, impulse: DVec2) {
        if self.kept {
            self.x.add(impulse.x);
            self.y.add(impulse.y);
        }
    }

    /// Books what a change of velocity (m/s) from outside does to a disc.
    #[inline]
    pub fn book_change(&mut self, mass: f64, change: DVec2) {
        if self.kept && mass.is_finite() {
            self.add_scaled(mass, change);
        }
    }

    /// Books a disc that comes.
    pub fn book_come(&mut self, disc: &Disc) {
        if self.kept {
            self.add(disc, 1.0);
        }
    }

    /// Books a disc that goes.
    pub fn book_gone(&mut self, disc: &Disc) {
        if self.kept {
            self.add(disc, -1.0);
        }
    }

    /// Lets a force that lasts be this, N, from `now` (s) on.
    pub fn set_pull(&mut self, now: f64, pull: DVec2) {
        if self.kept {
            self.book_until(now);
            self.pull = pull;
        }
    }

    /// Lets a force that lasts change by so much, N, from `now` (s) on.
    pub fn book_pull(&mut self, now: f64, change: DVec2) {
        if self.kept {
            self.book_until(now);
            self.pull += change;
        }
    }

    fn book_until(&mut self, now: f64) {
        let pull = self.pull;
        self.add_scaled(now - self.booked_until, pull);
        self.booked_until = now;
    }

    /// Takes all momenta for smaller by a factor, a power of two or 0.
    pub fn scale(&mut self, factor: f64) {
        (self.x, self.y) = (self.x.scaled(factor), self.y.scaled(factor));
    }

    /// Momentum that the discs have beyond what they ought to have at `now` (s), N s; `None` while
    /// the account is not kept.
    pub fn drift(&self, now: f64, discs: impl Iterator<Item = Disc>) -> Option<DVec2> {
        let mut rest = *self;
        rest.book_until(now);
        discs.for_each(|disc| rest.add(&disc, -1.0));
        self.kept.then(|| -DVec2::new(rest.x.value(), rest.y.value()))
    }

    /// Adds the momentum of a disc, or takes it away; one of infinite mass has none that counts.
    fn add(&mut self, disc: &Disc, sign: f64) {
        if disc.mass.is_finite() {
            self.add_scaled(sign * disc.mass, disc.velocity);
        }
    }

    fn add_scaled(&mut self, factor: f64, vector: DVec2) {
        for (sum, component) in [(&mut self.x, vector.x), (&mut self.y, vector.y)] {
            let (product, error) = two_product(factor, component);
            sum.add(product);
            sum.add(error);
        }
    }
}
