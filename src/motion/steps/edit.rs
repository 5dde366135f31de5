//! What is asked from outside between steps: other velocities, discs that come, move and go.

use std::collections::BTreeSet;

use glam::DVec2;

use super::{Steps, may_collide};
use crate::motion::entry::{fits_box, is_clear, may_stand, moved};
use crate::motion::plain::is_extreme;
use crate::world::{Disc, DiscId, NotDone, Owner};

impl Steps {
    /// Gives a simulated disc, if it is there, a new velocity from now on.
    pub fn set_velocity(&mut self, id: DiscId, velocity: DVec2) {
        let Some(k) = self.find(Owner::Simulated, id) else { return };
        if self.velocities[k] == velocity {
            return;
        }
        let before = self.disc_now(k);
        let after = Disc { velocity, ..before };
        self.put(k, &after);
        self.energy.book(after.kinetic_energy() - before.kinetic_energy());
        self.momentum.book_change(before.mass, velocity);
        self.momentum.book_change(before.mass, -before.velocity);
    }

    /// Puts an observed disc where its owner says that it is, adding it if it is new.
    pub fn observe(&mut self, disc: Disc) {
        self.laws.extreme_units |= is_extreme(&disc);
        self.near.discard();
        let Some(k) = self.find(Owner::Observed, disc.id) else {
            let k = self.ids.len();
            self.index.iter_mut().for_each(|index| {
                index.insert((Owner::Observed, disc.id), k);
            });
            self.push(&disc, Owner::Observed, self.steps_now());
            return self.note_who_passes();
        };
        (self.radii[k], self.masses[k]) = (disc.radius, disc.mass);
        self.radius_max = self.radius_max.max(disc.radius);
        self.put(k, &disc);
        self.note_who_passes();
    }

    /// Takes observed discs out.
    pub fn forget(&mut self, ids: &BTreeSet<DiscId>) {
        let gone = |k: &usize| self.owners[*k] == Owner::Observed && ids.contains(&self.ids[*k]);
        let gone: Vec<usize> = (0..self.ids.len()).filter(gone).collect();
        self.take_out(&gone);
    }

    /// Adds a simulated disc.
    ///
    /// # Errors
    /// [`NotDone`]; nothing is changed then.
    pub fn add(&mut self, disc: Disc) -> Result<(), NotDone> {
        may_stand(&disc, self.laws.walls.as_ref())?;
        fits_box(&disc, self.laws.periodic)?;
        if self.ids.contains(&disc.id) {
            return Err(NotDone::Taken(disc.id));
        }
        self.is_clear_at(&disc, None)?;
        self.laws.extreme_units |= is_extreme(&disc);
        let k = self.ids.len();
        self.index.iter_mut().for_each(|index| {
            index.insert((Owner::Simulated, disc.id), k);
        });
        self.push(&disc, Owner::Simulated, self.steps_now());
        self.energy.book(disc.kinetic_energy());
        self.momentum.book_come(&disc);
        self.near.discard();
        self.note_who_passes();
        Ok(())
    }

    /// Takes a simulated disc out.
    ///
    /// # Errors
    /// [`NotDone`] if there is none.
    pub fn remove(&mut self, id: DiscId) -> Result<(), NotDone> {
        let k = self.find(Owner::Simulated, id).ok_or(NotDone::Unknown(id))?;
        let gone = self.disc_now(k);
        self.energy.book(-gone.kinetic_energy());
        self.momentum.book_gone(&gone);
        self.take_out(&[k]);
        Ok(())
    }

    /// Puts a simulated disc somewhere else, with another velocity.
    ///
    /// # Errors
    /// [`NotDone`]; nothing is changed then.
    pub fn place(&mut self, id: DiscId, position: DVec2, velocity: DVec2) -> Result<(), NotDone> {
        let k = self.find(Owner::Simulated, id).ok_or(NotDone::Unknown(id))?;
        let before = self.disc_now(k);
        let after = Disc { position, velocity, ..before };
        may_stand(&after, self.laws.walls.as_ref())?;
        self.is_clear_at(&after, Some(k))?;
        self.laws.extreme_units |= is_extreme(&after);
        self.put(k, &after);
        self.energy.book(after.kinetic_energy() - before.kinetic_energy());
        self.momentum.book_gone(&before);
        self.momentum.book_come(&after);
        self.near.discard();
        Ok(())
    }

    /// Moves the walls, and brings discs inside.
    ///
    /// # Errors
    /// [`NotDone`] if there are no walls, or no room within; nothing is changed then.
    pub fn move_walls(&mut self, min: DVec2, max: DVec2) -> Result<(), NotDone> {
        let simulated = |k: &usize| self.owners[*k] == Owner::Simulated;
        let within: Vec<usize> = (0..self.ids.len()).filter(simulated).collect();
        let widest = within.iter().map(|&k| self.radii[k]).fold(0.0, f64::max);
        let walls = moved(self.laws.walls, (min, max), widest)?;
        self.laws.walls = Some(walls);
        for k in within {
            let disc = self.disc_now(k);
            let position = walls.inside(&disc);
            if position != disc.position {
                self.put(k, &Disc { position, ..disc });
            }
        }
        self.near.discard();
        Ok(())
    }

    fn is_clear_at(&self, disc: &Disc, but: Option<usize>) -> Result<(), NotDone> {
        let others = (0..self.ids.len()).filter(|k| Some(*k) != but);
        is_clear(disc, others.map(|k| self.disc_now(k)), self.laws.periodic)
    }

    fn take_out(&mut self, gone: &[usize]) {
        // From the last on; the others keep their order.
        for &k in gone.iter().rev() {
            self.starts.remove(k);
            self.began.remove(k);
            self.velocities.remove(k);
            self.radii.remove(k);
            self.masses.remove(k);
            self.ids.remove(k);
            self.owners.remove(k);
        }
        if !gone.is_empty() {
            self.places.truncate(self.ids.len());
            self.scratch.shared.truncate(self.ids.len());
            self.index = None;
            self.near.discard();
            self.note_who_passes();
        }
    }

    pub(super) fn push(&mut self, disc: &Disc, owner: Owner, began: f64) {
        self.starts.push(disc.position);
        self.began.push(began);
        self.velocities.push(disc.velocity);
        self.places.push(disc.position);
        self.radii.push(disc.radius);
        self.radius_max = self.radius_max.max(disc.radius);
        self.masses.push(disc.mass);
        self.ids.push(disc.id);
        self.owners.push(owner);
        self.scratch.shared.push(0);
        self.fastest.note(disc.velocity);
    }

    /// Begins a new flight at the present.
    fn put(&mut self, k: usize, disc: &Disc) {
        (self.starts[k], self.velocities[k]) = (disc.position, disc.velocity);
        self.began[k] = self.steps_now();
        self.fastest.note(disc.velocity);
    }

    /// The present in steps; whole at a step end.
    fn steps_now(&self) -> f64 {
        self.count as f64 + (self.now - self.time()) / self.stepping.step
    }

    /// Whether there are pairs without contacts of ours.
    pub(super) fn note_who_passes(&mut self) {
        let passes = |k: &usize| !may_collide([self.owners[*k]; 2], [self.masses[*k]; 2]);
        self.some_pass = (0..self.ids.len()).filter(passes).nth(1).is_some();
    }

    fn find(&mut self, owner: Owner, id: DiscId) -> Option<usize> {
        let keys = || self.owners.iter().copied().zip(self.ids.iter().copied());
        let index = self.index.get_or_insert_with(|| keys().zip(0..).collect());
        index.get(&(owner, id)).copied()
    }
}
