//! The plan: what a scene needs, decided once and only here. What it does not need is left out.

use std::fmt;

use glam::DVec2;
use serde::Serialize;

use crate::motion::events::Events;
use crate::motion::plain::{Laws, is_extreme};
use crate::world::{Disc, Settings};

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
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Plain => "plain",
            Self::Events => "events",
        })
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
    /// Whether times of impact need units of their own.
    pub extreme_units: bool,
    /// Whether time is mapped for discs that slow down; without drag that changes no bit.
    pub drag: bool,
}

impl Plan {
    /// Decides for these settings and pucks.
    pub fn of(settings: &Settings, pucks: &[Disc]) -> Self {
        let radius = pucks.iter().map(|puck| puck.radius).fold(f64::INFINITY, f64::min);
        let speed = pucks.iter().map(|puck| puck.velocity.length()).fold(0.0, f64::max);
        let scale = radius / speed;
        // Slow pucks, which commands will set in motion: at something like 1 m/s.
        let epoch = if scale > 0.0 { scale.min(radius.min(1.0)) } else { radius.min(1.0) };
        let wall = settings.walls.map_or(1.0, |walls| walls.restitution);
        let loses_energy = settings.restitution.min(wall) < 1.0;
        let contact_time = settings.contact_time.unwrap_or(CONTACT_TIME_SCALE * epoch);
        let mut plan = Self {
            method: Method::Plain,
            epoch,
            contact_time: if loses_energy { contact_time } else { 0.0 },
            extreme_units: pucks.iter().any(is_extreme),
            drag: settings.drag != 0.0,
        };
        if pucks.len() > ALL_PAIRS_UP_TO && Events::suits(&plan.laws(settings), pucks) {
            plan.method = Method::Events;
        }
        plan
    }

    /// Takes the method that somebody asked for instead.
    ///
    /// # Errors
    /// Why that method does not suit the scene.
    pub fn choose(
        &mut self,
        method: Option<Method>,
        settings: &Settings,
        pucks: &[Disc],
    ) -> Result<(), String> {
        let Some(method) = method else { return Ok(()) };
        if method == Method::Events && !Events::suits(&self.laws(settings), pucks) {
            let lacks = "gravity, extreme units and periodic boxes of less than five diameters";
            return Err(format!("method events does not do {lacks}"));
        }
        self.method = method;
        Ok(())
    }

    /// The laws of the arena, with the parts that it needs.
    pub fn laws(&self, settings: &Settings) -> Laws {
        Laws {
            restitution: settings.restitution,
            walls: settings.walls,
            periodic: settings.periodic,
            drag: settings.drag,
            gravity: settings.gravity.filter(|gravity| *gravity != DVec2::ZERO),
            contact_time: self.contact_time,
            extreme_units: self.extreme_units,
        }
    }

    /// How to find the touching pairs of so many discs.
    pub fn broad_phase(&self, discs: usize) -> BroadPhase {
        if discs <= ALL_PAIRS_UP_TO { BroadPhase::AllPairs } else { BroadPhase::Grid }
    }
}
