//! What is asked from outside between events: other velocities, discs that come, move and go.
//!
//! Energy that comes or goes with it is booked as work. What it does to the cells and the calendar
//! is for [`super::come`].

use std::collections::{BTreeSet, HashMap};

use glam::DVec2;

use super::{Each, Events};
use crate::motion::entry::{fits_box, may_stand_among, moved};
use crate::plan::parts::brings_energy;
use crate::world::{Disc, DiscId, NotDone, Owner};

impl Events {
    /// Gives a simulated disc, if it is there, a new velocity from now on.
    pub fn set_velocity(&mut self, id: DiscId, velocity: DVec2) {
        let Some(k) = self.find(Owner::Simulated, id) else { return };
        let before = self.disc(k);
        if !self.outdated {
            self.bring_start_near(velocity.length());
        }
        self.book_fall(k);
        self.turn(k, velocity);
        self.energy.book(self.disc(k).kinetic_energy() - before.kinetic_energy());
        self.momentum.book_change(before.mass, velocity);
        self.momentum.book_change(before.mass, -before.velocity);
        self.guests |= brings_energy(&self.disc(k));
        if !self.outdated {
            self.lanes.renew_all(self, &[k]);
        }
    }

    /// Adds a simulated disc, at the cost of a look around it; of one that the cells have no room
    /// for, once for all that come before time goes on, at that of new cells.
    ///
    /// # Errors
    /// [`NotDone`]; nothing is changed then.
    pub fn add(&mut self, disc: Disc) -> Result<(), NotDone> {
        may_stand_among(&disc, &self.laws)?;
        fits_box(&disc, self.laws.periodic)?;
        if [Owner::Simulated, Owner::Observed].iter().any(|&owner| self.has(owner, disc.id)) {
            return Err(NotDone::Taken(disc.id));
        }
        self.is_clear_at(&disc, None)?;
        self.guests |= brings_energy(&disc);
        self.come(&disc, Owner::Simulated);
        self.energy.book(disc.kinetic_energy());
        self.momentum.book_come(&disc);
        self.guests |= self.momentum.is_kept() && disc.mass.is_infinite();
        self.book_weight();
        Ok(())
    }

    /// Takes a simulated disc out, at no more than the cost of finding it. The last disc takes its
    /// place in [`Self::discs`].
    ///
    /// # Errors
    /// [`NotDone`] if there is none.
    pub fn remove(&mut self, id: DiscId) -> Result<(), NotDone> {
        let k = self.find(Owner::Simulated, id).ok_or(NotDone::Unknown(id))?;
        self.book_fall(k);
        let gone = self.disc(k);
        self.energy.book(-gone.kinetic_energy());
        self.momentum.book_gone(&gone);
        self.take_out(k);
        self.book_weight();
        Ok(())
    }

    /// Puts a simulated disc somewhere else, with another velocity.
    ///
    /// # Errors
    /// [`NotDone`]; nothing is changed then.
    pub fn place(&mut self, id: DiscId, position: DVec2, velocity: DVec2) -> Result<(), NotDone> {
        let k = self.find(Owner::Simulated, id).ok_or(NotDone::Unknown(id))?;
        let before = self.disc(k);
        let after = Disc { position, velocity, ..before };
        may_stand_among(&after, &self.laws)?;
        self.is_clear_at(&after, Some(k))?;
        self.book_fall(k);
        self.guests |= brings_energy(&after);
        self.energy.book(after.kinetic_energy() - before.kinetic_energy());
        self.momentum.book_gone(&before);
        self.momentum.book_come(&after);
        self.move_to(k, &after);
        self.book_weight();
        Ok(())
    }

    /// Moves the walls, and brings discs inside.
    ///
    /// # Errors
    /// [`NotDone`] if there are no walls, or no room within, or segments, which stay; nothing is
    /// changed then.
    pub fn move_walls(&mut self, min: DVec2, max: DVec2) -> Result<(), NotDone> {
        if self.laws.segments.is_some() {
            return Err(NotDone::FixedField);
        }
        let simulated = |k: &usize| self.owners[*k] == Owner::Simulated;
        let within: Vec<usize> = (0..self.flights.len()).filter(simulated).collect();
        let widest = within.iter().map(|&k| self.radii.get(k)).fold(0.0, f64::max);
        let walls = moved(self.laws.walls, (min, max), widest)?;
        self.outdate();
        // What rests on a wall may not rest on the next.
        within.iter().for_each(|&k| self.book_fall(k));
        self.laws.walls = Some(walls);
        for k in within {
            let disc = self.disc(k);
            self.put(k, &Disc { position: walls.inside(&disc), ..disc });
        }
        Ok(())
    }

    /// Puts an observed disc where its owner says that it is, adding it if it is new.
    pub fn observe(&mut self, disc: Disc) {
        self.guests = true;
        match self.find(Owner::Observed, disc.id) {
            Some(k) => self.move_to(k, &disc),
            None => self.come(&disc, Owner::Observed),
        }
    }

    /// Takes observed discs out.
    pub fn forget(&mut self, ids: &BTreeSet<DiscId>) {
        for &id in ids {
            if let Some(k) = self.find(Owner::Observed, id) {
                self.take_out(k);
            }
        }
    }

    /// Distances at contacts are kept in other units from the first disc of another radius on.
    pub(super) fn relate_excess(&mut self, radius: Option<f64>) {
        if let (Some(radius), Each::Own(_)) = (radius, &self.radii) {
            let unit = 2.0 * radius * radius;
            self.excess = (self.excess.0 / unit, self.excess.1 / unit);
        }
    }

    pub(super) fn equal_radius(&self) -> Option<f64> {
        if let Each::Same(radius) = self.radii { Some(radius) } else { None }
    }

    fn find(&mut self, owner: Owner, id: DiscId) -> Option<usize> {
        self.make_index().get(&(owner, id)).copied()
    }

    fn has(&mut self, owner: Owner, id: DiscId) -> bool {
        self.find(owner, id).is_some()
    }

    /// Where the disc of each id is, made when somebody asks.
    pub(super) fn make_index(&mut self) -> &HashMap<(Owner, DiscId), usize> {
        let keys = || self.owners.iter().copied().zip(self.ids.iter().copied());
        self.index.get_or_insert_with(|| keys().zip(0..).collect())
    }
}

impl Each {
    pub(super) fn push(&mut self, value: f64, count: usize) {
        self.make_own(value, count).into_iter().for_each(|own| own.push(value));
    }

    pub(super) fn set(&mut self, k: usize, value: f64, count: usize) {
        self.make_own(value, count).into_iter().for_each(|own| own[k] = value);
    }

    pub(super) fn swap_remove(&mut self, k: usize) {
        if let Self::Own(own) = self {
            own.swap_remove(k);
        }
    }

    /// The single numbers, if there must be some beside this value.
    fn make_own(&mut self, value: f64, count: usize) -> Option<&mut Vec<f64>> {
        if let Self::Same(same) = *self
            && same != value
        {
            *self = Self::Own(vec![same; count]);
        }
        match self {
            Self::Same(_) => None,
            Self::Own(own) => Some(own),
        }
    }
}
