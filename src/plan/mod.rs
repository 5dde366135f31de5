//! The plan: what a scene needs, decided once and only here. What it does not need is left out.

pub mod budget;

pub mod parts;

pub mod why;

use std::fmt;

use glam::DVec2;
use serde::Serialize;

use crate::motion::arena::Arena;
use crate::motion::events::Events;
use crate::motion::plain::Laws;
use crate::motion::springs::{self, Ending, Scheme};
use crate::motion::steps::Stepping;
use crate::world::{Disc, Pace, Segments, Settings, Walls};
use parts::{Part, Parts, brings_energy};

/// Up to so many discs looking at all pairs is quicker than building a grid (measured: `cargo
/// bench --bench resolver`).
const ALL_PAIRS_UP_TO: usize = 48;

/// The contact time of the collapse model in units of radius over speed: far below any mean free
/// time, so that a gas does not notice it (Luding, McNamara, doi:10.1007/s100350050017).
const CONTACT_TIME_SCALE: f64 = 1e-5;

/// How touching pairs are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BroadPhase {
    /// Every pair is looked at.
    AllPairs,
    /// A uniform grid.
    Grid,
}

/// How an arena moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// [`crate::motion::plain`]
    Plain,
    /// [`crate::motion::events`]
    Events,
    /// [`crate::motion::ticks`]
    Ticks,
    /// [`crate::motion::steps`]
    Steps,
    /// [`crate::motion::springs`]
    Springs,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Events, Self::Plain, Self::Ticks, Self::Steps, Self::Springs];

    /// Its name in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Events => "events",
            Self::Ticks => "ticks",
            Self::Steps => "steps",
            Self::Springs => "springs",
        }
    }

    /// The method of a name; `None` = `auto`, the plan chooses.
    ///
    /// # Errors
    /// What would be right.
    pub fn named(name: &str) -> Result<Option<Self>, String> {
        let known = Self::ALL.into_iter().find(|method| method.name() == name);
        if name == "auto" || known.is_some() {
            return Ok(known);
        }
        let names: Vec<&str> = Self::ALL.into_iter().map(Self::name).collect();
        Err(format!("`{name}` is no method: auto, {}", names.join(", ")))
    }

    /// Whether it resolves each contact at its instant.
    pub fn is_exact(self) -> bool {
        matches!(self, Self::Plain | Self::Events | Self::Ticks)
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What was decided for one scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// How the arena moves: all pairs are looked at where they are few, or where a scene needs what
    /// only that method has.
    pub method: Method,
    /// Scale of event times, s: radius over speed.
    pub epoch: f64,
    /// Contact time of the collapse model, s; 0 = left out.
    pub contact_time: f64,
    /// What the scene needs.
    pub needed: Parts,
    /// What is built: that, and what was asked for besides.
    pub built: Parts,
    /// What methods with a step of their own need.
    pub pace: Pace,
}

impl Plan {
    /// Decides for these settings and pucks.
    pub fn of(settings: &Settings, pucks: &[Disc]) -> Self {
        let radius = pucks.iter().map(|puck| puck.radius).fold(f64::INFINITY, f64::min);
        let speed = pucks.iter().map(|puck| puck.velocity.length()).fold(0.0, f64::max);
        let scale = radius / speed;
        // Slow pucks, which commands will set in motion: at something like 1 m/s.
        let epoch = if scale > 0.0 { scale.min(radius.min(1.0)) } else { radius.min(1.0) };
        let loses_energy = loses_energy(settings);
        let contact_time = settings.contact_time.unwrap_or(CONTACT_TIME_SCALE * epoch);
        let mut plan = Self {
            method: Method::Plain,
            epoch,
            contact_time: if loses_energy { contact_time } else { 0.0 },
            needed: Parts::NONE,
            built: Parts::NONE,
            pace: settings.pace,
        };
        plan.needed = Parts::needed(&plan.laws(settings), pucks);
        plan.built = plan.needed;
        if pucks.len() > ALL_PAIRS_UP_TO && Events::suits(&plan.laws(settings), pucks) {
            plan.method = Method::Events;
        }
        plan.build(settings);
        plan
    }

    /// Decides what is built: what is needed, and of what was asked for what can be.
    fn build(&mut self, settings: &Settings) {
        self.built = self.needed;
        let possible = Parts::that_can_be_forced(self.method, &self.laws(settings));
        self.built = self.needed.and(settings.keep.among(possible));
    }

