//! What a disc is due for: its next contact and the end of its stay in its cell.

use glam::DVec2;

use super::lanes::{Meeting, Query, Unit};
use super::{Due, Events, NOTHING, Place, TIE, WALL};
use crate::exact::UNIT_ROUNDOFF;
use crate::world::Side;

/// Walls by their numbers.
pub(super) const SIDES: [Side; 4] = [Side::Left, Side::Right, Side::Bottom, Side::Top];

/// Events closer than this, in units of their time or the epoch, are at the same instant.
const SAME_INSTANT: f64 = 16.0 * UNIT_ROUNDOFF;

impl Events {
    /// Puts all discs into cells.
    pub(super) fn place_all(&mut self) {
        for (k, flight) in self.flights.iter_mut().enumerate() {
            if let Some(periodic) = self.laws.periodic {
                let inside = periodic.inside(flight.start());
                (flight.x, flight.y) = (inside.x, inside.y);
            }
            let place = self.cells.place(flight.at(self.now));
            self.cells.add(place, k as u32);
            let exit = f64::INFINITY;
            self.dues.push(Due { contact: exit, exit, partner: NOTHING, stamp: 0, place });
        }
    }

    #[inline(always)]
    pub(super) fn predict_all<U: Unit>(&mut self) {
        for k in 0..self.flights.len() {
            self.dues[k].exit = self.exit(k, self.dues[k].place);
            self.predict::<U>(k);
            self.calendar.insert(self.dues[k].time(), k);
        }
    }

    /// Finds the next contact of a disc.
    #[inline(always)]
    pub(super) fn predict<U: Unit>(&mut self, k: usize) {
        let place = self.dues[k].place;
        let outermost = self.cells.is_outermost(place);
        let meeting = self.earliest_meeting::<U>(k, place, outermost);
        let tie = meeting.second - meeting.time
            <= SAME_INSTANT * meeting.time.max(self.calendar.epoch());
        let (mut contact, mut partner, mut stamp) = (meeting.time, NOTHING, 0);
        if meeting.time < f64::INFINITY {
            partner = meeting.with | if tie { TIE } else { 0 };
            stamp = self.flights[meeting.with as usize].stamp();
        }
        if outermost && let Some((time, side)) = self.wall(k) && time < contact {
            (contact, partner) = (time, WALL | side);
        }
        let due = &mut self.dues[k];
        (due.contact, due.partner, due.stamp) = (contact, partner, stamp);
    }

    #[inline(always)]
    fn earliest_meeting<U: Unit>(&mut self, k: usize, place: Place, outermost: bool) -> Meeting {
        let count = self.cells.collect(place, &mut self.near);
        let padded = count.next_multiple_of(4);
        self.near[count..padded].fill(k as u32);
        let radius = self.radii.get(k);
        let radii = self.radii.own();
        let query = Query {
            disc: k,
            now: self.now,
            reach: if radii.is_empty() { 2.0 * radius } else { radius },
            wrap: self.laws.periodic.filter(|_| outermost).map(|periodic| periodic.size()),
        };
        U::earliest(&query, &self.flights, radii, &self.near[..padded])
    }

    /// When a disc leaves its cell, s.
    #[inline(always)]
    pub(super) fn exit(&self, k: usize, place: Place) -> f64 {
        let (x, y) = self.exits(k, place);
        x.min(y).max(self.now)
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
        let Some((place, shift)) = self.cells.neighbour(due.place, along_x, up) else { return };
        if shift != DVec2::ZERO {
            flight.x += shift.x;
            flight.y += shift.y;
        }
        self.cells.remove(due.place, k as u32);
        self.cells.add(place, k as u32);
        self.dues[k].place = place;
        self.dues[k].exit = self.exit(k, place);
        self.predict::<U>(k);
        self.calendar.insert(self.dues[k].time(), k);
    }

    /// The next wall that a disc reaches.
    fn wall(&self, k: usize) -> Option<(f64, u32)> {
        let walls = self.laws.walls?;
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
