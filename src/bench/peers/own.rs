//! carom's stepped method behind the same seam as the others.

use super::{Setup, Stepper};
use crate::motion::plain::Laws;
use crate::motion::steps::{Stepping, Steps};
use crate::world::{Contact, Disc, Owner};

/// An arena that steps.
pub(super) struct Stepped {
    arena: Steps,
    step: f64,
    done: u64,
    contacts: Vec<Contact>,
    counts: bool,
}

impl Stepper for Stepped {
    fn new(setup: &Setup) -> Result<Self, String> {
        let laws = Laws { walls: setup.walls, ..Laws::FREE };
        let stepping = Stepping { count_missed: setup.count, ..Stepping::of(setup.step) };
        let arena = Steps::new(laws, setup.discs, stepping).map_err(|error| error.to_string())?;
        let (contacts, counts) = (Vec::new(), setup.count);
        Ok(Self { arena, step: setup.step, done: 0, contacts, counts })
    }

    fn step(&mut self) -> Result<(), String> {
        self.done += 1;
        self.contacts.clear();
        let until = self.done as f64 * self.step;
        // As with the others, contacts are looked at only where they are counted.
        let moved = if self.counts {
            self.arena.advance(until, &mut self.contacts)
        } else {
            self.arena.pass(until)
        };
        moved.map_err(|error| error.to_string())
    }

    fn discs(&self) -> Vec<Disc> {
        self.arena.discs(Owner::Simulated).collect()
    }

    fn contacts(&self) -> u64 {
        self.contacts.len() as u64
    }

    fn missed(&self) -> Option<u64> {
        let unseen = self.arena.unseen();
        self.counts.then_some(unseen.missed + unseen.too_late)
    }
}
