//! Many contacts at the same instant, until no touching pair approaches.
//!
//! In rounds: of the pairs that approach, one that shares no disc with another is a collision like
//! any other; those that share discs are reflected together, so that neither the order of the input
//! nor that of the ids matters and symmetry stays. A struck row of equal discs passes the blow on
//! to its end, a contact a round. Very large groups go pair by pair, by ids.
//!
//! Momentum is kept by every step, energy too at restitution 1. Below it a cluster needs endlessly
//! many rounds to come to rest: they are bounded, and what approach is left is a vanishing part of
//! the first.

use glam::DVec2;

use super::pair::{Impact, approach, collide, rounding_speed};
use super::simultaneous::{Blow, Reflector, Touching};
use crate::detect::Pair;
use crate::detect::touching::gap;
use crate::world::{Contact, Disc, Partner, Periodic, limits};

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
    resolve_in(discs, pairs, restitution, time, None)
}

/// The same in a periodic box: of each pair the second is seen as its image nearest to the first.
pub fn resolve_in(
    discs: &mut [Disc],
    pairs: &[Pair],
    restitution: f64,
    time: f64,
    periodic: Option<&Periodic>,
) -> Resolved {
    let mut cluster = Cluster::new(discs, pairs, restitution, time);
    cluster.periodic = periodic;
    let most = (limits::CONTACT_CHECKS / pairs.len().max(1)).clamp(1, limits::CONTACT_ROUNDS);
    for _ in 0..most {
        let approaching = cluster.approaching();
        if approaching.is_empty() {
            break;
        }
        let rooted = cluster.by_group(approaching);
        for group in rooted.chunk_by(|a, b| a.root == b.root) {
            cluster.resolve_group(group);
        }
    }
    cluster.finish()
}

/// The state of the rounds. Counters tell which pairs can have changed since they were looked at.
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
    reflector: Reflector,
    restitution: f64,
    time: f64,
    periodic: Option<&'a Periodic>,
}

/// A pair that approaches.
#[derive(Clone, Copy, Debug)]
struct Approaching {
    /// Names its group.
    root: usize,
    /// Index into the pairs.
    pair: usize,
    /// Unit normal from the first disc to the second.
    normal: DVec2,
}

impl<'a> Cluster<'a> {
    fn new(discs: &'a mut [Disc], pairs: &[Pair], restitution: f64, time: f64) -> Self {
        let id = |k: usize| discs[k].id;
        let by_id = |&(i, j): &Pair| if id(i) < id(j) { (i, j) } else { (j, i) };
        let mut pairs: Vec<Pair> = pairs.iter().map(by_id).collect();
        pairs.sort_unstable_by_key(|&(i, j)| (id(i), id(j)));
        let changed = vec![1; discs.len()];
        let (contact_of, checked) = (vec![None; pairs.len()], vec![0; pairs.len()]);
        Self {
            discs,
            contacts: Vec::with_capacity(pairs.len()),
            pairs,
            contact_of,
            checked,
            changed,
            now: 1,
            reflector: Reflector::default(),
            restitution,
            time,
            periodic: None,
        }
    }

    /// The discs of a pair, the second at its image nearest to the first.
    fn seen(&self, (i, j): Pair) -> (Disc, Disc) {
        let (a, mut b) = (self.discs[i], self.discs[j]);
        if let Some(periodic) = self.periodic {
            b.position += periodic.shift(b.position - a.position);
        }
        (a, b)
    }

    /// The pairs that approach and can change, by ids.
    fn approaching(&mut self) -> Vec<Approaching> {
        let mut approaching = Vec::new();
        for (pair, &(i, j)) in self.pairs.iter().enumerate() {
            if self.changed[i].max(self.changed[j]) <= self.checked[pair] {
                continue;
            }
            self.checked[pair] = self.now;
            let (a, b) = self.seen((i, j));
            let Some((normal, speed)) = approach(&a, &b) else { continue };
            // After a first blow, what is left may be the rounding of the velocities.
            let settled = self.contact_of[pair].is_some() && speed <= rounding_speed(&a, &b);
            if !settled && (a.mass.is_finite() || b.mass.is_finite()) {
                approaching.push(Approaching { root: 0, pair, normal });
            }
        }
        approaching
    }

