//! The event-driven method: exact like [`plain`](super::plain), at a cost per contact that does not
//! grow with the number of discs.
//!
//! Every disc keeps one event, the earlier of its next contact and the end of its stay in its
//! cell; a calendar says whose is the next. A contact changes two discs, which are predicted again;
//! what other discs expected of these two is not taken back but found out of date when its time
//! comes: the partner then flies otherwise. (After Smallenburg,
//! doi:10.1140/epje/s10189-022-00180-8, with cells instead of neighbour lists.) Where sizes differ
//! so much that cells for the largest discs would be crowded, there are several levels of them.
//!
//! Flights are kept as they would have been at the start of the present epoch: to know where a disc
//! is takes one product, and no time of its own. At the end of an epoch all are carried on to the
//! next, and the days of the calendar are fitted to what happened.
//!
//! Under gravity flights are kept as if there were none, and what it adds is for `fall`. Of line
//! segments a disc looks for those that it may touch while it is in its cell: `segments`.
//!
//! The laws and policies are those of the plain method, its judge, which agrees event for event
//! until rounding has grown; extreme units are left to that. The arithmetic has no
//! fused operations but those written down, so results have the same bits on every processor; they
//! do not depend on the frame rate.

mod again;
mod calendar;
mod cells;
mod come;
mod contacts;
mod edit;
mod fall;
mod lanes;
mod levels;
mod pages;
mod predict;
pub mod rows;
mod segments;
mod together;

use std::cmp::Ordering;
use std::collections::HashMap;

use glam::DVec2;

use super::energy::EnergyAccount;
use super::momentum::MomentumAccount;
use super::plain::{Laws, Stall};
use super::{Nobody, Witness};
use crate::exact::{RunningSum, UNIT_ROUNDOFF, power_of_two_near};
use crate::plan::parts::{AHEAD_FROM, Part, Parts};
use crate::world::{Contact, Disc, DiscId, Owner, Walls, limits};
use calendar::Calendar;
use cells::{Border, Cells, Needs, Place};
use come::UNSEEN;
use fall::Fall;
use lanes::{Near, Unit, Wrap};
use levels::{Grids, Levels};
use rows::Noted;
use segments::Fence;

pub use lanes::Lanes;

/// Where a disc would have been at the start of the epoch, and its velocity.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
struct Flight {
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

    fn at(&self, now: f64) -> DVec2 {
        DVec2::new(self.x + self.vx * now, self.y + self.vy * now)
    }

    /// The flight after a change of velocity.
    fn deflect(&mut self, now: f64, by: DVec2) {
        self.x += by.x * -now;
        self.y += by.y * -now;
        self.vx += by.x;
        self.vy += by.y;
    }

    /// The flight that passes here with another velocity.
    fn turn(&mut self, now: f64, velocity: DVec2) {
        self.x += (self.vx - velocity.x) * now;
        self.y += (self.vy - velocity.y) * now;
        (self.vx, self.vy) = (velocity.x, velocity.y);
    }

    /// Changes with every contact.
    #[inline(always)]
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

/// In `Due::partner`: another contact of the disc comes at the same instant.
const TIE: u32 = 1 << 31;
/// In `Due::partner`: from here on walls, in the order of `SIDES`.
const WALL: u32 = 1 << 30;
/// In `Due::partner`: from here on line segments, by their places.
const SEGMENT: u32 = WALL | 1 << 29;
/// In `Due::partner`: nothing.
const NOTHING: u32 = WALL | 0xff;

impl Due {
    #[inline(always)]
    fn time(&self) -> f64 {
        if self.exit < self.contact { self.exit } else { self.contact }
    }

    /// The disc or wall that it meets, whether or not another is met at that instant.
    #[inline(always)]
    fn met(&self) -> usize {
        (self.partner & !TIE) as usize
    }
}

/// The last contact of a disc, for the collapse model.
#[derive(Clone, Copy, Debug)]
struct Last {
    time: f64,
    /// Contacts in a row, each within the contact time of the one before.
    quick: u32,
}

const LONG_AGO: Last = Last { time: f64::NEG_INFINITY, quick: 0 };

/// A quantity of all discs: one number where they are equal.
#[derive(Clone, Debug, PartialEq)]
enum Each {
    Same(f64),
    Own(Vec<f64>),
}

impl Each {
    fn of(mut values: impl Iterator<Item = f64>, differ: bool) -> Self {
        if differ { Self::Own(values.collect()) } else { Self::Same(values.next().unwrap_or(1.0)) }
    }

