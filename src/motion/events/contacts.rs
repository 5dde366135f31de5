//! What happens when a disc is due for a contact: that is resolved, or found out of date.

use glam::DVec2;

use super::cells::Block;
use super::lanes::{Unit, prefetch};
use super::predict::SIDES;
use super::{Due, Each, Events, Last, Place, SEGMENT, TIE, WALL};
use crate::motion::Witness;
use crate::resolve::pair::{Exchange, MassFractions, exchange};
use crate::resolve::wall::{bounce, wall_contact};
use crate::world::{Contact, Disc, Owner, Partner, limits};

/// By how much the square of a distance may differ from contact, in its own units: beyond it, a
/// partner was moved from outside.
const OUT_OF_TOUCH: f64 = 1e-9;

/// Events from one look ahead to the next: what was asked for must not leave the first cache before
/// it is needed (measured at 1e6 discs: 3 takes 0.85 of the time of 8).
const STEP: usize = 3;

impl Events {
    /// The contact that a disc is due for.
    #[inline(always)]
    pub(super) fn meet<U: Unit>(&mut self, k: usize, due: Due, witness: &mut impl Witness) {
        let met = due.met();
        if !U::BARE && met >= WALL as usize {
            self.bounce_off::<U>(k, met, witness);
        } else if self.is_stale(&due) {
            U::renew(self, k, f64::NAN);
        } else if (due.partner | self.dues[met].partner) & TIE != 0 || self.is_crowded(k, met) {
            self.collide_together::<U>(k, met, witness);
        } else {
            self.collide::<U>(k, met, witness);
        }
    }

    /// Whether another disc than these two has a contact at this instant.
    #[inline(always)]
    fn is_crowded(&self, k: usize, partner: usize) -> bool {
        // The partner expects the same contact: its entry comes next to this one.
        let latest = self.calendar.latest(self.now + self.same_instant);
        let open = self.calendar.open();
        let is_other = |entry: u64| {
            let disc = self.calendar.disc(entry);
            (entry <= latest) & (disc != partner) & (disc != k)
        };
        // Without branches: whether the partner's entry is there cannot be foreseen.
        if let [.., c, b, a] = *open
            && !(is_other(a) | is_other(b) | is_other(c))
        {
            return false;
        }
        for &entry in open.iter().rev().take(3) {
            if entry > latest {
                return false;
            }
            let other = self.calendar.disc(entry);
            if other != partner && other != k {
                let latest = self.now + self.same_instant;
                return self.dues.get(other).is_some_and(|due| due.contact <= latest);
            }
        }
        false
    }

    /// Position of the second of two discs seen from the first, m.
    #[inline(always)]
    pub(super) fn offset(&self, i: usize, j: usize) -> DVec2 {
        self.offset_under(i, j, self.pull_between(i, j))
    }

    /// The same of two between which there is this acceleration, m/s^2.
    #[inline(always)]
    fn offset_under(&self, i: usize, j: usize, pull: Option<DVec2>) -> DVec2 {
        let (a, b) = (&self.flights[i], &self.flights[j]);
        let mut d = (b.start() - a.start()) + (b.velocity() - a.velocity()) * self.now;
        if let Some(pull) = pull {
            d += pull * (0.5 * self.now * self.now);
        }
        self.wrap.map_or(d, |wrap| wrap.nearest(d))
    }

    /// Two discs, the second as the first sees it.
    pub(super) fn pair(&self, i: usize, j: usize) -> (Disc, Disc) {
        let (a, b) = (self.disc(i), self.disc(j));
        (a, Disc { position: a.position + self.offset(i, j), ..b })
    }

    /// Whether two discs are as far from each other as their radii say, or nearer.
    pub(super) fn touch(&self, i: usize, j: usize) -> bool {
        let square = self.offset(i, j).length_squared();
        let reach = self.radii.get(i) + self.radii.get(j);
        square - reach * reach <= OUT_OF_TOUCH * square
    }

    #[inline(always)]
    pub(super) fn collide<U: Unit>(&mut self, i: usize, j: usize, witness: &mut impl Witness) {
        let pull = if U::BARE { None } else { self.pull_between(i, j) };
        let d = self.offset_under(i, j, pull);
        // Of two that fall alike without what both have gained.
        let velocities = if pull.is_some() {
            (self.velocity(i), self.velocity(j))
        } else {
            (self.flights[i].velocity(), self.flights[j].velocity())
        };
        let (restitution, exchange) = self.exchange::<U>(i, j, d, velocities);
        let reach = if U::BARE { self.reach } else { self.radii.get(i) + self.radii.get(j) };
        let excess = exchange.square - reach * reach;
        // Grazing to rounding, moved from outside, or without a normal.
        if exchange.along >= 0.0 || excess > OUT_OF_TOUCH * exchange.square {
            return U::renew(self, i, f64::NAN);
        }
        if exchange.square < 1e-6 * reach * reach {
            return self.collide_together::<U>(i, j, witness);
        }
        self.note_distance::<U>(i, j, excess);
        if !U::ALIKE && (self.lossy || self.guests) {
            self.book(i, j, &exchange, restitution);
        }
        witness.see(|| self.record(i, j, d, &exchange, restitution));
        U::deflect(&mut self.flights[i], self.now, exchange.by_a);
        U::deflect(&mut self.flights[j], self.now, exchange.by_b);
        if !U::BARE && self.fall.is_some() {
            self.settle(i);
            self.settle(j);
        }
        self.note_contacts::<U>(&[i, j], 1);
        let noted = self.dues[j].time();
        U::renew_two(self, i, j, noted);
    }

