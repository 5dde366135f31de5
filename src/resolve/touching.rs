//! Many contacts at the same instant: one pair after the other, until no touching pair approaches.
//!
//! The order is that of the ids, so the result does not depend on the order of the input. Momentum
//! is kept by every single step, energy too at restitution 1, and a struck row of equal discs
//! passes the blow on to its end. Below restitution 1 a cluster needs endlessly many blows to come
//! to rest: sweeps are bounded, what approach is left is a vanishing part of the first.

use std::ops::ControlFlow;

use super::pair::{Impact, collide};
use crate::detect::Pair;
use crate::detect::touching::gap;
use crate::world::{Contact, Disc, Partner, limits};

/// What became of touching pairs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Resolved {
    /// One for each pair that approached, by ids.
    pub contacts: Vec<Contact>,
    /// Indices of the discs in these contacts, by ids, each once.
    pub touched: Vec<usize>,
}

/// Resolves touching `pairs` of `discs` in place.
///
/// A pair hit more than once in the cluster reports its first approach speed and the sums of its
/// impulses and losses. `time` (s) is copied into the contacts. Pairs that do not approach are
/// left alone and not reported.
pub fn resolve(discs: &mut [Disc], pairs: &[Pair], restitution: f64, time: f64) -> Resolved {
    let mut cluster = Cluster::new(discs, pairs, restitution, time);
    let most_sweeps =
        (limits::CONTACT_CHECKS / pairs.len().max(1)).clamp(1, limits::CONTACT_SWEEPS);
    for _ in 0..most_sweeps {
        if cluster.sweep().is_break() {
            break;
        }
    }
    cluster.finish()
}

/// The state of the sweeps. Counters tell which pairs can have changed since they were looked at.
struct Cluster<'a> {
    discs: &'a mut [Disc],
    /// By ids; in each pair the smaller id first.
    pairs: Vec<Pair>,
    contacts: Vec<Contact>,
    /// Where in `contacts` a pair is, if it had one.
    contact_of: Vec<Option<u32>>,
    checked: Vec<usize>,
    changed: Vec<usize>,
    now: usize,
    restitution: f64,
    time: f64,
}

impl<'a> Cluster<'a> {
    fn new(discs: &'a mut [Disc], pairs: &[Pair], restitution: f64, time: f64) -> Self {
        let id = |k: usize| discs[k].id;
        let by_id = |&(i, j): &Pair| if id(i) < id(j) { (i, j) } else { (j, i) };
        let mut pairs: Vec<Pair> = pairs.iter().map(by_id).collect();
        pairs.sort_unstable_by_key(|&(i, j)| (id(i), id(j)));
        let changed = vec![1; discs.len()];
        let (contact_of, checked) = (vec![None; pairs.len()], vec![0; pairs.len()]);
        let contacts = Vec::with_capacity(pairs.len());
        Self { discs, pairs, contacts, contact_of, checked, changed, now: 1, restitution, time }
    }

    /// Looks once at every pair that may approach; breaks when none does.
    fn sweep(&mut self) -> ControlFlow<()> {
        let mut calm = true;
        for k in 0..self.pairs.len() {
            let (i, j) = self.pairs[k];
            if self.changed[i].max(self.changed[j]) <= self.checked[k] {
                continue;
            }
            if let Some(impact) = collide(&self.discs[i], &self.discs[j], self.restitution) {
                self.apply(k, &impact);
                calm = false;
            }
            self.checked[k] = self.now;
        }
        if calm { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn finish(mut self) -> Resolved {
        let in_contact = self.pairs.iter().zip(&self.contact_of).filter(|(_, c)| c.is_some());
        let mut touched: Vec<usize> = in_contact.flat_map(|(&(i, j), _)| [i, j]).collect();
        touched.sort_unstable_by_key(|&k| self.discs[k].id);
        touched.dedup();
        self.contacts.sort_unstable_by_key(|contact| (contact.a, contact.b));
        Resolved { contacts: self.contacts, touched }
    }

    fn apply(&mut self, k: usize, impact: &Impact) {
        let (i, j) = self.pairs[k];
        self.now += 1;
        (self.changed[i], self.changed[j]) = (self.now, self.now);
        self.discs[i].velocity = impact.velocity_a;
        self.discs[j].velocity = impact.velocity_b;
        if let Some(known) = self.contact_of[k] {
            let contact = &mut self.contacts[known as usize];
            contact.impulse += impact.impulse;
            contact.energy_loss += impact.energy_loss;
            return;
        }
        self.contact_of[k] = Some(self.contacts.len() as u32);
        self.contacts.push(pair_contact(&self.discs[i], &self.discs[j], impact, self.time));
    }
}

/// The record of a pair's contact.
pub fn pair_contact(a: &Disc, b: &Disc, impact: &Impact, time: f64) -> Contact {
    let gap = gap(a, b);
    Contact {
        a: a.id,
        b: Partner::Disc(b.id),
        point: a.position + impact.normal * (a.radius + 0.5 * gap),
        normal: impact.normal,
        gap,
        approach_speed: impact.approach_speed,
        impulse: impact.impulse,
        energy_loss: impact.energy_loss,
        time,
    }
}