    #[inline(always)]
    fn get(&self, k: usize) -> f64 {
        match self {
            Self::Same(value) => *value,
            Self::Own(values) => values[k],
        }
    }

    #[inline(always)]
    fn same(&self) -> f64 {
        if let Self::Same(value) = self { *value } else { 0.0 }
    }

    #[inline(always)]
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
    owners: Vec<Owner>,
    /// Last contacts, where the collapse model needs them.
    last: Vec<Last>,
    /// Whether energy comes in from outside: some disc is observed, or fixed and moves.
    guests: bool,
    /// What falls, where there is gravity.
    fall: Option<Fall>,
    /// The line segments, where there are any.
    fence: Option<Box<Fence>>,
    /// Whether contacts may lose energy, so that each is booked.
    lossy: bool,
    /// Where a disc of an id is, once somebody asked.
    index: Option<HashMap<(Owner, DiscId), usize>>,
    cells: Cells,
    /// Coarser cells, where sizes differ much.
    levels: Levels,
    /// Whether they must be made anew before time goes on.
    outdated: bool,
    /// How many discs they were made for.
    made_for: usize,
    /// The largest diameter that the cells have room for, m.
    diameter: f64,
    /// The largest diameter of those in the finest cells, m.
    scale: f64,
    calendar: Calendar,
    /// For two discs that look at once.
    near: Box<[Near; 2]>,
    /// The sum of two radii where all are equal, m.
    reach: f64,
    lanes: Lanes,
    wrap: Option<Wrap>,
    /// Whether that is asked where no border can lie between.
    wrap_inside: bool,
    /// Start of the epoch, s.
    base: f64,
    /// The present, s from the start of the epoch.
    now: f64,
    /// Events since the start of the epoch, and until today.
    events: u64,
    events_before_today: u64,
    instant: f64,
    events_at_instant: usize,
    /// What counts as one instant for the budget of events, s.
    instant_length: f64,
    /// Contacts closer than this are at the same instant, s.
    same_instant: f64,
    /// Events of a day that are too many, and of an instant.
    busy: u64,
    stalled: usize,
    /// Whether what comes next is fetched from memory in advance.
    ahead: bool,
    energy: EnergyAccount,
    momentum: MomentumAccount,
    /// Least and largest `d.d - s^2` at a contact of simulated discs: m^2 where all radii are
    /// equal, else in units of reach and smaller radius.
    excess: (f64, f64),
    contacts: u64,
    noted: Noted,
}

/// Times between contacts of a disc in an epoch: short enough that starts of flights are near, long
/// enough that carrying all on costs nothing.
const EPOCH: f64 = 8.0;

/// How far from its start a disc may fly in an epoch, in diameters: its place there is rounded to
/// 1e-13 of one.
const FAR: f64 = 1024.0;

/// What counts as one instant for the budget of events, in epochs.
const INSTANT: f64 = 1e-11;

/// Contacts closer than this, in epochs, are at the same instant: their times differ by rounding.
const SAME_INSTANT: f64 = 16.0 * UNIT_ROUNDOFF;

impl Events {
    /// Whether this method has all that a scene needs: not extreme units, or a periodic box so
    /// small that a disc could meet two images of another, or segments for what does not fly
    /// straight.
    pub fn suits(laws: &Laws, discs: &[Disc]) -> bool {
        let wide = laws.periodic.is_none() || grids(laws, discs).are_wide();
        let met = laws.segments.is_none() || laws.are_straight();
        !laws.extreme_units && wide && met
    }

    /// An arena at time 0, of a scene that [suits](Self::suits) the method.
    pub fn new(laws: Laws, discs: &[Disc]) -> Self {
        Self::with(laws, discs, Parts::needed(&laws, discs))
    }

