//! Steps of fixed length: discs fly straight for `dt`, then what touches collides.
//!
//! ```text
//! fly -> who is near -> what touches -> (count what was missed) -> collide -> (part overlaps)
//! ```
//!
//! The rough method, here to be compared with. A contact is found up to `dt` late, with an overlap,
//! and each disc of it is then `(1 + e) lag |v_n| mu / m` off for ever: first order in `dt`. Only
//! the pair law changes a velocity, so energy is kept to rounding at restitution 1 whatever `dt`
//! is. Two discs that meet and part within a step are missed: no `dt` is short enough for a grazing
//! contact. Every kind of error is counted, never hidden. (A step that stops at each time of impact
//! is [`super::plain`].)
//!
//! Flights are kept from each disc's own last contact, so that a million steps without one add no
//! rounding. Contacts of a step are resolved in groups that share no disc, by ids in each: the
//! order in which they were found changes nothing. Who is near is kept over many steps
//! ([`super::near`]); [`plain`] finds it anew at each and is the judge: the same bits.
//!
//! A command between two step ends counts from then on; what was missed in such a step is counted
//! as if the disc had flown so all the step. There is no gravity, and no collapse: a step has an
//! end.

mod contacts;
mod edit;
pub mod plain;

use std::collections::HashMap;

use glam::DVec2;

use super::energy::EnergyAccount;
use super::momentum::MomentumAccount;
use super::near::Near;
use super::near::lanes::{Flight, Pairs};
use super::plain::Laws;
use super::{Nobody, Witness};
use crate::detect::{Pair, TooManyPairs};
use crate::exact::RunningSum;
use crate::world::{Contact, Disc, DiscId, Owner, limits};

/// How to step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stepping {
    /// Length of a step, s.
    pub step: f64,
    /// Sweeps of the overlap correction after each step; 0 = left out.
    pub overlap_sweeps: usize,
    /// Whether to count contacts that were never resolved, which costs a test of each near pair.
    pub count_missed: bool,
}

impl Stepping {
    /// Steps of this length (s), nothing corrected, all errors counted.
    pub fn of(step: f64) -> Self {
        Self { step, overlap_sweeps: 0, count_missed: true }
    }

    fn check(&self, laws: &Laws) -> Result<(), NotInSteps> {
        if !(self.step > 0.0 && self.step.is_finite()) {
            return Err(NotInSteps::BadStep(self.step));
        }
        if laws.gravity.is_some() { Err(NotInSteps::Gravity) } else { Ok(()) }
    }
}

/// What this method cannot do.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NotInSteps {
    /// A step that is no length of time.
    #[error("step = {0} s, must be a finite number above 0")]
    BadStep(f64),
    /// Discs would not fly straight.
    #[error("steps know no gravity; take the method plain or events")]
    Gravity,
}

/// Contacts that the steps did not see when they happened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unseen {
    /// Resolved after they had begun: with an overlap.
    pub late: u64,
    /// Found when the discs had passed each other and parted already: never resolved.
    pub too_late: u64,
    /// Pairs whose paths met within a step, and that did not touch at its ends: never resolved.
    pub missed: u64,
}

/// The two largest speeds of different discs, m/s; never too low.
#[derive(Clone, Copy, Debug, Default)]
struct Fastest(f64, f64);

impl Fastest {
    fn of(velocities: &[DVec2]) -> Self {
        let (mut first, mut second) = (0.0f64, 0.0f64);
        for velocity in velocities {
            let square = velocity.length_squared();
            if square > second {
                (first, second) = if square > first { (square, first) } else { (first, square) };
            }
        }
        if first > 1e-250 && first.is_finite() {
            return Self(first.sqrt(), second.max(1e-280).sqrt());
        }
        let mut fastest = Self::default();
        velocities.iter().for_each(|velocity| fastest.note(*velocity));
        fastest
    }

    fn note(&mut self, velocity: DVec2) {
        let speed = velocity.length();
        // A square may have under- or overflown.
        let speed = if speed > 1e-140 { speed } else { 2.0 * velocity.abs().max_element() };
        self.1 = self.1.max(speed.min(self.0));
        self.0 = self.0.max(speed);
    }

    /// By how much two discs come closer in a time at most, m.
    fn closer(&self, time: f64) -> f64 {
        (self.0 + self.1) * time * (1.0 + 1e-9)
    }
}

