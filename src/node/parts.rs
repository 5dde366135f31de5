//! Large messages in parts, sent one after another with pauses.
//!
//! Fast DDS receives into a socket buffer of 212 992 bytes by default, of which a datagram of a
//! network's size takes half as much again; what RustDDS sends at once beyond it is lost, reliable
//! or not. And a reader keeps ten messages by default. So a part is small, and the pause lets it be
//! read. A message that comes before the last one on its topic is through is skipped and counted:
//! what arrives is whole.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use crate::messages::{CircleStates, CircleVelocities, Contacts, Crashes, Header};

/// Largest payload of a part, bytes.
const PART_BYTES: usize = 50_000;
/// Between two parts: twice what rclpy needs to read one.
pub const PAUSE: Duration = Duration::from_millis(6);

/// A message that may come in parts.
pub trait InParts: Sized {
    /// What the parts divide.
    type Item: Clone;
    /// Bytes of an item on the wire.
    const ITEM_BYTES: usize;

    /// Header and items.
    fn open(self) -> (Header, Vec<Self::Item>);

    /// One part.
    fn part(header: Header, part: u32, parts: u32, items: Vec<Self::Item>) -> Self;
}

macro_rules! in_parts {
    ($($message:ident $items:ident: $item:ty, $bytes:literal;)*) => {$(
        impl InParts for $message {
            type Item = $item;
            const ITEM_BYTES: usize = $bytes;

            fn open(self) -> (Header, Vec<$item>) {
                (self.header, self.$items)
            }

            fn part(header: Header, part: u32, parts: u32, $items: Vec<$item>) -> Self {
                Self { header, part, parts, $items }
            }
        }
    )*};
}

in_parts! {
    CircleStates circles: crate::messages::CircleState, 56;
    CircleVelocities velocities: crate::messages::CircleVelocity, 24;
    Contacts contacts: crate::messages::Contact, 80;
    Crashes crashes: crate::messages::Crash, 64;
}

/// The parts of a message; one that is small stays whole, with `parts` 0.
pub fn split<M: InParts>(message: M) -> Vec<M> {
    let (header, items) = message.open();
    let at_most = PART_BYTES / M::ITEM_BYTES;
    if items.len() <= at_most {
        return vec![M::part(header, 0, 0, items)];
    }
    let count = items.len().div_ceil(at_most);
    let parts = items.chunks(items.len().div_ceil(count)).enumerate();
    // Far fewer than 2^32: messages have at most some hundred thousand items.
    let number = |k: usize| u32::try_from(k).unwrap_or(u32::MAX);
    let parts =
        parts.map(|(k, chunk)| M::part(header.clone(), number(k), number(count), chunk.to_vec()));
    parts.collect()
}

/// The parts of one topic that wait for their turn.
#[derive(Debug)]
pub struct Waiting<M> {
    parts: VecDeque<M>,
    due: Option<Instant>,
    dropped: u64,
}

impl<M: InParts> Default for Waiting<M> {
    fn default() -> Self {
        Self { parts: VecDeque::new(), due: None, dropped: 0 }
    }
}

impl<M: InParts> Waiting<M> {
    /// Takes a message; what is to be sent of it at once. It is skipped while parts of the one
    /// before are waiting.
    pub fn take(&mut self, message: M, now: Instant) -> Option<M> {
        if !self.parts.is_empty() {
            self.dropped += 1;
            return None;
        }
        self.parts = split(message).into();
        let first = self.parts.pop_front();
        self.due = (!self.parts.is_empty()).then(|| now + PAUSE);
        first
    }

    /// When the next part is to be sent.
    pub fn due(&self) -> Option<Instant> {
        self.due
    }

    /// The next part, if its time has come.
    pub fn next(&mut self, now: Instant) -> Option<M> {
        if self.due.is_none_or(|due| now < due) {
            return None;
        }
        let part = self.parts.pop_front();
        // From now, though this one may be late: two at once would fill the reader's socket.
        self.due = (!self.parts.is_empty()).then(|| now + PAUSE);
        part
    }

    /// Messages that were skipped, since the start.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::CircleState;

    fn states(count: u32) -> CircleStates {
        let circles = (0..count).map(|id| CircleState { id, ..CircleState::default() }).collect();
        CircleStates { circles, ..CircleStates::default() }
    }

    #[test]
    fn parts_hold_everything_once_and_are_small() {
        for count in [0, 1, 892, 893, 10_000, 100_000] {
            let parts = split(states(count));
            let whole = parts.len() == 1;
            assert_eq!(whole, count <= 892, "{count}");
            let ids: Vec<u32> =
                parts.iter().flat_map(|part| part.circles.iter().map(|circle| circle.id)).collect();
            assert_eq!(ids, (0..count).collect::<Vec<_>>());
            for (k, part) in parts.iter().enumerate() {
                assert!(part.circles.len() * 56 <= PART_BYTES);
                let numbers = (part.part as usize, part.parts as usize);
                assert_eq!(numbers, if whole { (0, 0) } else { (k, parts.len()) });
            }
        }
    }

    #[test]
    fn parts_wait_and_no_message_comes_between_them() {
        let (start, mut waiting) = (Instant::now(), Waiting::default());
        assert_eq!(waiting.take(states(2_000), start).map(|part| part.part), Some(0));
        assert!(waiting.next(start).is_none());
        assert_eq!(waiting.next(start + PAUSE).map(|part| part.part), Some(1));
        assert!(waiting.take(states(10), start + PAUSE).is_none());
        assert_eq!(waiting.next(start + PAUSE * 2).map(|part| part.part), Some(2));
        assert_eq!((waiting.dropped(), waiting.due()), (1, None));
        assert!(waiting.next(start + PAUSE * 9).is_none());
        assert_eq!(waiting.take(states(10), start + PAUSE * 9).map(|part| part.parts), Some(0));
    }
}
