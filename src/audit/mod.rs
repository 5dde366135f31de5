//! The audit: judges the collisions of any simulator from what was recorded of it.
//!
//! ```text
//! frames -> calibrate -> flights -> groups -> verdicts -> findings -> tell, page
//!           noise, law   straight   who may    one or      sums, the
//!           (first ones) or bent    have met   several     worst
//! ```
//!
//! Between two samples discs fly straight but for contacts. From the earlier sample the law says
//! where the discs must be at the later one, with which velocities; from both, a collision of two
//! discs alone can be read in full. See [`Options::tolerance`] for what counts as a violation.
//!
//! It holds two sets of samples at a time, up to 20 more while discs are silent, and the first ones
//! until the law and the noise are known. It reads no file and no clock, and never changes what it
//! is given.

mod alone;

mod chains;

#[cfg(feature = "bags")]
mod commanded;

mod flight;

mod groups;

mod images;

mod judge;

#[cfg(feature = "bags")]
mod observed;

mod overlaps;

#[cfg(feature = "bags")]
mod rounds;

mod run;

mod sequel;

mod silent;

mod survey;

mod verdict;

pub mod findings;

pub mod law;

pub mod noise;

pub mod surroundings;

pub mod tell;

#[cfg(feature = "bags")]
pub mod recorded;

#[cfg(feature = "report")]
pub mod page;

#[cfg(all(feature = "bags", feature = "report"))]
pub mod command;

use std::collections::{HashMap, HashSet};

use glam::DVec2;

use crate::world::{Disc, DiscId, Periodic};
use findings::{Collision, Findings};
use law::Law;
use noise::Noise;
use run::Run;
use surroundings::Surroundings;

/// Samples from which noise and law are learnt.
const LEARNT_FROM: usize = 200_000;

/// Sets of samples from which they are learnt, at most.
const FRAMES_LEARNT_FROM: usize = 20_000;

/// What an audit may be told. All in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Restitution of pairs; `None` = estimated.
    pub restitution: Option<f64>,
    /// The box around; `None` = where discs turn round.
    pub walls: Option<Bounds>,
    /// Whether it is known that there are no walls.
    pub no_walls: bool,
    /// The box that repeats around; not with walls.
    pub periodic: Option<Periodic>,
    /// Acceleration of all discs; `None` = estimated.
    pub gravity: Option<DVec2>,
    /// Linear drag of all discs, 1/s; `None` = estimated.
    pub drag: Option<f64>,
    /// Deviation of a component of a position, m; `None` = measured.
    pub position_noise: Option<f64>,
    /// Deviation of a component of a velocity, m/s; `None` = measured.
    pub velocity_noise: Option<f64>,
    /// What drives may add to a velocity at any time, m/s^2; `None` = nothing.
    pub acceleration_max: Option<f64>,
    /// Drives act so often, s, and then for all of that time at once; 0 = always.
    pub drive_tick: f64,
    /// What else may change velocities, where it is not judged.
    pub surroundings: Surroundings,
    /// What is no violation though it can be seen: of the momentum exchanged, of a restitution, of
    /// the smaller radius; angles in rad. What noise and format allow is none in any case: 5
    /// deviations.
    pub tolerance: f64,
    /// Speed of approach above which collisions are listed as crashes, m/s.
    pub crash_speed: Option<f64>,
}

/// Walls as they are told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lower left corner, m.
    pub min: DVec2,
    /// Upper right corner, m.
    pub max: DVec2,
    /// Restitution; `None` = that of pairs.
    pub restitution: Option<f64>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            restitution: None,
            walls: None,
            no_walls: false,
            periodic: None,
            gravity: None,
            drag: None,
            position_noise: None,
            velocity_noise: None,
            acceleration_max: None,
            drive_tick: 0.0,
            surroundings: Surroundings::default(),
            tolerance: 1e-3,
            crash_speed: None,
        }
    }
}

/// All samples of one stamp.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// The stamp, ns.
    pub time_ns: i64,
    /// States of the discs, each once.
    pub discs: Vec<Disc>,
}

impl Frame {
    fn seconds(&self) -> f64 {
        1e-9 * self.time_ns as f64
    }
}

