//! What is asked from outside between events: other velocities, discs that come, move and go.

use std::collections::BTreeSet;

use glam::DVec2;

use super::body::Body;
use super::{Plain, is_extreme};
use crate::motion::entry::{fits_box, is_clear, may_stand_among, moved};
use crate::world::{Disc, DiscId, NotDone, Owner};

impl Plain {
    /// Gives a simulated disc, if it is there, a new velocity from now on.
    pub fn set_velocity(&mut self, id: DiscId, velocity: DVec2) {
        let Some(k) = self.find(id, Owner::Simulated) else { return };
        let before = self.move_to_now(k);
        self.set_velocity_of(k, velocity);
        self.energy.book(self.bodies[k].disc.kinetic_energy() - before.kinetic_energy());
        self.momentum.book_change(before.mass, velocity);
        self.momentum.book_change(before.mass, -before.velocity);
        self.predict_again(&[k], self.clock.offset(self.now));
    }

    /// Puts an observed disc where its owner says that it is, adding it if it is new.
    pub fn observe(&mut self, disc: Disc) {
        self.laws.extreme_units |= is_extreme(&disc);
        if let Some(k) = self.find(disc.id, Owner::Observed) {
            self.move_to_now(k);
            self.replace(k, disc);
        } else {
            self.push(disc, Owner::Observed);
            let last = self.bodies.len() - 1;
            self.replace(last, disc);
        }
    }

    /// Adds a simulated disc.
    ///
    /// # Errors
    /// [`NotDone`]; nothing is changed then.
    pub fn add(&mut self, disc: Disc) -> Result<(), NotDone> {
        may_stand_among(&disc, &self.laws)?;
        fits_box(&disc, self.laws.periodic)?;
        if self.bodies.iter().any(|body| body.disc.id == disc.id) {
            return Err(NotDone::Taken(disc.id));
        }
        self.is_clear_at(&disc, None)?;
        self.laws.extreme_units |= is_extreme(&disc);
        self.push(disc, Owner::Simulated);
        self.momentum.book_come(&disc);
        self.replace(self.bodies.len() - 1, disc);
        Ok(())
    }

    /// Takes a simulated disc out.
    ///
    /// # Errors
    /// [`NotDone`] if there is none.
    pub fn remove(&mut self, id: DiscId) -> Result<(), NotDone> {
        let k = self.find(id, Owner::Simulated).ok_or(NotDone::Unknown(id))?;
        let gone = self.move_to_now(k);
        self.energy.book(-gone.kinetic_energy());
        self.momentum.book_gone(&gone);
        self.bodies.remove(k);
        self.momentum.set_pull(self.now, self.weight());
        self.indices_changed();
        Ok(())
    }

    /// Puts a simulated disc somewhere else, with another velocity.
    ///
    /// # Errors
    /// [`NotDone`]; nothing is changed then.
    pub fn place(&mut self, id: DiscId, position: DVec2, velocity: DVec2) -> Result<(), NotDone> {
        let k = self.find(id, Owner::Simulated).ok_or(NotDone::Unknown(id))?;
        let after = Disc { position, velocity, ..self.bodies[k].disc };
        may_stand_among(&after, &self.laws)?;
        self.is_clear_at(&after, Some(k))?;
        self.laws.extreme_units |= is_extreme(&after);
        let before = self.move_to_now(k);
        self.energy.book(after.kinetic_energy() - before.kinetic_energy());
        self.momentum.book_gone(&before);
        self.momentum.book_come(&after);
        self.replace(k, after);
        Ok(())
    }

    /// Moves the walls, and brings discs inside.
    ///
    /// # Errors
    /// [`NotDone`] if there are no walls, or no room within; nothing is changed then.
    pub fn move_walls(&mut self, min: DVec2, max: DVec2) -> Result<(), NotDone> {
        let simulated = |k: &usize| self.bodies[*k].is_simulated();
        let within: Vec<usize> = (0..self.bodies.len()).filter(simulated).collect();
        let widest = within.iter().map(|&k| self.bodies[k].disc.radius).fold(0.0, f64::max);
        if self.laws.segments.is_some() {
            return Err(NotDone::FixedField);
        }
        let walls = moved(self.laws.walls, (min, max), widest)?;
        let discs: Vec<Disc> = within.iter().map(|&k| self.move_to_now(k)).collect();
        self.laws.walls = Some(walls);
        for (k, disc) in within.into_iter().zip(discs) {
            self.set_state(k, Disc { position: walls.inside(&disc), ..disc });
        }
        self.predict_all();
        Ok(())
    }

    /// Takes observed discs out.
    pub fn forget(&mut self, ids: &BTreeSet<DiscId>) {
        let before = self.bodies.len();
        let gone = |body: &Body| !body.is_simulated() && ids.contains(&body.disc.id);
        self.bodies.retain(|body| !gone(body));
        if self.bodies.len() < before {
            self.indices_changed();
        }
    }

    fn is_clear_at(&self, disc: &Disc, but: Option<usize>) -> Result<(), NotDone> {
        let offset = self.clock.offset(self.now);
        let others = self.bodies.iter().enumerate().filter(|(k, _)| Some(*k) != but);
        let others = others.map(|(_, body)| self.laws.inside(body.at(offset)));
        is_clear(disc, others, self.laws.periodic)
    }

    /// Predicts all, for discs went.
    fn indices_changed(&mut self) {
        self.remembered.clear();
        self.bodies.iter_mut().for_each(|body| body.collapse.forget_partners());
        self.predict_all();
    }
}
