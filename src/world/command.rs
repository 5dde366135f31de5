//! What may be asked of a world, and what one step answers.

use glam::DVec2;

use super::contact::Contact;
use super::disc::{Defect, Disc, DiscId};
use super::drives::{Drive, Wanted};
use crate::detect::TooManyPairs;
use crate::motion::arena::Halt;
use crate::referee::{Crash, Goal};

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
    /// A driven puck shall go this way from now on, within the limits of its drive.
    Drive {
        /// The puck.
        id: DiscId,
        /// Where to.
        wanted: Wanted,
    },
    /// A robot kicks along its heading as soon as a ball is in the mouth of its
    /// [kicker](super::Kicker): at this instant, or at the first control tick at which one is. It
    /// waits until then, or until another command to kick, or the command time-out.
    Kick {
        /// The robot.
        id: DiscId,
        /// Speed of the ball along the heading, m/s; above what the kicker can, that. 0 = it kicks
        /// no more.
        speed: f64,
    },
    /// The dribbler of a robot runs from now on, or does not. A command time-out stops it.
    Dribble {
        /// The robot.
        id: DiscId,
        /// Whether it runs.
        on: bool,
    },
    /// A force draws a robot or a ball to a place from now on, whatever it is commanded, and keeps
    /// it there, with an acceleration of [`PULL_MPS2`](super::PULL_MPS2) at most; it runs into what
    /// is in its way. [`Command::PlacePuck`] ends it too.
    Pull {
        /// The robot or ball.
        id: DiscId,
        /// Where its centre shall be, m; nothing = no force any more.
        to: Option<DVec2>,
    },
    /// A robot looks elsewhere from now on.
    Turn {
        /// The robot.
        id: DiscId,
        /// rad
        heading: f64,
        /// rad/s
        turn: f64,
    },
    /// A robot has other limits from now on; [`Drive::heading`] is not looked at.
    SetDrive {
        /// The robot.
        id: DiscId,
        /// What it can.
        drive: Drive,
    },
    /// A ball rolls from now on: its spin fits its velocity. [`Command::PlacePuck`] leaves it
    /// without spin, so that it slides first; [`Command::SetVelocity`] leaves the spin as it is.
    Roll {
        /// The ball.
        id: DiscId,
    },
    /// One more simulated puck, from now on.
    AddPuck(Disc),
    /// A simulated puck is no longer there.
    RemovePuck {
        /// The puck.
        id: DiscId,
    },
    /// A simulated puck is somewhere else from now on, with another velocity.
    PlacePuck {
        /// The puck.
        id: DiscId,
        /// Its centre, m.
        position: DVec2,
        /// Its velocity, m/s.
        velocity: DVec2,
    },
    /// The walls are elsewhere from now on; pucks outside are brought inside, where they may then
    /// overlap others.
    MoveWalls {
        /// Lower left corner, m.
        min: DVec2,
        /// Upper right corner, m.
        max: DVec2,
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
    /// Crashes of robots, where [somebody watches](super::World::watch), in the order of time.
    pub crashes: Vec<Crash>,
    /// Goals, where somebody watches a field, in the order of time.
    pub goals: Vec<Goal>,
    /// What observed circles must do after contacts with simulated pucks: the latest velocity each,
    /// by id.
    pub corrections: Vec<(DiscId, DVec2)>,
    /// Commands that were not carried out, by their place among all, and why: nothing was changed.
    pub not_done: Vec<(usize, NotDone)>,
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

/// Why an arena does not do what was asked.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NotDone {
    /// A number of the puck.
    #[error("{0}")]
    Defect(Defect),
    /// The id is in use.
    #[error("id {0} is taken; give the new puck another")]
    Taken(DiscId),
    /// There is no such puck.
    #[error("no puck has id {0}; see arena_states for those that are there")]
    Unknown(DiscId),
    /// It is no robot.
    #[error("puck {0} is not driven; give it a drive in the scene")]
    NotDriven(DiscId),
    /// It is no ball.
    #[error("puck {0} is no ball; only a scene's ball slides and rolls")]
    NoBall(DiscId),
    /// It would overlap a disc.
    #[error("the puck would overlap disc {0}; part them, or let them just touch")]
    Overlaps(DiscId),
    /// It would stand in or beyond a wall or a line segment.
    #[error("the puck would not lie within the walls")]
    OutsideWalls,
    /// It is so wide that it could touch another on two sides of a periodic box.
    #[error(
        "the puck is too wide for the periodic box: radius at most {} of its side",
        super::limits::RADIUS_IN_PERIODIC_BOX
    )]
    TooWide,
    /// The arena holds as many pucks as it may.
    #[error("the arena already holds {} pucks", super::limits::PUCKS_PER_SCENE)]
    TooMany,
    /// There is no arena.
    #[error("there is no arena; start with a scene that has a puck")]
    NoArena,
    /// There are no walls to be moved.
    #[error("the arena has no walls; start with a scene that has a box")]
    NoWalls,
    /// The boundary is made of line segments.
    #[error("a field of line segments stays where it is; start with another scene")]
    FixedField,
    /// The new walls are no box, or one without room for the widest puck.
    #[error("the walls must be finite and leave room for every puck")]
    NoRoom,
    /// The arena has halted on the way to the present.
    #[error("the arena stands still; its halt was told")]
    Halted,
}
