//! carom's methods with their settings, as the figures let them move a scene.
//!
//! Whatever a figure compares goes through here, so that all methods start alike, are looked at
//! alike, and none counts for itself what costs time.

use crate::exact::{DoubleDouble, RunningSum};
use crate::motion::arena::Arena;
use crate::motion::steps::{Stepping, Steps};
use crate::plan::{Method, Plan};
use crate::report::judge::Truth;
use crate::world::{Contact, Disc, Owner, Pace, Settings};

/// A scene and how long it runs.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Walls and restitution.
    pub settings: Settings,
    /// The discs; their ids are their indices.
    pub discs: Vec<Disc>,
    /// Simulated time, s.
    pub until: f64,
}

/// A method and what it needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mover {
    /// Exact, cells and a calendar.
    Events,
    /// Exact, all pairs, twice the digits.
    Plain,
    /// Exact, ticks of so many seconds.
    Ticks(f64),
    /// Steps of so many seconds.
    Steps(f64),
    /// Springs.
    Springs {
        /// N/m
        stiffness: f64,
        /// s
        step: f64,
    },
}

impl Mover {
    /// The method.
    pub fn method(self) -> Method {
        match self {
            Self::Events => Method::Events,
            Self::Plain => Method::Plain,
            Self::Ticks(_) => Method::Ticks,
            Self::Steps(_) => Method::Steps,
            Self::Springs { .. } => Method::Springs,
        }
    }

    /// Its settings as a person reads them; empty where there are none.
    pub fn note(self) -> String {
        match self {
            Self::Events | Self::Plain => String::new(),
            Self::Ticks(length) | Self::Steps(length) => seconds(length),
            Self::Springs { stiffness, step } => {
                format!("{} N/m, {}", power(stiffness), seconds(step))
            }
        }
    }

    /// An arena at the start of a scene.
    ///
    /// # Errors
    /// What the method does not do.
    pub fn arena(self, scene: &Scene) -> Result<Arena, String> {
        let mut pace = Pace::default();
        match self {
            Self::Ticks(length) => pace.tick = length,
            Self::Springs { stiffness, step } => (pace.stiffness, pace.step) = (stiffness, step),
            _ => {}
        }
        let settings = Settings { pace, ..scene.settings };
        let mut plan = Plan::of(&settings, &scene.discs);
        plan.choose(Some(self.method()), &settings, &scene.discs)?;
        let laws = plan.laws(&settings);
        if let Self::Steps(step) = self {
            // What was missed is not counted: that would cost time.
            let stepping = Stepping { count_missed: false, ..Stepping::of(step) };
            let steps = Steps::new(laws, &scene.discs, stepping);
            return Ok(Arena::Steps(Box::new(steps.map_err(|error| error.to_string())?)));
        }
        Arena::build(&plan, laws, &scene.discs)
    }
}

/// A time as `1/240 s` where it is one.
pub fn seconds(length: f64) -> String {
    let rate = 1.0 / length;
    if rate > 1.5 && (rate - rate.round()).abs() < 1e-9 * rate {
        return format!("1/{rate:.0} s");
    }
    format!("{length} s")
}

/// A number as `1e6` where it is a power of ten.
pub fn power(number: f64) -> String {
    format!("{number:e}")
}

/// Moves an arena on.
///
/// # Errors
/// Why it does not go on.
pub fn pass(arena: &mut Arena, until: f64) -> Result<(), String> {
    while arena.now() < until {
        arena.pass(until).map_err(|halt| halt.to_string())?;
    }
    Ok(())
}

/// The same, and who met whom.
///
/// # Errors
/// As [`pass`].
pub fn contacts(arena: &mut Arena, until: f64) -> Result<Vec<Contact>, String> {
    let mut contacts = Vec::new();
    while arena.now() < until {
        arena.advance(until, &mut contacts).map_err(|halt| halt.to_string())?;
    }
    Ok(contacts)
}

/// The discs of an arena now.
pub fn discs(arena: &Arena) -> Vec<Disc> {
    arena.discs(Owner::Simulated).collect()
}

/// By how much places are off the true ones.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Error {
    /// The worst disc, in smallest radii.
    pub worst: f64,
    /// Root mean square, in smallest radii.
    pub rms: f64,
    /// The median disc, in smallest radii.
    pub median: f64,
}

impl Error {
    /// Of discs in the order of the truth; not a number where one has no place.
    pub fn of(discs: &[Disc], truth: &Truth) -> Self {
        let radius = discs.iter().map(|disc| disc.radius).fold(f64::INFINITY, f64::min);
        let off = |(k, disc): (usize, &Disc)| truth.distance_m(k, disc) / radius;
        let mut off: Vec<f64> = discs.iter().enumerate().map(off).collect();
        let squares: RunningSum = off.iter().map(|off| off * off).collect();
        // A maximum that no NaN slips through.
        let worst = off.iter().fold(0.0, |worst: f64, &off| if off <= worst { worst } else { off });
        off.sort_by(f64::total_cmp);
        let median = off.get(off.len() / 2).copied().unwrap_or(0.0);
        Self { worst, rms: (squares.value() / off.len().max(1) as f64).sqrt(), median }
    }
}

/// Kinetic energy of discs, J, without rounding.
pub fn energy(discs: &[Disc]) -> DoubleDouble {
    let one = |disc: &Disc| {
        let [x, y] = [disc.velocity.x, disc.velocity.y].map(|v| DoubleDouble::product(v, v));
        x.plus(y).times_double(0.5 * disc.mass)
    };
    discs.iter().map(one).fold(DoubleDouble::default(), DoubleDouble::plus)
}

/// Signed relative difference of two energies.
pub fn drift(before: DoubleDouble, after: DoubleDouble) -> f64 {
    after.minus(before).value() / before.value()
}
