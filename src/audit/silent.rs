//! Discs that are silent at a stamp at which others speak: carried there along their own flight.
//!
//! Robots at different rates, or parts of a world from two publishers, are else never seen at once,
//! and what they do to each other is judged by nobody. The stamps wait until the silent ones speak
//! again, so their flight is known from both sides of a bend.
//!
//! Never carried: over a flight that no single sharp bend explains, over a long silence, or where
//! so few are seen at two stamps in a row that their noise is not known.

use std::collections::{HashMap, HashSet, VecDeque};

use super::Frame;
use super::flight::{Course, Flight, Means, Span};
use super::judge::JUDGED;
use super::law::Law;
use super::noise::Noise;
use crate::world::{Disc, DiscId};

/// Stamps that wait for whoever is silent, at most.
const WAITING_MAX: usize = 20;

/// Part of a silence by which the instant of a bend in it may be unsure.
const SHARP: f64 = 0.01;

/// A disc at a stamp, ns.
type Sample = (i64, Disc);

/// Stamps that wait, and who is silent.
#[derive(Debug, Default)]
pub(super) struct Silence {
    waiting: VecDeque<Frame>,
    /// As it was recorded.
    previous: Frame,
    /// The last samples of those that are not in the previous stamp.
    silent: HashMap<DiscId, Sample>,
    /// Whether most are seen at two stamps in a row.
    is_rare: bool,
    /// States that were carried.
    pub carried: u64,
}

impl Silence {
    /// Learns from the first stamps whether silence is rare enough.
    pub fn learn(&mut self, frames: &[Frame]) {
        let samples: usize = frames.iter().map(|frame| frame.discs.len()).sum();
        let pairs =
            super::steps(frames).map(|(before, after, _)| super::alike(before, after).count());
        self.is_rare = 2 * pairs.sum::<usize>() >= samples;
    }

    /// Takes the samples of a stamp; the stamps that are ready.
    pub fn hear(&mut self, frame: Frame, law: &Law, noise: &Noise) -> Vec<Frame> {
        if !self.is_rare {
            return vec![frame];
        }
        self.waiting.push_back(frame);
        self.ready(law, noise, WAITING_MAX)
    }

    /// What is left.
    pub fn end(&mut self, law: &Law, noise: &Noise) -> Vec<Frame> {
        self.ready(law, noise, 0)
    }

    /// The stamps that need not wait: at most so many do.
    fn ready(&mut self, law: &Law, noise: &Noise, waiting_max: usize) -> Vec<Frame> {
        let mut ready = Vec::new();
        while let Some(front) = self.waiting.front() {
            if self.silent.is_empty() && are_alike(front, &self.previous) {
                ready.extend(self.waiting.pop_front());
                ready.last().into_iter().for_each(|frame| self.previous.clone_from(frame));
                continue;
            }
            self.note_silent();
            let later = self.later();
            let all_speak = self.silent.keys().all(|id| later.contains_key(id));
            if !all_speak && self.waiting.len() <= waiting_max {
                break;
            }
            ready.extend(self.carry(&later, law, noise));
        }
        ready
    }

    /// Notes who is not in the first stamp that waits.
    fn note_silent(&mut self) {
        let Some(front) = self.waiting.front() else { return };
        let speak: HashSet<DiscId> = front.discs.iter().map(|disc| disc.id).collect();
        let Frame { time_ns, discs } = &self.previous;
        let silent = discs.iter().filter(|disc| !speak.contains(&disc.id));
        self.silent.extend(silent.map(|disc| (disc.id, (*time_ns, *disc))));
        self.silent.retain(|id, _| !speak.contains(id));
    }

    /// The next sample of each disc after the first stamp that waits.
    fn later(&self) -> HashMap<DiscId, Sample> {
        let later = self.waiting.iter().skip(1).rev();
        later.flat_map(|frame| frame.discs.iter().map(|d| (d.id, (frame.time_ns, *d)))).collect()
    }

    /// The first stamp that waits, with those who are silent at it; whoever says nothing later is
    /// gone.
    fn carry(
        &mut self,
        later: &HashMap<DiscId, Sample>,
        law: &Law,
        noise: &Noise,
    ) -> Option<Frame> {
        let mut frame = self.waiting.pop_front()?;
        self.previous.clone_from(&frame);
        self.silent.retain(|id, _| later.contains_key(id));
        let mut carried: Vec<Disc> = self
            .silent
            .iter()
            .filter_map(|(id, last)| between(*last, *later.get(id)?, frame.time_ns, law, noise))
            .collect();
        carried.sort_unstable_by_key(|disc| disc.id);
        self.carried += carried.len() as u64;
        frame.discs.extend(carried);
        Some(frame)
    }
}

fn are_alike(a: &Frame, b: &Frame) -> bool {
    let mut pairs = a.discs.iter().zip(&b.discs);
    a.discs.len() == b.discs.len() && pairs.all(|(a, b)| a.id == b.id)
}

/// Whether it is known on which side of a bend a time lies, and that it is one bend: not two that
/// noise makes one, and not what a drive did.
fn is_sharp(flight: &Flight, law: &Law, (instant, at, length): (f64, f64, f64)) -> bool {
    let blur = JUDGED * flight.sigma.of_rest(length) / flight.change.length();
    law.acceleration_max == 0.0 && blur <= SHARP * length && (at - instant).abs() > blur
}

/// A disc at a time between two of its samples, if one bend at most explains the later one.
fn between(last: Sample, next: Sample, time_ns: i64, law: &Law, noise: &Noise) -> Option<Disc> {
    let ((from_ns, before), (to_ns, after)) = (last, next);
    let is_same = before.radius == after.radius && before.mass == after.mass;
    if !is_same || time_ns <= from_ns || to_ns <= time_ns {
        return None;
    }
    let span = |end_ns: i64| Span::new(1e-9 * (end_ns - from_ns) as f64, law.drag);
    let (whole, part) = (span(to_ns), span(time_ns));
    let fastest = before.velocity.length().max(after.velocity.length());
    let flight = Means { law, noise, fastest }.flight(&before, &after, &whole);
    let fall = flight.fall(law);
    let bend = match flight.course {
        Course::Quiet => whole.length,
        Course::Bent(instant) if is_sharp(&flight, law, (instant, part.length, whole.length)) => {
            instant
        }
        Course::Bent(_) | Course::Tangled | Course::Jumped => return None,
    };
    let (start, by) = if part.length <= bend {
        (flight.before, part.length)
    } else {
        (flight.after, part.length - whole.length)
    };
    let position = start.position + (start.velocity + 0.5 * fall * by) * by;
    let position = law.periodic.map_or(position, |periodic| periodic.inside(position));
    Some(Disc { position, velocity: (start.velocity + fall * by) / part.scale, ..before })
}
