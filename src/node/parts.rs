//! Large messages in parts, sent one after another with pauses.
//!
//! Fast DDS receives into a socket buffer of 212 992 bytes by default, of which a datagram of a
//! network's size takes half as much again; what RustDDS sends at once beyond it is lost, reliable
//! or not. And a reader keeps ten messages by default. So a part fits into the buffer with room to
//! spare, parts are few, so that ten of them last long, and pauses spread them over the time that
//! there is until the next message. A message that comes while much of the last one on its topic
//! waits is skipped and counted: what arrives is whole.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use crate::messages::{CircleStates, CircleVelocities, Contacts, Crashes, Header};

/// Largest payload of a part, bytes.
const PART_BYTES: usize = 100_000;
/// Between two parts at least: twice what rclpy needs to read one.
pub const PAUSE_MIN: Duration = Duration::from_millis(12);
/// At most: who reads the last part shall not wait long for it.
const PAUSE_MAX: Duration = Duration::from_millis(20);
/// Of the time between two messages, what the pauses of one take: the rest is for parts that come
/// late.
const SPREAD: f64 = 0.8;

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
    pause: Duration,
    due: Option<Instant>,
    /// When the last message came.
    taken_at: Option<Instant>,
    dropped: u64,
}

impl<M: InParts> Default for Waiting<M> {
    fn default() -> Self {
        let (parts, pause) = (VecDeque::new(), PAUSE_MIN);
        Self { parts, pause, due: None, taken_at: None, dropped: 0 }
    }
}

impl<M: InParts> Waiting<M> {
    /// Takes a message; what is to be sent of it at once. It is skipped while more than half of
    /// the one before is waiting.
    pub fn take(&mut self, message: M, now: Instant) -> Option<M> {
        let parts = split(message);
        let since = self.taken_at.replace(now).map(|before| now - before);
        if self.parts.len() > parts.len() / 2 {
            self.dropped += 1;
            return None;
        }
        let each = since.unwrap_or_default().mul_f64(SPREAD / parts.len() as f64);
        self.pause = each.clamp(PAUSE_MIN, PAUSE_MAX);
        self.parts.extend(parts);
        if self.due.is_some() {
            return None;
        }
        self.pop(now)
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
        self.pop(now)
    }

    fn pop(&mut self, now: Instant) -> Option<M> {
        let part = self.parts.pop_front();
        // From now, though this one may be late: two at once would fill the reader's socket.
        self.due = (!self.parts.is_empty()).then(|| now + self.pause);
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
        for count in [0, 1, 1785, 1786, 10_000, 100_000] {
            let parts = split(states(count));
            let whole = parts.len() == 1;
            assert_eq!(whole, count <= 1785, "{count}");
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
    fn parts_wait_and_few_messages_wait_behind_them() {
        let (start, mut waiting) = (Instant::now(), Waiting::default());
        let after = |pauses: u32| start + PAUSE_MIN * pauses;
        assert_eq!(waiting.take(states(4_000), start).map(|part| part.part), Some(0));
        assert!(waiting.next(start).is_none());
        assert!(waiting.take(states(4_000), start).is_none());
        assert_eq!(waiting.next(after(1)).map(|part| part.part), Some(1));
        assert_eq!(waiting.dropped(), 1);
        // One part of three is left.
        assert!(waiting.take(states(4_000), after(1)).is_none());
        let rest: Vec<u32> =
            (2..=5).map(|k| waiting.next(after(k)).map_or(9, |part| part.part)).collect();
        assert_eq!((rest, waiting.dropped(), waiting.due()), (vec![2, 0, 1, 2], 1, None));
        assert!(waiting.next(after(9)).is_none());
        assert_eq!(waiting.take(states(10), after(9)).map(|part| part.parts), Some(0));
    }

    #[test]
    fn pauses_spread_parts_over_the_time_between_messages() {
        let (start, mut waiting) = (Instant::now(), Waiting::default());
        let mut now = start;
        for millis in [0, 100, 40, 1_000] {
            now += Duration::from_millis(millis);
            assert_eq!(waiting.take(states(10_000), now).map(|part| part.parts), Some(6));
            let pause = waiting.due().map(|due| (due - now).as_millis());
            let wanted = match millis {
                100 => 13,
                1_000 => 20,
                _ => 12,
            };
            assert_eq!(pause, Some(wanted), "{millis} ms");
            (1..=5).for_each(|k| assert!(waiting.next(now + PAUSE_MAX * k).is_some()));
        }
    }
}
