//! Gravity: the same constant acceleration of all discs that fall.
//!
//! Two that fall see each other fly straight, so flights are kept as they would be without gravity
//! since the start of the epoch, and all that is known of pairs stays as it is. What gravity adds
//! since then, `g t` and `g t^2 / 2`, is asked for only where one disc is looked at by itself: at
//! walls and edges of cells, at the start of an epoch, and by whoever looks from outside.
//!
//! Fixed and observed discs do not fall, and one that rests on a wall falls along it only. Such a
//! disc and one that falls see each other on a parabola: these pairs alone are looked at by the
//! exact routine of [`crate::detect::falling`], under the policies of the plain method.
//!
//! Without gravity nothing of this is there.

use glam::DVec2;

use super::lanes::{Meeting, Unit};
use super::predict::until;
use super::{Due, Events, FAR, Flight, Laws, Place};
use crate::detect::falling::{Approach, falling_pair_impact, time_to_fall};
use crate::exact::{RunningSum, UNIT_ROUNDOFF};
use crate::motion::Witness;
use crate::resolve::wall::{bounce, wall_contact};
use crate::world::{Disc, Owner, Side, limits};

/// An epoch is so short that a disc falls from rest by half of this, in diameters.
const DEEP: f64 = 64.0;

/// Discs count as touching if the square of their distance is that of contact to this part.
const TOUCHING: f64 = 1e-13;

/// What falls, and how.
#[derive(Clone, Debug)]
pub(super) struct Fall {
    gravity: DVec2,
    /// Along which axes each disc has this acceleration: a bit of x and one of y.
    along: Vec<u8>,
    /// Discs that lack it along one axis, at least.
    odd: usize,
    /// Where each disc was when the work of gravity was last booked, m.
    booked: Vec<DVec2>,
}

/// Along both axes.
const BOTH: u8 = 3;

impl Fall {
    /// Of no discs so far.
    pub fn new(gravity: DVec2) -> Self {
        Self { gravity, along: Vec::new(), odd: 0, booked: Vec::new() }
    }

    /// The longest epoch for discs of this diameter, s: starts of flights stay near.
    pub fn longest_epoch(&self, diameter: f64) -> f64 {
        if diameter > 0.0 {
            (DEEP * diameter / self.gravity.length()).sqrt()
        } else {
            f64::INFINITY
        }
    }

    /// Adds a disc.
    pub fn push(&mut self, laws: &Laws, disc: &Disc, owner: Owner) {
        self.along.push(BOTH);
        self.set(self.along.len() - 1, self.axes(laws, disc, owner));
        self.booked.push(disc.position);
    }

    /// Takes a disc out; the last one takes its place.
    pub fn swap_remove(&mut self, k: usize) {
        self.set(k, BOTH);
        self.along.swap_remove(k);
        self.booked.swap_remove(k);
    }

    fn set(&mut self, k: usize, along: u8) {
        let odd = |along: u8| usize::from(along != BOTH);
        self.odd = self.odd + odd(along) - odd(self.along[k]);
        self.along[k] = along;
    }

    /// Along which axes a disc falls.
    fn axes(&self, laws: &Laws, disc: &Disc, owner: Owner) -> u8 {
        let falls = owner == Owner::Simulated && disc.mass.is_finite();
        let pull = if falls { laws.acceleration(self.gravity, disc) } else { DVec2::ZERO };
        u8::from(pull.x == self.gravity.x) | u8::from(pull.y == self.gravity.y) << 1
    }

    fn acceleration(&self, k: usize) -> DVec2 {
        let along = self.along[k];
        let pull = |axis: u8, pull: f64| if along & axis == 0 { 0.0 } else { pull };
        DVec2::new(pull(1, self.gravity.x), pull(2, self.gravity.y))
    }

    /// How the second of two discs accelerates as the first sees it, m/s^2, if it does.
    #[inline(always)]
    pub fn between(&self, i: usize, j: usize) -> Option<DVec2> {
        let differ = self.odd > 0 && self.along[i] != self.along[j];
        differ.then(|| self.acceleration(j) - self.acceleration(i))
    }
}

/// The border that a falling disc reaches next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Border {
    /// When, s; infinite = never.
    pub time: f64,
    pub along_x: bool,
    pub up: bool,
}

impl Events {
    /// Where a disc is.
    #[inline(always)]
    pub(super) fn position(&self, k: usize) -> DVec2 {
        let position = self.flights[k].at(self.now);
        self.fall
            .as_ref()
            .map_or(position, |fall| position + fall.acceleration(k) * (0.5 * self.now * self.now))
    }

