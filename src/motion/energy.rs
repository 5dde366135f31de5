//! The energy account: what the kinetic energy of an arena ought to be.
//!
//! Restitution, observed circles, fixed discs that move and commands all change energy by amounts
//! that the laws give. The account books them; what is left between it and the discs is error.

use crate::exact::RunningSum;

/// An energy that is none, J.
const NOTHING: f64 = 1e-250;

/// Initial energy plus all work done since, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyAccount {
    due: RunningSum,
    largest: f64,
}

impl EnergyAccount {
    /// Books work done on the arena's discs, J; negative when they lose energy.
    #[inline]
    pub fn book(&mut self, work: f64) {
        self.due.add(work);
        self.largest = self.largest.max(self.due.value());
    }

    /// Takes all energies for smaller by a factor. So small that squares of speeds leave the range
    /// of doubles, there is nothing to account for.
    pub fn scale(&mut self, factor: f64) {
        (self.due, self.largest) = (self.due.scaled(factor), self.largest * factor);
        if self.largest < NOTHING {
            *self = Self::default();
        }
    }

    /// What the kinetic energy ought to be, J.
    pub fn due(&self) -> f64 {
        self.due.value()
    }

    /// Signed difference between an energy and what it ought to be, relative to the largest energy
    /// so far: an arena brought to rest has no drift worth a number.
    pub fn relative_drift(&self, energy: f64) -> f64 {
        if self.largest > 0.0 { (energy - self.due()) / self.largest } else { 0.0 }
    }
}
