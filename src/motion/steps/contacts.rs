//! What happens at a step end: who touches, what that does, and what it does to the account.

use glam::DVec2;

use super::{Fastest, Steps, may_collide};
use crate::detect::Pair;
use crate::detect::TooManyPairs;
use crate::detect::impact::{may_meet_within, pair_impact_at_any_scale};
use crate::detect::touching::{gap, overlap, touch};
use crate::exact::RunningSum;
use crate::motion::Witness;
use crate::resolve::overlap::{part_from_walls, part_pairs};
use crate::resolve::pair::{Impact, approach, collide};
use crate::resolve::touching::{self, pair_contact};
use crate::resolve::wall::{bounce, wall_contact};
use crate::world::{Contact, Disc, Owner, Side};

/// A pair that parts with so much of its speeds needs no second look.
const SURE: f64 = 1e-12;

/// Steps after which the fastest discs are looked for anew: some may have slowed down.
const RENEW_FASTEST: u64 = 16;

impl Steps {
    /// Lists the pairs that touch, and counts those that met and will not be resolved.
    #[inline(always)]
    pub(super) fn find_touching(&mut self) -> Result<(), TooManyPairs> {
        let closer = self.fastest.closer(self.stepping.step);
        let margin = if self.stepping.count_missed { closer } else { 0.0 };
        let (owners, masses) = (&self.owners, &self.masses);
        let counts =
            |i: usize, j: usize| may_collide([owners[i], owners[j]], [masses[i], masses[j]]);
        let counts = self.some_pass.then_some(counts);
        let mut found = std::mem::take(&mut self.scratch.near);
        let way = closer + self.pushed;
        self.near.within(&self.places, &self.radii, (margin, way), counts, &mut found)?;
        self.pushed = 0.0;
        self.scratch.touching.clear();
        for (i, j) in found.iter() {
            self.look_at(i, j);
        }
        self.scratch.near = found;
        Ok(())
    }

    /// Two discs, the smaller id first, as the nearest image of one sees the other.
    #[inline(always)]
    fn pair(&self, (i, j): Pair) -> (Disc, Disc) {
        let (mut a, mut b) = (self.disc(i), self.disc(j));
        if let Some(periodic) = &self.laws.periodic {
            (a.position, b.position) = (periodic.inside(a.position), periodic.inside(b.position));
            b.position += periodic.shift(b.position - a.position);
        }
        (a, b)
    }

    #[inline(always)]
    fn look_at(&mut self, i: usize, j: usize) {
        let pair = if self.ids[i] < self.ids[j] { (i, j) } else { (j, i) };
        let (a, b) = self.pair(pair);
        if self.stepping.count_missed
            && !self.laws.extreme_units
            && surely_unmet(&a, &b, self.stepping.step)
        {
            return;
        }
        let touches = touch(&a, &b, 0.0);
        if self.stepping.count_missed && self.met_on_the_way(pair) {
            if !touches {
                self.unseen.missed += 1;
            } else if approach(&a, &b).is_none() {
                self.unseen.too_late += 1;
            }
        }
        if touches {
            self.note_overlap((i, j), &a, &b);
            self.scratch.touching.push(pair);
            self.scratch.shared[i] += 1;
            self.scratch.shared[j] += 1;
        }
    }

    /// Whether the straight paths of two discs came together within the step that ends now.
    #[inline(always)]
    fn met_on_the_way(&self, (i, j): Pair) -> bool {
        let flight = self.flight(self.count as f64);
        let (mut d, w) = (flight.at(j) - flight.at(i), self.velocities[j] - self.velocities[i]);
        if let Some(periodic) = &self.laws.periodic {
            d += periodic.shift(d);
        }
        let (s, step) = (self.radii[i] + self.radii[j], self.stepping.step);
        if !self.laws.extreme_units && !may_meet_within(d, w, s, step) {
            return false;
        }
        pair_impact_at_any_scale(d, w, s).is_some_and(|time| time > 0.0 && time < step)
    }

    #[inline(always)]
    fn note_overlap(&mut self, (i, j): Pair, a: &Disc, b: &Disc) {
        let radius = a.radius.min(b.radius);
        let record = a.radius + b.radius - (self.largest_overlap * radius).min(self.deepest);
        let square = (b.position - a.position).length_squared();
        let simulated = self.owners[i] == Owner::Simulated && self.owners[j] == Owner::Simulated;
        let is_less = square > record * record * (1.0 + 1e-9) && square > 1e-280;
        if simulated && !is_less {
            let overlap = -gap(a, b);
            self.largest_overlap = self.largest_overlap.max(overlap / radius);
            self.deepest = self.deepest.max(overlap);
        }
    }

