//! The event-driven method: exact like [`plain`](super::plain), at a cost per contact that does not
//! grow with the number of discs.
//!
//! Every disc keeps one event, the earlier of its next contact and the end of its stay in its
//! [cell](cells); a [calendar](calendar) says whose is the next. A contact changes two discs, which
//! are predicted again; what other discs expected of these two is not taken back but found out of
//! date when its time comes: the partner then flies otherwise. (After Smallenburg 2022,
//! doi:10.1140/epje/s10189-022-00180-8, without neighbour lists.)
//!
//! Flights are kept as they would have been at the start of the present epoch: to know where a disc
//! is takes one product, and no time of its own. At the end of an epoch all are carried on to the
//! next.
//!
//! The same laws as the plain method, its judge, which agrees event for event until rounding has
//! grown; the arithmetic here has no fused operations, so results have the same bits on every
//! processor and do not depend on the frame rate.

mod calendar;
mod cells;
mod contacts;
mod lanes;
mod predict;

use glam::DVec2;

use super::energy::EnergyAccount;
use super::plain::{Laws, Stall};
use crate::exact::{RunningSum, power_of_two_near};
use crate::world::{Contact, Disc, DiscId, limits};
use calendar::Calendar;
use cells::{Border, Cells, Needs, Place};
use lanes::Unit;

/// Where a disc would have been at the start of the epoch, and its velocity.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Flight {
    x: f64,
    y: f64,
    vx: f64,
    vy: f64,
}

impl Flight {
    fn velocity(&self) -> DVec2 {
        DVec2::new(self.vx, self.vy)
    }

    fn start(&self) -> DVec2 {
        DVec2::new(self.x, self.y)
    }

    #[inline]
    fn at(&self, now: f64) -> DVec2 {
        DVec2::new(self.x + self.vx * now, self.y + self.vy * now)
    }

    /// The flight after a change of velocity at `now`.
    #[inline]
    fn deflect(&mut self, now: f64, by: DVec2) {
        // All four at once: what is written in parts is slow to read whole.
        let was = [self.x, self.y, self.vx, self.vy];
        let (by, times) = ([by.x, by.y, by.x, by.y], [-now, -now, 1.0, 1.0]);
        let [x, y, vx, vy] = std::array::from_fn(|k| was[k] + by[k] * times[k]);
        *self = Self { x, y, vx, vy };
    }

    /// Changes with every contact.
    #[inline]
    fn stamp(&self) -> u32 {
        let mixed = self.vx.to_bits() ^ self.vy.to_bits().rotate_left(29);
        (mixed.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as u32
    }
}

/// What a disc is due for.
#[derive(Clone, Copy, Debug)]
struct Due {
    /// Time of the next contact, s.
    contact: f64,
    /// Time at which it leaves its cell, s.
    exit: f64,
    /// The disc or wall that it meets.
    partner: u32,
    /// How that disc flew when the contact was predicted.
    stamp: u32,
    place: Place,
}

/// In `Due::partner`: another contact comes at the same instant.
const TIE: u32 = 1 << 31;
/// In `Due::partner`: from here on walls, in the order of `SIDES`.
const WALL: u32 = 1 << 30;
/// In `Due::partner`: nothing.
const NOTHING: u32 = WALL | 0xff;

impl Due {
    #[inline]
    fn time(&self) -> f64 {
        self.contact.min(self.exit)
    }
}

/// A quantity of all discs: one number where they are equal.
#[derive(Clone, Debug)]
enum Each {
    Same(f64),
    Own(Vec<f64>),
}

impl Each {
    fn of(values: impl Iterator<Item = f64> + Clone) -> Self {
        let first = values.clone().next().unwrap_or(1.0);
        if values.clone().all(|value| value == first) {
            Self::Same(first)
        } else {
            Self::Own(values.collect())
        }
    }

    #[inline]
    fn get(&self, k: usize) -> f64 {
        match self {
            Self::Same(value) => *value,
            Self::Own(values) => values[k],
        }
    }

