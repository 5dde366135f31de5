//! Exact within a control tick: for robots, whose velocities are set from outside at every tick.
//!
//! ```text
//! set velocities -> look at all -> who may meet -> first meetings, a heap -> contacts -> next tick
//! ```
//!
//! Within a tick discs fly straight, and all predictions die with it: a calendar of far collisions
//! would be wasted. At the start of a window, which is a tick or what a command left of one, the
//! pairs and walls that meet within it are found and put in order; a contact predicts its discs
//! again for the rest. No contact is missed or late, however fast a disc is: states are exact to
//! rounding, as those of [`super::plain`], the judge of this method. What a tick costs is one pass
//! over the discs and one over near pairs; lists of neighbours last for many ticks, and all buffers
//! for ever.
//!
//! Policies are those of [`super::plain`]: overlapping and approaching means now; of events at the
//! same time the smaller index goes first; contacts at the same instant that share a disc are
//! resolved together (only these allocate); the collapse model; an instant that cannot be left is a
//! stall. There is no gravity: discs would not fly straight.
//!
//! A window is shorter than a tick where discs fly further than a radius in one, or so far in a
//! periodic box that other images come near. Windows depend on the state only, so results do not
//! depend on where one stops to look. A tick without a command re-predicts, but begins no flight:
//! flights last from contact to contact, however many ticks that are.

mod agenda;
mod bodies;
mod cells;
mod contacts;
mod edit;
mod neighbours;
mod predict;
mod segments;

use glam::DVec2;

use super::energy::EnergyAccount;
use super::momentum::MomentumAccount;
use super::plain::{Laws, Stall};
use crate::detect::Pair;
use crate::exact::{RunningSum, power_of_two_near};
use crate::world::{Contact, Disc, Owner, limits};
use agenda::{Agenda, Event};
use bodies::{Bodies, Body, Moment};
use neighbours::Neighbours;
use predict::Forecast;
use segments::Fence;

/// The state of an arena under the method of ticks.
#[derive(Clone, Debug)]
pub struct Ticks {
    laws: Laws,
    tick_s: f64,
    /// Scale of event times, s.
    scale: f64,
    /// The present, rounded once, s.
    now: f64,
    present: Moment,
    /// Offset at which the window ends, s; `None` = the next one is not planned yet.
    window_end: Option<f64>,
    /// Components of velocities up to which the window is short enough for its images, m/s.
    speed_allowed: f64,
    bodies: Bodies,
    neighbours: Neighbours,
    fence: Fence,
    /// What happens within the window.
    agenda: Agenda,
    forecast: Forecast,
    /// Scratch: pairs that touch at one instant and share discs.
    together: Vec<Pair>,
    /// Start of the present instant, and events since.
    instant: f64,
    events_at_instant: usize,
    energy: EnergyAccount,
    momentum: MomentumAccount,
    largest_overlap: f64,
    contacts: u64,
}

/// What this method cannot do.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NotInTicks {
    /// A tick that is no length of time.
    #[error("tick = {0} s, must be a finite number above 0")]
    BadTick(f64),
    /// Discs would not fly straight within a tick.
    #[error("ticks know no gravity; take the method plain or events")]
    Gravity,
}

/// What counts as one instant, in scales of event times.
const INSTANT: f64 = 1e-10;

impl Ticks {
    /// An arena at time 0, whose ticks (s) begin at whole multiples of their length.
    ///
    /// # Errors
    /// [`NotInTicks`] with gravity, or a tick that is not above 0.
    pub fn new(laws: Laws, discs: &[Disc], tick_s: f64) -> Result<Self, NotInTicks> {
        if !(tick_s > 0.0 && tick_s.is_finite()) {
            return Err(NotInTicks::BadTick(tick_s));
        }
        if laws.gravity.is_some() {
            return Err(NotInTicks::Gravity);
        }
        let mut arena = Self {
            laws,
            tick_s,
            scale: time_scale(discs),
            now: 0.0,
            present: Moment { tick: 0.0, offset: 0.0 },
            window_end: None,
            speed_allowed: f64::INFINITY,
            bodies: Bodies::new(tick_s, laws.periodic),
            neighbours: Neighbours::new(laws.periodic),
            fence: Fence::new(laws.segments.as_ref()),
            agenda: Agenda::default(),
            forecast: Forecast::default(),
            together: Vec::new(),
            instant: 0.0,
            events_at_instant: 0,
            energy: EnergyAccount::default(),
            momentum: MomentumAccount::default(),
            largest_overlap: 0.0,
            contacts: 0,
        };
        for disc in discs {
            arena.bodies.add(disc, Owner::Simulated, arena.present);
            arena.energy.book(disc.kinetic_energy());
        }
        Ok(arena)
    }

    /// The present, s since the start.
    pub fn now(&self) -> f64 {
        self.now
    }