    /// Resolves what touches: pairs that share no disc one by one, the others together.
    #[inline(always)]
    pub(super) fn collide<W: Witness>(&mut self, witness: &mut W) {
        let touching = std::mem::take(&mut self.scratch.touching);
        self.scratch.together.clear();
        for &(i, j) in &touching {
            let alone = self.scratch.shared[i] == 1 && self.scratch.shared[j] == 1;
            if !(alone && self.collide_pair::<W>((i, j))) {
                self.scratch.together.push((i, j));
            }
        }
        for &(i, j) in &touching {
            (self.scratch.shared[i], self.scratch.shared[j]) = (0, 0);
        }
        self.scratch.touching = touching;
        if !self.scratch.together.is_empty() {
            self.collide_together::<W>();
        }
        if W::LOOKS {
            self.scratch.contacts.sort_unstable_by_key(|contact| (contact.a, contact.b));
            self.scratch.contacts.drain(..).for_each(|contact| witness.see(|| contact));
        }
    }

    /// Collides a pair whose discs touch no other; `false` if one blow may not settle it.
    #[inline(always)]
    fn collide_pair<W: Witness>(&mut self, (i, j): Pair) -> bool {
        let (a, b) = self.pair((i, j));
        let restitution = self.laws.restitution;
        let Some(impact) = collide(&a, &b, restitution) else { return true };
        let speeds = a.velocity.abs().max_element() + b.velocity.abs().max_element();
        let parts_at = restitution * impact.approach_speed;
        if !(parts_at > SURE * speeds && parts_at > 1e-250) {
            return false;
        }
        self.contacts += 1;
        self.unseen.late += u64::from(overlap(&a, &b));
        self.book_pair((i, &a), (j, &b), &impact);
        if W::LOOKS {
            self.scratch.contacts.push(pair_contact(&a, &b, &impact, self.time()));
        }
        self.change(i, impact.velocity_a);
        self.change(j, impact.velocity_b);
        true
    }

    /// Resolves touching pairs that share discs.
    #[inline(never)]
    fn collide_together<W: Witness>(&mut self) {
        let pairs = std::mem::take(&mut self.scratch.together);
        let mut members: Vec<usize> = pairs.iter().flat_map(|&(i, j)| [i, j]).collect();
        members.sort_unstable();
        members.dedup();
        let before: Vec<Disc> = members.iter().map(|&k| self.disc_inside(k)).collect();
        // Every disc of a pair is in the sorted list.
        let member = |k: usize| members.partition_point(|&other| other < k);
        let local: Vec<Pair> = pairs.iter().map(|&(i, j)| (member(i), member(j))).collect();
        let mut after = before.clone();
        let (restitution, periodic) = (self.laws.restitution, self.laws.periodic);
        let resolved =
            touching::resolve_in(&mut after, &local, restitution, self.time(), periodic.as_ref());
        self.book_together(&members, &before, &after, &resolved.contacts);
        self.contacts += resolved.contacts.len() as u64;
        let late = resolved.contacts.iter().filter(|contact| contact.gap < 0.0);
        self.unseen.late += late.count() as u64;
        for (&k, disc) in members.iter().zip(&after) {
            self.change(k, disc.velocity);
        }
        if W::LOOKS {
            self.scratch.contacts.extend(resolved.contacts);
        }
        self.scratch.together = pairs;
    }

    fn disc_inside(&self, k: usize) -> Disc {
        let disc = self.disc(k);
        let inside = |periodic: crate::world::Periodic| periodic.inside(disc.position);
        Disc { position: self.laws.periodic.map_or(disc.position, inside), ..disc }
    }

    #[inline(always)]
    fn change(&mut self, k: usize, velocity: DVec2) {
        if velocity != self.velocities[k] {
            self.scratch.changed.push((k as u32, self.velocities[k]));
            self.velocities[k] = velocity;
            self.fastest.note(velocity);
        }
    }

    /// Turns round at the walls who reached them.
    #[inline(always)]
    pub(super) fn bounce<W: Witness>(&mut self, witness: &mut W) {
        let Some(walls) = self.laws.walls else { return };
        let outside = std::mem::take(&mut self.scratch.outside);
        for &k in &outside {
            let k = k as usize;
            if self.owners[k] == Owner::Observed {
                continue;
            }
            let mut disc = self.disc(k);
            for side in [Side::Left, Side::Right, Side::Bottom, Side::Top] {
                let gap = walls.gap(side, &disc);
                let hit = bounce(&disc, side, walls.restitution).filter(|_| gap <= 0.0);
                let Some(hit) = hit else { continue };
                self.contacts += 1;
                self.unseen.late += u64::from(gap < 0.0);
                self.energy.book(-hit.energy_loss);
                self.momentum.book(side.normal() * -hit.impulse);
                witness.see(|| wall_contact(&disc, side, &walls, &hit, self.time()));
                self.change(k, hit.velocity);
                disc.velocity = hit.velocity;
            }
        }
        self.scratch.outside = outside;
    }