    fn own(&self) -> &[f64] {
        match self {
            Self::Same(_) => &[],
            Self::Own(values) => values,
        }
    }
}

/// The state of an arena under the event-driven method.
#[derive(Clone, Debug)]
pub struct Events {
    laws: Laws,
    flights: Vec<Flight>,
    dues: Vec<Due>,
    radii: Each,
    masses: Each,
    ids: Vec<DiscId>,
    cells: Cells,
    calendar: Calendar,
    near: Vec<u32>,
    /// Start of the epoch, s.
    base: f64,
    /// The present, s from the start of the epoch.
    now: f64,
    /// Events since the start of the epoch.
    events: u64,
    /// Whether what comes next is fetched from memory in advance.
    ahead: bool,
    energy: EnergyAccount,
    overlap: f64,
    contacts: u64,
}

/// Entries of a day when it comes: few enough to sort in the first cache.
fn entries_per_day(discs: usize) -> f64 {
    (discs as f64 / 32.0).clamp(32.0, 512.0)
}

/// Mean times between contacts of a disc in an epoch.
const EPOCH: f64 = 8.0;

impl Events {
    /// An arena at time 0. `epoch` (s) is a guess at the time between contacts of a disc.
    pub fn new(laws: Laws, discs: &[Disc], epoch: f64) -> Self {
        let flight = |disc: &Disc| {
            let DVec2 { x, y } = disc.position;
            Flight { x, y, vx: disc.velocity.x, vy: disc.velocity.y }
        };
        let cells = Cells::new(&needs(&laws, discs));
        let (day, days) = days(epoch, discs.len());
        let mut energy = EnergyAccount::default();
        energy.book(discs.iter().map(Disc::kinetic_energy).collect::<RunningSum>().value());
        let mut arena = Self {
            laws,
            flights: discs.iter().map(flight).collect(),
            dues: Vec::new(),
            radii: Each::of(discs.iter().map(|disc| disc.radius)),
            masses: Each::of(discs.iter().map(|disc| disc.mass)),
            ids: discs.iter().map(|disc| disc.id).collect(),
            cells,
            calendar: Calendar::new(day, days, discs.len()),
            near: Vec::new(),
            base: 0.0,
            now: 0.0,
            events: 0,
            ahead: discs.len() > 20_000,
            energy,
            overlap: 0.0,
            contacts: 0,
        };
        arena.place_all();
        lanes::predict_all(&mut arena);
        arena
    }

    /// The present, s since the start.
    pub fn now(&self) -> f64 {
        self.base + self.now
    }

    /// The discs as they are now, in the order in which they came.
    pub fn discs(&self) -> impl Iterator<Item = Disc> + '_ {
        (0..self.flights.len()).map(|k| self.disc(k))
    }

    /// Kinetic energy, J.
    pub fn kinetic_energy(&self) -> f64 {
        self.discs().map(|disc| disc.kinetic_energy()).collect::<RunningSum>().value()
    }

    /// Signed relative energy error, with all work accounted for.
    pub fn relative_energy_drift(&self) -> f64 {
        self.energy.relative_drift(self.kinetic_energy())
    }

    /// Largest overlap of a pair at any contact, in units of the smaller radius.
    pub fn largest_overlap(&self) -> f64 {
        self.overlap
    }

    /// Contacts since the start, pairs and walls.
    pub fn contacts(&self) -> u64 {
        self.contacts
    }

    /// Moves on to `until` (s) and adds the contacts on the way; nothing happens if that is past.
    ///
    /// Stops short of `until` after [`limits::EVENTS_PER_ADVANCE`] events: [`Self::now`] tells,
    /// and calling again goes on.
    ///
    /// # Errors
    /// [`Stall`] when endlessly many contacts fall on one instant; the arena then stands there.
    pub fn advance(&mut self, until: f64, contacts: &mut Vec<Contact>) -> Result<(), Stall> {
        lanes::advance(self, until, contacts)
    }