    /// The same with these parts, among them all that it needs.
    pub fn with(laws: Laws, discs: &[Disc], parts: Parts) -> Self {
        let records = if parts.has(Part::ContactTime) { discs.len() } else { 0 };
        let periodic = laws.periodic.map(|periodic| Wrap::new(periodic.size()));
        let Grids { cells, levels, diameter, needs } = grids(&laws, discs);
        let (mut day, days) = days(&needs, discs);
        let fall = laws.gravity.map(Fall::new);
        if let Some(fall) = &fall {
            day = day.min(power_of_two_near(fall.longest_epoch(needs.diameter) / days as f64));
        }
        let mut arena = Self {
            laws,
            flights: pages::with_room_for(discs.len()),
            dues: pages::with_room_for(discs.len()),
            radii: Each::of(discs.iter().map(|disc| disc.radius), parts.has(Part::Radii)),
            masses: Each::of(discs.iter().map(|disc| disc.mass), parts.has(Part::Masses)),
            ids: discs.iter().map(|disc| disc.id).collect(),
            owners: vec![Owner::Simulated; discs.len()],
            last: vec![LONG_AGO; records],
            guests: parts.has(Part::Observed),
            lossy: parts.has(Part::Restitution),
            fall,
            fence: laws.segments.as_ref().map(|all| Box::new(Fence::new(all))),
            index: None,
            cells,
            levels,
            outdated: false,
            made_for: discs.len(),
            diameter,
            scale: needs.diameter,
            calendar: Calendar::new(day, days, discs.len()),
            near: Default::default(),
            reach: 0.0,
            lanes: Lanes::best(),
            wrap: periodic.or(parts.has(Part::Periodic).then_some(Wrap::NONE)),
            wrap_inside: parts.has(Part::WrapInside) || laws.periodic.is_none(),
            base: 0.0,
            now: 0.0,
            events: 0,
            events_before_today: 0,
            instant: 0.0,
            events_at_instant: 0,
            instant_length: 0.0,
            same_instant: 0.0,
            busy: 0,
            stalled: 0,
            ahead: parts.has(Part::Ahead),
            energy: EnergyAccount::default(),
            momentum: MomentumAccount::default(),
            excess: (0.0, 0.0),
            contacts: 0,
            noted: Noted::default(),
        };
        arena.energy.book(discs.iter().map(Disc::kinetic_energy).collect::<RunningSum>().value());
        discs.iter().for_each(|disc| arena.push_flight(disc));
        arena.renew_grid();
        if parts.has(Part::Commands) {
            arena.make_index();
        }
        arena
    }

    /// The present, s since the start.
    pub fn now(&self) -> f64 {
        self.base + self.now
    }

    /// The discs of one owner as they are now.
    pub fn discs(&self, owner: Owner) -> impl Iterator<Item = Disc> + '_ {
        (0..self.flights.len()).filter(move |&k| self.owners[k] == owner).map(|k| self.disc(k))
    }

    /// Kinetic energy of the simulated discs, J.
    pub fn kinetic_energy(&self) -> f64 {
        let discs = self.discs(Owner::Simulated);
        discs.map(|disc| disc.kinetic_energy()).collect::<RunningSum>().value()
    }

    /// Signed relative energy error, with all work accounted for.
    pub fn relative_energy_drift(&self) -> f64 {
        let mut account = self.energy;
        account.book(self.work_of_gravity());
        account.relative_drift(self.kinetic_energy())
    }

    /// Keeps account of the momentum from now on.
    pub fn keep_momentum(&mut self) {
        if self.momentum.is_kept() {
            return;
        }
        let mut account = self.momentum;
        account.begin(self.discs(Owner::Simulated));
        self.momentum = account;
        self.momentum.set_pull(self.now(), self.weight());
        // Contacts with fixed discs are booked.
        let fixed = self.discs(Owner::Simulated).any(|disc| disc.mass.is_infinite());
        self.guests |= fixed;
    }

    /// Momentum gained by error, N s, while an account is kept.
    pub fn momentum_drift(&self) -> Option<DVec2> {
        self.momentum.drift(self.now(), self.discs(Owner::Simulated))
    }

    /// Largest overlap of a simulated pair at any contact, in units of the smaller radius.
    pub fn largest_overlap(&self) -> f64 {
        self.in_radii(-self.excess.0)
    }

    /// Largest gap of a simulated pair at any contact, in units of the smaller radius.
    pub fn largest_gap(&self) -> f64 {
        self.in_radii(self.excess.1)
    }

