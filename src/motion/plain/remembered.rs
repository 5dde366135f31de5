//! Contacts that are remembered: what coordinates cannot know about two discs that just collided.
//!
//! At a contact the gap is 0 by construction and the speed of parting is the restitution times the
//! speed of approach: both are known to so many digits of themselves. Coordinates know them to so
//! many digits of the coordinates, and in a collapse, where gaps and speeds shrink a hundredfold
//! from contact to contact, soon not at all. So for pairs that stay close `C = d.d - s^2` and
//! `B = d.w` are carried on instead: in flight `C += 2 B t + w^2 t^2`, `B += w^2 t`, and when one
//! of the two is kicked by a third disc `B` changes by `d` times the change of `w`.
//!
//! A pair is forgotten as soon as coordinates know it well enough, or when something else than a
//! collision of two changed one of them. Only below restitution 1 is anything remembered, and in a
//! gas hardly more than the last contact.

use crate::detect::precise::{Sight, time_to_contact};
use crate::exact::{DoubleDouble, DoubleDoubleVec};

/// A gap this part of the reach is known from coordinates to 2^-70 of itself or so.
const PARTED: f64 = 1.0 / (1u64 << 27) as f64;

/// Relative rounding error of a few operations in double-double.
pub(super) const ROUNDING: f64 = f64::EPSILON * f64::EPSILON;

/// What is known about two bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Known {
    /// The two, the smaller index first.
    pub pair: (usize, usize),
    /// `d.d - s^2`, m^2.
    pub clearance: DoubleDouble,
    /// `d.w`, m^2/s.
    pub closing: DoubleDouble,
    /// How much of `closing` may be rounding, m^2/s.
    pub doubt: f64,
    /// Offset at which all this holds, s.
    pub time: DoubleDouble,
    /// Sum of the radii, m.
    pub reach: DoubleDouble,
}

impl Known {
    /// `w^2`, from `d.w`, known here, and `d x w`, which flight does not change and coordinates
    /// know.
    pub fn speed2(&self, sight: &Sight) -> DoubleDouble {
        let across = sight.d.cross(sight.w);
        let sum = self.closing.squared().plus(across.squared());
        sum.over(self.reach.squared().plus(self.clearance))
    }

    /// Lets the time pass until an offset. The past is not looked at: before their contact, which
    /// may be later than its event by rounding, the two approached.
    pub fn fly(&mut self, offset: DoubleDouble, sight: &Sight) {
        let time = offset.minus(self.time);
        if time.hi <= 0.0 {
            return;
        }
        let gained = time.times(self.speed2(sight));
        // C += (2 B + w^2 t) t.
        let change = self.closing.scaled(2.0).plus(gained).times(time);
        self.clearance = self.clearance.plus(change);
        self.closing = self.closing.plus(gained);
        self.doubt += ROUNDING * gained.hi.abs();
        self.time = offset;
    }

    /// Time until the two collide, s; 0 = now.
    pub fn time_to_contact(&self, sight: &Sight) -> Option<f64> {
        let (clearance, closing) = (self.clearance.value(), self.closing.value());
        if closing >= -self.doubt {
            return None;
        }
        if clearance <= 0.0 {
            return Some(0.0);
        }
        time_to_contact(clearance, closing, self.speed2(sight).value() / -closing)
    }

    fn has_parted(&self, offset: f64) -> bool {
        let time = offset - self.time.hi;
        let clearance = self.clearance.hi + 2.0 * self.closing.hi * time;
        clearance.abs() > PARTED * self.reach.hi * self.reach.hi
    }

    fn partner_of(&self, body: usize) -> Option<usize> {
        let (i, j) = self.pair;
        if i == body { Some(j) } else { (j == body).then_some(i) }
    }
}

/// The pairs that are remembered; few.
#[derive(Clone, Debug, Default)]
pub(super) struct Remembered(Vec<Known>);

impl Remembered {
    /// What is known about two bodies.
    #[inline]
    pub fn find(&self, i: usize, j: usize) -> Option<&Known> {
        let pair = (i.min(j), i.max(j));
        self.0.iter().find(|known| known.pair == pair)
    }

    /// Remembers a pair, and nothing else about it; forgets those that have parted.
    pub fn remember(&mut self, known: Known) {
        let offset = known.time.hi;
        self.0.retain(|other| other.pair != known.pair && !other.has_parted(offset));
        if !known.has_parted(offset) {
            self.0.push(known);
        }
    }

    /// Tells the pairs of a body, but for that with `by`, that its velocity changes at an offset,
    /// as if `delay` later. `sight` shows it a partner as it is before.
    pub fn kick(
        &mut self,
        (body, by): (usize, usize),
        change: &DoubleDoubleVec,
        (offset, delay): (f64, f64),
        sight: impl Fn(usize) -> Sight,
    ) {
        for known in &mut self.0 {
            let Some(partner) = known.partner_of(body).filter(|k| *k != by) else { continue };
            let mut sight = sight(partner).after(delay);
            known.fly(DoubleDouble::sum(offset, delay), &sight);
            let kick = sight.d.dot(*change).negated();
            known.closing = known.closing.plus(kick);
            known.doubt += ROUNDING * kick.hi.abs();
            sight.w = sight.w.minus(*change);
            known.fly(offset.into(), &sight);
        }
    }

    /// Forgets what is known about a body.
    pub fn forget(&mut self, body: usize) {
        self.0.retain(|known| known.partner_of(body).is_none());
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Tells time anew: an offset becomes another, and the discs fly slower by a power of two.
    /// `sight` shows two as they are at the offset.
    pub fn begin_again(
        &mut self,
        offset: f64,
        at: f64,
        slowed: f64,
        sight: impl Fn(usize, usize) -> Sight,
    ) {
        for known in &mut self.0 {
            let (i, j) = known.pair;
            known.fly(offset.into(), &sight(i, j));
            let late = known.time.minus(offset.into());
            known.time = DoubleDouble::from(at).plus(late.scaled(slowed.recip()));
            known.closing = known.closing.scaled(slowed);
            known.doubt *= slowed;
        }
    }

    /// Moves the base of all offsets.
    pub fn rebase(&mut self, shift: f64) {
        self.0.iter_mut().for_each(|known| known.time = known.time.minus(shift.into()));
    }
}
