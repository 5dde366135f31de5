//! What a disc is due for: its next contact and the end of its stay in its cell.

use glam::DVec2;

use super::lanes::{self, Meeting, NOBODY, Query, Unit};
use super::{Due, Events, NOTHING, Place, SAME_INSTANT, TIE, WALL};
use crate::resolve::pair::{approach, rounding_speed};
use crate::world::{Owner, Side};

/// Walls by their numbers.
pub(super) const SIDES: [Side; 4] = [Side::Left, Side::Right, Side::Bottom, Side::Top];

impl Events {
    /// Makes new cells, and predicts all.
    pub(super) fn renew_grid(&mut self) {
        self.dues.clear();
        for (k, flight) in self.flights.iter_mut().enumerate() {
            if let Some(periodic) = self.laws.periodic {
                let position = flight.at(self.now);
                let shift = periodic.inside(position) - position;
                (flight.x, flight.y) = (flight.x + shift.x, flight.y + shift.y);
            }
            let place = self.cells.place(flight.at(self.now));
            self.cells.add(place, k as u32);
            let exit = f64::INFINITY;
            self.dues.push(Due { contact: exit, exit, partner: NOTHING, stamp: 0, place });
        }
        self.calendar.restart(self.calendar.day(), self.calendar.days());
        let all: Vec<usize> = (0..self.flights.len()).collect();
        lanes::renew_all(self, &all);
    }

    #[inline(always)]
    pub(super) fn renew_all<U: Unit>(&mut self, discs: &[usize]) {
        discs.iter().for_each(|&k| self.renew::<U>(k, f64::NAN));
    }

    /// Predicts a disc again; `noted`: its time in the calendar.
    #[inline(never)]
    pub(super) fn renew<U: Unit>(&mut self, k: usize, noted: f64) {
        self.predict::<U>(k);
        let time = self.dues[k].time();
        if time != noted {
            self.calendar.insert(time, k);
        }
    }

    /// Finds the next contact of a disc.
    #[inline(always)]
    fn predict<U: Unit>(&mut self, k: usize) {
        let place = self.dues[k].place;
        let outermost = self.cells.is_outermost(place);
        let meeting = self.earliest_meeting::<U>(k, place, outermost);
        let (mut contact, mut partner, mut stamp) = (meeting.time, NOTHING, 0);
        if meeting.time < f64::INFINITY {
            let tie = meeting.second - meeting.time <= SAME_INSTANT * self.calendar.epoch();
            partner = meeting.with | if tie { TIE } else { 0 };
            stamp = self.flights[meeting.with as usize].stamp();
        }
        if outermost
            && let Some((time, side)) = self.wall(k)
            && time < contact
        {
            (contact, partner) = (time, WALL | side);
        }
        let exit = self.exit_before(k, place, contact);
        self.dues[k] = Due { contact, exit, partner, stamp, place };
    }

    #[inline(always)]
    fn earliest_meeting<U: Unit>(&mut self, k: usize, place: Place, outermost: bool) -> Meeting {
        let count = self.cells.collect(place, &mut self.near);
        let padded = count.next_multiple_of(4);
        self.near[count..padded].fill(k as u32);
        let query = self.query(k, outermost);
        let near = &self.near[..padded];
        let meeting = U::earliest(&query, &self.flights, self.radii.own(), near);
        // Touching already: whether they approach is a question of rounding.
        if meeting.time <= self.now || self.guests {
            return self.earliest_with_care(k, count, &query);
        }
        meeting
    }

    #[inline(always)]
    fn query(&self, k: usize, outermost: bool) -> Query {
        let (radius, own) = (self.radii.get(k), self.radii.own());
        Query {
            disc: k,
            now: self.now,
            reach: if own.is_empty() { 2.0 * radius } else { radius },
            wrap: self.laws.periodic.filter(|_| outermost).map(|periodic| periodic.size()),
        }
    }

    /// The same, with a look at who the others are.
    #[cold]
    fn earliest_with_care(&self, k: usize, count: usize, query: &Query) -> Meeting {
        let mut found = NOBODY;
        for &with in &self.near[..count] {
            let Some(time) = self.meeting(k, with as usize, query) else { continue };
            found.second = found.second.min(time.max(found.time));
            if time < found.time {
                (found.time, found.with) = (time, with);
            }
        }
        found
    }

