//! What a disc is due for: its next contact and the end of its stay in its cell.

use glam::DVec2;

use super::cells::Block;
use super::lanes::{self, Meeting, Sight, Unit};
use super::{Due, Events, Flight, NOTHING, Place, TIE, WALL};
use crate::resolve::pair::{approach, rounding_speed};
use crate::world::{Owner, Side};

/// Walls by their numbers.
pub(super) const SIDES: [Side; 4] = [Side::Left, Side::Right, Side::Bottom, Side::Top];

/// What discs see; beyond the border of a periodic box if that may lie between. As a function it
/// would borrow the whole arena.
macro_rules! sight {
    ($arena:expr, $beyond_border:expr) => {
        Sight {
            numbers: $arena.cells.numbers(),
            flights: &$arena.flights,
            radii: $arena.radii.own(),
            square: $arena.reach * $arena.reach,
            now: $arena.now,
            wrap: if $beyond_border || $arena.wrap_inside { $arena.wrap } else { None },
            instant: $arena.same_instant,
        }
    };
}

impl Events {
    /// Makes new cells, and predicts all.
    pub(super) fn renew_grid(&mut self) {
        self.list_segments();
        self.dues.clear();
        for k in 0..self.flights.len() {
            self.bring_inside(k);
            let (level, at) = (self.levels.level(k), self.position(k));
            let cells = self.levels.grid_mut(&mut self.cells, level);
            let place = cells.place(at);
            cells.add(place, k as u32);
            let exit = f64::INFINITY;
            self.dues.push(Due { contact: exit, exit, partner: NOTHING, stamp: 0, place });
        }
        self.calendar.restart(self.calendar.day(), self.calendar.days());
        self.fit_limits();
        let all: Vec<usize> = (0..self.flights.len()).collect();
        self.lanes.renew_all(self, &all);
    }

    /// Brings a disc back into a periodic box, if it has left one.
    pub(super) fn bring_inside(&mut self, k: usize) {
        if let Some(periodic) = self.laws.periodic {
            self.noted.turn(&[k]);
            let flight = &mut self.flights[k];
            let position = flight.at(self.now);
            let shift = periodic.inside(position) - position;
            (flight.x, flight.y) = (flight.x + shift.x, flight.y + shift.y);
        }
    }

    #[inline(always)]
    pub(super) fn renew_all<U: Unit>(&mut self, discs: &[usize]) {
        discs.iter().for_each(|&k| U::renew(self, k, f64::NAN));
    }

    /// Predicts a disc again; `noted`: its time in the calendar.
    #[inline(always)]
    pub(super) fn predict_again<U: Unit>(&mut self, k: usize, noted: f64) {
        if U::BARE || self.levels.is_single() {
            let block = self.cells.around(self.dues[k].place);
            self.predict::<U>(k, &block);
        } else {
            self.predict_on_levels::<U>(k);
        }
        self.note(k, noted);
    }

    /// Notes in the calendar when a disc is due, if it is not `noted` there already.
    #[inline(always)]
    fn note(&mut self, k: usize, noted: f64) {
        let time = self.dues[k].time();
        if time != noted {
            self.calendar.insert(time, k);
        }
    }

    /// The same for two discs that just met; `noted`: the time of the second in the calendar.
    #[inline(always)]
    pub(super) fn predict_two_again<U: Unit>(&mut self, i: usize, j: usize, noted: f64) {
        if !U::BARE && !self.levels.is_single() {
            self.predict_again::<U>(i, f64::NAN);
            return self.predict_again::<U>(j, noted);
        }
        let places = [i, j].map(|k| self.dues[k].place);
        let blocks = places.map(|place| self.cells.around(place));
        let outermost = places.map(|place| self.cells.is_outermost(place));
        let sight = sight!(self, outermost[0] | outermost[1]);
        let [a, b] = U::earliest_of_two(&sight, &blocks, [i, j], &mut self.near);
        let a = self.checked::<U>(a, 0, i, places[0], &blocks[0]);
        let b = self.checked::<U>(b, 1, j, places[1], &blocks[1]);
        self.take::<U>(i, self.due_for(i, a, places[0]));
        self.take::<U>(j, self.due_for(j, b, places[1]));
        self.note(i, f64::NAN);
        self.note(j, noted);
    }

