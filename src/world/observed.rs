//! The observed circles: what their owners last said of them, and when.
//!
//! Nothing here moves or corrects a circle: an answer is a function of the reports alone, so the
//! same report twice gets the same answer.

use std::collections::{BTreeSet, HashMap};

use super::command::Refusal;
use super::disc::{Disc, DiscId};
use super::limits;

/// All observed circles that are not stale.
#[derive(Clone, Debug, Default)]
pub struct Observed {
    /// In no order: a stale circle's place is taken by the last one.
    discs: Vec<Disc>,
    heard_at: Vec<f64>,
    /// Number of the report that a circle was last in.
    reported_in: Vec<u64>,
    places: HashMap<DiscId, usize>,
    reports: u64,
    /// No circle is stale before this, s.
    next_look: f64,
}

impl Observed {
    /// All circles.
    pub fn discs(&self) -> &[Disc] {
        &self.discs
    }

    /// Place of a circle in [`Self::discs`].
    pub fn place(&self, id: DiscId) -> Option<usize> {
        self.places.get(&id).copied()
    }

    /// Whether a circle, by its place in [`Self::discs`], was in the last report.
    pub fn is_in_last_report(&self, place: usize) -> bool {
        self.reported_in[place] == self.reports
    }

    /// Takes over a report; circles beyond the limit are refused.
    pub fn take(&mut self, discs: &[Disc], heard_at: f64) -> Vec<(DiscId, Refusal)> {
        self.reports += 1;
        let mut refused = Vec::new();
        // Circles mostly come in the same order again: each place is looked for behind the last.
        let mut guess = 0;
        for disc in discs {
            let known = match self.discs.get(guess) {
                Some(next) if next.id == disc.id => Some(guess),
                _ => self.place(disc.id),
            };
            if let Some(k) = known {
                guess = k + 1;
                (self.discs[k], self.heard_at[k], self.reported_in[k]) =
                    (*disc, heard_at, self.reports);
            } else if self.discs.len() < limits::OBSERVED_CIRCLES {
                self.places.insert(disc.id, self.discs.len());
                self.discs.push(*disc);
                self.heard_at.push(heard_at);
                self.reported_in.push(self.reports);
            } else {
                refused.push((disc.id, Refusal::TooManyObserved));
            }
        }
        refused
    }

    /// Drops the circles not heard of for `stale_after` seconds; returns their ids, in an
    /// order that is the same in every run.
    pub fn drop_stale(&mut self, now: f64, stale_after: f64) -> BTreeSet<DiscId> {
        let mut dropped = BTreeSet::new();
        if now < self.next_look {
            return dropped;
        }
        for k in (0..self.discs.len()).rev() {
            if now - self.heard_at[k] > stale_after {
                dropped.insert(self.remove(k));
            }
        }
        // Circles heard of from now on go stale later than the oldest of today.
        let oldest = self.heard_at.iter().copied().fold(now, f64::min);
        self.next_look = oldest + stale_after;
        dropped
    }

    /// Circles may be stale earlier than it was thought.
    pub fn look_again(&mut self) {
        self.next_look = 0.0;
    }

    /// Forgets all of them, as if nobody had ever reported any; returns their ids.
    pub fn clear(&mut self) -> BTreeSet<DiscId> {
        std::mem::take(self).places.into_keys().collect()
    }

    fn remove(&mut self, k: usize) -> DiscId {
        let id = self.discs.swap_remove(k).id;
        self.heard_at.swap_remove(k);
        self.reported_in.swap_remove(k);
        self.places.remove(&id);
        if let Some(moved) = self.discs.get(k) {
            self.places.insert(moved.id, k);
        }
        id
    }
}
