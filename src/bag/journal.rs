//! The journal of a run: what was asked of the world, and to which instant it then moved.
//!
//! A bag that carom records of itself has it as text on a topic of its own, a JSON object a line,
//! between the messages that came of it. With the scene it is all that a run depends on. Numbers
//! are written so that the same bits are read back.

use std::collections::BTreeMap;

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::decode;
use crate::messages::Header;
use crate::scene::Scene;
use crate::world::{Ball, Command, Disc, DiscId, Drive, Frame, Kicker, Model, Report, Wanted};

/// The last name of the topic; it is private to the node.
pub const TOPIC: &str = "~/journal";
/// The name of the note with all that a run begins with.
pub const NOTE: &str = "carom";

/// Something that was done to the world. Small, for most are steps, noted at each tick: what is
/// rare or large is boxed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Entry {
    /// One step: of what was asked, then to an instant.
    Step {
        /// Simulated time to advance to, s.
        to: f64,
        /// What makes circles stale, s; nothing where it does not matter.
        heard: Option<f64>,
        /// What was asked.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        asked: Option<Box<Asked>>,
    },
    /// A world with these pucks instead, at time 0.
    World {
        /// The pucks.
        pucks: Vec<Line>,
    },
    /// A puck of it has a drive.
    Driven {
        /// The puck.
        id: DiscId,
        /// How it moves.
        drive: Box<DriveLine>,
    },
    /// A puck of it is a ball.
    Ball {
        /// The puck.
        id: DiscId,
        /// How it slows down.
        ball: Ball,
    },
    /// A world of another scene instead; of none, where there is no text.
    Scene {
        /// The scene.
        text: Option<String>,
    },
    /// A setting of the world has another value.
    Setting {
        /// As the parameter is called.
        name: String,
        /// Its value.
        value: f64,
    },
    /// All observed circles are forgotten.
    Forget {},
    /// So many messages were not recorded before this.
    Dropped {
        /// How many.
        messages: u64,
    },
}

impl Entry {
    /// From the payload of a message of its topic.
    ///
    /// # Errors
    /// Why it is none.
    pub fn read(payload: &[u8]) -> Result<Self, String> {
        let text = decode::message::<String>(payload).map_err(|error| error.to_string())?;
        serde_json::from_str(&text).map_err(|error| error.to_string())
    }
}

/// What was asked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Asked {
    /// The last message of this topic.
    Message {
        /// Its whole name.
        topic: String,
    },
    /// Circles that somebody reports.
    Circles {
        /// Of the message, for the answer.
        sec: i32,
        /// Of the message, for the answer.
        nanosec: u32,
        /// Of the message, for the answer.
        frame_id: String,
        /// The circles.
        circles: Vec<Line>,
    },
    /// A velocity of a puck.
    Velocity {
        /// The puck.
        id: DiscId,
        /// m/s
        velocity: [f64; 2],
    },
    /// Where a driven puck shall go.
    Drive {
        /// The puck.
        id: DiscId,
        /// m/s
        linear: [f64; 2],
        /// rad/s
        angular: f64,
        /// The frame of the velocity; nothing = the robot's own.
        #[serde(default, skip_serializing_if = "is_own")]
        frame: Frame,
    },
    /// A kick.
    Kick {
        /// The robot.
        id: DiscId,
        /// m/s
        speed: f64,
    },
    /// A dribbler.
    Dribble {
        /// The robot.
        id: DiscId,
        /// Whether it runs.
        on: bool,
    },
    /// A force to a place, or none any more.
    Pull {
        /// The robot or ball.
        id: DiscId,
        /// m
        to: Option<[f64; 2]>,
    },
    /// Another pose.
    Turn {
        /// The robot.
        id: DiscId,
        /// rad
        heading: f64,
        /// rad/s
        turn: f64,
    },
    /// Other limits.
    Limits {
        /// The robot.
        id: DiscId,
        /// What it can.
        drive: DriveLine,
    },
    /// A ball that rolls.
    Roll {
        /// The ball.
        id: DiscId,
    },
    /// A puck more.
    Add {
        /// The puck.
        puck: Line,
    },
    /// A puck less.
    Remove {
        /// The puck.
        id: DiscId,
    },
    /// A puck elsewhere.
    Place {
        /// The puck.
        id: DiscId,
        /// m
        position: [f64; 2],
        /// m/s
        velocity: [f64; 2],
    },
    /// Walls elsewhere.
    Walls {
        /// m
        min: [f64; 2],
        /// m
        max: [f64; 2],
    },
}

/// A disc: its id, position (m), velocity (m/s), radius (m) and mass (kg; nothing = infinite).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line(DiscId, f64, f64, f64, f64, f64, Option<f64>);

impl Line {
    /// Of a disc.
    pub fn new(disc: &Disc) -> Self {
        let Disc { id, position: at, velocity, radius, mass } = *disc;
        Self(id, at.x, at.y, velocity.x, velocity.y, radius, mass.is_finite().then_some(mass))
    }

    /// The disc.
    pub fn disc(self) -> Disc {
        let Self(id, x, y, vx, vy, radius, mass) = self;
        let mass = mass.unwrap_or(f64::INFINITY);
        Disc { id, position: DVec2::new(x, y), velocity: DVec2::new(vx, vy), radius, mass }
    }
}

fn is_own(frame: &Frame) -> bool {
    *frame == Frame::Own
}

/// A drive, its four limits (nothing = none), its first heading (rad), and what few have.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DriveLine(
    Model,
    [Option<f64>; 4],
    f64,
    #[serde(default, skip_serializing_if = "Option::is_none")] Option<Extra>,
);

