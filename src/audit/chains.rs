//! Discs at rest in touch: they pass a blow on in one instant, and those in the middle of the row
//! show nothing of it.
//!
//! Such a chain belongs to the group of those who gave the blow and who took it. It only looks:
//! what the contacts were is judged elsewhere.

use super::flight::{Course, Flight};
use super::groups::{Couple, NEAR, Sets};
use super::judge::JUDGED;
use super::law::Law;
use crate::detect::Pair;
use crate::world::Side;

/// A disturbed disc and an undisturbed one that it touched.
#[derive(Clone, Copy, Debug)]
struct Blow {
    /// Names the chain of the undisturbed one.
    chain: usize,
    quiet: usize,
    disturbed: usize,
}

/// The time between two samples, of which chains are looked for.
#[derive(Clone, Copy)]
pub(super) struct Chains<'a> {
    pub flights: &'a [Flight],
    pub law: &'a Law,
    /// Time between the samples, s.
    pub length: f64,
    /// Undisturbed pairs in touch.
    pub resting: &'a [Pair],
    /// Pairs of a disturbed and an undisturbed disc that came near each other.
    pub mixed: &'a [Pair],
}

impl<'a> Chains<'a> {
    /// Joins chains with the disturbed discs at them: where one of these met nobody else, where one
    /// gave the blow and another took it, and where the chain is held.
    pub fn join(&self, sets: &mut Sets) {
        let mut chains = Sets::new(self.flights.len());
        // What is fixed ends a chain, and passes nothing on.
        let pairs = self.resting.iter().filter(|&&pair| !self.is_held(pair));
        pairs.for_each(|&(i, j)| chains.join(i, j));
        let blows = self.blows(&mut chains);
        if blows.is_empty() {
            return;
        }
        let held = self.held(&mut chains);
        let mut is_passed = vec![false; self.flights.len()];
        for same in blows.chunk_by(|a, b| a.chain == b.chain) {
            let chain = same[0].chain;
            let mut blows = same.iter();
            let is_joined = blows.any(|blow| sets.root(blow.quiet) == sets.root(blow.disturbed));
            if is_joined || held[chain] || self.is_passed_on(same) {
                is_passed[chain] = true;
                same.iter().for_each(|blow| sets.join(blow.quiet, blow.disturbed));
            }
        }
        for &(i, j) in self.resting {
            if is_passed[chains.root(self.movable((i, j)))] {
                sets.join(i, j);
            }
        }
    }

    fn couple(&self, i: usize, j: usize) -> Couple<'a> {
        Couple::new(&self.flights[i], &self.flights[j], self.length, self.law)
    }

    fn is_fixed(&self, k: usize) -> bool {
        self.flights[k].before.mass.is_infinite()
    }

    /// Whether one of a pair is fixed.
    fn is_held(&self, (i, j): Pair) -> bool {
        self.is_fixed(i) || self.is_fixed(j)
    }

    fn movable(&self, (i, j): Pair) -> usize {
        if self.is_fixed(i) { j } else { i }
    }

    /// All blows, by chains.
    fn blows(&self, chains: &mut Sets) -> Vec<Blow> {
        let disturbed_first =
            |&(i, j): &Pair| if self.flights[i].is_disturbed() { (i, j) } else { (j, i) };
        let is_blow = |&(i, quiet): &Pair| !self.is_fixed(quiet) && self.couple(i, quiet).is_blow();
        let pairs = self.mixed.iter().map(disturbed_first).filter(is_blow);
        let mut blows: Vec<Blow> = pairs
            .map(|(disturbed, quiet)| Blow { chain: chains.root(quiet), quiet, disturbed })
            .collect();
        blows.sort_by_key(|blow| blow.chain);
        blows
    }

    /// Chains that lie at a wall or at something fixed.
    fn held(&self, chains: &mut Sets) -> Vec<bool> {
        let mut held = vec![false; self.flights.len()];
        let at_fixed = self.resting.iter().filter(|&&pair| self.is_held(pair));
        let at_fixed = at_fixed.map(|&pair| self.movable(pair));
        let at_walls =
            (0..self.flights.len()).filter(|&k| rests_at_a_wall(&self.flights[k], self.law));
        at_fixed.chain(at_walls).for_each(|k| held[chains.root(k)] = true);
        held
    }

    /// Whether two disturbed discs changed at once at a chain, of which one lay at it before.
    fn is_passed_on(&self, blows: &[Blow]) -> bool {
        let rested = |blow: &Blow| self.couple(blow.disturbed, blow.quiet).rests_in_touch();
        blows.iter().enumerate().any(|(k, a)| {
            blows[k + 1..].iter().any(|b| {
                a.disturbed != b.disturbed
                    && self.couple(a.disturbed, b.disturbed).is_at_once()
                    && (rested(a) || rested(b))
            })
        })
    }
}

/// Whether an undisturbed disc lies at a wall.
fn rests_at_a_wall(flight: &Flight, law: &Law) -> bool {
    let Some(walls) = &law.walls else { return false };
    let Flight { before, sigma, .. } = flight;
    let near = NEAR * before.radius + JUDGED * (sigma.position + law.walls_sigma);
    let is_still = before.velocity.length() <= JUDGED * sigma.velocity;
    let rests = |side| walls.gap(side, before).abs() <= near && is_still;
    let sides = [Side::Left, Side::Right, Side::Bottom, Side::Top];
    !flight.is_disturbed() && sides.into_iter().any(rests)
}

impl Couple<'_> {
    /// Whether two discs rest in touch at the earlier sample.
    pub(super) fn rests_in_touch(&self) -> bool {
        let w = self.b.before.velocity - self.a.before.velocity;
        let near = self.nearness();
        (self.early(0.0).length() - self.reach()).abs() <= near && self.is_still(w.length())
    }

    /// Whether the first, a disturbed disc, touched the second where it was bent, or on its way.
    fn is_blow(&self) -> bool {
        match self.a.course {
            Course::Bent(bend) => {
                (self.apart(bend).length() - self.reach()).abs() <= self.nearness()
            }
            _ => self.meets_ahead() || self.met_behind(),
        }
    }
}
