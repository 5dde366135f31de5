//! The discs as rows that stand for themselves: a copy tells the same discs, bit for bit, while it
//! hears who turned since. For [watchers](crate::motion::watch).
//!
//! Only where discs fly straight and are all simulated: of others there are no rows.

use std::sync::atomic::{AtomicU64, Ordering};

use super::{Each, Events, Flight};
use crate::world::{Disc, DiscId, Owner, Periodic};

/// What the discs are and how they fly.
#[derive(Clone, Debug)]
pub struct Rows {
    ids: Vec<DiscId>,
    radii: Each,
    masses: Each,
    flights: Vec<Flight>,
    periodic: Option<Periodic>,
}

/// A disc that flies otherwise than before.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    disc: u32,
    /// Not a [`Flight`], whose alignment would half fill a list of these with nothing.
    flight: [f64; 4],
}

impl Rows {
    /// The discs at an instant, s since the start of the epoch.
    pub fn discs(&self, now: f64) -> impl Iterator<Item = Disc> + '_ {
        self.flights.iter().enumerate().map(move |(k, flight)| {
            let position = flight.at(now);
            Disc {
                id: self.ids[k],
                position: self.periodic.map_or(position, |periodic| periodic.inside(position)),
                velocity: flight.velocity(),
                radius: self.radii.get(k),
                mass: self.masses.get(k),
            }
        })
    }

    /// What they take, bytes.
    pub fn bytes(&self) -> usize {
        self.flights.len() * size_of::<Disc>()
    }

    /// Follows the arena.
    pub fn turn(&mut self, turns: &[Turn]) {
        for Turn { disc, flight: [x, y, vx, vy] } in turns {
            self.flights[*disc as usize] = Flight { x: *x, y: *y, vx: *vx, vy: *vy };
        }
    }
}

/// What a look at an arena tells.
#[derive(Clone, Debug)]
pub enum Seen {
    /// All discs.
    Rows(Box<Rows>),
    /// So many fly otherwise than at the look before.
    Turns(usize),
}

/// A look at an arena, like no other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LookNumber(u64);

/// Who turned since the last look, while somebody looks: noted where a flight changes, for it costs
/// more to compare all of them.
#[derive(Clone, Debug, Default)]
pub(super) struct Noted {
    look: Option<LookNumber>,
    /// Some of them more than once.
    discs: Vec<u32>,
    /// With more turns than discs the list would save nothing.
    most: usize,
}

impl LookNumber {
    fn next() -> Self {
        static LOOKS: AtomicU64 = AtomicU64::new(0);
        Self(LOOKS.fetch_add(1, Ordering::Relaxed))
    }
}

impl Noted {
    /// Takes note of discs that fly otherwise.
    #[inline(always)]
    pub fn turn(&mut self, discs: &[usize]) {
        if self.look.is_some() {
            self.note(discs);
        }
    }

    #[inline(never)]
    fn note(&mut self, discs: &[usize]) {
        if self.discs.len() + discs.len() > self.most {
            return self.forget();
        }
        // A scene has far fewer than 2^32 pucks.
        self.discs.extend(discs.iter().map(|&k| k as u32));
    }

    /// All may fly otherwise, or be others: the next look is one at all.
    pub fn forget(&mut self) {
        self.look = None;
        self.discs.clear();
    }

    fn begin(&mut self, look: LookNumber, discs: usize) {
        self.look = Some(look);
        self.discs.clear();
        self.most = discs;
    }
}

impl Events {
    /// Looks at the discs, of which those are known that the last look told, if it was one at this
    /// arena; nothing if they are no rows. With it the present, s since the start of the epoch.
    pub fn look(
        &mut self,
        last: &mut Option<LookNumber>,
        turns: &mut Vec<Turn>,
    ) -> Option<(Seen, f64)> {
        let seen = if last.is_some() && self.noted.look == *last {
            turns.extend(self.noted.discs.iter().map(|&disc| self.turn_of(disc)));
            Seen::Turns(self.noted.discs.len())
        } else {
            Seen::Rows(Box::new(self.rows()?))
        };
        let look = LookNumber::next();
        self.noted.begin(look, self.flights.len());
        *last = Some(look);
        Some((seen, self.now))
    }

    fn turn_of(&self, disc: u32) -> Turn {
        let Flight { x, y, vx, vy } = self.flights[disc as usize];
        Turn { disc, flight: [x, y, vx, vy] }
    }

    fn rows(&self) -> Option<Rows> {
        let are_rows = self.fall.is_none() && self.owners.iter().all(|o| *o == Owner::Simulated);
        are_rows.then(|| Rows {
            ids: self.ids.clone(),
            radii: self.radii.clone(),
            masses: self.masses.clone(),
            flights: self.flights.clone(),
            periodic: self.laws.periodic,
        })
    }
}
