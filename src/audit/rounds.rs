//! Robots that are stamped one by one, brought to common stamps: frames.
//!
//! A round is over when all have said something new, or one has spoken twice. Its frame is at the
//! latest of their stamps. Each robot is taken there along its own flight: on from the sample
//! before that stamp, or back from the one after it, on whichever side of the bend between the two
//! the stamp lies. So a round waits for the next one.
//!
//! It judges nothing: where a robot was bent twice between two samples, its place is a guess.

use std::collections::BTreeMap;

use super::Frame;
use crate::world::{Disc, DiscId};

/// Stamps so close are the same, ns.
const SAME_STAMP_NS: i64 = 1_000;

/// What a robot said of itself.
#[derive(Clone, Copy, Debug)]
struct Sample {
    time_ns: i64,
    disc: Disc,
}

type Round = BTreeMap<DiscId, Sample>;

/// Samples to frames.
#[derive(Debug, Default)]
pub(super) struct Rounds {
    robots: usize,
    now: Round,
    /// The round before, until it is known where its robots went on.
    held: Option<Round>,
    /// States that were moved.
    pub moved: u64,
    /// By how much at most, ns.
    pub moved_ns: i64,
}

impl Rounds {
    /// Of so many robots.
    pub fn new(robots: usize) -> Self {
        Self { robots, ..Self::default() }
    }

    /// Takes a sample; the frame that is ready with it.
    pub fn hear(&mut self, time_ns: i64, disc: Disc) -> Option<Frame> {
        // Somebody else is silent: the frame is of those who spoke.
        let silent = self.now.contains_key(&disc.id).then(|| self.close()).flatten();
        self.now.insert(disc.id, Sample { time_ns, disc });
        if self.now.len() < self.robots { silent } else { self.close() }
    }

    /// What is left.
    pub fn end(&mut self) -> Vec<Frame> {
        let before = self.close();
        let last = self.held.take().and_then(|round| self.frame(&round, &Round::new()));
        before.into_iter().chain(last).collect()
    }

    /// Ends the round; the frame of the one before it.
    fn close(&mut self) -> Option<Frame> {
        let later = std::mem::take(&mut self.now);
        let frame = self.held.take().and_then(|round| self.frame(&round, &later));
        self.held = Some(later);
        frame
    }

    /// The robots of a round at the latest of their stamps.
    fn frame(&mut self, round: &Round, later: &Round) -> Option<Frame> {
        let time_ns = round.values().map(|sample| sample.time_ns).max()?;
        let mut discs = Vec::with_capacity(round.len());
        for (id, sample) in round {
            let by = time_ns - sample.time_ns;
            if by <= SAME_STAMP_NS {
                discs.push(sample.disc);
                continue;
            }
            self.moved += 1;
            self.moved_ns = self.moved_ns.max(by);
            let next = later.get(id).filter(|next| next.time_ns >= time_ns);
            discs.push(between(sample, next, time_ns));
        }
        Some(Frame { time_ns, discs })
    }
}

/// A robot at a time after one sample, and before the next if there is one.
fn between(sample: &Sample, next: Option<&Sample>, time_ns: i64) -> Disc {
    let Sample { disc, time_ns: from_ns } = *sample;
    let ahead = 1e-9 * (time_ns - from_ns) as f64;
    let on = Disc { position: disc.position + disc.velocity * ahead, ..disc };
    let Some(next) = next else { return on };
    let length = 1e-9 * (next.time_ns - from_ns) as f64;
    let change = next.disc.velocity - disc.velocity;
    let rest = next.disc.position - disc.position - disc.velocity * length;
    let square = change.length_squared();
    let bend = if square > 0.0 { length - rest.dot(change) / square } else { length };
    if ahead <= bend.clamp(0.0, length) {
        return on;
    }
    Disc { position: next.disc.position - next.disc.velocity * (length - ahead), ..next.disc }
}
