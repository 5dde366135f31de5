//! Causes: the closed list of why input is refused, by short names, and how often each was.
//!
//! Every refusal is one of them, whoever refuses: the decoder, the reader of messages, the world.
//! Never put a number or a name of a topic into a cause; the log says those.

use super::{BadCircle, TooManyCircles};
use crate::detect::TooManyPairs;
use crate::world::{Defect, Refusal};

/// Why input is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Cause {
    /// The payload is not the type of its topic.
    Undecodable,
    /// More circles in a message than are read.
    TooManyCircles,
    /// A number is not finite.
    NotFinite,
    /// A number is finite, but no radius, mass, place or speed that is served.
    OutOfRange,
    /// Circles of one message share an id.
    DuplicateId,
    /// The id stands for a wall.
    WallId,
    /// The id is that of a simulated puck.
    SimulatedId,
    /// The world holds as many observed circles as it may.
    TooManyObserved,
    /// Too wide for the periodic box.
    TooWide,
    /// The method of the pucks cannot meet it.
    NotMet,
    /// More touching pairs than are resolved.
    TooManyPairs,
    /// There is no robot or ball of that name.
    UnknownRobot,
}

impl Cause {
    /// All of them, in the order in which they are told.
    pub const ALL: [Self; 12] = [
        Self::Undecodable,
        Self::TooManyCircles,
        Self::NotFinite,
        Self::OutOfRange,
        Self::DuplicateId,
        Self::WallId,
        Self::SimulatedId,
        Self::TooManyObserved,
        Self::TooWide,
        Self::NotMet,
        Self::TooManyPairs,
        Self::UnknownRobot,
    ];

    /// Its name in `refused_causes`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Undecodable => "undecodable",
            Self::TooManyCircles => "too_many_circles",
            Self::NotFinite => "not_finite",
            Self::OutOfRange => "out_of_range",
            Self::DuplicateId => "duplicate_id",
            Self::WallId => "wall_id",
            Self::SimulatedId => "simulated_id",
            Self::TooManyObserved => "too_many_observed",
            Self::TooWide => "too_wide",
            Self::NotMet => "not_met",
            Self::TooManyPairs => "too_many_pairs",
            Self::UnknownRobot => "unknown_robot",
        }
    }
}

impl From<&Defect> for Cause {
    fn from(defect: &Defect) -> Self {
        if defect.value.is_finite() { Self::OutOfRange } else { Self::NotFinite }
    }
}

impl From<&BadCircle> for Cause {
    fn from(reason: &BadCircle) -> Self {
        match reason {
            BadCircle::Defect(defect) => defect.into(),
            BadCircle::Duplicate { .. } => Self::DuplicateId,
            BadCircle::Wall => Self::WallId,
        }
    }
}

impl From<&Refusal> for Cause {
    fn from(reason: &Refusal) -> Self {
        match reason {
            Refusal::Simulated => Self::SimulatedId,
            Refusal::TooManyObserved => Self::TooManyObserved,
            Refusal::TooWide => Self::TooWide,
            Refusal::NotMet => Self::NotMet,
        }
    }
}

impl From<&TooManyCircles> for Cause {
    fn from(_: &TooManyCircles) -> Self {
        Self::TooManyCircles
    }
}

impl From<&TooManyPairs> for Cause {
    fn from(_: &TooManyPairs) -> Self {
        Self::TooManyPairs
    }
}

/// How often input was refused, by cause.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Refused([u64; Cause::ALL.len()]);

impl Refused {
    /// Counts one refusal.
    pub fn count(&mut self, cause: Cause) {
        self.0[cause as usize] += 1;
    }

    /// Each cause and how often it was, all of them in the order of [`Cause::ALL`].
    pub fn counts(&self) -> impl Iterator<Item = (Cause, u64)> + '_ {
        Cause::ALL.into_iter().zip(self.0.iter().copied())
    }

    /// Refusals of all causes.
    pub fn total(&self) -> u64 {
        self.0.iter().sum()
    }
}