    /// Takes the method that somebody asked for instead.
    ///
    /// # Errors
    /// Why that method does not suit the scene; the plan is then as it was.
    pub fn choose(
        &mut self,
        method: Option<Method>,
        settings: &Settings,
        pucks: &[Disc],
    ) -> Result<(), String> {
        let Some(method) = method else { return Ok(()) };
        let mut plan = Self { method, built: self.needed, ..*self };
        let laws = plan.laws(settings);
        let lacks = match method {
            Method::Steps | Method::Springs if laws.segments.is_some() => {
                Some("segments; take events, ticks or plain")
            }
            Method::Events if laws.segments.is_some() && !laws.are_straight() => {
                Some("segments with gravity, drag or a periodic box")
            }
            Method::Events if !Events::suits(&laws, pucks) => {
                Some("extreme units and periodic boxes of less than five diameters")
            }
            Method::Ticks | Method::Steps | Method::Springs if laws.gravity.is_some() => {
                Some("gravity; take events or plain")
            }
            Method::Ticks | Method::Steps | Method::Springs if laws.drag != 0.0 => {
                Some("drag; take events or plain")
            }
            Method::Springs if laws.periodic.is_some() => Some("periodic boxes; take steps"),
            Method::Springs if settings.walls.is_some() && pucks.iter().any(brings_energy) => {
                Some("fixed pucks that move among walls, which no spring stops; take ticks")
            }
            Method::Springs if loses_energy(settings) => {
                Some("restitution; leave it out and set damping")
            }
            _ => None,
        };
        if let Some(lacks) = lacks {
            return Err(format!("method {method} does not do {lacks}"));
        }
        if matches!(method, Method::Ticks | Method::Steps | Method::Springs) {
            Arena::build(&plan, laws, pucks)?;
        }
        plan.build(settings);
        *self = plan;
        Ok(())
    }

    /// How the method of steps steps: every error is counted, no position corrected.
    pub fn stepping(&self) -> Stepping {
        Stepping::of(self.pace.step)
    }

    /// What springs obey, but for walls.
    pub fn spring_laws(&self) -> springs::Laws {
        let Pace { stiffness, damping, .. } = self.pace;
        springs::Laws { stiffness, damping, ending: Ending::NoAttraction, walls: None }
    }

    /// How springs of so many discs step.
    pub fn spring_stepping(&self, discs: usize) -> springs::Stepping {
        springs::Stepping {
            step: self.pace.step,
            scheme: Scheme::ClosedForm,
            refuse_unstable: true,
            broad_phase: self.broad_phase(discs),
        }
    }

    /// The laws of the arena, with the parts that it needs.
    pub fn laws(&self, settings: &Settings) -> Laws {
        let (walls, segments) = boundary(settings);
        Laws {
            restitution: settings.restitution,
            walls: walls.or(self.built.has(Part::Walls).then_some(Walls::FAR_AWAY)),
            segments,
            periodic: settings.periodic,
            drag: settings.drag,
            gravity: settings.gravity.filter(|gravity| *gravity != DVec2::ZERO),
            contact_time: self.contact_time,
            extreme_units: self.built.has(Part::ExtremeUnits),
        }
    }

    /// How to find the touching pairs of so many discs.
    pub fn broad_phase(&self, discs: usize) -> BroadPhase {
        let few = discs <= ALL_PAIRS_UP_TO && !self.built.has(Part::Grid);
        if few { BroadPhase::AllPairs } else { BroadPhase::Grid }
    }
}

/// The box and the segments around an arena: where the segments are a box, that is enough.
fn boundary(settings: &Settings) -> (Option<Walls>, Option<Segments>) {
    let segments = settings.segments.filter(|segments| !segments.all().is_empty());
    match (settings.walls, segments.and_then(|segments| segments.as_box())) {
        (None, Some(walls)) => (Some(walls), None),
        (walls, _) => (walls, segments),
    }
}

fn loses_energy(settings: &Settings) -> bool {
    let wall = settings.walls.map_or(1.0, |walls| walls.restitution);
    let segment = settings.segments.map_or(1.0, |segments| segments.restitution);
    settings.restitution.min(wall).min(segment) < 1.0
}
