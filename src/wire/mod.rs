//! The wire: robot soccer on its leagues' own protocols, so that teams' software plugs in as it is.
//!
//! ```text
//! datagram -> robots, control, vsss, grsim -> orders, faults -> stage -> answer to the sender
//! stage -> View -> vision, tracked, vsss, geometry -> datagrams
//! ```
//!
//! | file | holds |
//! |---|---|
//! | [`proto`] | the messages |
//! | [`robots`], [`control`], [`vsss`], [`grsim`] | what a datagram asks, or what is wrong in it |
//! | [`orders`] | what may be asked of robots and ball, and the commands that it becomes |
//! | [`room`] | where a robot that makes way may stand |
//! | [`specs`] | what a robot is: wheels, limits, kicker |
//! | [`field`], [`geometry`] | the field of a league, and how it is told |
//! | [`vision`], [`realism`] | cameras, and how badly they see |
//! | [`frames`] | the same on topics of ROS 2, in and out |
//! | [`states`] | robots and ball on topics of their own |
//! | [`tracked`] | positions and velocities as a tracker tells them |
//!
//! Everything here is a function of its arguments: the node has the sockets and the clock. A
//! datagram may be anything at all; it never makes anything panic, and what it asks is bounded by
//! [`limits`].

pub mod proto;

pub mod robots;

pub mod control;

pub mod vsss;

pub mod grsim;

pub mod orders;

pub mod room;

pub mod specs;

pub mod field;

pub mod geometry;

pub mod vision;

pub mod realism;

pub mod tracked;

pub mod frames;

pub mod states;

mod fault;

use std::fmt;

use glam::DVec2;

pub use crate::scene::league::{Member as RobotName, Team};
pub use fault::{Code, Fault, Faults};

/// The bounds of what a datagram may ask.
pub mod limits {
    /// Robots of a team are numbered below this, as on their lids.
    pub const ROBOTS_PER_TEAM: u32 = 16;
    /// Largest speed accepted, m/s.
    pub const SPEED_MAX_MPS: f64 = 100.0;
    /// Largest turning rate accepted, rad/s.
    pub const TURN_MAX_RADPS: f64 = 1_000.0;
    /// Largest coordinate accepted, m.
    pub const PLACE_MAX_M: f64 = 1_000.0;
    /// Simulation speeds accepted; 0 is a pause.
    pub const SIMULATION_SPEED_MAX: f64 = 1_000.0;
    /// Most errors told in an answer: it must fit into a datagram.
    pub const FAULTS_TOLD: usize = 32;
    /// Longest datagram read, bytes: the field of a league with its cameras takes a quarter.
    pub const DATAGRAM_BYTES: usize = 16_384;
    /// Most commands read in a datagram, several for each robot.
    pub const COMMANDS_PER_DATAGRAM: usize = 256;
    /// Longest delay of vision, s, and most frames in it at any rate.
    pub const DELAY_MAX_S: f64 = 1.0;
    /// Largest rate of vision, 1/s of simulated time.
    pub const VISION_RATE_MAX_HZ: f64 = 1_000.0;
}

impl fmt::Display for RobotName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let team = match self.team {
            Team::Blue => "blue",
            Team::Yellow => "yellow",
        };
        write!(f, "{team}_{}", self.number)
    }
}

/// The game at one instant, as all outputs see it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View {
    /// Simulated time, s.
    pub time: f64,
    /// Centre (m) and velocity (m/s) of the ball, if there is one.
    pub ball: Option<(DVec2, DVec2)>,
    /// The robots, by their names.
    pub robots: Vec<Seen>,
    /// Goals of blue and yellow.
    pub score: [u32; 2],
    /// The ball's last kick, if it still moves from there.
    pub kicked: Option<Kicked>,
}

/// A ball that a robot has kicked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kicked {
    /// Who has, if it is still there.
    pub by: Option<RobotName>,
    /// Where the ball was, m.
    pub position: DVec2,
    /// Its velocity then, m/s.
    pub velocity: DVec2,
    /// When, s of simulated time.
    pub time: f64,
    /// When (s of simulated time) and where (m) it will stop if it meets nobody; nothing if it
    /// never does.
    pub stop: Option<(f64, DVec2)>,
}

/// A robot at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Its name.
    pub name: RobotName,
    /// Centre, m.
    pub position: DVec2,
    /// m/s
    pub velocity: DVec2,
    /// Where it looks, rad, 0 along x, against the clock.
    pub heading: f64,
    /// rad/s
    pub turn: f64,
    /// m
    pub radius: f64,
    /// m
    pub height: f64,
}