    /// Finds the next contact of a disc among those of a block.
    #[inline(always)]
    fn predict<U: Unit>(&mut self, k: usize, block: &Block) {
        let place = self.dues[k].place;
        let meeting = self.earliest_meeting::<U>(k, place, block);
        self.take::<U>(k, self.due_for(k, meeting, place));
    }

    /// Writes down what a disc is due for, if no wall comes before that.
    #[inline(always)]
    fn take<U: Unit>(&mut self, k: usize, mut due: Due) {
        if !U::BARE {
            let outermost = self.cells.is_outermost(due.place);
            self.consider_wall(k, &mut due, outermost);
        }
        due.exit = match &self.fall {
            Some(fall) if !U::BARE => self.falling_exit(fall, k, due.place).time,
            _ => self.exit(self.exits(k, due.place)),
        };
        self.dues[k] = due;
        if !U::BARE && self.fence.is_some() {
            self.consider_segments(k, 0);
        }
    }

    /// What a disc is due for that meets somebody, or nobody.
    #[inline(always)]
    pub(super) fn due_for(&self, k: usize, meeting: Meeting, place: Place) -> Due {
        let is_met = meeting.time < f64::INFINITY;
        let with = if is_met { meeting.with as usize } else { k };
        let met = meeting.with | if meeting.tie { TIE } else { 0 };
        Due {
            contact: meeting.time,
            exit: f64::INFINITY,
            partner: if is_met { met } else { NOTHING },
            stamp: self.flights[with].stamp(),
            place,
        }
    }

    /// A wall may come before another disc, if the cell is outermost.
    #[inline(always)]
    pub(super) fn consider_wall(&self, k: usize, due: &mut Due, outermost: bool) {
        if self.laws.walls.is_some()
            && outermost
            && let Some((time, side)) = self.wall(k)
            && time < due.contact
        {
            (due.contact, due.partner) = (time, WALL | side);
        }
    }

    /// The earliest meeting of a disc with those of a block of cells.
    #[inline(always)]
    fn earliest_meeting<U: Unit>(&mut self, k: usize, place: Place, block: &Block) -> Meeting {
        let sight = sight!(self, self.cells.is_outermost(place));
        let meeting = U::earliest(&sight, block, k, &mut self.near[0]);
        self.checked::<U>(meeting, 0, k, place, block)
    }

    /// A meeting that was found among `near[of]`, if nothing about it is in doubt.
    #[inline(always)]
    fn checked<U: Unit>(
        &self,
        meeting: Meeting,
        of: usize,
        k: usize,
        place: Place,
        block: &Block,
    ) -> Meeting {
        if self.cells.is_spilled() || self.is_in_doubt::<U>(meeting, of, k) {
            return self.earliest_with_care(of, k, place, block);
        }
        if !U::BARE && self.fall.is_some() {
            return self.among_odd(of, k, meeting);
        }
        meeting
    }

    /// Whether a meeting with one of `near[of]` must be looked at by the rules: they touch already,
    /// so that it is a question of rounding whether they approach, or somebody is a guest.
    #[inline(always)]
    fn is_in_doubt<U: Unit>(&self, meeting: Meeting, of: usize, k: usize) -> bool {
        meeting.time <= self.now || !U::BARE && self.guests && self.is_near_guest(of, k)
    }

    /// Whether a disc is, or is near, one with which not all contacts are ours to resolve.
    #[cold]
    fn is_near_guest(&self, of: usize, k: usize) -> bool {
        let near = self.near[of].discs().iter().map(|&other| other as usize);
        near.chain([k]).any(|k| self.is_guest(k) || self.masses.get(k).is_infinite())
    }