    /// The discs of one owner as they are now, in the order in which they came.
    pub fn discs(&self, owner: Owner) -> impl Iterator<Item = Disc> + '_ {
        let bodies = self.bodies.bodies.iter().enumerate();
        bodies.filter(move |(_, body)| body.owner == owner).map(|(k, _)| {
            let disc = self.bodies.at(k, self.present);
            Disc { position: self.bodies.inside(disc.position), ..disc }
        })
    }

    /// Kinetic energy of the simulated discs, J.
    pub fn kinetic_energy(&self) -> f64 {
        let discs = self.discs(Owner::Simulated);
        discs.map(|disc| disc.kinetic_energy()).collect::<RunningSum>().value()
    }

    /// Signed relative energy error, with all work accounted for.
    pub fn relative_energy_drift(&self) -> f64 {
        self.energy.relative_drift(self.kinetic_energy())
    }

    /// Keeps account of the momentum from now on.
    pub fn keep_momentum(&mut self) {
        let mut account = self.momentum;
        account.begin(self.discs(Owner::Simulated));
        self.momentum = account;
    }

    /// Momentum gained by error, N s, while an account is kept.
    pub fn momentum_drift(&self) -> Option<DVec2> {
        self.momentum.drift(self.now, self.discs(Owner::Simulated))
    }

    /// Largest overlap of a simulated pair at any contact, in units of the smaller radius.
    pub fn largest_overlap(&self) -> f64 {
        self.largest_overlap
    }

    /// Contacts since the start, pairs and walls.
    pub fn contacts(&self) -> u64 {
        self.contacts
    }

    /// Moves on to `until` (s), tick by tick, and adds the contacts on the way; nothing happens if
    /// that is not ahead. Where it stops makes no difference: between ticks the state is as exact.
    ///
    /// Contacts at `until` itself are among them, but for those that only commands given there
    /// bring about: they are found when it goes on. Stops short of `until` after
    /// [`limits::EVENTS_PER_ADVANCE`] events or windows: [`Self::now`] tells, and calling again
    /// goes on.
    ///
    /// # Errors
    /// [`Stall`] when endlessly many contacts fall on one instant; the arena then stands there.
    pub fn advance(&mut self, until: f64, contacts: &mut Vec<Contact>) -> Result<(), Stall> {
        let ahead = until > self.now;
        for _ in 0..limits::EVENTS_PER_ADVANCE {
            if !ahead || (self.window_end.is_none() && self.now >= until) {
                break;
            }
            let end = self.window_end.unwrap_or_else(|| self.plan());
            let goal = self.offset(until);
            if let Some(event) = self.agenda.next(goal.min(end)) {
                self.present.offset = event.time;
                self.now = self.time(self.present).max(self.now).min(until);
                self.count_event(event)?;
                self.process(event, contacts);
            } else if goal >= end {
                self.leave_window(end, until);
            } else {
                self.present.offset = goal;
                self.now = until;
                break;
            }
        }
        Ok(())
    }

    /// The time of a moment, s, rounded once.
    fn time(&self, moment: Moment) -> f64 {
        moment.tick.mul_add(self.tick_s, moment.offset)
    }

    /// The offset of a time in the present tick, s; infinite = not before the tick's end.
    fn offset(&self, time: f64) -> f64 {
        let tick = self.present.tick;
        if time >= (tick + 1.0) * self.tick_s {
            return f64::INFINITY;
        }
        // Rounding must not end the tick before its time.
        (-tick).mul_add(self.tick_s, time).min(self.tick_s.next_down())
    }

    /// Goes on to the end of a window in which nothing more happens.
    fn leave_window(&mut self, end: f64, until: f64) {
        self.window_end = None;
        self.present.offset = end;
        if end >= self.tick_s {
            self.present = Moment { tick: self.present.tick + 1.0, offset: 0.0 };
            self.instant -= self.tick_s;
        }
        self.now = self.time(self.present).max(self.now).min(until);
    }

    fn count_event(&mut self, event: Event) -> Result<(), Stall> {
        if event.time > self.instant + INSTANT * self.scale {
            (self.instant, self.events_at_instant) = (event.time, 0);
        }
        self.events_at_instant += 1;
        let events =
            limits::EVENTS_PER_INSTANT + limits::EVENTS_PER_INSTANT_AND_DISC * self.bodies.len();
        if self.events_at_instant > events {
            // A later call starts with a fresh budget, and with predictions of its own.
            self.events_at_instant = 0;
            self.window_end = None;
            let disc = self.bodies.bodies[event.first as usize].id;
            return Err(Stall { time: self.now, events, disc });
        }
        Ok(())
    }

    fn body(&self, k: usize) -> &Body {
        &self.bodies.bodies[k]
    }
}

/// The scale of event times, s: radius over speed, for discs at something like 1 m/s at least.
fn time_scale(discs: &[Disc]) -> f64 {
    let radius = discs.iter().map(|disc| disc.radius).fold(f64::INFINITY, f64::min);
    let speed = discs.iter().map(|disc| disc.velocity.length()).fold(0.0, f64::max);
    let (scale, most) = (radius / speed, radius.min(1.0));
    power_of_two_near(if scale > 0.0 { scale.min(most) } else { most })
}
