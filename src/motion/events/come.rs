//! Discs that come and go, in cells and calendar, at the cost of their neighbourhood.
//!
//! A disc that comes looks around once, as after a contact: so of each pair the one that looked
//! last saw the other. Of a disc that goes nothing needs to be taken back: what others expect of it
//! is found out of date when its time comes, as ever, since it flies otherwise, is not there, or is
//! not in touch; entries of the calendar hold only for a disc that is due then. The last disc takes
//! the place of the one that goes, so that discs stay in a row.
//!
//! All cells are made anew, once before time goes on, when a disc comes that they have no room for,
//! or when there are so many more, or so many fewer, discs than they were made for that they would
//! be crowded, or empty: over many edits that costs as much as the edits.

use super::cells::EMPTY;
use super::levels::Grids;
use super::{Due, Events, Flight, LONG_AGO, NOTHING, Place, grids};
use crate::motion::entry::is_clear;
use crate::world::{Disc, NotDone, Owner};

use glam::DVec2;

/// By how many times more, or fewer, discs cells are outgrown, and how many are never too few.
const OUTGROWN: (usize, usize, usize) = (2, 4, 64);

/// What a disc is due for that was not looked at yet.
pub(super) const UNSEEN: Due = Due {
    contact: f64::INFINITY,
    exit: f64::INFINITY,
    partner: NOTHING,
    stamp: 0,
    place: Place { column: 1, row: 1 },
};

impl Events {
    /// A new disc.
    pub(super) fn come(&mut self, disc: &Disc, owner: Owner) {
        let k = self.flights.len();
        self.noted.forget();
        self.ids.push(disc.id);
        self.owners.push(owner);
        self.push_flight(disc);
        self.dues.push(UNSEEN);
        self.levels.push(disc.radius);
        let equal = self.equal_radius();
        self.radii.push(disc.radius, k);
        self.masses.push(disc.mass, k);
        self.relate_excess(equal);
        if self.laws.contact_time > 0.0 || !self.last.is_empty() {
            self.last.push(LONG_AGO);
        }
        if let Some(index) = &mut self.index {
            index.insert((owner, disc.id), k);
        }
        self.put(k, disc);
        self.settle_in(k, disc);
    }

    /// A disc is somewhere else, and may be another.
    pub(super) fn move_to(&mut self, k: usize, disc: &Disc) {
        if !self.outdated {
            self.leave_cell(k);
        }
        self.put(k, disc);
        self.settle_in(k, disc);
    }

    /// A disc goes; the last one takes its place.
    pub(super) fn take_out(&mut self, k: usize) {
        let last = self.flights.len() - 1;
        if !self.outdated {
            self.leave_cell(k);
            if k != last {
                let cells = self.levels.grid_mut(&mut self.cells, self.levels.level(last));
                cells.rename(self.dues[last].place, last as u32, k as u32);
                self.levels.rename(last, k);
            }
        }
        if let Some(index) = &mut self.index {
            index.remove(&(self.owners[k], self.ids[k]));
            if k != last {
                index.insert((self.owners[last], self.ids[last]), k);
            }
        }
        self.forget_row(k);
        if !self.outdated && k != last {
            self.calendar.insert(self.dues[k].time(), k);
        }
        if self.flights.len() * OUTGROWN.1 < self.made_for && self.made_for > OUTGROWN.2 {
            self.outdate();
        }
        self.fit_limits();
    }

    /// Takes out what is kept of a disc.
    fn forget_row(&mut self, k: usize) {
        self.noted.forget();
        self.flights.swap_remove(k);
        self.dues.swap_remove(k);
        self.ids.swap_remove(k);
        self.owners.swap_remove(k);
        self.radii.swap_remove(k);
        self.masses.swap_remove(k);
        self.levels.swap_remove(k);
        self.fall.iter_mut().for_each(|fall| fall.swap_remove(k));
        if !self.last.is_empty() {
            self.last.swap_remove(k);
        }
    }

    fn leave_cell(&mut self, k: usize) {
        let cells = self.levels.grid_mut(&mut self.cells, self.levels.level(k));
        cells.remove(self.dues[k].place, k as u32);
        self.levels.erase(k);
    }

