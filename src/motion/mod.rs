//! Motion: how an arena gets from one instant to a later one.
//!
//! | method | what it is | error |
//! |---|---|---|
//! | [`plain`] | the next collision, then the next; the judge of every faster one | rounding |
//! | [`ticks`] | exact within a control tick, for velocities set at each | rounding |
//! | [`steps`] | a fixed step, contacts found at its end | first order in the step |
//! | [`springs`] | contacts that give way: spring and dashpot | the model's: k^-1/2 |
//!
//! Each is made from laws, discs and how to go on; `advance(until, &mut contacts)` moves it,
//! `discs()` shows it, `now()` says how far it came. [`clock`] keeps the times of events exact;
//! [`energy`] tells drift, which is error, from work, which is physics.

pub mod plain;

pub mod events;

pub mod ticks;

pub mod steps;

pub mod springs;

pub mod clock;

pub mod energy;
