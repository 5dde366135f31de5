//! Motion: how an arena gets from one instant to a later one.
//!
//! [`plain`] is the event-driven method at its plainest, exact and the judge of every faster one;
//! [`clock`] keeps its times exact; [`energy`] tells drift, which is error, from work, which is
//! physics.

pub mod plain;

pub mod steps;

pub mod clock;

pub mod energy;