    /// Begins a new flight for every disc that left its old one.
    #[inline(always)]
    pub(super) fn begin_flights(&mut self) {
        let now = self.count as f64;
        let mut changed = std::mem::take(&mut self.scratch.changed);
        for &(k, before) in &changed {
            let k = k as usize;
            // The first of several changes tells what was before.
            let first = std::mem::replace(&mut self.scratch.shared[k], 1) == 0;
            if first && self.velocities[k] != before && self.began[k] != now {
                let place = self.places[k];
                self.starts[k] =
                    self.laws.periodic.map_or(place, |periodic| periodic.inside(place));
                self.began[k] = now;
            }
        }
        changed.drain(..).for_each(|(k, _)| self.scratch.shared[k as usize] = 0);
        self.scratch.changed = changed;
        if self.count.is_multiple_of(RENEW_FASTEST) {
            self.fastest = Fastest::of(&self.velocities);
        }
    }

    /// Parts overlapping discs by moving them.
    pub(super) fn part(&mut self) {
        if self.stepping.overlap_sweeps == 0 {
            return;
        }
        let mut pairs = self.scratch.touching.clone();
        pairs.iter_mut().for_each(|pair| *pair = (pair.0.min(pair.1), pair.0.max(pair.1)));
        pairs.sort_unstable();
        let mut discs: Vec<Disc> = (0..self.ids.len()).map(|k| self.disc(k)).collect();
        let owners = &self.owners;
        for _ in 0..self.stepping.overlap_sweeps {
            part_pairs(&mut discs, &pairs, self.laws.periodic.as_ref());
            if let Some(walls) = &self.laws.walls {
                let simulated = discs.iter_mut().zip(owners);
                let simulated = simulated.filter(|(_, owner)| **owner == Owner::Simulated);
                simulated.for_each(|(disc, _)| part_from_walls(disc, walls));
            }
        }
        for (k, disc) in discs.iter().enumerate() {
            if disc.position != self.places[k] {
                self.pushed = self.pushed.max(2.0 * disc.position.distance(self.places[k]));
                (self.starts[k], self.began[k]) = (disc.position, self.count as f64);
            }
        }
    }

    fn is_closed(&self, k: usize) -> bool {
        self.owners[k] == Owner::Simulated && self.masses[k].is_finite()
    }

    /// Books what a contact does to the energy of simulated discs.
    #[inline(always)]
    fn book_pair(&mut self, a: (usize, &Disc), b: (usize, &Disc), impact: &Impact) {
        if self.is_closed(a.0) && self.is_closed(b.0) {
            if impact.energy_loss != 0.0 {
                self.energy.book(-impact.energy_loss);
            }
            return;
        }
        for (side, after, sign) in [(a, impact.velocity_a, -1.0), (b, impact.velocity_b, 1.0)] {
            if self.is_closed(side.0) {
                let mean_velocity = 0.5 * (side.1.velocity + after);
                self.energy.book(sign * impact.impulse * impact.normal.dot(mean_velocity));
                self.momentum.book(impact.normal * (sign * impact.impulse));
            }
        }
    }

    /// The same for contacts together. With discs that bring in energy from outside, what they
    /// brought is what is there: no error is told from work then.
    fn book_together(
        &mut self,
        members: &[usize],
        before: &[Disc],
        after: &[Disc],
        contacts: &[Contact],
    ) {
        let is_closed = |k: &usize| self.is_closed(*k);
        let mut changes = Vec::new();
        let work: RunningSum = if members.iter().all(is_closed) {
            contacts.iter().map(|contact| -contact.energy_loss).collect()
        } else {
            let all = members.iter().zip(before.iter().zip(after));
            let closed = all.filter(|(k, _)| is_closed(k));
            let gain = |(_, (before, after)): (_, (&Disc, &Disc))| {
                changes.push((after.mass, after.velocity - before.velocity));
                after.kinetic_energy() - before.kinetic_energy()
            };
            closed.map(gain).collect()
        };
        self.energy.book(work.value());
        changes.into_iter().for_each(|(mass, by)| self.momentum.book_change(mass, by));
    }
}

/// Whether two discs at a step end clearly neither touch nor have passed each other within the
/// step: they approach, or are farther apart than their way.
#[inline(always)]
fn surely_unmet(a: &Disc, b: &Disc, step: f64) -> bool {
    let (d, w) = (b.position - a.position, b.velocity - a.velocity);
    let reach = a.radius + b.radius;
    let (square, reach2, way2) =
        (d.length_squared(), reach * reach, w.length_squared() * step * step);
    let (x, y) = (d.x * w.x, d.y * w.y);
    let beyond = square - reach2 * (1.0 + 1e-9);
    // d > s + way, without a root.
    let farther = beyond - way2;
    let out_of_way = farther > 0.0 && farther * farther > 4.0 * reach2 * way2 * (1.0 + 1e-9);
    beyond > 0.0 && (x + y < -1e-9 * (x.abs() + y.abs()) || out_of_way)
}
