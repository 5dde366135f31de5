//! An arena of simulated discs under the method that the plan chose for it.

use std::collections::HashSet;

use glam::DVec2;

use super::drag::Drag;
use super::events::Events;
use super::plain::{Laws, Plain, Stall};
use crate::plan::{Method, Plan};
use crate::world::{Contact, Disc, DiscId, Owner};

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
}

/// Calls the same of whichever method it is.
macro_rules! each {
    ($arena:expr, $method:ident => $call:expr) => {
        match $arena {
            Arena::Plain($method) => $call,
            Arena::Events($method) => $call,
            Arena::SlowedPlain($method) => $call,
            Arena::SlowedEvents($method) => $call,
        }
    };
}

impl Arena {
    /// An arena at time 0 under these laws.
    pub fn new(plan: &Plan, laws: Laws, discs: &[Disc]) -> Self {
        let plain = || Plain::new(laws, discs, plan.epoch);
        let events = || Events::new(laws, discs);
        match (plan.method, plan.drag) {
            (Method::Plain, false) => Self::Plain(Box::new(plain())),
            (Method::Events, false) => Self::Events(Box::new(events())),
            (Method::Plain, true) => Self::SlowedPlain(Box::new(Drag::new(plain()))),
            (Method::Events, true) => Self::SlowedEvents(Box::new(Drag::new(events()))),
        }
    }

    /// The present, s since the start.
    pub fn now(&self) -> f64 {
        each!(self, method => method.now())
    }

    /// The discs of one owner as they are now, in the order in which they came.
    pub fn discs(&self, owner: Owner) -> impl Iterator<Item = Disc> + use<> {
        let discs: Vec<Disc> = each!(self, method => method.discs(owner).collect());
        discs.into_iter()
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
        each!(self, method => method.largest_overlap())
    }

    /// Contacts since the start, pairs and walls.
    pub fn contacts(&self) -> u64 {
        each!(self, method => method.contacts())
    }

    /// Moves on to `until` (s) and adds the contacts on the way, at most a bounded number of
    /// events: [`Self::now`] tells how far it came.
    ///
    /// # Errors
    /// [`Stall`] when endlessly many contacts fall on one instant; the arena then stands there.
    pub fn advance(&mut self, until: f64, contacts: &mut Vec<Contact>) -> Result<(), Stall> {
        each!(self, method => method.advance(until, contacts))
    }

    /// The same without a record of the contacts.
    ///
    /// # Errors
    /// As [`Self::advance`].
    pub fn pass(&mut self, until: f64) -> Result<(), Stall> {
        each!(self, method => method.pass(until))
    }

    /// Largest distance from contact of a simulated pair when it collided, in units of the smaller
    /// radius; the plain method tells overlaps only.
    pub fn largest_miss(&self) -> f64 {
        match self {
            Self::Plain(method) => method.largest_overlap(),
            Self::Events(method) => method.largest_overlap().max(method.largest_gap()),
            Self::SlowedPlain(method) => method.largest_overlap(),
            Self::SlowedEvents(method) => method.largest_overlap().max(method.largest_gap()),
        }
    }

    /// Gives a simulated disc, if it is there, a new velocity from now on.
    pub fn set_velocity(&mut self, id: DiscId, velocity: DVec2) {
        each!(self, method => method.set_velocity(id, velocity));
    }

    /// Puts an observed disc where its owner says that it is, adding it if it is new.
    pub fn observe(&mut self, disc: Disc) {
        each!(self, method => method.observe(disc));
    }

    /// Takes observed discs out.
    pub fn forget(&mut self, ids: &HashSet<DiscId>) {
        each!(self, method => method.forget(ids));
    }
}