    /// Sorts pairs into groups that share no disc which they could move; each in order of ids.
    fn by_group(&self, mut approaching: Vec<Approaching>) -> Vec<Approaching> {
        let mut roots = Roots((0..self.discs.len()).collect());
        let finite = |disc: usize| self.discs[disc].mass.is_finite();
        for &Approaching { pair, .. } in &approaching {
            let (i, j) = self.pairs[pair];
            if finite(i) && finite(j) {
                roots.join(i, j);
            }
        }
        for member in &mut approaching {
            let (i, j) = self.pairs[member.pair];
            member.root = roots.find(if finite(i) { i } else { j });
        }
        approaching.sort_by_key(|member| member.root);
        approaching
    }

    fn resolve_group(&mut self, group: &[Approaching]) {
        if (2..=limits::GROUP_CONTACTS).contains(&group.len()) {
            return self.reflect_group(group);
        }
        for &Approaching { pair, .. } in group {
            let (i, j) = self.pairs[pair];
            let (a, b) = self.seen((i, j));
            if let Some(impact) = collide(&a, &b, self.restitution) {
                self.discs[i].velocity = impact.velocity_a;
                self.discs[j].velocity = impact.velocity_b;
                let contact = pair_contact(&a, &b, &impact, self.time);
                self.note(pair, &contact);
            }
        }
    }

    /// Reflects a group of contacts together.
    fn reflect_group(&mut self, group: &[Approaching]) {
        let touching = |member: &Approaching| {
            let (i, j) = self.pairs[member.pair];
            Touching { i, j, normal: member.normal }
        };
        let contacts: Vec<Touching> = group.iter().map(touching).collect();
        let mut reflector = std::mem::take(&mut self.reflector);
        let blows: Vec<Blow> = reflector.reflect(self.discs, &contacts, self.restitution).collect();
        self.reflector = reflector;
        for (member, blow) in group.iter().zip(&blows) {
            let (a, b) = self.seen(self.pairs[member.pair]);
            self.note(member.pair, &contact(&a, &b, member.normal, blow, self.time));
        }
    }

    /// Takes note of a contact; a pair hit again adds to its first.
    fn note(&mut self, k: usize, contact: &Contact) {
        let (i, j) = self.pairs[k];
        self.now += 1;
        (self.changed[i], self.changed[j]) = (self.now, self.now);
        if let Some(known) = self.contact_of[k] {
            let known = &mut self.contacts[known as usize];
            known.impulse += contact.impulse;
            known.energy_loss += contact.energy_loss;
            return;
        }
        self.contact_of[k] = Some(self.contacts.len() as u32);
        self.contacts.push(*contact);
    }

    fn finish(mut self) -> Resolved {
        let in_contact = self.pairs.iter().zip(&self.contact_of).filter(|(_, c)| c.is_some());
        let mut touched: Vec<usize> = in_contact.flat_map(|(&(i, j), _)| [i, j]).collect();
        touched.sort_unstable_by_key(|&k| self.discs[k].id);
        touched.dedup();
        self.contacts.sort_unstable_by_key(|contact| (contact.a, contact.b));
        Resolved { contacts: self.contacts, touched }
    }
}

/// Disjoint sets of discs, each known by its smallest member.
struct Roots(Vec<usize>);

impl Roots {
    fn find(&mut self, mut disc: usize) -> usize {
        while self.0[disc] != disc {
            // Halves the path on the way.
            self.0[disc] = self.0[self.0[disc]];
            disc = self.0[disc];
        }
        disc
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b)] = a.min(b);
    }
}

/// The record of a pair's collision.
pub fn pair_contact(a: &Disc, b: &Disc, impact: &Impact, time: f64) -> Contact {
    let Impact { impulse, approach_speed, energy_loss, .. } = *impact;
    contact(a, b, impact.normal, &Blow { impulse, approach_speed, energy_loss }, time)
}

/// The record of a contact.
fn contact(a: &Disc, b: &Disc, normal: DVec2, blow: &Blow, time: f64) -> Contact {
    let gap = gap(a, b);
    Contact {
        a: a.id,
        b: Partner::Disc(b.id),
        point: a.position + normal * (a.radius + 0.5 * gap),
        normal,
        gap,
        approach_speed: blow.approach_speed,
        impulse: blow.impulse,
        energy_loss: blow.energy_loss,
        time,
    }
}
