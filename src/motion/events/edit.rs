//! What is asked from outside between events: other velocities, discs that come, move and go.

use std::collections::{HashMap, HashSet};

use glam::DVec2;

use super::levels::Grids;
use super::{Each, Events, Flight, LONG_AGO, grids};
use crate::plan::parts::brings_energy;
use crate::world::{Disc, DiscId, Owner};

impl Events {
    /// Gives a simulated disc, if it is there, a new velocity from now on.
    pub fn set_velocity(&mut self, id: DiscId, velocity: DVec2) {
        let Some(k) = self.find(Owner::Simulated, id) else { return };
        let before = self.disc(k);
        self.bring_start_near(velocity.length());
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

    /// Puts an observed disc where its owner says that it is, adding it if it is new.
    pub fn observe(&mut self, disc: Disc) {
        let known = self.find(Owner::Observed, disc.id);
        let fits = |k: &usize| !self.outdated && disc.radius <= self.radius_max(*k);
        let Some(k) = known.filter(fits) else {
            return self.come(known, &disc);
        };
        let level = self.levels.level(k);
        self.levels.grid_mut(&mut self.cells, level).remove(self.dues[k].place, k as u32);
        self.put(k, &disc);
        let cells = self.levels.grid_mut(&mut self.cells, level);
        self.dues[k].place = cells.place(self.flights[k].at(self.now));
        cells.add(self.dues[k].place, k as u32);
        self.note_jump(k);
        // Who expects to meet it may not notice that it is elsewhere.
        self.expect_otherwise(k);
        self.lanes.renew_all(self, &[k]);
    }

    /// An observed disc that is new, or too large for the cells: they are made anew before time
    /// goes on, once for all that come.
    fn come(&mut self, known: Option<usize>, disc: &Disc) {
        self.guests = true;
        if !self.outdated {
            self.carry_on(self.now);
            self.outdated = true;
        }
        let k = known.unwrap_or(self.flights.len());
        if known.is_none() {
            self.ids.push(disc.id);
            self.owners.push(Owner::Observed);
            self.push_flight(disc);
            let equal = self.equal_radius();
            self.radii.push(disc.radius, k);
            self.masses.push(disc.mass, k);
            self.relate_excess(equal);
            if self.laws.contact_time > 0.0 || !self.last.is_empty() {
                self.last.push(LONG_AGO);
            }
            self.index.iter_mut().for_each(|index| {
                index.insert((Owner::Observed, disc.id), k);
            });
        }
        self.put(k, disc);
    }

    /// Writes down what a disc is.
    fn put(&mut self, k: usize, disc: &Disc) {
        if !self.outdated {
            self.bring_start_near(disc.velocity.length());
        }
        let periodic = self.laws.periodic;
        let position = periodic.map_or(disc.position, |periodic| periodic.inside(disc.position));
        let start = position - disc.velocity * self.now;
        let DVec2 { x: vx, y: vy } = disc.velocity;
        let equal = self.equal_radius();
        self.flights[k] = Flight { x: start.x, y: start.y, vx, vy };
        let discs = self.flights.len();
        self.radii.set(k, disc.radius, discs);
        self.masses.set(k, disc.mass, discs);
        self.relate_excess(equal);
    }

    /// Distances at contacts are kept in other units from the first disc of another radius on.
    fn relate_excess(&mut self, radius: Option<f64>) {
        if let (Some(radius), Each::Own(_)) = (radius, &self.radii) {
            let unit = 2.0 * radius * radius;
            self.excess = (self.excess.0 / unit, self.excess.1 / unit);
        }
    }

    fn equal_radius(&self) -> Option<f64> {
        if let Each::Same(radius) = self.radii { Some(radius) } else { None }
    }

    pub(super) fn push_flight(&mut self, disc: &Disc) {
        let start = disc.position - disc.velocity * self.now;
        let DVec2 { x: vx, y: vy } = disc.velocity;
        self.flights.push(Flight { x: start.x, y: start.y, vx, vy });
        let owner = self.owners[self.flights.len() - 1];
        self.fall.iter_mut().for_each(|fall| fall.push(&self.laws, disc, owner));
    }

    /// Takes observed discs out.
    pub fn forget(&mut self, ids: &HashSet<DiscId>) {
        let gone = |k: &usize| self.owners[*k] == Owner::Observed && ids.contains(&self.ids[*k]);
        let gone: Vec<usize> = (0..self.flights.len()).filter(gone).collect();
        // From the last on: what takes the place of one is not itself to go.
        for &k in gone.iter().rev() {
            self.flights.swap_remove(k);
            self.ids.swap_remove(k);
            self.owners.swap_remove(k);
            self.radii.swap_remove(k);
            self.masses.swap_remove(k);
            self.fall.iter_mut().for_each(|fall| fall.swap_remove(k));
            if !self.last.is_empty() {
                self.last.swap_remove(k);
            }
        }
        if !gone.is_empty() {
            self.index = None;
            self.outdated = true;
        }
    }

    /// New cells for the discs as they lie now.
    #[cold]
    pub(super) fn renew_all_cells(&mut self) {
        let discs: Vec<Disc> = (0..self.flights.len()).map(|k| self.disc(k)).collect();
        let Grids { cells, levels, diameter, needs } = grids(&self.laws, &discs);
        (self.cells, self.levels, self.diameter) = (cells, levels, diameter);
        self.scale = needs.diameter;
        self.calendar.make_room_for(self.flights.len());
        self.renew_grid();
        self.outdated = false;
    }

    fn find(&mut self, owner: Owner, id: DiscId) -> Option<usize> {
        self.make_index().get(&(owner, id)).copied()
    }

    /// Where the disc of each id is, made when somebody asks.
    pub(super) fn make_index(&mut self) -> &HashMap<(Owner, DiscId), usize> {
        let keys = || self.owners.iter().copied().zip(self.ids.iter().copied());
        self.index.get_or_insert_with(|| keys().zip(0..).collect())
    }
}

impl Each {
    fn push(&mut self, value: f64, count: usize) {
        self.make_own(value, count).into_iter().for_each(|own| own.push(value));
    }

    fn set(&mut self, k: usize, value: f64, count: usize) {
        self.make_own(value, count).into_iter().for_each(|own| own[k] = value);
    }

    fn swap_remove(&mut self, k: usize) {
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