    /// The restitution of two discs that touch, and what the law makes of their velocities.
    #[inline(always)]
    fn exchange<U: Unit>(
        &self,
        i: usize,
        j: usize,
        d: DVec2,
        velocities: (DVec2, DVec2),
    ) -> (f64, Exchange) {
        if U::ALIKE {
            return (1.0, exchange(d, velocities, 1.0, &MassFractions::EQUAL, true));
        }
        let share = MassFractions::of(self.masses.get(i), self.masses.get(j));
        let restitution = self.restitution(self.laws.restitution, &[i, j]);
        (restitution, exchange(d, velocities, restitution, &share, !self.lossy))
    }

    /// The record of a contact.
    fn record(
        &self,
        i: usize,
        j: usize,
        d: DVec2,
        exchange: &Exchange,
        restitution: f64,
    ) -> Contact {
        let distance = exchange.square.sqrt();
        let approach_speed = -exchange.along / distance;
        let reduced_mass = self.reduced_mass(i, j);
        let (first, second, d) = if self.ids[i] < self.ids[j] { (i, j, d) } else { (j, i, -d) };
        let gap = distance - (self.radii.get(i) + self.radii.get(j));
        let normal = d / distance;
        let Disc { id, position, radius, .. } = self.disc(first);
        Contact {
            a: id,
            b: Partner::Disc(self.ids[second]),
            point: position + normal * (radius + 0.5 * gap),
            normal,
            gap,
            approach_speed,
            impulse: reduced_mass * (1.0 + restitution) * approach_speed,
            energy_loss: loss(reduced_mass, restitution, approach_speed * approach_speed),
            time: self.now(),
        }
    }

    #[inline]
    fn reduced_mass(&self, i: usize, j: usize) -> f64 {
        let (a, b) = (self.masses.get(i), self.masses.get(j));
        let share = MassFractions::of(a, b);
        if a.is_finite() { a * share.a.hi } else { b * share.b.hi }
    }

    #[inline(always)]
    fn note_distance<U: Unit>(&mut self, i: usize, j: usize, excess: f64) {
        if !U::BARE && self.guests && (self.is_guest(i) || self.is_guest(j)) {
            return;
        }
        let excess = match &self.radii {
            Each::Own(radii) if !U::BARE => {
                excess / ((radii[i] + radii[j]) * radii[i].min(radii[j]))
            }
            _ => excess,
        };
        self.excess.0 = if excess < self.excess.0 { excess } else { self.excess.0 };
        self.excess.1 = if excess > self.excess.1 { excess } else { self.excess.1 };
    }

    pub(super) fn is_guest(&self, k: usize) -> bool {
        self.owners[k] == Owner::Observed
    }

    /// Whether its energy counts, and changes only by known amounts.
    pub(super) fn closes_energy(&self, k: usize) -> bool {
        !self.is_guest(k) && self.masses.get(k).is_finite()
    }

    /// Books what a contact does to the energy of simulated discs, before velocities change.
    #[inline]
    fn book(&mut self, i: usize, j: usize, exchange: &Exchange, restitution: f64) {
        if self.fall.is_some() {
            self.book_fall(i);
            self.book_fall(j);
        }
        if !self.guests || (self.closes_energy(i) && self.closes_energy(j)) {
            let squared_speed = exchange.along * exchange.along / exchange.square;
            let loss = loss(self.reduced_mass(i, j), restitution, squared_speed);
            return self.energy.book(-loss);
        }
        for (k, by) in [(i, exchange.by_a), (j, exchange.by_b)] {
            if self.closes_energy(k) {
                let mean_velocity = self.velocity(k) + 0.5 * by;
                self.energy.book(self.masses.get(k) * by.dot(mean_velocity));
                self.momentum.book_change(self.masses.get(k), by);
            }
        }
    }

