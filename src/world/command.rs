//! What may be asked of a world, and what one step answers.

use glam::DVec2;

use super::contact::Contact;
use super::disc::{Disc, DiscId};
use crate::detect::TooManyPairs;
use crate::motion::arena::Halt;

/// Something asked of the world, by a topic or a program.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Somebody reports the circles that they own.
    Observe(Report),
    /// A simulated puck shall have this velocity (m/s) from now on.
    SetVelocity {
        /// The puck.
        id: DiscId,
        /// Its velocity, m/s.
        velocity: DVec2,
    },
}

/// Observed circles, as one message gave them. The ids are unique and every disc is sound.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// The circles.
    pub discs: Vec<Disc>,
    /// Time of the message, s: copied into the contacts of the answer.
    pub time: f64,
}

/// The instants of one step. The core reads no clock: the caller does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instants {
    /// Now, s on a clock that never jumps: decides what is stale.
    pub heard_at: f64,
    /// Simulated time to advance the arena to, s.
    pub advance_to: f64,
}

/// What one step says outward.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// One answer for each report, in their order.
    pub answers: Vec<Answer>,
    /// The arena's contacts, in the order of time.
    pub contacts: Vec<Contact>,
    /// What observed circles must do after contacts with simulated pucks: the latest velocity each,
    /// by id.
    pub corrections: Vec<(DiscId, DVec2)>,
    /// Why the arena stands still, if it does.
    pub stall: Option<Halt>,
}

/// The answer to one report.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answer {
    /// Contacts among observed circles of which at least one is in the report.
    pub contacts: Vec<Contact>,
    /// The velocities of all circles in these contacts after them, by id.
    pub velocities: Vec<(DiscId, DVec2)>,
    /// Circles that were not taken, and why.
    pub refused: Vec<(DiscId, Refusal)>,
    /// Why the contacts were not resolved, if they were not.
    pub unresolved: Option<TooManyPairs>,
}

/// Why the world does not take a circle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// The id is that of a simulated puck.
    #[error("the id belongs to a simulated puck; give observed circles other ids")]
    Simulated,
    /// The world holds as many observed circles as it may.
    #[error("the world already holds {} observed circles", super::limits::OBSERVED_CIRCLES)]
    TooManyObserved,
    /// It is so wide that a puck of the periodic arena could touch it on two sides.
    #[error(
        "the circle is too wide for the periodic box: radius at most {} of its side",
        super::limits::RADIUS_IN_PERIODIC_BOX
    )]
    TooWide,
    /// The pucks move by a method that cannot meet it; circles still meet each other.
    #[error("pucks pass through observed circles under the method springs; take another")]
    NotMet,
}