/// The state of an arena under the stepped method.
#[derive(Clone, Debug)]
pub struct Steps {
    laws: Laws,
    stepping: Stepping,
    now: f64,
    /// Steps done.
    count: u64,
    /// Where and when, in steps, the straight flight of each disc began.
    starts: Vec<DVec2>,
    began: Vec<f64>,
    velocities: Vec<DVec2>,
    /// Where the discs are at the step end.
    places: Vec<DVec2>,
    radii: Vec<f64>,
    radius_max: f64,
    masses: Vec<f64>,
    ids: Vec<DiscId>,
    owners: Vec<Owner>,
    /// Where a disc of an id is, once somebody asked.
    index: Option<HashMap<(Owner, DiscId), usize>>,
    /// Whether some pairs have no contacts of ours: of observed discs, or of fixed ones.
    some_pass: bool,
    near: Near,
    fastest: Fastest,
    /// How far the last step moved discs beside their flights, m.
    pushed: f64,
    scratch: Scratch,
    energy: EnergyAccount,
    momentum: MomentumAccount,
    unseen: Unseen,
    largest_overlap: f64,
    /// The same of any pair, m.
    deepest: f64,
    contacts: u64,
}

/// Buffers that are kept.
#[derive(Clone, Debug, Default)]
struct Scratch {
    /// Discs that may touch a wall.
    outside: Vec<u32>,
    near: Pairs,
    touching: Vec<Pair>,
    together: Vec<Pair>,
    /// How many touching pairs a disc is in.
    shared: Vec<u32>,
    /// Discs whose velocity changed, and what it was.
    changed: Vec<(u32, DVec2)>,
    contacts: Vec<Contact>,
}

impl Steps {
    /// An arena at time 0.
    ///
    /// # Errors
    /// [`NotInSteps`].
    pub fn new(laws: Laws, discs: &[Disc], stepping: Stepping) -> Result<Self, NotInSteps> {
        stepping.check(&laws)?;
        let mut arena = Self {
            laws,
            stepping,
            now: 0.0,
            count: 0,
            starts: Vec::with_capacity(discs.len()),
            began: Vec::with_capacity(discs.len()),
            velocities: Vec::with_capacity(discs.len()),
            places: Vec::new(),
            radii: Vec::with_capacity(discs.len()),
            radius_max: 0.0,
            masses: Vec::with_capacity(discs.len()),
            ids: Vec::with_capacity(discs.len()),
            owners: Vec::with_capacity(discs.len()),
            index: None,
            some_pass: false,
            near: Near::new(laws.periodic),
            fastest: Fastest::default(),
            pushed: 0.0,
            scratch: Scratch::default(),
            energy: EnergyAccount::default(),
            momentum: MomentumAccount::default(),
            unseen: Unseen::default(),
            largest_overlap: 0.0,
            deepest: 0.0,
            contacts: 0,
        };
        for disc in discs {
            arena.push(disc, Owner::Simulated, 0.0);
            arena.energy.book(disc.kinetic_energy());
        }
        arena.note_who_passes();
        Ok(arena)
    }

    /// The present, s since the start.
    pub fn now(&self) -> f64 {
        self.now
    }

