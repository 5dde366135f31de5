//! What is known of each disc, as arrays: its straight flight, and what rarely changes.
//!
//! A flight begins where the disc last changed its velocity, and times are whole ticks and a rest:
//! a million ticks without a contact then add no rounding. Never decide here who meets whom.

use glam::DVec2;

use crate::world::{Disc, DiscId, Owner, Periodic};

/// An instant: whole ticks since the start, and seconds since the last of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Moment {
    /// A whole number.
    pub tick: f64,
    pub offset: f64,
}

impl Moment {
    /// Before everything.
    pub const NEVER: Self = Self { tick: f64::NEG_INFINITY, offset: 0.0 };

    /// Time since an earlier instant, s.
    #[inline]
    pub fn since(self, earlier: Self, tick_s: f64) -> f64 {
        (self.tick - earlier.tick) * tick_s + (self.offset - earlier.offset)
    }
}

/// A straight flight: all of a disc that a prediction needs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flight {
    pub start: DVec2,
    pub velocity: DVec2,
    pub began: Moment,
    pub radius: f64,
}

impl Flight {
    /// Where the disc is at a moment; in a periodic box it may be at any of its images.
    #[inline(always)]
    pub fn at(&self, moment: Moment, tick_s: f64) -> DVec2 {
        self.start + self.velocity * moment.since(self.began, tick_s)
    }
}

/// The rest of a disc.
#[derive(Clone, Copy, Debug)]
pub(super) struct Body {
    pub id: DiscId,
    pub owner: Owner,
    pub mass: f64,
    pub last_contact: Moment,
    /// Contacts in a row, each within the contact time of the one before.
    pub quick_contacts: u32,
}

impl Body {
    pub fn is_simulated(&self) -> bool {
        self.owner == Owner::Simulated
    }

    /// Whether a contact of the two is ours to resolve and would change one of them.
    pub fn can_collide_with(&self, other: &Self) -> bool {
        let ours = self.is_simulated() || other.is_simulated();
        ours && (self.mass.is_finite() || other.mass.is_finite())
    }

    /// Whether its energy counts, and changes only by known amounts.
    pub fn is_closed(&self) -> bool {
        self.is_simulated() && self.mass.is_finite()
    }
}

/// A disc as it is when a window begins: what all predictions there start from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub position: DVec2,
    pub velocity: DVec2,
    pub radius: f64,
    pub speed: f64,
}

/// How large and fast discs are when a window begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sizes {
    /// m.
    pub radius_mean: f64,
    /// m.
    pub radius_max: f64,
    /// m/s.
    pub speed_mean: f64,
    /// Of all components of velocities, m/s; only in a periodic box.
    pub component_max: f64,
}

/// All discs, in the order in which they came.
#[derive(Clone, Debug)]
pub(super) struct Bodies {
    tick_s: f64,
    periodic: Option<Periodic>,
    pub flights: Vec<Flight>,
    pub bodies: Vec<Body>,
    /// As of the last look.
    pub seen: Vec<Seen>,
    /// Where the disc of an id is, by ids.
    by_id: Vec<(DiscId, u32)>,
    /// The place after the one last found: commands tend to come in the order of the discs.
    guess: usize,
}

impl Bodies {
    /// No discs yet.
    pub fn new(tick_s: f64, periodic: Option<Periodic>) -> Self {
        Self {
            tick_s,
            periodic,
            flights: Vec::new(),
            bodies: Vec::new(),
            seen: Vec::new(),
            by_id: Vec::new(),
            guess: 0,
        }
    }

    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Adds a disc as it is at a moment.
    pub fn add(&mut self, disc: &Disc, owner: Owner, began: Moment) {
        let place = self.by_id.partition_point(|(id, _)| *id <= disc.id);
        self.by_id.insert(place, (disc.id, self.len() as u32));
        let Disc { position: start, velocity, radius, .. } = *disc;
        self.flights.push(Flight { start, velocity, began, radius });
        self.bodies.push(Body {
            id: disc.id,
            owner,
            mass: disc.mass,
            last_contact: Moment::NEVER,
            quick_contacts: 0,
        });
    }

    /// Takes discs out.
    pub fn retain(&mut self, stays: impl Fn(&Body) -> bool) {
        let mut stay = self.bodies.iter().map(&stays);
        self.flights.retain(|_| stay.next() == Some(true));
        self.bodies.retain(stays);
        self.by_id.clear();
        self.by_id.extend((0..).zip(&self.bodies).map(|(k, body)| (body.id, k)));
        self.by_id.sort_unstable();
    }

    /// The place of a disc of an owner.
    #[inline]
    pub fn find(&mut self, id: DiscId, owner: Owner) -> Option<usize> {
        let is_it = |body: &Body| body.id == id && body.owner == owner;
        let place = if self.bodies.get(self.guess).is_some_and(is_it) {
            self.guess
        } else {
            let first = self.by_id.partition_point(|(other, _)| *other < id);
            let same = self.by_id[first..].iter().take_while(|(other, _)| *other == id);
            same.map(|(_, k)| *k as usize).find(|&k| is_it(&self.bodies[k]))?
        };
        self.guess = place + 1;
        Some(place)
    }

    /// A disc at a moment; in a periodic box it may be any of its images.
    #[inline]
    pub fn at(&self, k: usize, moment: Moment) -> Disc {
        let (flight, body) = (&self.flights[k], &self.bodies[k]);
        Disc {
            id: body.id,
            position: flight.at(moment, self.tick_s),
            velocity: flight.velocity,
            radius: flight.radius,
            mass: body.mass,
        }
    }

    /// A place as the periodic box shows it.
    #[inline]
    pub fn inside(&self, position: DVec2) -> DVec2 {
        self.periodic.map_or(position, |periodic| periodic.inside(position))
    }

    /// The image of a disc that is nearest to a place.
    pub fn near(&self, place: DVec2, disc: Disc) -> Disc {
        let Some(periodic) = self.periodic else { return disc };
        let shift = periodic.shift(disc.position - place);
        Disc { position: disc.position + shift, ..disc }
    }

    /// Begins a new flight where a disc is at a moment; returns the disc.
    #[inline]
    pub fn move_to(&mut self, k: usize, moment: Moment) -> Disc {
        let disc = self.at(k, moment);
        let position = self.inside(disc.position);
        let flight = &mut self.flights[k];
        (flight.start, flight.began) = (position, moment);
        Disc { position, ..disc }
    }

    /// Looks at all discs as they are at a moment.
    pub fn look(&mut self, moment: Moment) -> Sizes {
        let (tick_s, periodic) = (self.tick_s, self.periodic);
        let (mut radii, mut speeds) = (0.0, 0.0);
        let (mut radius_max, mut component_max) = (0.0f64, 0.0f64);
        self.seen.clear();
        self.seen.extend(self.flights.iter().map(|flight| {
            let Flight { velocity, radius, .. } = *flight;
            let mut position = flight.at(moment, tick_s);
            if let Some(periodic) = periodic {
                position = periodic.inside(position);
                component_max = component_max.max(velocity.abs().max_element());
            }
            let speed = velocity.length();
            radii += radius;
            speeds += speed;
            radius_max = radius_max.max(radius);
            Seen { position, velocity, radius, speed }
        }));
        let count = self.len().max(1) as f64;
        let (radius_mean, speed_mean) = (radii / count, speeds / count);
        Sizes { radius_mean, radius_max, speed_mean, component_max }
    }
}
