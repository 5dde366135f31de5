//! Motion: how an arena gets from one instant to a later one.
//!
//! | method | what it is | error |
//! |---|---|---|
//! | [`plain`] | the next collision, then the next; the judge of every faster one | rounding |
//! | [`events`] | the same with cells and a calendar: for many discs | rounding |
//! | [`ticks`] | exact within a control tick, for velocities set at each | rounding |
//! | [`steps`] | a fixed step, contacts found at its end | first order in the step |
//! | [`springs`] | contacts that give way: spring and dashpot | the model's: k^-1/2 |
//!
//! The same linear drag for all discs leaves the first two exact: [`drag`] is a mapping of time
//! around them. Observed circles slow down with the others until they are heard of again, and so
//! does what has infinite mass and moves.
//!
//! Where the laws alone do not say what happens, the exact methods do this:
//!
//! - Discs overlap, however deep, and approach: one collision at once, along the line of centres;
//!   no position is changed.
//! - Discs overlap and separate: nothing. The direction of motion decides, never a distance.
//! - Centres coincide: they neither approach nor separate, so no collision. Where a message reports
//!   such a pair, the relative velocity serves as its normal.
//! - They approach by no more than the rounding of their velocities: at rest on each other.
//! - Several contacts at one instant share a disc: reflected together, so symmetry stays. Walls
//!   come after them, x before y.
//! - A disc at its wall or beyond it: bounces if it moves outwards, is let in if inwards.
//! - Contacts without end in a finite time (a collapse, a train pressed on a wall at restitution
//!   0): after [many](crate::world::limits::QUICK_CONTACTS) in a row within the contact time they
//!   are elastic until the discs have peace.
//! - Contacts without end at one instant: a budget, then a [stall](plain::Stall) that says where.
//!
//! Each is made from laws, discs and how to go on; `advance(until, &mut contacts)` moves it,
//! `discs()` shows it, `now()` says how far it came; [`watch`] tells it to another thread.
//! [`clock`] keeps the times of events exact; [`energy`] and [`momentum`] tell drift, which is
//! error, from work, which is physics.

pub mod arena;

pub mod watch;

pub mod plain;

pub mod events;

pub mod ticks;

pub mod near;

pub mod steps;

pub mod springs;

pub mod drag;

pub mod entry;

pub mod clock;

pub mod energy;

pub mod momentum;

use crate::world::Contact;

/// Who is told of contacts; what nobody looks at is not computed.
pub trait Witness {
    /// Whether contacts are looked at.
    const LOOKS: bool = true;

    /// A contact took place.
    fn see(&mut self, contact: impl FnOnce() -> Contact);
}

impl Witness for Vec<Contact> {
    #[inline(always)]
    fn see(&mut self, contact: impl FnOnce() -> Contact) {
        self.push(contact());
    }
}

/// A witness who does not look.
#[derive(Clone, Copy, Debug, Default)]
pub struct Nobody;

impl Witness for Nobody {
    const LOOKS: bool = false;

    #[inline(always)]
    fn see(&mut self, _: impl FnOnce() -> Contact) {}
}
