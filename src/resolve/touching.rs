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

/// Resolves touching `pairs` of `discs` in place; what happened is one [`Contact`] a pair, by ids.
///
/// A pair hit more than once in the cluster reports its first approach speed and the sums of its
/// impulses and losses. `time` (s) is copied into the contacts. Pairs that do not approach are
/// left alone and not reported.
pub fn resolve(discs: &mut [Disc], pairs: &[Pair], restitution: f64, time: f64) -> Vec<Contact> {
    let mut cluster = Cluster::new(discs, pairs, restitution, time);
    let most_sweeps =
        (limits::CONTACT_CHECKS / pairs.len().max(1)).clamp(1, limits::CONTACT_SWEEPS);
    for _ in 0..most_sweeps {
        if cluster.sweep().is_break() {
            break;
        }
    }
    cluster.contacts.into_iter().flatten().collect()
}

/// The state of the sweeps. Counters tell which pairs can have changed since they were looked at.
struct Cluster<'a> {
    discs: &'a mut [Disc],
    /// By ids; in each pair the smaller id first.
    pairs: Vec<Pair>,
    contacts: Vec<Option<Contact>>,
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
        let (contacts, checked) = (vec![None; pairs.len()], vec![0; pairs.len()]);
        Self { discs, pairs, contacts, checked, changed, now: 1, restitution, time }
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

    fn apply(&mut self, k: usize, impact: &Impact) {
        let (i, j) = self.pairs[k];
        self.now += 1;
        (self.changed[i], self.changed[j]) = (self.now, self.now);
        self.discs[i].velocity = impact.velocity_a;
        self.discs[j].velocity = impact.velocity_b;
        match &mut self.contacts[k] {
            Some(contact) => {
                contact.impulse += impact.impulse;
                contact.energy_loss += impact.energy_loss;
            }
            first => *first = Some(pair_contact(&self.discs[i], &self.discs[j], impact, self.time)),
        }
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