/// Each two frames one after the other, and the time between them, s; not where time went back.
fn steps(frames: &[Frame]) -> impl Iterator<Item = (&Frame, &Frame, f64)> {
    let steps = frames.iter().zip(frames.iter().skip(1));
    steps.filter_map(|(before, after)| {
        let seconds = 1e-9 * (after.time_ns - before.time_ns) as f64;
        (seconds > 0.0).then_some((before, after, seconds))
    })
}

/// The discs of both frames that are the same in all but their state.
fn alike<'a>(before: &'a Frame, after: &'a Frame) -> impl Iterator<Item = (&'a Disc, &'a Disc)> {
    let mut places: Option<HashMap<DiscId, usize>> = None;
    before.discs.iter().enumerate().filter_map(move |(k, disc)| {
        let same = |other: &&Disc| other.id == disc.id;
        let other = after.discs.get(k).filter(same).or_else(|| {
            let places = places.get_or_insert_with(|| {
                after.discs.iter().enumerate().map(|(k, disc)| (disc.id, k)).collect()
            });
            places.get(&disc.id).map(|&k| &after.discs[k])
        })?;
        let equal = other.radius == disc.radius && other.mass == disc.mass;
        equal.then_some((disc, other))
    })
}

/// Told every collision as it is found.
pub type Listener<'a> = Box<dyn FnMut(&Collision) + 'a>;

/// An audit that goes on.
pub struct Audit<'a> {
    options: Options,
    learning: Vec<Frame>,
    waiting: usize,
    unsound: u64,
    learnt: Option<Run>,
    listener: Listener<'a>,
}

impl<'a> Audit<'a> {
    /// An audit that has heard nothing yet.
    pub fn new(options: Options, listener: Listener<'a>) -> Self {
        let (learning, waiting, unsound, learnt) = (Vec::new(), 0, 0, None);
        Self { options, learning, waiting, unsound, learnt, listener }
    }

    /// Takes the samples of one stamp.
    pub fn hear(&mut self, frame: Frame) {
        let frame = self.sound(frame);
        if let Some(run) = &mut self.learnt {
            run.hear(frame, &mut self.listener);
            return;
        }
        self.waiting += frame.discs.len();
        self.learning.push(frame);
        if self.waiting >= LEARNT_FROM || self.learning.len() >= FRAMES_LEARNT_FROM {
            self.learn();
        }
    }

    /// All that was found.
    pub fn finish(mut self) -> Findings {
        self.learn();
        let Self { learnt, options, unsound, mut listener, .. } = self;
        let run = learnt.unwrap_or_else(|| Run::new(Law::told(&options), Noise::NONE, &options));
        let mut findings = run.finish(&mut listener);
        findings.counts.unsound = unsound;
        findings
    }

    /// Learns noise and law from the first frames, then judges these.
    fn learn(&mut self) {
        if self.learnt.is_some() {
            return;
        }
        let frames = std::mem::take(&mut self.learning);
        let mut law = Law::told(&self.options);
        law.learn_motion(&frames);
        let mut noise = Noise::measure(&frames, &law);
        noise.position = self.options.position_noise.unwrap_or(noise.position);
        noise.velocity = self.options.velocity_noise.unwrap_or(noise.velocity);
        let (mut contacts, turns) = survey::survey(&frames, &law, &noise, self.options.tolerance);
        law.learn_restitution(&mut contacts);
        law.learn_walls(&turns);
        let mut run = Run::new(law, noise, &self.options);
        run.expect_steps_of(&frames);
        for frame in frames {
            run.hear(frame, &mut self.listener);
        }
        self.learnt = Some(run);
    }

    /// Leaves out what is no disc, and ids that are taken.
    fn sound(&mut self, mut frame: Frame) -> Frame {
        let all = frame.discs.len();
        frame.discs.retain(|disc| disc.refusal().is_none());
        if !frame.discs.is_sorted_by(|a, b| a.id < b.id) {
            let mut taken = HashSet::new();
            frame.discs.retain(|disc| taken.insert(disc.id));
        }
        self.unsound += (all - frame.discs.len()) as u64;
        frame
    }
}
