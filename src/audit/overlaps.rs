//! Overlaps that last: from the sample that first shows one to the first without it.
//!
//! An overlap in which velocities changed was a late collision, which is told as one. Otherwise the
//! discs ran into each other and nothing happened, or they overlap for another reason.

use std::collections::BTreeMap;

use super::findings::{Kind, Violation};
use super::groups::Crossing;
use crate::world::{Disc, DiscId};

/// One pair.
#[derive(Clone, Copy, Debug)]
struct Episode {
    /// When it was first seen, s.
    first: f64,
    /// When it was last seen, s.
    last: f64,
    /// Deepest, m.
    depth: f64,
    /// m
    smaller_radius: f64,
    place: [f64; 2],
    /// When and how fast they ran into each other, if they did.
    entered: Option<(f64, f64)>,
    /// Whether a contact changed velocities meanwhile.
    answered: bool,
}

/// All that last.
#[derive(Clone, Debug, Default)]
pub(super) struct Overlaps {
    open: BTreeMap<(DiscId, DiscId), Episode>,
    /// Deepest of all over the smaller radius.
    pub deepest: f64,
    /// How many there were.
    pub count: u64,
}

impl Overlaps {
    /// A pair overlaps at this sample.
    pub fn see(&mut self, (a, b): (&Disc, &Disc), depth: f64, time: f64) {
        let smaller_radius = a.radius.min(b.radius);
        self.deepest = self.deepest.max(depth / smaller_radius);
        let count = &mut self.count;
        let episode = self.open.entry(key(a.id, b.id)).or_insert_with(|| {
            *count += 1;
            let (depth, place) = (0.0, [0.0; 2]);
            let (entered, answered) = (None, false);
            Episode { first: time, last: time, depth, smaller_radius, place, entered, answered }
        });
        episode.last = time;
        if depth > episode.depth {
            episode.depth = depth;
            episode.place = (0.5 * (a.position + b.position)).to_array();
        }
    }

    /// Whether a pair is known to overlap.
    pub fn is_open(&self, a: DiscId, b: DiscId) -> bool {
        self.open.contains_key(&key(a, b))
    }

    /// A pair ran into each other at this time.
    pub fn enter(&mut self, a: DiscId, b: DiscId, crossing: &Crossing, time: f64) {
        if let Some(episode) = self.open.get_mut(&key(a, b)) {
            episode.entered.get_or_insert((time, crossing.approach));
        }
    }

    /// A contact changed velocities of a pair.
    pub fn answer(&mut self, a: DiscId, b: DiscId) {
        if let Some(episode) = self.open.get_mut(&key(a, b)) {
            episode.answered = true;
        }
    }

    /// Ends those that were not seen since this time, and says what they were.
    pub fn close(&mut self, before: f64) -> Vec<Violation> {
        let mut ended = Vec::new();
        self.open.retain(|pair, episode| {
            let over = episode.last < before;
            if over && !episode.answered {
                ended.push(violation(*pair, episode));
            }
            !over
        });
        ended
    }
}

fn key(a: DiscId, b: DiscId) -> (DiscId, DiscId) {
    (a.min(b), a.max(b))
}

fn violation((a, b): (DiscId, DiscId), episode: &Episode) -> Violation {
    let Episode { first, last, depth, smaller_radius, place, entered, .. } = *episode;
    let (time, approach) = entered.unwrap_or((first, 0.0));
    Violation {
        kind: if entered.is_some() { Kind::Missed } else { Kind::Overlap },
        also: Vec::new(),
        time_s: time,
        discs: vec![a, b],
        wall: false,
        place_m: place,
        approach_speed_mps: approach,
        severity: depth / smaller_radius,
        detail: format!("{depth:.3e} m deep at most, at samples from {first:.6} s to {last:.6} s"),
    }
}