    /// How a disc moves.
    #[inline(always)]
    pub(super) fn velocity(&self, k: usize) -> DVec2 {
        let velocity = self.flights[k].velocity();
        self.fall.as_ref().map_or(velocity, |fall| velocity + fall.acceleration(k) * self.now)
    }

    /// The acceleration of the second of two discs as the first sees it, m/s^2, if there is one.
    #[inline(always)]
    pub(super) fn pull_between(&self, i: usize, j: usize) -> Option<DVec2> {
        self.fall.as_ref().and_then(|fall| fall.between(i, j))
    }

    /// Gives a disc another velocity from now on.
    pub(super) fn turn(&mut self, k: usize, velocity: DVec2) {
        if self.fall.is_none() {
            self.noted.turn(&[k]);
            return self.flights[k].turn(self.now, velocity);
        }
        self.set_state(k, self.position(k), velocity);
    }

    /// Whether a disc rests may be otherwise after its velocity has changed.
    pub(super) fn settle(&mut self, k: usize) {
        let disc = self.disc(k);
        let owner = self.owners[k];
        let changed = |fall: &Fall| fall.axes(&self.laws, &disc, owner) != fall.along[k];
        if self.fall.as_ref().is_some_and(changed) {
            self.set_state(k, disc.position, disc.velocity);
        }
    }

    /// Puts a disc somewhere, under gravity.
    fn set_state(&mut self, k: usize, position: DVec2, velocity: DVec2) {
        let disc = Disc { position, velocity, ..self.disc(k) };
        let Some(fall) = &mut self.fall else { return };
        let before = fall.acceleration(k);
        fall.set(k, fall.axes(&self.laws, &disc, self.owners[k]));
        let (acceleration, now) = (fall.acceleration(k), self.now);
        if acceleration != before && self.momentum.is_kept() {
            let change = (acceleration - before) * disc.mass;
            self.momentum.book_pull(self.base + now, change);
        }
        let DVec2 { x: vx, y: vy } = velocity - acceleration * now;
        let start = position - (DVec2::new(vx, vy) + acceleration * (0.5 * now)) * now;
        let before = self.flights[k].stamp();
        self.flights[k] = Flight { x: start.x, y: start.y, vx, vy };
        if self.flights[k].stamp() == before {
            self.expect_otherwise(k);
        }
    }

    /// Puts a disc where it did not come by falling: gravity did no work on the way.
    pub(super) fn put_falling(&mut self, k: usize, position: DVec2, velocity: DVec2) {
        self.set_state(k, position, velocity);
        if let Some(fall) = &mut self.fall {
            fall.booked[k] = position;
        }
    }

    /// Who expects to meet a disc is wrong, though it seems to fly as before.
    pub(super) fn expect_otherwise(&mut self, k: usize) {
        let met = self.dues.iter_mut().filter(|due| due.met() == k);
        met.for_each(|due| due.stamp = !due.stamp);
    }

    /// Carries all flights on to a later start of the epoch, under gravity. They have other stamps
    /// then; what was expected of them holds as before.
    pub(super) fn carry_falling(&mut self, by: f64) {
        let Some(fall) = &self.fall else { return };
        let stamp_of = |flights: &[Flight], due: &Due| flights.get(due.met()).map(Flight::stamp);
        let holds = |due: &Due| stamp_of(&self.flights, due) == Some(due.stamp);
        let held: Vec<bool> = self.dues.iter().map(holds).collect();
        for (k, flight) in self.flights.iter_mut().enumerate() {
            let gained = fall.acceleration(k) * by;
            let start = flight.at(by) + gained * (0.5 * by);
            let DVec2 { x: vx, y: vy } = flight.velocity() + gained;
            *flight = Flight { x: start.x, y: start.y, vx, vy };
        }
        for (due, held) in self.dues.iter_mut().zip(held) {
            if let Some(stamp) = stamp_of(&self.flights, due) {
                due.stamp = if held { stamp } else { !stamp };
            }
        }
    }

    /// Whether gravity has carried discs so far since the start of the epoch that it must begin
    /// anew.
    pub(super) fn fell_far(&self) -> bool {
        let far = |fall: &Fall| self.now > fall.longest_epoch(self.diameter * FAR / DEEP);
        self.fall.as_ref().is_some_and(far)
    }

