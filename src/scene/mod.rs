//! Scenes: an arena and its pucks, from a YAML file or shipped with the program.
//!
//! [`mod@file`] is the format and its checks, [`league`] what robot soccer adds to it;
//! [`batch`] places random pucks from a seed,
//! [`lattice`] on a lattice; [`shipped`] are the scenes in `config/`. Nothing here moves.

pub mod file;

pub mod league;

mod boundary;

pub mod batch;

pub mod lattice;

pub mod spread;

pub mod shipped;

use std::fmt;
use std::fs::{File, Metadata};
use std::io::Read;
use std::sync::Arc;

use crate::plan::budget::Wish;
use crate::plan::{Method, Plan};
use crate::referee::{CRASH_SPEED_MPS, Posts, Referee};
use crate::world::{Ball, Disc, Drive, Settings, World, limits};
use glam::DVec2;
use league::{Field, Member, Team};

/// Everything that a run begins with.
#[derive(Clone, Debug)]
pub struct Scene {
    /// What it is, for people.
    pub name: String,
    /// The laws and settings of its world.
    pub settings: Settings,
    /// The simulated pucks, in the order of their ids.
    pub pucks: Vec<Puck>,
    /// How the node runs it.
    pub node: NodeSettings,
    /// The field as its league measures it, if it is one.
    pub field: Option<Field>,
    /// The names of the segments, in their order.
    pub segment_names: Vec<String>,
    /// The file that it was read from, word by word.
    pub text: Arc<str>,
}

impl Scene {
    /// Reads the shipped scene of this name, or else the file at this path.
    ///
    /// # Errors
    /// [`SceneError`] with file, line and column where there is one.
    pub fn load(name_or_path: &str) -> Result<Self, SceneError> {
        if let Some((file, text)) = shipped::find(name_or_path) {
            return file::parse(text, file);
        }
        let error =
            |message: String| SceneError { file: name_or_path.to_owned(), place: None, message };
        let file = File::open(name_or_path).map_err(|cause| {
            let names: Vec<&str> = shipped::names().collect();
            error(format!("{cause}; a path to a scene, or one of {}", names.join(", ")))
        })?;
        // Devices tell no size: what counts is what comes.
        let mut text = String::new();
        let read = file.take(limits::SCENE_FILE_BYTES + 1).read_to_string(&mut text);
        let size = read.map_err(|cause| error(cause.to_string()))?;
        if size as u64 > limits::SCENE_FILE_BYTES {
            return Err(error(format!("larger than {} bytes", limits::SCENE_FILE_BYTES)));
        }
        file::parse(&text, name_or_path)
    }

