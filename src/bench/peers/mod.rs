//! `carom bench peers`: other engines beside carom's own methods, on the same scenes.
//!
//! Box2D and Rapier as people use them, in f32, with what their settings allow for elastic discs:
//! restitution 1, no friction, no damping, no sleep, no threshold below which nothing bounces, no
//! limit of speed. All start from one [gas] that carom's exact method has melted, and take turns.
//! A run that lost a disc is told without a time. Feature `peers`: nothing of it is in other
//! builds.
//!
//! | file | holds |
//! |---|---|
//! | `stretch` | the gas: time, energy, contacts, overlaps |
//! | `isolated` | one oblique collision against its closed form |
//! | `own`, `box2d`, `rapier` | one engine each, behind one seam |
//! | `table` | what a person reads |
//!
//! [gas]: super::gas

mod box2d;
mod isolated;
mod own;
mod rapier;
mod stretch;
mod table;

use std::fmt;
use std::io::{self, Write};

use serde::Serialize;

use super::BenchError;
use super::gas::Gas;
use crate::scene::lattice::Lattice;
use crate::world::{Disc, Pace, Walls};
pub(crate) use box2d::Box2d;
pub use isolated::Isolated;
pub(crate) use rapier::Rapier;
pub use stretch::Row;

/// Timed runs of every row, of which the median and the least are told.
const REPEATS: usize = 5;

/// What is compared, and how it is told.
#[derive(Clone, Debug)]
pub struct Options {
    /// Discs of the gas.
    pub discs: usize,
    /// Share of the area that they cover.
    pub area_fraction: f64,
    /// Simulated time of a run, s; its first tenth warms up and is not timed.
    pub seconds: f64,
    /// Seed of the velocities.
    pub seed: u64,
    /// Lengths of the step, s.
    pub steps: Vec<f64>,
    /// One JSON object instead of words.
    pub json: bool,
}

impl Options {
    fn gas(&self, walled: bool) -> Gas {
        let lattice = Lattice {
            count: self.discs,
            area_fraction: self.area_fraction,
            size_ratio: 1.0,
            mass_max: 1.0,
            walled,
            seed: self.seed,
        };
        Gas { lattice, spread: false, restitution: 1.0, melt: 30.0, step: Pace::default().step }
    }

    fn check(&self) -> Result<(), BenchError> {
        let long = |step: &&f64| self.seconds / **step < 10.0;
        match self.steps.iter().find(long) {
            Some(step) => Err(BenchError::BadUse(format!(
                "{} s are less than ten steps of {step} s: simulate longer",
                self.seconds
            ))),
            None => Ok(()),
        }
    }
}

/// Who moves the discs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Mover {
    /// carom, exact, between walls.
    Events,
    /// carom, exact, in a periodic box, which the others do not have.
    EventsPeriodic,
    /// carom, steps of fixed length.
    Steps,
    /// Box2D.
    Box2d,
    /// Rapier.
    Rapier,
    /// Rapier, told to look at every contact anew at each step.
    RapierFresh,
}

impl Mover {
    /// Those that step, as they come.
    const STEPPERS: [Self; 3] = [Self::Steps, Self::Box2d, Self::Rapier];
}

impl fmt::Display for Mover {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Events => "carom events",
            Self::EventsPeriodic => "carom events, periodic",
            Self::Steps => "carom steps",
            Self::Box2d => "Box2D",
            Self::Rapier => "Rapier",
            Self::RapierFresh => "Rapier, not recycling",
        })
    }
}

/// A scene for an engine: elastic discs of 1 kg, without friction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Setup<'a> {
    pub discs: &'a [Disc],
    pub walls: Option<Walls>,
    /// s
    pub step: f64,
    /// Whether contacts are counted, which nobody does whose time is taken.
    pub count: bool,
}

/// An engine with a scene in it, which goes on by steps.
pub(crate) trait Stepper: Sized {
    /// The scene, as the engine holds it.
    fn new(setup: &Setup) -> Result<Self, String>;

    /// One step.
    fn step(&mut self) -> Result<(), String>;

    /// The discs as the engine holds them, in their order.
    fn discs(&self) -> Vec<Disc>;

    /// Contacts of pairs and walls at the last step: those with an impulse.
    fn contacts(&self) -> u64;

    /// Contacts since the start that were never resolved, where the engine tells.
    fn missed(&self) -> Option<u64> {
        None
    }
}

/// All that was found.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// Discs of the gas.
    pub discs: usize,
    /// Share of the area that they cover.
    pub area_fraction: f64,
    /// Simulated time of a run, s.
    pub seconds: f64,
    /// Seed of the velocities.
    pub seed: u64,
    /// Timed runs of every row.
    pub repeats: usize,
    /// The gas, by engine and step.
    pub gas: Vec<Row>,
    /// One collision, by engine and step.
    pub isolated: Vec<Isolated>,
}

/// Compares and tells.
///
/// # Errors
/// [`BenchError`]; where carom's exact method is wrong, nothing is told at all.
pub fn bench(options: &Options, out: &mut impl Write) -> Result<(), BenchError> {
    let comparison = compare(options)?;
    if options.json {
        let text = serde_json::to_string_pretty(&comparison).map_err(io::Error::from)?;
        return Ok(writeln!(out, "{text}")?);
    }
    table::tell(&comparison, out)?;
    Ok(())
}

/// Compares.
///
/// # Errors
/// As [`bench()`].
pub fn compare(options: &Options) -> Result<Comparison, BenchError> {
    options.check()?;
    let gas = stretch::rows(options)?;
    let isolated = isolated::rows(&options.steps).map_err(BenchError::Wrong)?;
    Ok(Comparison {
        discs: options.discs,
        area_fraction: options.area_fraction,
        seconds: options.seconds,
        seed: options.seed,
        repeats: REPEATS,
        gas,
        isolated,
    })
}
