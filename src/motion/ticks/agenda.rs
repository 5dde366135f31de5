//! What is predicted to happen within a window: a heap in order of time, and a chain for each disc,
//! so that what else a disc does at an instant is found without a look at everybody's events.
//!
//! An event is void as soon as one of its discs flies differently; it stays until it comes up.
//! Never predict here.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::world::Side;

/// What a disc meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum With {
    Wall(Side),
    /// A segment, by its place.
    Segment(u32),
    Body(u32),
}

/// A predicted event.
#[derive(Clone, Copy, Debug)]
pub(super) struct Event {
    /// Offset, s.
    pub time: f64,
    /// The disc with the smaller index.
    pub first: u32,
    pub with: With,
    /// Changes of the two discs when this was predicted.
    changes: [u32; 2],
    /// The events of the two discs before this.
    before: [u32; 2],
}

/// The place of an event in order: the earliest first, of equals that of the smallest index, and
/// its walls before its partners.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Turn {
    /// Bits of the offset: ordered as offsets are, since none is below 0.
    time: u64,
    first: u32,
    with: With,
    /// Index of the event.
    event: u32,
}

/// The last event of a disc, and how often its flight has changed.
#[derive(Clone, Copy, Debug)]
struct Chain {
    last: u32,
    changes: u32,
}

/// No event.
const NONE: u32 = u32::MAX;

/// All events of a window.
#[derive(Clone, Debug, Default)]
pub(super) struct Agenda {
    heap: BinaryHeap<Reverse<Turn>>,
    events: Vec<Event>,
    chains: Vec<Chain>,
}

impl Agenda {
    /// Begins anew with so many discs.
    pub fn clear(&mut self, discs: usize) {
        self.heap.clear();
        self.events.clear();
        self.chains.clear();
        self.chains.resize(discs, Chain { last: NONE, changes: 0 });
    }

    /// Makes all events of a disc void.
    pub fn void(&mut self, k: usize) {
        let chain = &mut self.chains[k];
        *chain = Chain { last: NONE, changes: chain.changes + 1 };
    }

    /// Adds an event at an offset, at least 0.
    pub fn add(&mut self, time: f64, first: usize, with: With) {
        let event = self.events.len() as u32;
        let second = second(first, with);
        let [a, b] = [first, second].map(|k| self.chains[k]);
        let (changes, before) = ([a.changes, b.changes], [a.last, b.last]);
        let first = first as u32;
        self.events.push(Event { time, first, with, changes, before });
        self.chains[first as usize].last = event;
        self.chains[second].last = event;
        // Adding 0 makes a 0 of the other sign the usual one.
        let time = (time + 0.0).to_bits();
        self.heap.push(Reverse(Turn { time, first, with, event }));
    }

    /// The next event up to an offset, taken out.
    pub fn next(&mut self, latest: f64) -> Option<Event> {
        while let Some(Reverse(turn)) = self.heap.peek()
            && f64::from_bits(turn.time) <= latest
        {
            let event = self.events[turn.event as usize];
            self.heap.pop();
            if self.is_valid(&event) {
                return Some(event);
            }
        }
        None
    }

    /// All valid events of a disc, and perhaps some that have come up.
    pub fn of(&self, k: usize) -> impl Iterator<Item = &Event> {
        let mut next = self.chains[k].last;
        let all = std::iter::from_fn(move || {
            let event = self.events.get(next as usize)?;
            next = event.before[usize::from(event.first as usize != k)];
            Some(event)
        });
        all.filter(|event| self.is_valid(event))
    }

    /// Whether the discs of an event fly as they did when it was predicted.
    fn is_valid(&self, event: &Event) -> bool {
        let first = event.first as usize;
        [first, second(first, event.with)].map(|k| self.chains[k].changes) == event.changes
    }
}

/// The other disc of an event, or the same.
fn second(first: usize, with: With) -> usize {
    match with {
        With::Wall(_) | With::Segment(_) => first,
        With::Body(k) => k as usize,
    }
}
