//! The judge of [`super::Steps`]: the same, with everything looked for anew at each step.
//!
//! Pairs are found by all pairs or by a grid, all touching ones are resolved in one call, and every
//! disc is looked at at every wall. Only simulated discs, and nobody gives commands.

use glam::DVec2;

use super::{NotInSteps, Stepping, Unseen, may_collide};
use crate::detect::impact::pair_impact_at_any_scale;
use crate::detect::touching::{gap, touch};
use crate::detect::{self, Pair, TooManyPairs};
use crate::exact::RunningSum;
use crate::motion::energy::EnergyAccount;
use crate::motion::plain::Laws;
use crate::plan::BroadPhase;
use crate::resolve::overlap::{part_from_walls, part_pairs};
use crate::resolve::pair::approach;
use crate::resolve::touching;
use crate::resolve::wall::{bounce, wall_contact};
use crate::world::{Contact, Disc, Owner, Partner, Periodic, Side, Walls, limits};

/// The state of an arena under the stepped method.
#[derive(Clone, Debug)]
pub struct PlainSteps {
    laws: Laws,
    stepping: Stepping,
    broad_phase: BroadPhase,
    now: f64,
    /// Steps done.
    count: u64,
    /// The discs at the last step end.
    discs: Vec<Disc>,
    /// Where and when the straight flight of each disc began.
    anchors: Vec<Anchor>,
    energy: EnergyAccount,
    unseen: Unseen,
    largest_overlap: f64,
    contacts: u64,
}

/// The beginning of a straight flight.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Anchor {
    disc: Disc,
    step: u64,
}

impl PlainSteps {
    /// An arena at time 0.
    ///
    /// # Errors
    /// [`NotInSteps`].
    pub fn new(
        laws: Laws,
        discs: &[Disc],
        stepping: Stepping,
        broad_phase: BroadPhase,
    ) -> Result<Self, NotInSteps> {
        stepping.check(&laws)?;
        let mut energy = EnergyAccount::default();
        discs.iter().for_each(|disc| energy.book(disc.kinetic_energy()));
        Ok(Self {
            laws,
            stepping,
            broad_phase,
            now: 0.0,
            count: 0,
            discs: discs.to_vec(),
            anchors: discs.iter().map(|&disc| Anchor { disc, step: 0 }).collect(),
            energy,
            unseen: Unseen::default(),
            largest_overlap: 0.0,
            contacts: 0,
        })
    }

    /// The present, s since the start.
    pub fn now(&self) -> f64 {
        self.now
    }