    /// Distance of two surfaces, in units of the smaller radius.
    fn in_radii(&self, excess: f64) -> f64 {
        // |d| - s = (d.d - s^2) / (|d| + s).
        0.5 * match self.radii {
            Each::Same(radius) => excess / (2.0 * radius * radius),
            Each::Own(_) => excess,
        }
    }

    /// Levels of cells: more than one where sizes differ much.
    pub fn levels(&self) -> usize {
        1 + self.levels.coarser()
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
        self.bring_up_to_date();
        self.lanes.advance(self, until, contacts)
    }

    /// The same without a record of the contacts, which saves making them.
    ///
    /// # Errors
    /// As [`Self::advance`].
    pub fn pass(&mut self, until: f64) -> Result<(), Stall> {
        self.bring_up_to_date();
        self.lanes.advance(self, until, &mut Nobody)
    }

    /// Goes on with this of what the processor has: the same bits, slower or faster.
    pub fn use_lanes(&mut self, lanes: Lanes) {
        self.lanes = lanes;
    }

    /// Whether it has nothing that makes more of it than a gas of discs of one size; what comes
    /// from outside may change that.
    fn is_bare(&self) -> bool {
        let built = Parts::that(|part| match part {
            Part::Walls => self.laws.walls.is_some(),
            Part::Segments => self.fence.is_some(),
            Part::Radii => !self.radii.own().is_empty(),
            Part::Gravity => self.fall.is_some(),
            Part::Observed => self.guests,
            _ => false,
        });
        self.levels.is_single() && built.among(Parts::besides_a_gas()) == Parts::NONE
    }

    /// Whether masses are equal, and contacts lose nothing.
    fn is_alike(&self) -> bool {
        self.masses.own().is_empty() && !self.lossy && self.last.is_empty()
    }

    fn bring_up_to_date(&mut self) {
        if self.outdated {
            self.renew_all_cells();
        }
    }

    /// The same, to be compiled for each kind of processor.
    #[inline(always)]
    fn advance_with<U: Unit, W: Witness>(
        &mut self,
        until: f64,
        witness: &mut W,
    ) -> Result<(), Stall> {
        // What is no number is not later than now.
        if until.partial_cmp(&self.now()) != Some(Ordering::Greater) {
            return Ok(());
        }
        for _ in 0..limits::EVENTS_PER_ADVANCE {
            let Some((k, due)) = self.next_due::<U>(until) else {
                self.reach(until);
                return Ok(());
            };
            self.now = self.now.max(due.time());
            self.count_event(k)?;
            if due.contact <= due.exit {
                self.meet::<U>(k, due, witness);
            } else {
                self.change_cell::<U>(k, due);
            }
        }
        Ok(())
    }

    /// Nothing more happens before `until`: that is the present, to the last bit.
    fn reach(&mut self, until: f64) {
        // An event's time may have rounded to just after it.
        self.now = self.now.max(until - self.base);
        if self.now() < until {
            self.now = self.now.next_up();
        }
    }

    /// The disc whose event is the next, if that comes before `until`.
    #[inline(always)]
    fn next_due<U: Unit>(&mut self, until: f64) -> Option<(usize, Due)> {
        if self.events - self.events_before_today > self.busy {
            self.shorten_days();
        }
        loop {
            let Some(&entry) = self.calendar.open().last() else {
                if !self.turn_page::<U>(until) {
                    return None;
                }
                continue;
            };
            let k = self.calendar.disc(entry);
            // A disc that went may have left entries.
            let due = self.dues.get(k).copied().unwrap_or(UNSEEN);
            let holds = self.calendar.holds(entry, due.time());
            if holds && due.time() > until - self.base {
                return None;
            }
            self.calendar.pop();
            if self.ahead {
                self.fetch_ahead::<U>();
            }
            if holds {
                return Some((k, due));
            }
        }
    }

    /// Goes on to the next day, or epoch; `false` if that comes after `until`.
    #[inline(always)]
    fn turn_page<U: Unit>(&mut self, until: f64) -> bool {
        // So late that no double tells one day from the next, nothing happens any more.
        let is_lost = self.base + self.calendar.day() == self.base;
        if is_lost || self.base + self.calendar.tomorrow() > until {
            return false;
        }
        self.events_before_today = self.events;
        if self.calendar.is_last_day() {
            return self.next_epoch(until);
        }
        U::next_day(self);
        true
    }