    /// When two discs meet by the rules, s.
    fn meeting(&self, k: usize, with: usize, query: &Query) -> Option<f64> {
        if k == with || !self.can_collide(k, with) {
            return None;
        }
        let time = lanes::meeting(query, &self.flights, self.radii.own(), with)?;
        (time > self.now || self.approaches_beyond_rounding(k, with)).then_some(time)
    }

    /// When two discs that may be anywhere meet, s.
    pub(super) fn meeting_of(&self, k: usize, with: usize) -> Option<f64> {
        self.meeting(k, with, &self.query(k, true))
    }

    /// Whether a contact of the two is ours to resolve and would change one of them.
    fn can_collide(&self, k: usize, l: usize) -> bool {
        let ours = self.owners[k] == Owner::Simulated || self.owners[l] == Owner::Simulated;
        ours && (self.masses.get(k).is_finite() || self.masses.get(l).is_finite())
    }

    fn approaches_beyond_rounding(&self, k: usize, l: usize) -> bool {
        let (a, b) = self.pair(k, l);
        approach(&a, &b).is_some_and(|(_, speed)| speed > rounding_speed(&a, &b))
    }

    /// When a disc leaves its cell, s; infinite if its contact comes first.
    #[inline(always)]
    fn exit_before(&self, k: usize, place: Place, contact: f64) -> f64 {
        let (low, high) = self.cells.edges(place);
        let at = self.flights[k].at(contact);
        // Also false for a place that is no number.
        if at.x > low.x && at.x < high.x && at.y > low.y && at.y < high.y {
            return f64::INFINITY;
        }
        let (x, y) = self.exits(k, place);
        let exit = if y < x { y } else { x };
        if exit < self.now { self.now } else { exit }
    }

    /// The same for each axis.
    #[inline(always)]
    fn exits(&self, k: usize, place: Place) -> (f64, f64) {
        let (low, high) = self.cells.edges(place);
        let flight = &self.flights[k];
        (until(flight.x, flight.vx, low.x, high.x), until(flight.y, flight.vy, low.y, high.y))
    }

    /// A disc that leaves its cell goes over to the next one.
    #[inline(always)]
    pub(super) fn change_cell<U: Unit>(&mut self, k: usize, due: Due) {
        let (x, y) = self.exits(k, due.place);
        let along_x = x <= y;
        let flight = &mut self.flights[k];
        let up = if along_x { flight.vx > 0.0 } else { flight.vy > 0.0 };
        let Some((place, shift)) = self.cells.neighbour(due.place, along_x, up) else {
            return self.renew_all_cells();
        };
        if shift != DVec2::ZERO {
            (flight.x, flight.y) = (flight.x + shift.x, flight.y + shift.y);
        }
        self.cells.remove(due.place, k as u32);
        self.cells.add(place, k as u32);
        self.dues[k].place = place;
        self.renew::<U>(k, f64::NAN);
    }

    /// The next wall that a disc reaches.
    #[inline]
    fn wall(&self, k: usize) -> Option<(f64, u32)> {
        let walls = self.laws.walls.filter(|_| self.owners[k] == Owner::Simulated)?;
        let (flight, radius) = (&self.flights[k], self.radii.get(k));
        let (min, max) = (walls.min + radius, walls.max - radius);
        let x = until(flight.x, flight.vx, min.x, max.x);
        let y = until(flight.y, flight.vy, min.y, max.y);
        let side = |base: u32, v: f64| base + u32::from(v > 0.0);
        let (time, side) = if y < x { (y, side(2, flight.vy)) } else { (x, side(0, flight.vx)) };
        (time < f64::INFINITY).then_some((time.max(self.now), side))
    }
}

/// When `x + v t` reaches the bound ahead; infinite without velocity.
#[inline(always)]
fn until(x: f64, v: f64, low: f64, high: f64) -> f64 {
    let bound = if v > 0.0 { high } else { low };
    if v == 0.0 { f64::INFINITY } else { (bound - x) / v }
}