/// What few drives have.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Extra {
    /// m/s^2 and rad/s^2; nothing = as it speeds up.
    braking: [Option<f64>; 2],
    /// Speed (m/s), half angle (rad), reach (m) and grip (m/s^2).
    kicker: Option<[f64; 4]>,
}

impl DriveLine {
    /// Of a drive.
    pub fn new(drive: &Drive) -> Self {
        let Drive { speed_max, acceleration_max, turn_max, turn_acceleration_max, .. } = *drive;
        let limits = [speed_max, acceleration_max, turn_max, turn_acceleration_max];
        let limits = limits.map(|limit| limit.is_finite().then_some(limit));
        let braking = [drive.braking_max, drive.turn_braking_max];
        let kicker = drive.kicker.map(|kicker| {
            let Kicker { speed_max, half_angle, reach, grip } = kicker;
            [speed_max, half_angle, reach, grip].map(|number| number.min(f64::MAX))
        });
        let has_more = kicker.is_some() || braking != [None; 2];
        Self(drive.model, limits, drive.heading, has_more.then_some(Extra { braking, kicker }))
    }

    /// The drive.
    pub fn drive(self) -> Drive {
        let Self(model, limits, heading, more) = self;
        let limits = limits.map(|limit| limit.unwrap_or(f64::INFINITY));
        let [speed_max, acceleration_max, turn_max, turn_acceleration_max] = limits;
        let [braking_max, turn_braking_max] = more.map_or([None; 2], |more| more.braking);
        let kicker = more.and_then(|more| more.kicker);
        let kicker = kicker.map(|[speed_max, half_angle, reach, grip]| Kicker {
            speed_max,
            half_angle,
            reach,
            grip,
        });
        Drive {
            model,
            speed_max,
            acceleration_max,
            braking_max,
            turn_max,
            turn_acceleration_max,
            turn_braking_max,
            heading,
            kicker,
        }
    }
}

impl Asked {
    /// Of a command; of a report with the header of its message.
    pub fn new(command: &Command, header: &Header) -> Self {
        match *command {
            Command::Observe(ref report) => Self::Circles {
                sec: header.stamp.sec,
                nanosec: header.stamp.nanosec,
                frame_id: header.frame_id.clone(),
                circles: report.discs.iter().map(Line::new).collect(),
            },
            Command::SetVelocity { id, velocity } => {
                Self::Velocity { id, velocity: velocity.to_array() }
            }
            Command::Drive { id, wanted: Wanted { linear, angular, frame } } => {
                Self::Drive { id, linear: linear.to_array(), angular, frame }
            }
            Command::Kick { id, speed } => Self::Kick { id, speed },
            Command::Dribble { id, on } => Self::Dribble { id, on },
            Command::Pull { id, to } => Self::Pull { id, to: to.map(|to| to.to_array()) },
            Command::Turn { id, heading, turn } => Self::Turn { id, heading, turn },
            Command::SetDrive { id, ref drive } => {
                Self::Limits { id, drive: DriveLine::new(drive) }
            }
            Command::Roll { id } => Self::Roll { id },
            Command::AddPuck(ref disc) => Self::Add { puck: Line::new(disc) },
            Command::RemovePuck { id } => Self::Remove { id },
            Command::PlacePuck { id, position, velocity } => {
                Self::Place { id, position: position.to_array(), velocity: velocity.to_array() }
            }
            Command::MoveWalls { min, max } => {
                Self::Walls { min: min.to_array(), max: max.to_array() }
            }
        }
    }

    /// The command, but for a message, which stands elsewhere.
    pub fn command(&self, time: f64) -> Option<Command> {
        let vector = DVec2::from_array;
        Some(match *self {
            Self::Message { .. } => return None,
            Self::Circles { ref circles, .. } => {
                let discs = circles.iter().map(|circle| circle.disc()).collect();
                Command::Observe(Report { discs, time })
            }
            Self::Velocity { id, velocity } => {
                Command::SetVelocity { id, velocity: vector(velocity) }
            }
            Self::Drive { id, linear, angular, frame } => {
                Command::Drive { id, wanted: Wanted { linear: vector(linear), angular, frame } }
            }
            Self::Kick { id, speed } => Command::Kick { id, speed },
            Self::Dribble { id, on } => Command::Dribble { id, on },
            Self::Pull { id, to } => Command::Pull { id, to: to.map(vector) },
            Self::Turn { id, heading, turn } => Command::Turn { id, heading, turn },
            Self::Limits { id, drive } => Command::SetDrive { id, drive: drive.drive() },
            Self::Roll { id } => Command::Roll { id },
            Self::Add { puck } => Command::AddPuck(puck.disc()),
            Self::Remove { id } => Command::RemovePuck { id },
            Self::Place { id, position, velocity } => {
                let (position, velocity) = (vector(position), vector(velocity));
                Command::PlacePuck { id, position, velocity }
            }
            Self::Walls { min, max } => Command::MoveWalls { min: vector(min), max: vector(max) },
        })
    }
}

/// What a run begins with, as a note: the scene's text, its seeds, this version, the parameters.
pub fn note(scene: &Scene, parameters: &BTreeMap<String, String>) -> BTreeMap<String, String> {
    let after_seed = |line: &str| {
        let (_, rest) = line.split('#').next()?.split_once("seed:")?;
        let digits: String =
            rest.trim_start().chars().take_while(|c| !",} ".contains(*c)).collect();
        Some(digits)
    };
    let seeds: Vec<String> = scene.text.lines().filter_map(after_seed).collect();
    let mut said = BTreeMap::from([
        ("version".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
        ("scene".to_owned(), scene.text.to_string()),
        ("seeds".to_owned(), seeds.join(" ")),
    ]);
    let parameter =
        |(name, value): (&String, &String)| (format!("parameter.{name}"), value.clone());
    said.extend(parameters.iter().map(parameter));
    said
}
