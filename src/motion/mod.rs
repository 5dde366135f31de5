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
//! Each is made from laws, discs and how to go on; `advance(until, &mut contacts)` moves it,
//! `discs()` shows it, `now()` says how far it came. [`clock`] keeps the times of events exact;
//! [`energy`] tells drift, which is error, from work, which is physics.

pub mod arena;

pub mod plain;

pub mod events;

pub mod ticks;

pub mod steps;

pub mod springs;

pub mod clock;

pub mod energy;

use crate::world::Contact;

/// Who is told of contacts; what nobody looks at is not computed.
pub trait Witness {
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
    #[inline(always)]
    fn see(&mut self, _: impl FnOnce() -> Contact) {}
}
