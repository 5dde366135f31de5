//! What happens at an event: a contact is resolved, or found out of date.

use glam::DVec2;

use super::lanes::{Unit, prefetch};
use super::predict::SIDES;
use super::{Due, Events, TIE, WALL};
use crate::resolve::pair::{MassFractions, exchange};
use crate::resolve::wall::bounce;
use crate::world::{Contact, Partner, Side};

impl Events {
    /// The contact that a disc is due for.
    #[inline(always)]
    pub(super) fn meet<U: Unit>(&mut self, k: usize, due: Due, contacts: &mut Vec<Contact>) {
        let partner = due.partner & !TIE;
        if partner >= WALL {
            self.bounce_off::<U>(k, SIDES[(partner & 3) as usize], contacts);
        } else if self.flights[partner as usize].stamp() == due.stamp {
            self.collide::<U>(k, partner as usize, contacts);
        } else {
            self.predict::<U>(k);
            self.calendar.insert(self.dues[k].time(), k);
        }
    }

    #[inline(always)]
    fn collide<U: Unit>(&mut self, i: usize, j: usize, contacts: &mut Vec<Contact>) {
        let (a, b) = (self.flights[i], self.flights[j]);
        let w = DVec2::new(b.vx - a.vx, b.vy - a.vy);
        let mut d = (b.start() - a.start()) + w * self.now;
        if let Some(periodic) = self.laws.periodic {
            d += periodic.shift(d);
        }
        let d2 = d.length_squared();
        let reach = self.radii.get(i) + self.radii.get(j);
        let c = d2 - reach * reach;
        self.overlap = self.overlap.max(c.abs());
        let fractions = MassFractions::of(self.masses.get(i), self.masses.get(j));
        let (by_a, by_b) = exchange(d, a.velocity(), b.velocity(), self.laws.restitution, &fractions);
        self.flights[i].deflect(self.now, by_a);
        self.flights[j].deflect(self.now, by_b);
        self.contacts += 1;
        let _ = contacts;
        for k in [i, j] {
            let before = self.dues[k].time();
            self.dues[k].exit = self.exit(k, self.dues[k].place);
            self.predict::<U>(k);
            let after = self.dues[k].time();
            if k == i || after != before {
                self.calendar.insert(after, k);
            }
        }
    }

    #[inline(never)]
    fn bounce_off<U: Unit>(&mut self, k: usize, side: Side, contacts: &mut Vec<Contact>) {
        let Some(walls) = self.laws.walls else { return };
        let disc = self.disc(k);
        if let Some(hit) = bounce(&disc, side, walls.restitution) {
            self.flights[k].deflect(self.now, hit.velocity - disc.velocity);
            self.contacts += 1;
            contacts.push(Contact {
                a: disc.id,
                b: Partner::Wall(side),
                point: disc.position + side.normal() * disc.radius,
                normal: side.normal(),
                gap: walls.gap(side, &disc),
                approach_speed: hit.approach_speed,
                impulse: hit.impulse,
                energy_loss: hit.energy_loss,
                time: self.base + self.now,
            });
        }
        self.dues[k].exit = self.exit(k, self.dues[k].place);
        self.predict::<U>(k);
        self.calendar.insert(self.dues[k].time(), k);
    }

    /// Asks for the memory that the next events of the day will touch.
    #[inline(always)]
    pub(super) fn fetch_ahead(&self) {
        let open = self.calendar.open();
        let ahead = |by: usize| open.len().checked_sub(by).map(|at| self.calendar.disc(open[at]));
        if let Some(k) = ahead(12) {
            prefetch(&self.dues, k);
            prefetch(&self.flights, k);
        }
        if let Some(k) = ahead(8) {
            let due = &self.dues[k];
            let start = self.cells.start(due.place);
            for row in [start - self.cells.row_stride(), start, start + self.cells.row_stride()] {
                prefetch(self.cells.numbers(), row - self.cells.size());
                prefetch(self.cells.numbers(), row + 2 * self.cells.size() - 1);
            }
            let partner = (due.partner & !TIE) as usize;
            prefetch(&self.dues, partner);
            prefetch(&self.flights, partner);
        }
        if let Some(k) = ahead(5) {
            let due = &self.dues[k];
            let partner = (due.partner & !TIE) as usize;
            let start = self.cells.start(due.place);
            for row in [start - self.cells.row_stride(), start, start + self.cells.row_stride()] {
                let from = row - self.cells.size();
                for &near in &self.cells.numbers()[from..from + 3 * self.cells.size()] {
                    prefetch(&self.flights, near as usize);
                }
            }
            if partner < self.dues.len() {
                let _ = partner;
            }
        }
    }
}
