//! An arena of simulated discs under the method that the plan chose for it.

use std::collections::BTreeSet;

use glam::DVec2;

use super::drag::Drag;
use super::events::Events;
use super::plain::{Laws, Plain, Stall};
use super::springs::{self, Refused, Springs};
use super::steps::{Steps, Unseen};
use super::ticks::Ticks;
use crate::detect::TooManyPairs;
use crate::plan::parts::Part;
use crate::plan::{Method, Plan};
use crate::world::{Contact, Disc, DiscId, NotDone, Owner};

/// Why an arena does not go on.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Halt {
    /// Endlessly many contacts fall on one instant.
    #[error(transparent)]
    Stalled(#[from] Stall),
    /// A step finds discs heaped on each other.
    #[error("arena stopped: {0}; shorten step_s, or part the discs")]
    Heaped(#[from] TooManyPairs),
    /// The springs do not stand it.
    #[error("arena stopped: {0}")]
    Springs(#[from] Refused),
}

impl Halt {
    /// The instant at which it stands, s, where that is known.
    pub fn time(&self) -> Option<f64> {
        match self {
            Self::Stalled(stall) => Some(stall.time),
            Self::Springs(Refused::NotFinite { time }) => Some(*time),
            _ => None,
        }
    }
}

/// One arena, by method.
#[derive(Clone, Debug)]
pub enum Arena {
    /// The next of all pairs, then the next.
    Plain(Box<Plain>),
    /// Cells and a calendar.
    Events(Box<Events>),
    /// The first under drag.
    SlowedPlain(Box<Drag<Plain>>),
    /// The second under drag.
    SlowedEvents(Box<Drag<Events>>),
    /// Exact within a control tick.
    Ticks(Box<Ticks>),
    /// Fixed steps, contacts found at their ends.
    Steps(Box<Steps>),
    /// Contacts that give way.
    Springs(Box<Springs>),
}

/// Calls the same of whichever method it is.
macro_rules! each {
    ($arena:expr, $method:ident => $call:expr) => {
        match $arena {
            Arena::Plain($method) => $call,
            Arena::Events($method) => $call,
            Arena::SlowedPlain($method) => $call,
            Arena::SlowedEvents($method) => $call,
            Arena::Ticks($method) => $call,
            Arena::Steps($method) => $call,
            Arena::Springs($method) => $call,
        }
    };
}

impl Arena {
    /// An arena at time 0 under these laws, of a plan that [suits](Plan::choose) them.
    ///
    /// # Panics
    /// If the plan does not suit them.
    pub fn new(plan: &Plan, laws: Laws, discs: &[Disc]) -> Self {
        // Only a plan that nobody checked fails here.
        Self::build(plan, laws, discs).expect("a plan that suits the scene")
    }

    /// The same, or why the method cannot do it.
    ///
    /// # Errors
    /// What the method does not do.
    pub fn build(plan: &Plan, laws: Laws, discs: &[Disc]) -> Result<Self, String> {
        let say = |error: &dyn std::fmt::Display| error.to_string();
        if laws.segments.is_some() && !Part::Segments.is_known_to(plan.method) {
            return Err(format!("method {} does not do segments", plan.method));
        }
        let plain = || Plain::new(laws, discs, plan.epoch);
        let events = || Events::with(laws, discs, plan.built);
        let mut arena = match (plan.method, plan.built.has(Part::Drag)) {
            (Method::Plain, false) => Self::Plain(Box::new(plain())),
            (Method::Events, false) => Self::Events(Box::new(events())),
            (Method::Plain, true) => Self::SlowedPlain(Box::new(Drag::new(plain()))),
            (Method::Events, true) => Self::SlowedEvents(Box::new(Drag::new(events()))),
            (method, true) => return Err(format!("method {method} does not do drag")),
            (Method::Ticks, false) => {
                let ticks = Ticks::new(laws, discs, plan.pace.tick);
                Self::Ticks(Box::new(ticks.map_err(|error| say(&error))?))
            }
            (Method::Steps, false) => {
                let steps = Steps::new(laws, discs, plan.stepping());
                Self::Steps(Box::new(steps.map_err(|error| say(&error))?))
            }
            (Method::Springs, false) => {
                let laws = springs::Laws { walls: laws.walls, ..plan.spring_laws() };
                let springs = Springs::new(laws, discs, plan.spring_stepping(discs.len()));
                Self::Springs(Box::new(springs.map_err(|error| say(&error))?))
            }
        };
        if plan.built.has(Part::Account) {
            arena.keep_account();
        }
        Ok(arena)
    }

    /// Whether pucks meet observed circles: a spring has no instant at which to correct them.
    pub fn meets_observed(&self) -> bool {
        !matches!(self, Self::Springs(_))
    }

    /// Steps of fixed length since the start, where there are any.
    pub fn steps(&self) -> Option<u64> {
        match self {
            Self::Steps(method) => Some(method.steps()),
            Self::Springs(method) => Some(method.steps()),
            _ => None,
        }
    }

    /// Contacts that steps of fixed length did not see when they happened.
    pub fn unseen(&self) -> Option<Unseen> {
        match self {
            Self::Steps(method) => Some(method.unseen()),
            _ => None,
        }
    }

    /// The present, s since the start.
    pub fn now(&self) -> f64 {
        each!(self, method => method.now())
    }

    /// The discs of one owner as they are now, in the order in which they came until one goes.
    pub fn discs(&self, owner: Owner) -> impl Iterator<Item = Disc> + use<> {
        let discs: Vec<Disc> = match self {
            Self::Plain(method) => listed(method.discs(owner)),
            Self::Events(method) => listed(method.discs(owner)),
            Self::SlowedPlain(method) => listed(method.discs(owner)),
            Self::SlowedEvents(method) => listed(method.discs(owner)),
            Self::Ticks(method) => listed(method.discs(owner)),
            Self::Steps(method) => listed(method.discs(owner)),
            Self::Springs(method) if owner == Owner::Simulated => method.discs().collect(),
            Self::Springs(_) => Vec::new(),
        };
        discs.into_iter()
    }

    /// A simulated disc as it is now.
    pub fn disc(&self, id: DiscId) -> Option<Disc> {
        self.discs(Owner::Simulated).find(|disc| disc.id == id)
    }

    /// Kinetic energy of the simulated discs, J.
    pub fn kinetic_energy(&self) -> f64 {
        each!(self, method => method.kinetic_energy())
    }

    /// Signed relative energy error, with all work accounted for.
    pub fn relative_energy_drift(&self) -> f64 {
        each!(self, method => method.relative_energy_drift())
    }

    /// Largest overlap of a simulated pair at any contact, in units of the smaller radius.
    pub fn largest_overlap(&self) -> f64 {
        match self {
            Self::Plain(method) => method.largest_overlap(),
            Self::Events(method) => method.largest_overlap(),
            Self::SlowedPlain(method) => method.largest_overlap(),
            Self::SlowedEvents(method) => method.largest_overlap(),
            Self::Ticks(method) => method.largest_overlap(),
            Self::Steps(method) => method.largest_overlap(),
            Self::Springs(method) => {
                let smallest = method.discs().map(|disc| disc.radius).fold(f64::INFINITY, f64::min);
                method.largest_overlap() / smallest
            }
        }
    }

    /// The same, m, or a bound of it where radii differ and the method resolves each contact at its
    /// instant: overlaps are rounding there.
    pub fn largest_overlap_m(&self) -> f64 {
        match self {
            Self::Springs(method) => method.largest_overlap(),
            Self::Steps(method) => method.largest_overlap_m(),
            _ => self.largest_overlap() * self.second_largest_radius(),
        }
    }

    /// The largest smaller radius of any pair of simulated discs, m.
    fn second_largest_radius(&self) -> f64 {
        let (mut first, mut second) = (0.0f64, 0.0f64);
        for Disc { radius, .. } in self.discs(Owner::Simulated) {
            second = second.max(radius.min(first));
            first = first.max(radius);
        }
        second
    }

    /// Keeps account of the momentum from now on, where the method can.
    pub fn keep_account(&mut self) {
        match self {
            Self::Plain(method) => method.keep_momentum(),
            Self::Events(method) => method.keep_momentum(),
            Self::SlowedPlain(method) => method.keep_momentum(),
            Self::SlowedEvents(method) => method.keep_momentum(),
            Self::Ticks(method) => method.keep_momentum(),
            Self::Steps(method) => method.keep_momentum(),
            Self::Springs(_) => {}
        }
    }

    /// Momentum of the simulated discs of finite mass gained by error, with all impulses from
    /// outside accounted for since [`Self::keep_account`], N s; `None` = no account: nobody asked,
    /// or springs, whose walls push for a time.
    pub fn momentum_drift(&self) -> Option<DVec2> {
        match self {
            Self::Plain(method) => method.momentum_drift(),
            Self::Events(method) => method.momentum_drift(),
            Self::SlowedPlain(method) => method.momentum_drift(),
            Self::SlowedEvents(method) => method.momentum_drift(),
            Self::Ticks(method) => method.momentum_drift(),
            Self::Steps(method) => method.momentum_drift(),
            Self::Springs(_) => None,
        }
    }

    /// Contacts since the start, pairs and walls.
    pub fn contacts(&self) -> u64 {
        each!(self, method => method.contacts())
    }

    /// Moves on to `until` (s) and adds the contacts on the way, at most a bounded number of
    /// events: [`Self::now`] tells how far it came.
    ///
    /// # Errors
    /// [`Halt`]; the arena then stands where it is.
    pub fn advance(&mut self, until: f64, contacts: &mut Vec<Contact>) -> Result<(), Halt> {
        each!(self, method => Ok(method.advance(until, contacts)?))
    }

    /// The same without a record of the contacts.
    ///
    /// # Errors
    /// As [`Self::advance`].
    pub fn pass(&mut self, until: f64) -> Result<(), Halt> {
        match self {
            Self::Plain(method) => Ok(method.pass(until)?),
            Self::Events(method) => Ok(method.pass(until)?),
            Self::SlowedPlain(method) => Ok(method.pass(until)?),
            Self::SlowedEvents(method) => Ok(method.pass(until)?),
            Self::Steps(method) => Ok(method.pass(until)?),
            _ => self.advance(until, &mut Vec::new()),
        }
    }

    /// Largest distance from contact of a simulated pair when it collided, in units of the smaller
    /// radius; only the method of events tells gaps.
    pub fn largest_miss(&self) -> f64 {
        match self {
            Self::Events(method) => method.largest_overlap().max(method.largest_gap()),
            Self::SlowedEvents(method) => method.largest_overlap().max(method.largest_gap()),
            _ => self.largest_overlap(),
        }
    }

    /// Gives a simulated disc, if it is there, a new velocity from now on.
    pub fn set_velocity(&mut self, id: DiscId, velocity: DVec2) {
        match self {
            Self::Plain(method) => method.set_velocity(id, velocity),
            Self::Events(method) => method.set_velocity(id, velocity),
            Self::SlowedPlain(method) => method.set_velocity(id, velocity),
            Self::SlowedEvents(method) => method.set_velocity(id, velocity),
            Self::Ticks(method) => method.set_velocity(id, velocity),
            Self::Steps(method) => method.set_velocity(id, velocity),
            // What refuses it refuses to go on too, and is told then.
            Self::Springs(method) => drop(method.set_velocity(id, velocity)),
        }
    }

    /// Adds a simulated disc: sound, within the walls, clear of all others, with an id of its own.
    ///
    /// # Errors
    /// [`NotDone`]; nothing is changed then.
    pub fn add(&mut self, disc: Disc) -> Result<(), NotDone> {
        each!(self, method => method.add(disc))
    }

    /// Takes a simulated disc out.
    ///
    /// # Errors
    /// [`NotDone`] if there is none.
    pub fn remove(&mut self, id: DiscId) -> Result<(), NotDone> {
        each!(self, method => method.remove(id))
    }

    /// Puts a simulated disc somewhere else, with another velocity.
    ///
    /// # Errors
    /// [`NotDone`]; nothing is changed then.
    pub fn place(&mut self, id: DiscId, position: DVec2, velocity: DVec2) -> Result<(), NotDone> {
        each!(self, method => method.place(id, position, velocity))
    }

    /// Moves the walls, and brings discs inside, where they may then overlap others.
    ///
    /// # Errors
    /// [`NotDone`] if there are no walls, or no room within; nothing is changed then.
    pub fn move_walls(&mut self, min: DVec2, max: DVec2) -> Result<(), NotDone> {
        each!(self, method => method.move_walls(min, max))
    }

    /// Puts an observed disc where its owner says that it is, adding it if it is new; nothing
    /// happens where pucks [meet none](Self::meets_observed).
    pub fn observe(&mut self, disc: Disc) {
        match self {
            Self::Plain(method) => method.observe(disc),
            Self::Events(method) => method.observe(disc),
            Self::SlowedPlain(method) => method.observe(disc),
            Self::SlowedEvents(method) => method.observe(disc),
            Self::Ticks(method) => method.observe(disc),
            Self::Steps(method) => method.observe(disc),
            Self::Springs(_) => {}
        }
    }

    /// Takes observed discs out.
    pub fn forget(&mut self, ids: &BTreeSet<DiscId>) {
        match self {
            Self::Plain(method) => method.forget(ids),
            Self::Events(method) => method.forget(ids),
            Self::SlowedPlain(method) => method.forget(ids),
            Self::SlowedEvents(method) => method.forget(ids),
            Self::Ticks(method) => method.forget(ids),
            Self::Steps(method) => method.forget(ids),
            Self::Springs(_) => {}
        }
    }
}

/// All of them, in memory that is asked for once: filters do not say how many are left.
fn listed(discs: impl Iterator<Item = Disc>) -> Vec<Disc> {
    let mut list = Vec::with_capacity(discs.size_hint().1.unwrap_or(0));
    list.extend(discs);
    list
}