    /// The border between two corners that a disc reaches next.
    fn border(&self, fall: &Fall, k: usize, low: DVec2, high: DVec2) -> Border {
        let (flight, acceleration) = (&self.flights[k], fall.acceleration(k));
        let x = Axis { start: flight.x, speed: flight.vx, pull: acceleration.x };
        let y = Axis { start: flight.y, speed: flight.vy, pull: acceleration.y };
        let (time_x, up_x) = x.leaves(self.now, low.x, high.x);
        let (time_y, up_y) = y.leaves(self.now, low.y, high.y);
        if time_y < time_x {
            Border { time: time_y, along_x: false, up: up_y }
        } else {
            Border { time: time_x, along_x: true, up: up_x }
        }
    }

    /// Where and when a disc leaves its cell, under gravity.
    pub(super) fn falling_exit(&self, fall: &Fall, k: usize, place: Place) -> Border {
        let (low, high) = self.cells.edges(place);
        self.border(fall, k, low, high)
    }

    /// The next wall that a disc reaches, under gravity, by its number.
    pub(super) fn falling_wall(&self, fall: &Fall, k: usize) -> Option<(f64, u32)> {
        let walls = self.laws.walls?;
        let radius = self.radii.get(k);
        let Border { time, along_x, up } =
            self.border(fall, k, walls.min + radius, walls.max - radius);
        let side = if along_x { 0 } else { 2 } + u32::from(up);
        (time < f64::INFINITY).then_some((time, side))
    }

    /// When two discs meet of which one falls otherwise than the other, s; what comes after `until`
    /// may be left out.
    pub(super) fn falling_meeting(
        &self,
        k: usize,
        with: usize,
        pull: DVec2,
        until: f64,
    ) -> Option<f64> {
        let (d, w) = (self.offset(k, with), self.velocity(with) - self.velocity(k));
        let (reach, distance) = (self.radii.get(k) + self.radii.get(with), d.length());
        let horizon = until - self.now;
        let way = (w.length() + 0.5 * pull.length() * horizon) * horizon;
        if distance - reach > way + 1e-9 * (way + reach) {
            return None;
        }
        // What touches to rounding touches: a gap would be a flight of its own.
        let touches = (distance * distance - reach * reach).abs() <= TOUCHING * reach * reach;
        let reach = if touches { distance * (1.0 + 4.0 * UNIT_ROUNDOFF) } else { reach };
        // Quick enough for the collapse model to make it a hop: or it would sink in.
        let quick = 0.25 * self.laws.contact_time;
        let shortest = if quick > 0.0 { quick } else { limits::PRESSED_CONTACT_S };
        Some(match falling_pair_impact(d, w, pull, reach, shortest)? {
            Approach::At(time) if self.now + time > self.now => self.now + time,
            Approach::At(_) | Approach::Now if self.approaches_beyond_rounding(k, with) => self.now,
            _ => self.now + shortest,
        })
    }

    /// The earliest meeting among those that were found as if all fell alike, if some do not.
    pub(super) fn among_odd(&self, of: usize, k: usize, meeting: Meeting) -> Meeting {
        let Some(fall) = self.fall.as_ref().filter(|fall| fall.odd > 0) else { return meeting };
        let near = self.near[of].discs();
        let is_odd = |with: u32| fall.along[with as usize] != fall.along[k];
        if !near.iter().any(|&with| is_odd(with)) {
            return meeting;
        }
        let alike = near.iter().zip(self.near[of].times());
        let alike = alike.map(|(&with, &time)| if is_odd(with) { f64::INFINITY } else { time });
        let mut times: Vec<f64> = alike.collect();
        let mut first = times.iter().copied().fold(f64::INFINITY, f64::min);
        for (&with, time) in near.iter().zip(&mut times) {
            if let Some(pull) = fall.between(k, with as usize) {
                let until = first + self.same_instant;
                let found = self.falling_meeting(k, with as usize, pull, until);
                *time = found.unwrap_or(f64::INFINITY);
                first = first.min(*time);
            }
        }
        Meeting::earliest(near, &times, self.same_instant)
    }

