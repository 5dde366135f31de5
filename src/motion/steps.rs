//! Steps of fixed length: discs fly straight for `dt`, then what touches collides.
//!
//! ```text
//! fly -> find contacts -> (count what was missed) -> collide -> (part overlaps) -> next step
//! ```
//!
//! The rough method, here to be compared with. A contact is found up to `dt` late, with an overlap,
//! and each disc of it is then `(1 + e) lag |v_n| mu / m` off for ever: first order in `dt`. Only
//! the pair law changes a velocity, so energy is kept to rounding at restitution 1 whatever `dt`
//! is. Two discs that meet and part within a step are missed: no `dt` is short enough for a grazing
//! contact. Every kind of error is counted, never hidden. (A step that stops at each time of impact
//! is [`super::plain`].)
//!
//! Positions are kept as in the event method, from each disc's own last contact, so that a million
//! steps without one add no rounding.

use super::energy::EnergyAccount;
use super::plain::Laws;
use crate::detect::impact::pair_impact_at_any_scale;
use crate::detect::touching::{gap, touch};
use crate::detect::{self, Pair, TooManyPairs};
use crate::exact::RunningSum;
use crate::plan::BroadPhase;
use crate::resolve::overlap::{part_from_walls, part_pairs};
use crate::resolve::pair::approach;
use crate::resolve::touching;
use crate::resolve::wall::{bounce, wall_contact};
use crate::world::{Contact, Disc, Partner, Side, Walls, limits};

/// How to step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stepping {
    /// Length of a step, s.
    pub step: f64,
    /// Sweeps of the overlap correction after each step; 0 = left out.
    pub overlap_sweeps: usize,
    /// Whether to count contacts that were never resolved, which costs a second search.
    pub count_missed: bool,
    /// How touching pairs are found.
    pub broad_phase: BroadPhase,
}

/// A step that is no length of time.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("step = {0} s, must be a finite number above 0")]
pub struct BadStep(pub f64);

/// Contacts that the steps did not see when they happened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unseen {
    /// Resolved after they had begun: with an overlap.
    pub late: u64,
    /// Found when the discs had passed each other and parted already: never resolved.
    pub too_late: u64,
    /// Pairs whose paths met within a step, and that did not touch at its ends: never resolved.
    pub missed: u64,
}

/// The state of an arena under the stepped method.
#[derive(Clone, Debug)]
pub struct Steps {
    laws: Laws,
    stepping: Stepping,
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

impl Steps {
    /// An arena at time 0.
    ///
    /// # Errors
    /// [`BadStep`].
    pub fn new(laws: Laws, discs: &[Disc], stepping: Stepping) -> Result<Self, BadStep> {
        if !(stepping.step > 0.0 && stepping.step.is_finite()) {
            return Err(BadStep(stepping.step));
        }
        let mut energy = EnergyAccount::default();
        discs.iter().for_each(|disc| energy.book(disc.kinetic_energy()));
        Ok(Self {
            laws,
            stepping,
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
        let fly = move |disc: &Disc| disc.position + disc.velocity * since;
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
        let pairs = detect::touching_pairs(&flown, 0.0, self.stepping.broad_phase)?;
        self.count_unresolved(&flown)?;
        let before = std::mem::replace(&mut self.discs, flown);
        self.count += 1;
        let first = contacts.len();
        self.collide(&pairs, contacts);
        self.bounce(contacts);
        self.account(&contacts[first..]);
        self.part(&pairs);
        self.anchor(&before);
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

    /// Counts pairs that met on their straight way to `flown` and will not be resolved there.
    fn count_unresolved(&mut self, flown: &[Disc]) -> Result<(), TooManyPairs> {
        if !self.stepping.count_missed {
            return Ok(());
        }
        let fastest = self.discs.iter().map(|disc| disc.velocity.length()).fold(0.0, f64::max);
        let reach = 2.0 * fastest * self.stepping.step;
        for (i, j) in detect::touching_pairs(flown, reach, self.stepping.broad_phase)? {
            let (a, b) = (&self.discs[i], &self.discs[j]);
            let (d, w) = (b.position - a.position, b.velocity - a.velocity);
            let time = pair_impact_at_any_scale(d, w, a.radius + b.radius);
            if !time.is_some_and(|time| time > 0.0 && time < self.stepping.step) {
                continue;
            }
            if !touch(&flown[i], &flown[j], 0.0) {
                self.unseen.missed += 1;
            } else if approach(&flown[i], &flown[j]).is_none() {
                self.unseen.too_late += 1;
            }
        }
        Ok(())
    }

    fn collide(&mut self, pairs: &[Pair], contacts: &mut Vec<Contact>) {
        for &(i, j) in pairs {
            let (a, b) = (&self.discs[i], &self.discs[j]);
            let overlap = -gap(a, b) / a.radius.min(b.radius);
            self.largest_overlap = self.largest_overlap.max(overlap);
        }
        let (restitution, time) = (self.laws.restitution, self.time());
        contacts.extend(touching::resolve(&mut self.discs, pairs, restitution, time).contacts);
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
        let moving = |disc: &&Disc| disc.mass.is_infinite() && disc.velocity != glam::DVec2::ZERO;
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
            part_pairs(&mut self.discs, pairs);
            if let Some(walls) = &self.laws.walls {
                self.discs.iter_mut().for_each(|disc| part_from_walls(disc, walls));
            }
        }
    }

    /// Begins a new flight for every disc that left its old one.
    fn anchor(&mut self, before: &[Disc]) {
        let step = self.count;
        let time = |anchor: &Anchor| (step - anchor.step) as f64 * self.stepping.step;
        for ((disc, before), anchor) in self.discs.iter().zip(before).zip(&mut self.anchors) {
            let flown = anchor.disc.position + anchor.disc.velocity * time(anchor);
            if disc.velocity != before.velocity || disc.position != flown {
                *anchor = Anchor { disc: *disc, step };
            }
        }
    }
}

fn bounce_off(disc: &mut Disc, side: Side, walls: &Walls, time: f64) -> Option<Contact> {
    let touches = walls.gap(side, disc) <= 0.0;
    let bounce = bounce(disc, side, walls.restitution).filter(|_| touches)?;
    let contact = wall_contact(disc, side, walls, &bounce, time);
    disc.velocity = bounce.velocity;
    Some(contact)
}