    /// The discs of one owner as they are now: since the last step end they fly straight.
    pub fn discs(&self, owner: Owner) -> impl Iterator<Item = Disc> + '_ {
        let all = 0..self.ids.len();
        all.filter(move |&k| self.owners[k] == owner).map(|k| self.disc_now(k))
    }

    /// Kinetic energy of the simulated discs, J.
    pub fn kinetic_energy(&self) -> f64 {
        let simulated = (0..self.ids.len()).filter(|&k| self.owners[k] == Owner::Simulated);
        simulated.map(|k| self.disc(k).kinetic_energy()).collect::<RunningSum>().value()
    }

    /// Signed relative energy error, with all work accounted for.
    pub fn relative_energy_drift(&self) -> f64 {
        self.energy.relative_drift(self.kinetic_energy())
    }

    /// Keeps account of the momentum from now on.
    pub fn keep_momentum(&mut self) {
        let mut account = self.momentum;
        account.begin(self.discs(Owner::Simulated));
        self.momentum = account;
    }

    /// Momentum gained by error, N s, while an account is kept.
    pub fn momentum_drift(&self) -> Option<DVec2> {
        self.momentum.drift(self.now, self.discs(Owner::Simulated))
    }

    /// Largest overlap of a pair at any contact, in units of the smaller radius.
    pub fn largest_overlap(&self) -> f64 {
        self.largest_overlap
    }

    /// Largest overlap of a pair at any contact, m.
    pub fn largest_overlap_m(&self) -> f64 {
        self.deepest
    }

    /// Contacts resolved since the start, pairs and walls.
    pub fn contacts(&self) -> u64 {
        self.contacts
    }

    /// Contacts seen late, too late or never (the last two if [`Stepping::count_missed`]).
    pub fn unseen(&self) -> Unseen {
        self.unseen
    }

    /// Steps since the start.
    pub fn steps(&self) -> u64 {
        self.count
    }

    /// Moves on to `until` (s) by the whole steps on the way, and adds their contacts; nothing
    /// happens if that is past. Results do not depend on where one stops to look.
    ///
    /// Stops short of `until` after [`limits::STEPS_PER_ADVANCE`] steps: [`Self::now`] tells, and
    /// calling again goes on.
    ///
    /// # Errors
    /// [`TooManyPairs`] when discs lie heaped on each other, or a step is so long that most of them
    /// could have met (then do not count the missed ones, or shorten it); the arena stays at the
    /// last step end.
    pub fn advance(&mut self, until: f64, contacts: &mut Vec<Contact>) -> Result<(), TooManyPairs> {
        self.advance_with(until, contacts)
    }

    /// The same without a record of the contacts.
    ///
    /// # Errors
    /// As [`Self::advance`].
    pub fn pass(&mut self, until: f64) -> Result<(), TooManyPairs> {
        self.advance_with(until, &mut Nobody)
    }

    #[inline(always)]
    fn advance_with(&mut self, until: f64, witness: &mut impl Witness) -> Result<(), TooManyPairs> {
        for _ in 0..limits::STEPS_PER_ADVANCE {
            let end = (self.count + 1) as f64 * self.stepping.step;
            if end > until || until.is_nan() {
                self.now = self.now.max(until);
                return Ok(());
            }
            self.step(witness)?;
            self.now = self.now.max(end);
        }
        Ok(())
    }

    /// One step, stage by stage.
    #[inline(always)]
    fn step(&mut self, witness: &mut impl Witness) -> Result<(), TooManyPairs> {
        self.fly();
        self.find_touching()?;
        self.count += 1;
        self.collide(witness);
        self.bounce(witness);
        self.part();
        self.begin_flights();
        Ok(())
    }

    /// Time of the last step end, s.
    fn time(&self) -> f64 {
        self.count as f64 * self.stepping.step
    }

    /// The flights as they are so many steps after the start.
    #[inline(always)]
    fn flight(&self, steps: f64) -> Flight<'_> {
        Flight {
            starts: &self.starts,
            velocities: &self.velocities,
            began: &self.began,
            now: steps,
            step: self.stepping.step,
            inside: (DVec2::NEG_INFINITY, DVec2::INFINITY),
        }
    }

    /// Brings the discs one step further.
    #[inline(always)]
    fn fly(&mut self) {
        let mut places = std::mem::take(&mut self.places);
        let mut outside = std::mem::take(&mut self.scratch.outside);
        places.resize(self.ids.len(), DVec2::ZERO);
        let mut flight = self.flight((self.count + 1) as f64);
        if let Some(walls) = &self.laws.walls {
            let radius = self.radius_max;
            // Whoever lies so near the border is looked at exactly.
            let low = walls.min + (radius + 1e-9 * (walls.min.abs() + radius));
            let high = walls.max - (radius + 1e-9 * (walls.max.abs() + radius));
            flight.inside = (low, high);
        }
        flight.fly(&mut places, &mut outside);
        (self.places, self.scratch.outside) = (places, outside);
    }

    /// A disc at the step end; in a periodic box it may be any of its images.
    #[inline(always)]
    fn disc(&self, k: usize) -> Disc {
        Disc {
            id: self.ids[k],
            position: self.places[k],
            velocity: self.velocities[k],
            radius: self.radii[k],
            mass: self.masses[k],
        }
    }

    /// A disc at the present.
    fn disc_now(&self, k: usize) -> Disc {
        let place = self.flight(self.count as f64).at(k);
        let position = place + self.velocities[k] * (self.now - self.time());
        let position = self.laws.periodic.map_or(position, |periodic| periodic.inside(position));
        Disc { position, ..self.disc(k) }
    }
}

/// Whether a contact of two discs would change one of them, and is ours to resolve.
fn may_collide(owners: [Owner; 2], masses: [f64; 2]) -> bool {
    owners.contains(&Owner::Simulated) && masses.iter().any(|mass| mass.is_finite())
}
