//! Contacts at one instant that share discs: found from one of them on, and resolved together.

use super::Events;
use super::lanes::Unit;
use crate::detect::Pair;
use crate::exact::RunningSum;
use crate::motion::Witness;
use crate::resolve::touching;
use crate::world::{Contact, Disc};

/// Contacts at one instant, and the discs in them as the first one sees them.
struct Group {
    members: Vec<usize>,
    discs: Vec<Disc>,
    /// By places in `members`.
    pairs: Vec<Pair>,
}

impl Events {
    #[cold]
    pub(super) fn collide_together<U: Unit>(
        &mut self,
        i: usize,
        j: usize,
        witness: &mut impl Witness,
    ) {
        // Moved from outside, and flies again as it did before.
        if !self.touch(i, j) {
            return U::renew(self, i, f64::NAN);
        }
        let group = self.group::<U>(i, j);
        let noted: Vec<f64> = group.members.iter().map(|&k| self.dues[k].time()).collect();
        let touched = if group.pairs.len() == 1 || self.laws.periodic.is_none() {
            self.reflect::<U>(&group, &group.pairs, witness)
        } else {
            // A group may close around the box, where no image shows it whole: pair by pair.
            self.reflect::<U>(&group, &group.pairs[..1], witness)
        };
        for (&k, &noted) in group.members.iter().zip(&noted) {
            let noted = if k == i { f64::NAN } else { noted };
            if touched.contains(&k) || k == i {
                U::renew(self, k, noted);
            }
        }
    }

    /// The contacts at this instant that hang together with that of two discs.
    fn group<U: Unit>(&mut self, i: usize, j: usize) -> Group {
        let (first, second) = self.pair(i, j);
        let mut group =
            Group { members: vec![i, j], discs: vec![first, second], pairs: vec![(0, 1)] };
        let latest = self.now + self.same_instant;
        let mut seen = 0;
        while let Some(&k) = group.members.get(seen) {
            for l in self.discs_near::<U>(k) {
                if self.meeting_of(k, l).is_some_and(|time| time <= latest) {
                    let at = group.members.iter().position(|&member| member == l);
                    let place = at.unwrap_or(group.members.len());
                    if at.is_none() {
                        let (a, b) = self.pair(k, l);
                        let position = group.discs[seen].position + (b.position - a.position);
                        group.members.push(l);
                        group.discs.push(Disc { position, ..b });
                    }
                    let pair = (seen.min(place), seen.max(place));
                    if !group.pairs.contains(&pair) {
                        group.pairs.push(pair);
                    }
                }
            }
            seen += 1;
        }
        group
    }

    /// Resolves contacts of a group; returns the discs that fly otherwise now.
    fn reflect<U: Unit>(
        &mut self,
        group: &Group,
        pairs: &[Pair],
        witness: &mut impl Witness,
    ) -> Vec<usize> {
        let mut discs = group.discs.clone();
        let members: Vec<usize> = pairs.iter().flat_map(|&(a, b)| [a, b]).collect();
        let members: Vec<usize> = members.iter().map(|&place| group.members[place]).collect();
        let restitution = self.restitution(self.laws.restitution, &members);
        let resolved = touching::resolve(&mut discs, pairs, restitution, self.now());
        self.book_together(group, &discs, &resolved.contacts);
        let touched: Vec<usize> = resolved.touched.iter().map(|&at| group.members[at]).collect();
        for &at in &resolved.touched {
            self.turn(group.members[at], discs[at].velocity);
        }
        self.note_contacts::<U>(&touched, resolved.contacts.len());
        resolved.contacts.into_iter().for_each(|contact| witness.see(|| contact));
        touched
    }

    /// Books what contacts together do to the energy. With discs that bring in energy from outside,
    /// what they brought is what is there: no error is told from work then.
    fn book_together(&mut self, group: &Group, after: &[Disc], contacts: &[Contact]) {
        if self.fall.is_some() {
            group.members.iter().for_each(|&k| self.book_fall(k));
        }
        let closed = |k: usize| !self.guests || self.closes_energy(k);
        let mut changes = Vec::new();
        let work: RunningSum = if group.members.iter().all(|&k| closed(k)) {
            contacts.iter().map(|contact| -contact.energy_loss).collect()
        } else {
            let each = group.members.iter().zip(group.discs.iter().zip(after));
            let closed = each.filter(|&(&k, _)| closed(k));
            let gain = |(_, (was, is)): (_, (&Disc, &Disc))| {
                changes.push((was.mass, is.velocity - was.velocity));
                is.kinetic_energy() - was.kinetic_energy()
            };
            closed.map(gain).collect()
        };
        self.energy.book(work.value());
        changes.into_iter().for_each(|(mass, by)| self.momentum.book_change(mass, by));
    }
}