    /// The same, but not from a pipe, to which nobody may ever write.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn load_without_waiting(name_or_path: &str) -> Result<Self, SceneError> {
        let is_shipped = shipped::find(name_or_path).is_some();
        let waits = |metadata: Metadata| !metadata.is_file() && !metadata.is_dir();
        if !is_shipped && std::fs::metadata(name_or_path).is_ok_and(waits) {
            let message = "neither a file nor the name of a scene".to_owned();
            return Err(SceneError { file: name_or_path.to_owned(), place: None, message });
        }
        Self::load(name_or_path)
    }

    /// Takes another method or step than the file says.
    ///
    /// # Errors
    /// Why the method does not suit the scene.
    pub fn choose(
        &mut self,
        method: Option<Option<Method>>,
        step: Option<f64>,
    ) -> Result<(), String> {
        let mut settings = self.settings;
        settings.method = method.unwrap_or(settings.method);
        settings.pace.step = step.unwrap_or(settings.pace.step);
        let discs: Vec<Disc> = self.pucks.iter().map(|puck| puck.disc).collect();
        Plan::of(&settings, &discs).choose(settings.method, &settings, &discs)?;
        self.settings = settings;
        Ok(())
    }

    /// How its pucks move: as it says, or as the plan chooses.
    pub fn method(&self) -> Method {
        let discs: Vec<Disc> = self.pucks.iter().map(|puck| puck.disc).collect();
        self.settings.method.unwrap_or_else(|| Plan::of(&self.settings, &discs).method)
    }

    /// Who watches the robots of its teams, if there are two, and the goals of its field.
    pub fn referee(&self) -> Option<Referee> {
        let team = |puck: &Puck| Some((puck.disc.id, puck.member?.team as u8));
        let robots: Vec<(u32, u8)> = self.pucks.iter().filter_map(team).collect();
        let are_two = robots.iter().any(|(_, team)| *team != robots[0].1);
        let referee = are_two.then(|| Referee::new(&robots, CRASH_SPEED_MPS))?;
        let ball = self.pucks.iter().find(|puck| puck.ball.is_some());
        Some(match (self.field, ball) {
            (Some(field), Some(ball)) => referee.with_goals(self.posts(&field), ball.disc.id),
            _ => referee,
        })
    }

    /// A team's own goal is on the side on which it stands at first.
    fn posts(&self, field: &Field) -> Posts {
        let is_blue = |puck: &&Puck| puck.member.is_some_and(|member| member.team == Team::Blue);
        let place: f64 = self.pucks.iter().filter(is_blue).map(|puck| puck.disc.position.x).sum();
        let at_left = if place > 0.0 { Team::Blue } else { Team::Yellow };
        Posts {
            line: 0.5 * field.length,
            half_width: 0.5 * field.goal_width,
            scorer_at_left: at_left as u8,
        }
    }

    /// The world at time 0.
    pub fn world(&self) -> World {
        let discs: Vec<Disc> = self.pucks.iter().map(|puck| puck.disc).collect();
        let mut world = World::new(self.settings, &discs);
        let driven = self.pucks.iter().filter(|puck| puck.driven);
        driven.for_each(|puck| world.drive(puck.disc.id, puck.drive));
        let balls = self.pucks.iter().filter_map(|puck| Some((puck.disc.id, puck.ball?)));
        balls.for_each(|(id, ball)| world.add_ball(id, ball));
        world.watch(self.referee());
        world
    }
}

/// A simulated puck.
#[derive(Clone, Debug, PartialEq)]
pub struct Puck {
    /// Its name, a token of topic names.
    pub name: String,
    /// The namespace of its topics, without slashes at its ends; mostly none.
    pub namespace: String,
    /// Its id and its state at time 0.
    pub disc: Disc,
    /// Red, green, blue, opacity.
    pub colour: [u8; 4],
    /// Whether `pucks/<name>/cmd_vel` drives it.
    pub driven: bool,
    /// How it follows that.
    pub drive: Drive,
    /// How it slows down, if it is a ball.
    pub ball: Option<Ball>,
    /// Whom it plays for, if it is a robot of a team.
    pub member: Option<Member>,
}

impl Default for Puck {
    /// A puck of 1 m and 1 kg that nobody drives.
    fn default() -> Self {
        let (position, velocity) = (DVec2::ZERO, DVec2::ZERO);
        Self {
            name: String::new(),
            namespace: String::new(),
            disc: Disc { id: 0, position, velocity, radius: 1.0, mass: 1.0 },
            colour: file::DEFAULT_COLOUR,
            driven: false,
            drive: Drive::default(),
            ball: None,
            member: None,
        }
    }
}

impl Puck {
    /// The name of a topic of its own, such as `cmd_vel`.
    pub fn topic(&self, last: &str) -> String {
        let Self { namespace, name, .. } = self;
        let slash = if namespace.is_empty() { "" } else { "/" };
        format!("{namespace}{slash}pucks/{name}/{last}")
    }
}

/// How the node runs a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeSettings {
    /// Rate of `arena_states`, 1/s of simulated time.
    pub publish_rate_hz: f64,
    /// Frame of everything that the arena publishes.
    pub frame_id: String,
    /// Topics on which circles are reported.
    pub circle_topics: Vec<String>,
    /// Bounds of error and run time, by which the method is chosen.
    pub wish: Wish,
}

/// Why a scene was refused: one line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub struct SceneError {
    /// The file, as it was named.
    pub file: String,
    /// Line and column, from 1.
    pub place: Option<(u64, u64)>,
    /// What is wrong, and what would be right.
    pub message: String,
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place {
            Some((line, column)) => write!(f, "{}:{line}:{column}: {}", self.file, self.message),
            None => write!(f, "{}: {}", self.file, self.message),
        }
    }
}