    #[inline(always)]
    fn open_next_day<U: Unit>(&mut self) {
        let dues = &self.dues;
        self.calendar.next_day::<U>(|k| dues.get(k).map_or(f64::INFINITY, Due::time));
    }

    /// Carries all flights on to the next epoch in which something happens; `false` if nothing does
    /// before `until`: carried on for that, they would be rounded as often as somebody looks.
    #[inline(never)]
    fn next_epoch(&mut self, until: f64) -> bool {
        let epoch = self.calendar.epoch();
        let first = self.dues.iter().map(Due::time).fold(f64::INFINITY, f64::min);
        if first == f64::INFINITY || self.base + first > until {
            return false;
        }
        let wanted = entries_per_day(self.flights.len()) * self.calendar.days() as f64;
        let factor = power_of_two_near(wanted / (self.events as f64).max(wanted / 4096.0));
        let change =
            if (0.6..1.7).contains(&factor) { 1.0 } else { factor.clamp(1.0 / 16.0, 16.0) };
        let epochs = (first / epoch).floor().max(1.0);
        self.carry_on(if epochs.is_finite() { epoch * epochs } else { first });
        let fastest = self.flights.iter().map(|flight| flight.velocity().length_squared());
        let fastest = fastest.fold(0.0, f64::max).sqrt();
        self.events = 0;
        self.events_before_today = 0;
        self.restart_calendar(self.calendar.day() * change, fastest);
        true
    }

    /// Moves the start of the epoch.
    fn carry_on(&mut self, by: f64) {
        self.noted.forget();
        self.base += by;
        self.now = (self.now - by).max(0.0);
        self.instant -= by;
        if self.fall.is_some() {
            self.carry_falling(by);
        } else {
            // Each by itself: of discs that came or went only the flights are kept up to date.
            for flight in &mut self.flights {
                (flight.x, flight.y) = (flight.x + flight.vx * by, flight.y + flight.vy * by);
            }
        }
        for due in &mut self.dues {
            due.contact -= by;
            due.exit -= by;
        }
        self.last.iter_mut().for_each(|last| last.time -= by);
    }

    /// Starts the calendar again with days of about this length, s, but none in which a disc of
    /// this speed, m/s, comes so far that its start is known badly.
    fn restart_calendar(&mut self, day: f64, fastest: f64) {
        let days = days_of(self.flights.len());
        let mut longest = FAR * self.scale / (fastest * days as f64);
        if let Some(fall) = &self.fall {
            longest = longest.min(fall.longest_epoch(self.scale) / days as f64);
        }
        let day = day.max(self.shortest_day());
        let day = if day > longest { power_of_two_near(longest) } else { day };
        self.calendar.restart(day, days);
        self.fit_limits();
        for (k, due) in self.dues.iter().enumerate() {
            self.calendar.insert(due.time(), k);
        }
    }

    /// What depends on the length of an epoch and on how many discs there are.
    fn fit_limits(&mut self) {
        let discs = self.flights.len();
        self.instant_length = INSTANT * self.calendar.epoch();
        self.same_instant = SAME_INSTANT * self.calendar.epoch();
        self.reach = 2.0 * self.radii.same();
        self.busy = 16 * entries_per_day(discs) as u64;
        self.stalled = limits::EVENTS_PER_INSTANT + limits::EVENTS_PER_INSTANT_AND_DISC * discs;
    }

    /// Counts events, and those of an instant.
    #[inline(always)]
    fn count_event(&mut self, k: usize) -> Result<(), Stall> {
        self.events += 1;
        if self.now > self.instant {
            self.instant = self.now + self.instant_length;
            self.events_at_instant = 0;
        }
        self.events_at_instant += 1;
        if self.events_at_instant > self.stalled {
            return Err(self.stall(k));
        }
        Ok(())
    }

    /// More happens in a day than was expected: makes shorter days of it.
    #[cold]
    fn shorten_days(&mut self) {
        self.events_before_today = self.events;
        if self.calendar.day() <= self.shortest_day() {
            return;
        }
        self.carry_on(self.calendar.today());
        self.restart_calendar(self.calendar.day() / 16.0, 0.0);
    }

