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
        if !cluster.round() {
            break;
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
    contact_of: Vec<u32>,
    checked: Vec<u32>,
    changed: Vec<u32>,
    now: u32,
    /// Those of a round, and of these the ones that share a disc with another.
    approaching: Vec<Approaching>,
    sharing: Vec<Approaching>,
    /// By disc: in how many of a round it is.
    shares: Vec<u32>,
    roots: Roots,
    touching: Vec<Touching>,
    reflector: Reflector,
    restitution: f64,
    time: f64,
    periodic: Option<&'a Periodic>,
}

/// A pair that had no contact.
const NONE: u32 = u32::MAX;

/// What is counted before the first contact.
const START: u32 = 1;

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
        let (changed, shares) = (vec![START; discs.len()], vec![0; discs.len()]);
        let (contact_of, checked) = (vec![NONE; pairs.len()], vec![0; pairs.len()]);
        Self {
            discs,
            contacts: Vec::with_capacity(pairs.len()),
            pairs,
            contact_of,
            checked,
            changed,
            now: START,
            approaching: Vec::new(),
            sharing: Vec::new(),
            shares,
            roots: Roots::default(),
            touching: Vec::new(),
            reflector: Reflector::default(),
            restitution,
            time,
            periodic: None,
        }
    }

    /// Resolves all pairs that approach; whether there was one.
    fn round(&mut self) -> bool {
        let mut approaching = std::mem::take(&mut self.approaching);
        self.find_approaching(&mut approaching);
        self.set_shares(&approaching, |count| count + 1);
        let mut sharing = std::mem::take(&mut self.sharing);
        sharing.clear();
        sharing.extend(approaching.iter().filter(|member| self.shares_a_disc(member)));
        for member in &approaching {
            if !self.shares_a_disc(member) {
                self.collide(member.pair);
            }
        }
        self.set_shares(&approaching, |_| 0);
        self.sort_by_group(&mut sharing);
        for group in sharing.chunk_by(|a, b| a.root == b.root) {
            self.resolve_group(group);
        }
        let any = !approaching.is_empty();
        (self.approaching, self.sharing) = (approaching, sharing);
        any
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
    fn find_approaching(&mut self, approaching: &mut Vec<Approaching>) {
        approaching.clear();
        for (pair, &(i, j)) in self.pairs.iter().enumerate() {
            if self.changed[i].max(self.changed[j]) <= self.checked[pair] {
                continue;
            }
            self.checked[pair] = self.now;
            let (a, b) = self.seen((i, j));
            let Some((normal, speed)) = approach(&a, &b) else { continue };
            // After a first blow, what is left may be the rounding of the velocities.
            let settled = self.contact_of[pair] != NONE && speed <= rounding_speed(&a, &b);
            if !settled && (a.mass.is_finite() || b.mass.is_finite()) {
                approaching.push(Approaching { root: 0, pair, normal });
            }
        }
    }

    fn set_shares(&mut self, approaching: &[Approaching], count: impl Fn(u32) -> u32) {
        for member in approaching {
            let (i, j) = self.pairs[member.pair];
            self.shares[i] = count(self.shares[i]);
            self.shares[j] = count(self.shares[j]);
        }
    }

    /// Whether another pair that approaches could move a disc of this one.
    fn shares_a_disc(&self, member: &Approaching) -> bool {
        let (i, j) = self.pairs[member.pair];
        [i, j].iter().any(|&disc| self.shares[disc] > 1 && self.discs[disc].mass.is_finite())
    }

    /// Sorts pairs into groups that share no disc which they could move; each in order of ids.
    fn sort_by_group(&mut self, sharing: &mut [Approaching]) {
        if sharing.is_empty() {
            return;
        }
        let (roots, discs) = (&mut self.roots, &self.discs);
        roots.be_apart(discs.len());
        let finite = |disc: usize| discs[disc].mass.is_finite();
        for member in &*sharing {
            let (i, j) = self.pairs[member.pair];
            if finite(i) && finite(j) {
                roots.join(i, j);
            }
        }
        for member in &mut *sharing {
            let (i, j) = self.pairs[member.pair];
            member.root = roots.find(if finite(i) { i } else { j });
        }
        sharing.sort_by_key(|member| member.root);
    }

    fn resolve_group(&mut self, group: &[Approaching]) {
        if group.len() <= limits::GROUP_CONTACTS {
            return self.reflect_group(group);
        }
        group.iter().for_each(|member| self.collide(member.pair));
    }

    /// Collides a pair, if it still approaches.
    fn collide(&mut self, pair: usize) {
        let (i, j) = self.pairs[pair];
        let (a, b) = self.seen((i, j));
        if let Some(impact) = collide(&a, &b, self.restitution) {
            self.discs[i].velocity = impact.velocity_a;
            self.discs[j].velocity = impact.velocity_b;
            let contact = pair_contact(&a, &b, &impact, self.time);
            self.note(pair, &contact);
        }
    }

    /// Reflects a group of contacts together.
    fn reflect_group(&mut self, group: &[Approaching]) {
        let touching = |member: &Approaching| {
            let (i, j) = self.pairs[member.pair];
            Touching { i, j, normal: member.normal }
        };
        let mut contacts = std::mem::take(&mut self.touching);
        contacts.clear();
        contacts.extend(group.iter().map(touching));
        let mut reflector = std::mem::take(&mut self.reflector);
        reflector.reflect(self.discs, &contacts, self.restitution);
        for (member, blow) in group.iter().zip(reflector.blows()) {
            let (a, b) = self.seen(self.pairs[member.pair]);
            self.note(member.pair, &contact(&a, &b, member.normal, blow, self.time));
        }
        (self.touching, self.reflector) = (contacts, reflector);
    }

    /// Takes note of a contact; a pair hit again adds to its first.
    fn note(&mut self, k: usize, contact: &Contact) {
        let (i, j) = self.pairs[k];
        self.now += 1;
        (self.changed[i], self.changed[j]) = (self.now, self.now);
        if let Some(known) = self.contacts.get_mut(self.contact_of[k] as usize) {
            known.impulse += contact.impulse;
            known.energy_loss += contact.energy_loss;
            return;
        }
        self.contact_of[k] = self.contacts.len() as u32;
        self.contacts.push(*contact);
    }

    fn finish(self) -> Resolved {
        // The pairs are by ids, so their contacts are.
        let had_one = self.contact_of.iter().filter(|contact| **contact != NONE);
        let contacts = had_one.map(|&contact| self.contacts[contact as usize]).collect();
        let (discs, changed) = (&*self.discs, &self.changed);
        let mut touched: Vec<usize> = (0..discs.len()).filter(|&k| changed[k] > START).collect();
        touched.sort_unstable_by_key(|&k| discs[k].id);
        Resolved { contacts, touched }
    }
}

/// Disjoint sets of discs, each known by its smallest member.
#[derive(Default)]
struct Roots(Vec<usize>);

impl Roots {
    /// So many discs, each by itself.
    fn be_apart(&mut self, discs: usize) {
        self.0.clear();
        self.0.extend(0..discs);
    }

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
