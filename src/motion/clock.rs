//! The clock of an event engine: a base that moves and short offsets from it.
//!
//! A single double loses u t of every event time; after an hour that is 4e-13 s, more than the
//! gap of two discs in contact. Event times are therefore offsets from a base that moves on in
//! whole epochs. An epoch is a power of two of seconds, so base and shift are exact.

use crate::exact::power_of_two_near;

/// A base time and the length of the epochs in which it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    base: f64,
    epoch: f64,
}

impl Clock {
    /// A clock at 0 with epochs of about `scale` seconds (any positive number).
    pub fn new(scale: f64) -> Self {
        Self { base: 0.0, epoch: power_of_two_near(scale) }
    }

    /// Length of an epoch, s.
    pub fn epoch(&self) -> f64 {
        self.epoch
    }

    /// Offset of an absolute time, s.
    pub fn offset(&self, time: f64) -> f64 {
        time - self.base
    }

    /// Absolute time of an offset, s, rounded once.
    pub fn time(&self, offset: f64) -> f64 {
        self.base + offset
    }

    /// Whether an offset lies beyond the current epoch.
    pub fn is_past(&self, offset: f64) -> bool {
        offset >= self.epoch
    }

    /// Moves the base on by the whole epochs in `offset`; returns by how much: to be taken from
    /// every stored offset.
    pub fn advance(&mut self, offset: f64) -> f64 {
        let shift = (offset / self.epoch).floor() * self.epoch;
        self.base += shift;
        shift
    }
}