    /// A disc meets a wall or a segment, by its number.
    #[inline(never)]
    fn bounce_off<U: Unit>(&mut self, k: usize, met: usize, witness: &mut impl Witness) {
        if met >= SEGMENT as usize {
            return self.bounce_off_segment::<U>(k, met - SEGMENT as usize, witness);
        }
        let side = SIDES[met & 3];
        if self.fall.is_some() {
            return self.land::<U>(k, side, witness);
        }
        let Some(walls) = self.laws.walls else { return };
        let disc = self.disc(k);
        let restitution = self.restitution(walls.restitution, &[k]);
        if let Some(hit) = bounce(&disc, side, restitution) {
            self.flights[k].turn(self.now, hit.velocity);
            self.energy.book(-hit.energy_loss);
            self.momentum.book(side.normal() * -hit.impulse);
            self.note_contacts::<U>(&[k], 1);
            witness.see(|| wall_contact(&disc, side, &walls, &hit, self.now()));
        }
        U::renew(self, k, f64::NAN);
    }

    /// The restitution of a contact: elastic between discs that are all caught in a collapse.
    #[inline(always)]
    pub(super) fn restitution(&self, usual: f64, discs: &[usize]) -> f64 {
        let collapsing = |&k: &usize| {
            let Last { time, quick } = self.last[k];
            quick >= limits::QUICK_CONTACTS && self.is_quick(time)
        };
        if usual < 1.0 && !self.last.is_empty() && discs.iter().all(collapsing) {
            1.0
        } else {
            usual
        }
    }

    #[inline(always)]
    pub(super) fn note_contacts<U: Unit>(&mut self, discs: &[usize], count: usize) {
        self.contacts += count as u64;
        self.noted.turn(discs);
        if U::ALIKE || self.last.is_empty() {
            return;
        }
        for &k in discs {
            let quick = self.is_quick(self.last[k].time);
            let last = &mut self.last[k];
            last.quick = if quick { last.quick.saturating_add(1) } else { 0 };
            last.time = self.now;
        }
    }

    /// Whether a contact is within the contact time of one at `last`, s.
    #[inline(always)]
    fn is_quick(&self, last: f64) -> bool {
        self.now - last < self.laws.contact_time_after(self.base + last)
    }

    /// Asks for the memory that the next events of the day will touch: first what a disc is due
    /// for, then whom it meets and the cells around it, then those around whom it meets, then who
    /// is in all these.
    #[inline(always)]
    pub(super) fn fetch_ahead<U: Unit>(&mut self) {
        let open = self.calendar.open();
        let Some(last) = open.len().checked_sub(4 * STEP) else { return };
        let disc = |step: usize| self.calendar.disc(open[last + step * STEP]);
        let [first, second, third, fourth] = [0, 1, 2, 3].map(disc);
        // One of them went, or there are only few: nothing is far away then.
        if first.max(second).max(third).max(fourth) >= self.dues.len() {
            return;
        }
        prefetch(&self.dues, first);
        prefetch(&self.flights, first);
        let due = &self.dues[second];
        prefetch(&self.flights, self.partner_or(due, second));
        if let Some((place, _)) = self.next_place(second) {
            self.fetch_cells(place);
        } else {
            prefetch(&self.dues, self.partner_or(due, second));
            self.fetch_cells(due.place);
        }
        if self.next_place(third).is_none() {
            let partner = self.partner_or(&self.dues[third], third);
            self.fetch_cells(self.dues[partner].place);
        }
        if let Some((_, ahead)) = self.next_place(fourth) {
            return self.fetch_flights::<U>(&ahead);
        }
        for k in [fourth, self.partner_or(&self.dues[fourth], fourth)] {
            self.fetch_flights::<U>(&self.cells.around(self.dues[k].place));
        }
    }

    /// The cell to which a disc goes over before it meets anybody, and the cells that come near.
    #[inline(always)]
    fn next_place(&self, k: usize) -> Option<(Place, Block)> {
        let due = &self.dues[k];
        if due.contact <= due.exit {
            return None;
        }
        let (along_x, up) = self.way_out(k, due.place);
        let (place, _) = self.cells.neighbour(due.place, along_x, up)?;
        Some((place, self.cells.ahead(place, along_x, up)))
    }

    #[inline(always)]
    fn fetch_flights<U: Unit>(&mut self, block: &Block) {
        let near = &mut self.near[0];
        U::fetch_flights(self.cells.numbers(), &self.flights, block, near);
    }

    /// The disc that another is due to meet, or that other itself.
    #[inline(always)]
    fn partner_or(&self, due: &Due, k: usize) -> usize {
        let met = due.met();
        if met < self.flights.len() { met } else { k }
    }

    #[inline(always)]
    fn fetch_cells(&self, place: Place) {
        let block = self.cells.around(place);
        for row in 0..3 {
            let start = block.start + row * block.stride;
            prefetch(self.cells.numbers(), start);
            prefetch(self.cells.numbers(), start + block.width - 1);
        }
    }
}

/// Kinetic energy that a contact loses, J.
fn loss(reduced_mass: f64, restitution: f64, squared_speed: f64) -> f64 {
    0.5 * reduced_mass * (1.0 - restitution) * (1.0 + restitution) * squared_speed
}
