//! What is asked from outside between events: other velocities, discs that come, move and go.

use std::collections::BTreeSet;

use glam::DVec2;

use super::Ticks;
use super::bodies::Flight;
use crate::motion::entry::{fits_box, is_clear, may_stand_among, moved};
use crate::motion::plain::is_extreme;
use crate::world::{Disc, DiscId, NotDone, Owner};

impl Ticks {
    /// Gives a simulated disc, if it is there, a new velocity (m/s) from now on.
    pub fn set_velocity(&mut self, id: DiscId, velocity: DVec2) {
        let Some(k) = self.bodies.find(id, Owner::Simulated) else { return };
        if self.bodies.flights[k].velocity == velocity {
            return;
        }
        let before = self.bodies.move_to(k, self.present);
        let after = Disc { velocity, ..before };
        self.bodies.flights[k].velocity = velocity;
        self.energy.book(after.kinetic_energy() - before.kinetic_energy());
        self.momentum.book_change(before.mass, velocity);
        self.momentum.book_change(before.mass, -before.velocity);
        self.window_end = None;
    }

    /// Puts an observed disc where its owner says that it is, adding it if it is new.
    pub fn observe(&mut self, disc: Disc) {
        self.laws.extreme_units |= is_extreme(&disc);
        self.window_end = None;
        let Some(k) = self.bodies.find(disc.id, Owner::Observed) else {
            self.bodies.add(&disc, Owner::Observed, self.present);
            self.neighbours.discard();
            return;
        };
        let flight = &mut self.bodies.flights[k];
        let body = &mut self.bodies.bodies[k];
        if (flight.radius, body.mass) != (disc.radius, disc.mass) {
            self.neighbours.discard();
        }
        let Disc { position: start, velocity, radius, .. } = disc;
        *flight = Flight { start, velocity, began: self.present, radius };
        body.mass = disc.mass;
    }

    /// Takes observed discs out.
    pub fn forget(&mut self, ids: &BTreeSet<DiscId>) {
        let before = self.bodies.len();
        self.bodies.retain(|body| body.is_simulated() || !ids.contains(&body.id));
        if self.bodies.len() < before {
            self.neighbours.discard();
            self.window_end = None;
        }
    }

    /// Adds a simulated disc.
    ///
    /// # Errors
    /// [`NotDone`]; nothing is changed then.
    pub fn add(&mut self, disc: Disc) -> Result<(), NotDone> {
        may_stand_among(&disc, &self.laws)?;
        fits_box(&disc, self.laws.periodic)?;
        if self.bodies.bodies.iter().any(|body| body.id == disc.id) {
            return Err(NotDone::Taken(disc.id));
        }
        self.is_clear_at(&disc, None)?;
        self.laws.extreme_units |= is_extreme(&disc);
        self.bodies.add(&disc, Owner::Simulated, self.present);
        self.energy.book(disc.kinetic_energy());
        self.momentum.book_come(&disc);
        self.look_anew();
        Ok(())
    }

    /// Takes a simulated disc out.
    ///
    /// # Errors
    /// [`NotDone`] if there is none.
    pub fn remove(&mut self, id: DiscId) -> Result<(), NotDone> {
        let k = self.bodies.find(id, Owner::Simulated).ok_or(NotDone::Unknown(id))?;
        let gone = self.bodies.at(k, self.present);
        self.energy.book(-gone.kinetic_energy());
        self.momentum.book_gone(&gone);
        self.bodies.retain(|body| !body.is_simulated() || body.id != id);
        self.look_anew();
        Ok(())
    }

    /// Puts a simulated disc somewhere else, with another velocity.
    ///
    /// # Errors
    /// [`NotDone`]; nothing is changed then.
    pub fn place(&mut self, id: DiscId, position: DVec2, velocity: DVec2) -> Result<(), NotDone> {
        let k = self.bodies.find(id, Owner::Simulated).ok_or(NotDone::Unknown(id))?;
        let before = self.bodies.at(k, self.present);
        let after = Disc { position, velocity, ..before };
        may_stand_among(&after, &self.laws)?;
        self.is_clear_at(&after, Some(k))?;
        self.laws.extreme_units |= is_extreme(&after);
        let start = self.bodies.inside(position);
        let flight = &mut self.bodies.flights[k];
        *flight = Flight { start, velocity, began: self.present, ..*flight };
        self.energy.book(after.kinetic_energy() - before.kinetic_energy());
        self.momentum.book_gone(&before);
        self.momentum.book_come(&after);
        self.look_anew();
        Ok(())
    }

    /// Moves the walls, and brings discs inside.
    ///
    /// # Errors
    /// [`NotDone`] if there are no walls, or no room within; nothing is changed then.
    pub fn move_walls(&mut self, min: DVec2, max: DVec2) -> Result<(), NotDone> {
        let simulated = |k: &usize| self.body(*k).is_simulated();
        let within: Vec<usize> = (0..self.bodies.len()).filter(simulated).collect();
        let widest = within.iter().map(|&k| self.bodies.flights[k].radius).fold(0.0, f64::max);
        if self.laws.segments.is_some() {
            return Err(NotDone::FixedField);
        }
        let walls = moved(self.laws.walls, (min, max), widest)?;
        self.laws.walls = Some(walls);
        for k in within {
            let disc = self.bodies.move_to(k, self.present);
            self.bodies.flights[k].start = walls.inside(&disc);
        }
        self.look_anew();
        Ok(())
    }

    fn is_clear_at(&self, disc: &Disc, but: Option<usize>) -> Result<(), NotDone> {
        let others = (0..self.bodies.len()).filter(|k| Some(*k) != but);
        let others = others.map(|k| self.bodies.at(k, self.present));
        is_clear(disc, others, self.laws.periodic)
    }

    /// Lets all be predicted, and lists of neighbours be made, anew.
    fn look_anew(&mut self) {
        self.neighbours.discard();
        self.window_end = None;
    }
}
