//! An arena watched from afar: looks are taken of it, cheaply, and told somewhere else.
//!
//! Between two looks few discs of many have met anybody. The arena notes who did, so a look is what
//! flies otherwise since the one before, and who hears all looks knows all discs: the same bits as
//! [`Arena::discs`] gives. Where discs do not fly straight, a look is all of them.

use super::arena::Arena;
pub use super::events::rows::Turn;
use super::events::rows::{LookNumber, Rows, Seen};
use crate::world::{Disc, Owner};

/// Who looks at an arena, and remembers what it has told.
#[derive(Clone, Debug, Default)]
pub struct Watcher {
    last: Option<LookNumber>,
}

/// What a watcher tells of the simulated discs, besides turns.
#[derive(Clone, Debug)]
pub struct Look(Told);

#[derive(Clone, Debug)]
enum Told {
    /// They are these.
    Discs(Vec<Disc>),
    /// They are these, or so many turned, at an instant of the epoch, s.
    Seen(Seen, f64),
}

/// Who hears what a watcher tells, all of it and in order.
#[derive(Clone, Debug, Default)]
pub struct Listener {
    heard: Option<Rows>,
}

impl Watcher {
    /// Looks at the discs of an arena, which may be another one each time. Who turned is put
    /// behind the turns that are there: whoever looks often has room for them.
    pub fn look(&mut self, arena: &mut Arena, turns: &mut Vec<Turn>) -> Look {
        if let Arena::Events(events) = arena
            && let Some((seen, now)) = events.look(&mut self.last, turns)
        {
            return Look(Told::Seen(seen, now));
        }
        self.last = None;
        Look(Told::Discs(arena.discs(Owner::Simulated).collect()))
    }
}

impl Look {
    /// How many turns belong to it.
    pub fn turns(&self) -> usize {
        match self.0 {
            Told::Seen(Seen::Turns(count), _) => count,
            _ => 0,
        }
    }

    /// What it takes with its turns, bytes.
    pub fn bytes(&self) -> usize {
        match &self.0 {
            Told::Discs(discs) => size_of_val(discs.as_slice()),
            Told::Seen(Seen::Rows(rows), _) => rows.bytes(),
            Told::Seen(Seen::Turns(count), _) => count * size_of::<Turn>(),
        }
    }
}

impl Listener {
    /// The discs of a look and of its turns, in the order of [`Arena::discs`].
    ///
    /// # Panics
    /// If a look was left out.
    pub fn hear(&mut self, look: Look, turns: &[Turn]) -> Box<dyn Iterator<Item = Disc> + '_> {
        let now = match look.0 {
            Told::Discs(discs) => return Box::new(discs.into_iter()),
            Told::Seen(Seen::Rows(rows), now) => {
                self.heard = Some(*rows);
                now
            }
            Told::Seen(Seen::Turns(_), now) => now,
        };
        // A watcher begins with rows.
        let rows = self.heard.as_mut().expect("the looks before");
        rows.turn(turns);
        Box::new(rows.discs(now))
    }
}