    /// A disc meets a wall, under gravity: it bounces, or comes to rest there.
    #[inline(never)]
    pub(super) fn land<U: Unit>(&mut self, k: usize, side: Side, witness: &mut impl Witness) {
        let Some(walls) = self.laws.walls else { return };
        self.book_fall(k);
        // No rounding may leave it a little above the wall, or below: flights are short.
        let mut disc = self.disc(k);
        disc.position = walls.onto(side, &disc);
        let mut restitution = self.restitution(walls.restitution, &[k]);
        let slow = disc.velocity.dot(side.normal()) * restitution <= limits::REST_SPEED_MPS;
        let collapses = restitution != walls.restitution;
        let presses = self.laws.presses_on(side);
        if presses && walls.restitution < 1.0 && (slow || collapses) {
            restitution = 0.0;
        }
        if let Some(hit) = bounce(&disc, side, restitution) {
            self.energy.book(-hit.energy_loss);
            self.momentum.book(side.normal() * -hit.impulse);
            self.set_state(k, disc.position, hit.velocity);
            self.note_contacts::<U>(&[k], 1);
            witness.see(|| wall_contact(&disc, side, &walls, &hit, self.now()));
        } else if presses {
            self.lay_down(k, side, &disc);
        }
        U::renew(self, k, f64::NAN);
    }

    /// Ends a hop off a wall that is too short for the clock.
    fn lay_down(&mut self, k: usize, side: Side, disc: &Disc) {
        let velocity = disc.velocity - side.normal() * disc.velocity.dot(side.normal());
        let after = Disc { velocity, ..*disc };
        if self.closes_energy(k) {
            self.energy.book(after.kinetic_energy() - disc.kinetic_energy());
            self.momentum.book_change(disc.mass, velocity - disc.velocity);
        }
        self.set_state(k, disc.position, velocity);
    }

    /// Books what gravity has done to a disc since it was last booked.
    pub(super) fn book_fall(&mut self, k: usize) {
        let (position, work) = (self.position(k), self.work_since(k));
        if let Some(fall) = &mut self.fall {
            fall.booked[k] = position;
            self.energy.book(work);
        }
    }

    /// Books gravity on those that fall from now on: some came, went or were moved.
    pub(super) fn book_weight(&mut self) {
        if self.fall.is_some() && self.momentum.is_kept() {
            self.momentum.set_pull(self.now(), self.weight());
        }
    }

    /// What gravity does to all that falls, N.
    pub(super) fn weight(&self) -> DVec2 {
        let Some(fall) = &self.fall else { return DVec2::ZERO };
        let falling = (0..self.flights.len()).filter(|&k| self.closes_energy(k));
        falling.map(|k| self.masses.get(k) * fall.acceleration(k)).sum()
    }

    /// What gravity has done to discs and is not booked yet, J.
    pub(super) fn work_of_gravity(&self) -> f64 {
        if self.fall.is_none() {
            return 0.0;
        }
        let each = (0..self.flights.len()).map(|k| self.work_since(k));
        each.collect::<RunningSum>().value()
    }

    fn work_since(&self, k: usize) -> f64 {
        let Some(fall) = self.fall.as_ref().filter(|_| self.closes_energy(k)) else { return 0.0 };
        self.masses.get(k) * fall.gravity.dot(self.position(k) - fall.booked[k])
    }
}

/// One coordinate of a flight, at the start of the epoch.
struct Axis {
    start: f64,
    speed: f64,
    pull: f64,
}

impl Axis {
    /// When it reaches one of two bounds, s, and whether that is the upper one.
    fn leaves(&self, now: f64, low: f64, high: f64) -> (f64, bool) {
        let Self { start, speed, pull } = *self;
        if pull == 0.0 {
            return (until(start, speed, low, high).max(now), speed > 0.0);
        }
        let place = (start + speed * now) + pull * (0.5 * now * now);
        let rounding = 8.0 * UNIT_ROUNDOFF * (start.abs() + (speed.abs() + pull.abs() * now) * now);
        let speed = speed + pull * now;
        let up = wait(high - place, speed, pull, rounding);
        let down = wait(place - low, -speed, -pull, rounding);
        if down < up { (now + down, false) } else { (now + up, true) }
    }
}

/// Time until a distance `left`, known to rounding, that shrinks with `speed` and ever faster by
/// `pull`, is used up, s; infinite = never.
fn wait(left: f64, speed: f64, pull: f64, rounding: f64) -> f64 {
    if left == f64::INFINITY {
        return left;
    }
    if left > rounding {
        return time_to_fall(left, speed, pull).unwrap_or(f64::INFINITY);
    }
    if speed > 0.0 || (speed == 0.0 && pull > 0.0) {
        return 0.0;
    }
    // It leaves, and may come back.
    if pull > 0.0 { -2.0 * speed / pull } else { f64::INFINITY }
}