    /// Doubles must tell days apart, s: where thousands meet at one instant no day is short enough,
    /// and what comes after that has days of its own.
    fn shortest_day(&self) -> f64 {
        16.0 * (self.base.next_up() - self.base).max(f64::MIN_POSITIVE * 1e30)
    }

    /// Begins an epoch now if a disc of this speed, m/s, would have started too far away.
    fn bring_start_near(&mut self, speed: f64) {
        if speed * self.now > FAR * self.scale || self.fell_far() {
            self.carry_on(self.now);
            self.restart_calendar(self.calendar.day(), speed);
        }
    }

    #[cold]
    fn stall(&mut self, k: usize) -> Stall {
        let events = self.events_at_instant;
        // A later call starts with a fresh budget.
        self.events_at_instant = 0;
        self.calendar.insert(self.dues[k].time(), k);
        Stall { time: self.base + self.now, events, disc: self.ids[k] }
    }

    fn disc(&self, k: usize) -> Disc {
        let position = self.position(k);
        Disc {
            id: self.ids[k],
            position: self.laws.periodic.map_or(position, |periodic| periodic.inside(position)),
            velocity: self.velocity(k),
            radius: self.radii.get(k),
            mass: self.masses.get(k),
        }
    }
}

/// Entries of a day when it comes: few enough to sort by counting; where one looks ahead so many
/// that one can, and few enough to sort in the first cache.
fn entries_per_day(discs: usize) -> f64 {
    (discs as f64 / 32.0).clamp(16.0, if discs < AHEAD_FROM { 24.0 } else { 1024.0 })
}

fn days_of(discs: usize) -> usize {
    ((2.0 * EPOCH * discs as f64 / entries_per_day(discs)) as usize).next_power_of_two().max(16)
}

/// Length of a day, s, a power of two, and days in an epoch: a first guess.
fn days(needs: &Needs, discs: &[Disc]) -> (f64, usize) {
    let days = days_of(discs.len());
    let count = discs.len().max(1) as f64;
    let speed = discs.iter().map(|disc| disc.velocity.length()).sum::<f64>() / count;
    let fraction = (0.8 * needs.density * needs.diameter * needs.diameter).min(0.9);
    let rate =
        speed * (needs.density * needs.diameter / (1.0 - fraction).powi(2) + needs.density.sqrt());
    let epoch = if rate > 0.0 && rate.is_finite() { EPOCH / rate } else { needs.diameter };
    (power_of_two_near(epoch / days as f64), days)
}

/// The cells that discs need as they lie. Levels are for straight flights.
fn grids(laws: &Laws, discs: &[Disc]) -> Grids {
    let needs = needs(laws, discs);
    if laws.gravity.is_some() { levels::one_level(&needs) } else { levels::grids(&needs, discs) }
}

fn needs(laws: &Laws, discs: &[Disc]) -> Needs {
    let diameter = 2.0 * discs.iter().map(|disc| disc.radius).fold(0.0, f64::max);
    let walls = laws.walls.filter(|walls| *walls != Walls::FAR_AWAY);
    let whole = |min: DVec2, max: DVec2, border| (min, max, border, (max - min).element_product());
    let (min, max, border, area) = match (walls, laws.periodic) {
        (Some(walls), _) => whole(walls.min, walls.max, Border::Closed),
        (_, Some(periodic)) => whole(periodic.min, periodic.max, Border::Periodic(periodic)),
        _ => laws.segments.as_ref().and_then(|all| segments::field(all, discs)).unwrap_or_else(
            || {
                let (min, max) = bounds(discs);
                whole(min, max, Border::Open)
            },
        ),
    };
    let density = discs.len() as f64 / area;
    let is_equal = discs.iter().all(|disc| 2.0 * disc.radius == diameter);
    Needs { min, max, area, diameter, density, border, is_equal, is_finest: false }
}

/// A box around all discs with as much room again.
fn bounds(discs: &[Disc]) -> (DVec2, DVec2) {
    let min = discs.iter().map(|disc| disc.position - disc.radius).reduce(DVec2::min);
    let max = discs.iter().map(|disc| disc.position + disc.radius).reduce(DVec2::max);
    let (min, max) = (min.unwrap_or(DVec2::ZERO), max.unwrap_or(DVec2::ONE));
    let room = DVec2::splat(0.5 * (max - min).max_element());
    (min - room, max + room)
}