    /// The discs as they are now: since the last step end they fly straight.
    pub fn discs(&self) -> impl Iterator<Item = Disc> + '_ {
        let since = self.now - self.time();
        let fly = move |disc: &Disc| {
            let position = disc.position + disc.velocity * since;
            self.laws.periodic.map_or(position, |periodic| periodic.inside(position))
        };
        self.discs.iter().map(move |disc| Disc { position: fly(disc), ..*disc })
    }

    /// Kinetic energy, J.
    pub fn kinetic_energy(&self) -> f64 {
        self.discs.iter().map(Disc::kinetic_energy).collect::<RunningSum>().value()
    }

    /// Signed relative energy error, with all work accounted for.
    pub fn relative_energy_drift(&self) -> f64 {
        self.energy.relative_drift(self.kinetic_energy())
    }

    /// Largest overlap of a pair at any contact, in units of the smaller radius.
    pub fn largest_overlap(&self) -> f64 {
        self.largest_overlap
    }

    /// Contacts resolved since the start, pairs and walls.
    pub fn contacts(&self) -> u64 {
        self.contacts
    }

    /// Contacts seen late, too late or never (the last two if [`Stepping::count_missed`]).
    pub fn unseen(&self) -> Unseen {
        self.unseen
    }

    /// Moves on to `until` (s) by the whole steps on the way, and adds their contacts; nothing
    /// happens if that is past. Results do not depend on where one stops to look.
    ///
    /// Stops short of `until` after [`limits::STEPS_PER_ADVANCE`] steps: [`Self::now`] tells, and
    /// calling again goes on.
    ///
    /// # Errors
    /// [`TooManyPairs`] when discs lie heaped on each other, or a step is so long that most of them
    /// could have met (then do not count the missed ones, or shorten it); the arena stays at the
    /// last step end.
    pub fn advance(&mut self, until: f64, contacts: &mut Vec<Contact>) -> Result<(), TooManyPairs> {
        for _ in 0..limits::STEPS_PER_ADVANCE {
            let end = (self.count + 1) as f64 * self.stepping.step;
            if end > until || until.is_nan() {
                self.now = self.now.max(until);
                return Ok(());
            }
            self.step(contacts)?;
            self.now = self.now.max(end);
        }
        Ok(())
    }

    /// One step, stage by stage.
    fn step(&mut self, contacts: &mut Vec<Contact>) -> Result<(), TooManyPairs> {
        let flown = self.flown();
        let pairs = self.pairs_within(&flown, 0.0)?;
        self.count_unresolved(&flown)?;
        let before = std::mem::replace(&mut self.discs, flown);
        self.count += 1;
        let first = contacts.len();
        self.collide(&pairs, contacts);
        self.bounce(contacts);
        self.account(&contacts[first..]);
        let flown: Vec<DVec2> = self.discs.iter().map(|disc| disc.position).collect();
        self.part(&pairs);
        self.anchor(&before, &flown);
        Ok(())
    }

    /// Time of the last step end, s.
    fn time(&self) -> f64 {
        self.count as f64 * self.stepping.step
    }

    /// The discs one step further.
    fn flown(&self) -> Vec<Disc> {
        let fly = |anchor: &Anchor| {
            let time = (self.count + 1 - anchor.step) as f64 * self.stepping.step;
            let position = anchor.disc.position + anchor.disc.velocity * time;
            Disc { position, ..anchor.disc }
        };
        self.anchors.iter().map(fly).collect()
    }

    /// Pairs with a gap up to a margin (m) whose contacts would change something.
    fn pairs_within(&self, discs: &[Disc], margin: f64) -> Result<Vec<Pair>, TooManyPairs> {
        let mut pairs = match &self.laws.periodic {
            None => detect::touching_pairs(discs, margin, self.broad_phase)?,
            Some(periodic) => {
                let all = (0..discs.len()).flat_map(|i| (i + 1..discs.len()).map(move |j| (i, j)));
                let near = |&(i, j): &Pair| {
                    let (a, b) = seen(discs, (i, j), Some(periodic));
                    touch(&a, &b, margin)
                };
                all.filter(near).collect()
            }
        };
        let owners = [Owner::Simulated; 2];
        pairs.retain(|&(i, j)| may_collide(owners, [discs[i].mass, discs[j].mass]));
        Ok(pairs)
    }

    /// Counts pairs that met on their straight way to `flown` and will not be resolved there.
    fn count_unresolved(&mut self, flown: &[Disc]) -> Result<(), TooManyPairs> {
        if !self.stepping.count_missed {
            return Ok(());
        }
        let fastest = self.discs.iter().map(|disc| disc.velocity.length()).fold(0.0, f64::max);
        let reach = 2.0 * fastest * self.stepping.step;
        for (i, j) in self.pairs_within(flown, reach)? {
            let (a, b) = (&self.discs[i], &self.discs[j]);
            let (mut d, w) = (b.position - a.position, b.velocity - a.velocity);
            if let Some(periodic) = &self.laws.periodic {
                d += periodic.shift(d);
            }
            let time = pair_impact_at_any_scale(d, w, a.radius + b.radius);
            if !time.is_some_and(|time| time > 0.0 && time < self.stepping.step) {
                continue;
            }
            let (a, b) = seen(flown, (i, j), self.laws.periodic.as_ref());
            if !touch(&a, &b, 0.0) {
                self.unseen.missed += 1;
            } else if approach(&a, &b).is_none() {
                self.unseen.too_late += 1;
            }
        }
        Ok(())
    }

    fn collide(&mut self, pairs: &[Pair], contacts: &mut Vec<Contact>) {
        let periodic = self.laws.periodic;
        for &pair in pairs {
            let (a, b) = seen(&self.discs, pair, periodic.as_ref());
            let overlap = -gap(&a, &b) / a.radius.min(b.radius);
            self.largest_overlap = self.largest_overlap.max(overlap);
        }
        let (restitution, time) = (self.laws.restitution, self.time());
        let mut inside = self.discs.clone();
        if let Some(periodic) = &periodic {
            inside.iter_mut().for_each(|disc| disc.position = periodic.inside(disc.position));
        }
        let resolved =
            touching::resolve_in(&mut inside, pairs, restitution, time, periodic.as_ref());
        for (disc, after) in self.discs.iter_mut().zip(&inside) {
            disc.velocity = after.velocity;
        }
        contacts.extend(resolved.contacts);
    }

    fn bounce(&mut self, contacts: &mut Vec<Contact>) {
        let Some(walls) = self.laws.walls else { return };
        let time = self.time();
        for disc in &mut self.discs {
            for side in [Side::Left, Side::Right, Side::Bottom, Side::Top] {
                contacts.extend(bounce_off(disc, side, &walls, time));
            }
        }
    }

    /// Counts the contacts of a step, and books what they did to the energy.
    fn account(&mut self, contacts: &[Contact]) {
        self.contacts += contacts.len() as u64;
        self.unseen.late += contacts.iter().filter(|contact| contact.gap < 0.0).count() as u64;
        for contact in contacts {
            self.energy.book(-contact.energy_loss);
        }
        // A fixed disc that moves does work: seen from it, only restitution takes energy.
        let moving = |disc: &&Disc| disc.mass.is_infinite() && disc.velocity != DVec2::ZERO;
        for fixed in self.discs.iter().filter(moving) {
            for contact in contacts {
                let along = contact.impulse * contact.normal.dot(fixed.velocity);
                if contact.a == fixed.id {
                    self.energy.book(along);
                } else if contact.b == Partner::Disc(fixed.id) {
                    self.energy.book(-along);
                }
            }
        }
    }

    fn part(&mut self, pairs: &[Pair]) {
        for _ in 0..self.stepping.overlap_sweeps {
            part_pairs(&mut self.discs, pairs, self.laws.periodic.as_ref());
            if let Some(walls) = &self.laws.walls {
                self.discs.iter_mut().for_each(|disc| part_from_walls(disc, walls));
            }
        }
    }

    /// Begins a new flight for every disc that left its old one.
    fn anchor(&mut self, before: &[Disc], flown: &[DVec2]) {
        let all = self.discs.iter().zip(before).zip(flown).zip(&mut self.anchors);
        for (((disc, before), flown), anchor) in all {
            if disc.position != *flown {
                *anchor = Anchor { disc: *disc, step: self.count };
            } else if disc.velocity != before.velocity {
                let inside = |periodic: Periodic| periodic.inside(disc.position);
                let position = self.laws.periodic.map_or(disc.position, inside);
                *anchor = Anchor { disc: Disc { position, ..*disc }, step: self.count };
            }
        }
    }
}

/// A pair, the smaller id first, as the nearest image of one sees the other.
fn seen(discs: &[Disc], (i, j): Pair, periodic: Option<&Periodic>) -> (Disc, Disc) {
    let (mut a, mut b) = (discs[i], discs[j]);
    if b.id < a.id {
        (a, b) = (b, a);
    }
    if let Some(periodic) = periodic {
        (a.position, b.position) = (periodic.inside(a.position), periodic.inside(b.position));
        b.position += periodic.shift(b.position - a.position);
    }
    (a, b)
}

fn bounce_off(disc: &mut Disc, side: Side, walls: &Walls, time: f64) -> Option<Contact> {
    let touches = walls.gap(side, disc) <= 0.0;
    let bounce = bounce(disc, side, walls.restitution).filter(|_| touches)?;
    let contact = wall_contact(disc, side, walls, &bounce, time);
    disc.velocity = bounce.velocity;
    Some(contact)
}
