//! The discs as rows that stand for themselves: a copy tells the same discs, bit for bit, and what
//! changed since it was made is found by looking at it. For [watchers](crate::motion::watch).
//!
//! Only where discs fly straight and are all simulated: of others there are no rows.

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

/// Of so many discs one turns between two looks, as a first guess.
const DISCS_PER_TURN: usize = 8;

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

impl Events {
    /// Its rows, if there are any, and the present, s since the start of the epoch.
    pub fn rows(&self) -> Option<(Rows, f64)> {
        let has_rows = self.fall.is_none() && self.owners.iter().all(|o| *o == Owner::Simulated);
        has_rows.then(|| {
            let rows = Rows {
                ids: self.ids.clone(),
                radii: self.radii.clone(),
                masses: self.masses.clone(),
                flights: self.flights.clone(),
                periodic: self.laws.periodic,
            };
            (rows, self.now)
        })
    }

    /// What flies otherwise than in the rows, which then are those of now, and the present, s since
    /// the start of the epoch; nothing if these are not the rows of its discs.
    pub fn turns(&self, rows: &mut Rows) -> Option<(Vec<Turn>, f64)> {
        let same = self.fall.is_none()
            && self.owners.iter().all(|owner| *owner == Owner::Simulated)
            && rows.periodic == self.laws.periodic
            && rows.ids == self.ids
            && rows.radii == self.radii
            && rows.masses == self.masses;
        if !same {
            return None;
        }
        let mut turns = Vec::with_capacity(self.flights.len() / DISCS_PER_TURN);
        let pairs = self.flights.iter().zip(&mut rows.flights);
        for (disc, (flight, row)) in pairs.enumerate() {
            if flight.bits() != row.bits() {
                *row = *flight;
                // A scene has far fewer than 2^32 pucks.
                turns.push(Turn { disc: disc as u32, flight: flight.numbers() });
            }
        }
        Some((turns, self.now))
    }
}

impl Flight {
    /// Not the numbers: -0 is another 0, and tells another disc.
    fn bits(&self) -> [u64; 4] {
        self.numbers().map(f64::to_bits)
    }

    fn numbers(&self) -> [f64; 4] {
        [self.x, self.y, self.vx, self.vy]
    }
}