    /// The same, to be compiled for each kind of processor.
    #[inline(always)]
    fn advance_with<U: Unit>(&mut self, until: f64, contacts: &mut Vec<Contact>) -> Result<(), Stall> {
        for _ in 0..limits::EVENTS_PER_ADVANCE {
            if !self.step::<U>(until, contacts) {
                // An event's time may have rounded to just after `until`.
                self.now = self.now.max(until - self.base);
                return Ok(());
            }
        }
        Ok(())
    }

    /// The next event; `false` if none comes before `until`.
    #[inline(always)]
    fn step<U: Unit>(&mut self, until: f64, contacts: &mut Vec<Contact>) -> bool {
        let latest = until - self.base;
        loop {
            let Some(&entry) = self.calendar.open().last() else {
                if !self.turn_page(until) {
                    return false;
                }
                continue;
            };
            let k = self.calendar.disc(entry);
            let due = self.dues[k];
            let time = due.time();
            if !self.calendar.holds(entry, time) {
                self.calendar.pop();
                continue;
            }
            if time > latest {
                return false;
            }
            self.calendar.pop();
            if self.ahead {
                self.fetch_ahead();
            }
            self.now = self.now.max(time);
            self.events += 1;
            if due.contact <= due.exit {
                self.meet::<U>(k, due, contacts);
            } else {
                self.change_cell::<U>(k, due);
            }
            return true;
        }
    }

    /// Goes on to the next day, or epoch; `false` if that comes after `until`.
    #[cold]
    fn turn_page(&mut self, until: f64) -> bool {
        if self.base + self.calendar.tomorrow() > until {
            return false;
        }
        if self.calendar.is_last_day() {
            self.next_epoch(until);
            return true;
        }
        let dues = &self.dues;
        self.calendar.next_day(|k| dues[k].time());
        true
    }

    fn next_epoch(&mut self, _until: f64) {
        let epoch = self.calendar.epoch();
        self.base += epoch;
        self.now = (self.now - epoch).max(0.0);
        for (flight, due) in self.flights.iter_mut().zip(&mut self.dues) {
            (flight.x, flight.y) = (flight.x + flight.vx * epoch, flight.y + flight.vy * epoch);
            due.contact -= epoch;
            due.exit -= epoch;
        }
        let (day, days) = (self.calendar.day(), days_of(self.flights.len()));
        let mean = self.events as f64 / self.calendar.epoch() * day;
        let wanted = entries_per_day(self.flights.len());
        let factor = power_of_two_near((wanted / mean.max(1e-3 * wanted)).sqrt());
        let _ = factor;
        self.events = 0;
        self.calendar.restart(day, days);
        for (k, due) in self.dues.iter().enumerate() {
            self.calendar.insert(due.time(), k);
        }
    }

    fn disc(&self, k: usize) -> Disc {
        let flight = &self.flights[k];
        Disc {
            id: self.ids[k],
            position: flight.at(self.now),
            velocity: flight.velocity(),
            radius: self.radii.get(k),
            mass: self.masses.get(k),
        }
    }
}

fn needs(laws: &Laws, discs: &[Disc]) -> Needs {
    let diameter = 2.0 * discs.iter().map(|disc| disc.radius).fold(0.0, f64::max);
    let (min, max, border) = match (laws.walls, laws.periodic) {
        (Some(walls), _) => (walls.min, walls.max, Border::Closed),
        (_, Some(periodic)) => (periodic.min, periodic.max, Border::Periodic(periodic)),
        _ => (DVec2::ZERO, DVec2::ONE, Border::Open),
    };
    let density = discs.len() as f64 / (max - min).element_product();
    Needs { min, max, diameter, density, border }
}

fn days_of(discs: usize) -> usize {
    ((EPOCH * discs as f64 / entries_per_day(discs)) as usize).next_power_of_two().max(16)
}

/// Length of a day, s, and days in an epoch.
fn days(epoch: f64, discs: usize) -> (f64, usize) {
    let days = days_of(discs);
    (power_of_two_near(EPOCH * epoch / days as f64), days)
}