    /// The same, with a look at who the others are.
    #[cold]
    fn earliest_with_care(&self, of: usize, k: usize, place: Place, block: &Block) -> Meeting {
        let near = self.near[of].discs().iter().copied();
        let near: Vec<u32> = near.chain(self.cells.beyond(block)).collect();
        self.earliest_of(k, &near, self.cells.is_outermost(place))
    }

    /// The earliest meeting by the rules with one of these discs.
    fn earliest_of(&self, k: usize, near: &[u32], beyond_border: bool) -> Meeting {
        let sight = sight!(self, beyond_border);
        let time = |&with: &u32| self.meeting(&sight, k, with as usize).unwrap_or(f64::INFINITY);
        let times: Vec<f64> = near.iter().map(time).collect();
        Meeting::earliest(near, &times, sight.instant)
    }

    /// The earliest meeting of a disc with those gathered in `near`, wherever they are.
    #[inline(always)]
    pub(super) fn earliest_gathered<U: Unit>(&mut self, k: usize) -> Meeting {
        let sight = sight!(self, true);
        let meeting = U::earliest_gathered(&sight, k, &mut self.near[0]);
        if self.is_in_doubt::<U>(meeting, 0, k) {
            return self.earliest_of(k, self.near[0].discs(), true);
        }
        meeting
    }

    /// The discs around another.
    pub(super) fn discs_near<U: Unit>(&mut self, k: usize) -> Vec<usize> {
        if !self.levels.is_single() {
            return self.discs_on_levels_near::<U>(k);
        }
        let block = self.cells.around(self.dues[k].place);
        self.near[0].clear();
        U::gather(self.cells.numbers(), &block, &mut self.near[0]);
        let near = self.near[0].discs().iter().copied().chain(self.cells.beyond(&block));
        near.filter(|&other| other != k as u32).map(|other| other as usize).collect()
    }

    /// When two discs meet by the rules, s.
    fn meeting(&self, sight: &Sight, k: usize, with: usize) -> Option<f64> {
        if k == with || !self.can_collide(k, with) {
            return None;
        }
        if let Some(pull) = self.pull_between(k, with) {
            return self.falling_meeting(k, with, pull, f64::INFINITY);
        }
        let time = lanes::meeting(sight, k, with)?;
        (time > self.now || self.approaches_beyond_rounding(k, with)).then_some(time)
    }

    /// When two discs that may be anywhere meet, s.
    pub(super) fn meeting_of(&self, k: usize, with: usize) -> Option<f64> {
        self.meeting(&sight!(self, true), k, with)
    }

    /// Whether a contact of the two is ours to resolve and would change one of them.
    fn can_collide(&self, k: usize, l: usize) -> bool {
        let ours = self.owners[k] == Owner::Simulated || self.owners[l] == Owner::Simulated;
        ours && (self.masses.get(k).is_finite() || self.masses.get(l).is_finite())
    }

    pub(super) fn approaches_beyond_rounding(&self, k: usize, l: usize) -> bool {
        let (a, b) = self.pair(k, l);
        approach(&a, &b).is_some_and(|(_, speed)| speed > rounding_speed(&a, &b))
    }

    /// When a disc leaves its cell that reaches the edges then, s.
    #[inline(always)]
    pub(super) fn exit(&self, (x, y): (f64, f64)) -> f64 {
        let exit = if y < x { y } else { x };
        if exit < self.now { self.now } else { exit }
    }

    /// The same for each axis, not bounded by the present.
    #[inline(always)]
    fn exits(&self, k: usize, place: Place) -> (f64, f64) {
        self.exits_between(k, self.cells.edges(place))
    }