    /// Writes down what a disc is, and where.
    pub(super) fn put(&mut self, k: usize, disc: &Disc) {
        self.noted.forget();
        if !self.outdated {
            self.bring_start_near(disc.velocity.length());
        }
        let periodic = self.laws.periodic;
        let position = periodic.map_or(disc.position, |periodic| periodic.inside(disc.position));
        let equal = self.equal_radius();
        let discs = self.flights.len();
        self.radii.set(k, disc.radius, discs);
        self.masses.set(k, disc.mass, discs);
        self.relate_excess(equal);
        if self.fall.is_some() {
            return self.put_falling(k, position, disc.velocity);
        }
        let start = position - disc.velocity * self.now;
        let DVec2 { x: vx, y: vy } = disc.velocity;
        self.flights[k] = Flight { x: start.x, y: start.y, vx, vy };
    }

    pub(super) fn push_flight(&mut self, disc: &Disc) {
        let start = disc.position - disc.velocity * self.now;
        let DVec2 { x: vx, y: vy } = disc.velocity;
        self.flights.push(Flight { x: start.x, y: start.y, vx, vy });
        let owner = self.owners[self.flights.len() - 1];
        self.fall.iter_mut().for_each(|fall| fall.push(&self.laws, disc, owner));
    }

    /// A disc that is in no cell goes into one, if they do for it, and looks around.
    fn settle_in(&mut self, k: usize, disc: &Disc) {
        let is_outgrown = self.flights.len() > OUTGROWN.0 * self.made_for.max(OUTGROWN.2);
        let has_room = disc.radius <= self.radius_max(k) && self.cells.covers(self.position(k));
        if self.outdated || is_outgrown || !has_room {
            return self.outdate();
        }
        if !self.calendar.has_room_for(self.flights.len()) {
            self.carry_on(self.now);
            self.calendar.make_room_for(self.flights.len());
            self.restart_calendar(self.calendar.day(), 0.0);
        }
        let at = self.position(k);
        let cells = self.levels.grid_mut(&mut self.cells, self.levels.level(k));
        self.dues[k].place = cells.place(at);
        cells.add(self.dues[k].place, k as u32);
        self.note_jump(k);
        self.fit_limits();
        self.lanes.renew_all(self, &[k]);
    }

    /// Lets all cells be made anew before time goes on.
    pub(super) fn outdate(&mut self) {
        if !self.outdated {
            self.carry_on(self.now);
            self.outdated = true;
        }
    }

    /// New cells for the discs as they lie now.
    #[cold]
    pub(super) fn renew_all_cells(&mut self) {
        let discs: Vec<Disc> = (0..self.flights.len()).map(|k| self.disc(k)).collect();
        let grids = grids(&self.laws, &discs);
        // Discs that went may have left so few that others would be wider than a periodic box.
        if self.laws.periodic.is_none() || grids.are_wide() {
            let Grids { cells, levels, diameter, needs } = grids;
            (self.cells, self.levels, self.diameter) = (cells, levels, diameter);
            self.scale = needs.diameter;
        } else {
            self.cells.clear();
            self.levels.clear();
        }
        self.made_for = discs.len();
        self.calendar.make_room_for(discs.len());
        self.renew_grid();
        self.outdated = false;
    }

    /// Whether a disc would overlap none but perhaps one.
    ///
    /// # Errors
    /// One that it overlaps.
    pub(super) fn is_clear_at(&self, disc: &Disc, but: Option<usize>) -> Result<(), NotDone> {
        let periodic = self.laws.periodic;
        let position = periodic.map_or(disc.position, |periodic| periodic.inside(disc.position));
        let disc = Disc { position, ..*disc };
        let near = if self.outdated {
            (0..self.flights.len()).collect()
        } else {
            self.discs_around(&disc)
        };
        let others = near.into_iter().filter(|&k| Some(k) != but).map(|k| self.disc(k));
        is_clear(&disc, others, periodic)
    }

    /// All discs that a disc may overlap.
    fn discs_around(&self, disc: &Disc) -> Vec<usize> {
        let mut near = Vec::new();
        for level in 0..self.levels() {
            let cells = self.levels.grid(&self.cells, level);
            let reach = disc.radius + self.levels.radius(level).unwrap_or(0.5 * self.diameter);
            cells.for_each_in_ring(disc.position, (0.0, reach), &mut |block| {
                let numbers = block.rows().flat_map(|row| &cells.numbers()[row]).copied();
                let held = numbers.filter(|&number| number != EMPTY);
                near.extend(held.chain(cells.beyond(&block)).map(|k| k as usize));
            });
        }
        near
    }
}