    /// When a disc leaves the region between edges, for each axis, s.
    #[inline(always)]
    pub(super) fn exits_between(&self, k: usize, (low, high): (DVec2, DVec2)) -> (f64, f64) {
        let flight = &self.flights[k];
        (until(flight.x, flight.vx, low.x, high.x), until(flight.y, flight.vy, low.y, high.y))
    }

    /// Along which axis a disc leaves its cell, and whether upwards.
    #[inline(always)]
    pub(super) fn way_out(&self, k: usize, place: Place) -> (bool, bool) {
        let (x, y) = self.exits(k, place);
        let (along_x, flight) = (x <= y, &self.flights[k]);
        (along_x, if along_x { flight.vx > 0.0 } else { flight.vy > 0.0 })
    }

    /// A disc that leaves its cell goes over to the next one.
    #[inline(always)]
    pub(super) fn change_cell<U: Unit>(&mut self, k: usize, due: Due) {
        if !U::BARE && !self.levels.is_single() {
            return self.change_cell_on_level::<U>(k, due);
        }
        let falls = self.fall.as_ref().filter(|_| !U::BARE);
        let (along_x, up) = if let Some(fall) = falls {
            let exit = self.falling_exit(fall, k, due.place);
            // By rounding it is not there yet, or turns round just before.
            if exit.time > self.now + self.same_instant {
                return U::renew(self, k, f64::NAN);
            }
            (exit.along_x, exit.up)
        } else {
            self.way_out(k, due.place)
        };
        let Some((place, shift)) = self.cells.neighbour(due.place, along_x, up) else {
            return self.renew_all_cells();
        };
        if shift != DVec2::ZERO {
            self.noted.turn(&[k]);
            let flight = &mut self.flights[k];
            (flight.x, flight.y) = (flight.x + shift.x, flight.y + shift.y);
        }
        self.cells.remove(due.place, k as u32);
        self.cells.add(place, k as u32);
        self.dues[k].place = place;
        if self.is_stale(&due) {
            return U::renew(self, k, f64::NAN);
        }
        let ahead = self.cells.ahead(place, along_x, up);
        self.predict_ahead::<U>(k, Due { place, ..due }, &ahead);
        self.note(k, f64::NAN);
    }

    /// Whether the disc that is to be met flies otherwise than when that was predicted.
    #[inline(always)]
    pub(super) fn is_stale(&self, due: &Due) -> bool {
        let met = due.met();
        // Of one that went the last disc may have taken the place, or nobody.
        met < WALL as usize && self.flights.get(met).map(Flight::stamp) != Some(due.stamp)
    }

    /// What is known still holds: only the discs in cells that came near are looked at.
    #[inline(never)]
    fn predict_ahead<U: Unit>(&mut self, k: usize, mut due: Due, ahead: &Block) {
        let meeting = self.earliest_meeting::<U>(k, due.place, ahead);
        due = self.sooner(k, due, meeting);
        self.take::<U>(k, due);
    }

    /// What was known, or what was found beside it if that comes first.
    #[inline(always)]
    pub(super) fn sooner(&self, k: usize, mut due: Due, meeting: Meeting) -> Due {
        let instant = self.same_instant;
        if meeting.time < due.contact {
            let tie = meeting.tie || due.contact <= meeting.time + instant;
            due = self.due_for(k, Meeting { tie, ..meeting }, due.place);
        } else if meeting.time <= due.contact + instant && due.partner < WALL {
            due.partner |= TIE;
        }
        due
    }

    /// The next wall that a disc reaches.
    #[inline]
    fn wall(&self, k: usize) -> Option<(f64, u32)> {
        let walls = self.laws.walls.filter(|_| self.owners[k] == Owner::Simulated)?;
        if let Some(fall) = &self.fall {
            return self.falling_wall(fall, k);
        }
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
pub(super) fn until(x: f64, v: f64, low: f64, high: f64) -> f64 {
    let bound = if v > 0.0 { high } else { low };
    if v == 0.0 { f64::INFINITY } else { (bound - x) / v }
}
