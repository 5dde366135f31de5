//! Springs: discs push each other apart by a linear spring and a dashpot while they overlap.
//!
//! ```text
//! force = k overlap + gamma d(overlap)/dt    omega0^2 = k / mu, mu the reduced mass
//!
//!   closed form   a contact alone is exact at any stiffness and step ............ [`pair`]
//!                 contacts that share a disc: parts of the step, implicit ...... [`flow`]
//!   implicit      all contacts at once, stable at any step .................... [`cluster`]
//!   explicit      Euler, Verlet, Runge-Kutta: refused beyond the stable step ... [`integrators`]
//! ```
//!
//! The limit of a stiff spring is the hard disc of [`super::plain`], late by `pi sqrt(mu / k)` for
//! each contact; where three discs touch the two differ for ever. What ends a contact is a law that
//! must be stated, it changes the restitution by a factor: [`Ending`].
//!
//! Steps stand on a fixed grid of times. The state between two step ends is a copy of the last one
//! moved on by a shorter step, so results do not depend on where one stops to look.

pub mod oscillator;

pub mod pair;

pub mod cluster;

pub mod flow;

pub mod integrators;

pub mod links;

mod edit;

use std::collections::BTreeMap;

use glam::DVec2;

use super::energy::EnergyAccount;
use super::near::Near;
use super::near::lanes::Pairs;
use crate::detect::{Pair, TooManyPairs};
use crate::exact::RunningSum;
use crate::plan::BroadPhase;
use crate::world::{Contact, Disc, Partner, Walls, limits};
pub use cluster::Implicit;
use flow::Flow;
pub use integrators::Explicit;
use integrators::State;
use links::{Link, Other, stiffest_mode};
pub use oscillator::Ending;
use oscillator::Oscillator;
use pair::Work;

/// What the discs of an arena obey.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Laws {
    /// Spring constant of a contact, N/m.
    pub stiffness: f64,
    /// Dashpot constant of a contact, N s/m.
    pub damping: f64,
    /// When a contact ends.
    pub ending: Ending,
    /// The box, if there is one; its walls are as stiff as the discs. Restitution is not used.
    pub walls: Option<Walls>,
}

/// How a step is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// Exact for a contact alone; the default.
    ClosedForm,
    /// All contacts at once, without a limit of the step.
    Implicit(Implicit),
    /// To compare with.
    Explicit(Explicit),
}

/// How to step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stepping {
    /// Length of a step, s.
    pub step: f64,
    /// How it is made.
    pub scheme: Scheme,
    /// Refuse steps beyond the stability limit; `false` only to show what happens there.
    pub refuse_unstable: bool,
    /// How neighbours are found: with a grid the closed form keeps lists of them over many steps;
    /// all pairs are its judge, to the same bits.
    pub broad_phase: BroadPhase,
}

/// Why an arena does not step.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Refused {
    /// A number that is none.
    #[error("{what} = {}, must be {wanted}", limits::short(*.value))]
    Number {
        /// Which.
        what: &'static str,
        /// What it was.
        value: f64,
        /// What would be right.
        wanted: &'static str,
    },
    /// An explicit rule would blow up.
    #[error(
        "step = {step} s is too long for {scheme}: the largest stable step is {largest:e} s; \
         shorten it, soften the springs or use the closed form"
    )]
    StepTooLong {
        /// The rule.
        scheme: &'static str,
        /// The step asked for, s.
        step: f64,
        /// The largest stable one, s; 0 = none.
        largest: f64,
    },
    /// Discs heaped on each other, or a step in which most could meet.
    #[error(transparent)]
    Pairs(#[from] TooManyPairs),
    /// Positions or velocities beyond the range of doubles.
    #[error("the arena left the range of numbers after t = {time} s; shorten the step")]
    NotFinite {
        /// The last step end before it, s.
        time: f64,
    },
}

/// The state of an arena under the method of springs.
#[derive(Clone, Debug)]
pub struct Springs {
    laws: Laws,
    stepping: Stepping,
    /// Steps done.
    count: u64,
    now: f64,
    /// When the grid of times began, s.
    base: f64,
    /// At the last step end.
    discs: Vec<Disc>,
    /// At present, if that is not a step end.
    shown: Option<Vec<Disc>>,
    neighbours: Neighbours,
    /// Contacts that a command ended, to be told.
    ended: Vec<Contact>,
    /// Contacts that go on.
    open: BTreeMap<Link, Contact>,
    /// The stiffest mode, 1/s^2, that was found to be stable.
    stable_mode: f64,
    deepest: f64,
    contacts: u64,
    /// What dashpots and the ends of damped contacts took, J.
    lost: RunningSum,
    energy: EnergyAccount,
}

/// Who is near whom, kept over many steps.
#[derive(Clone, Debug)]
struct Neighbours {
    near: Near,
    places: Vec<DVec2>,
    radii: Vec<f64>,
    found: Pairs,
    pairs: Vec<Pair>,
    /// By how much two discs can have come closer since the last look, m.
    closer: f64,
    /// The discs after the step, before it is known to be right.
    next: Vec<Disc>,
}

impl Default for Neighbours {
    fn default() -> Self {
        Self {
            near: Near::new(None),
            places: Vec::new(),
            radii: Vec::new(),
            found: Pairs::default(),
            pairs: Vec::new(),
            closer: 0.0,
            next: Vec::new(),
        }
    }
}

impl Neighbours {
    /// Lists the pairs with a gap up to a margin (m), and perhaps some more, in ascending order.
    fn list(&mut self, discs: &[Disc], margin: f64) -> Result<(), TooManyPairs> {
        self.places.clear();
        self.places.extend(discs.iter().map(|disc| disc.position));
        self.radii.clear();
        self.radii.extend(discs.iter().map(|disc| disc.radius));
        let everyone: Option<fn(usize, usize) -> bool> = None;
        let Self { near, places, radii, found, .. } = self;
        near.within(places, radii, (margin, self.closer), everyone, found)?;
        self.closer = 0.0;
        self.pairs.clear();
        self.pairs.extend(self.found.iter());
        self.pairs.sort_unstable();
        Ok(())
    }
}

impl Springs {
    /// An arena at time 0.
    ///
    /// # Errors
    /// [`Refused`]: numbers out of range; a step that no pair of these discs stands.
    pub fn new(laws: Laws, discs: &[Disc], stepping: Stepping) -> Result<Self, Refused> {
        let mut masses: Vec<f64> = discs.iter().map(|disc| disc.mass).collect();
        masses.sort_unstable_by(f64::total_cmp);
        let lightest = masses.iter().take(2).map(|mass| 1.0 / mass).sum::<f64>();
        check_numbers(&laws, &stepping, lightest)?;
        let mut arena = Self {
            laws,
            stepping,
            count: 0,
            now: 0.0,
            base: 0.0,
            discs: discs.to_vec(),
            shown: None,
            neighbours: Neighbours::default(),
            ended: Vec::new(),
            lost: RunningSum::default(),
            energy: EnergyAccount::default(),
            open: BTreeMap::new(),
            stable_mode: 0.0,
            deepest: 0.0,
            contacts: 0,
        };
        arena.refuse_unstable_contacts(laws.stiffness * lightest)?;
        arena.energy.book(arena.mechanical_energy());
        Ok(arena)
    }

    /// The present, s since the start.
    pub fn now(&self) -> f64 {
        self.now
    }

    /// The discs as they are now.
    pub fn discs(&self) -> impl Iterator<Item = Disc> + '_ {
        self.now_discs().iter().copied()
    }

    fn now_discs(&self) -> &[Disc] {
        self.shown.as_deref().unwrap_or(&self.discs)
    }

    /// Steps since the start or the last command.
    pub fn steps(&self) -> u64 {
        self.count
    }

    /// Kinetic energy now, J.
    pub fn kinetic_energy(&self) -> f64 {
        self.now_discs().iter().map(Disc::kinetic_energy).collect::<RunningSum>().value()
    }

    /// Energy stored in the springs now, J.
    ///
    /// # Errors
    /// [`TooManyPairs`].
    pub fn elastic_energy(&self) -> Result<f64, TooManyPairs> {
        let walls = self.laws.walls.as_ref();
        let links = links::within(self.now_discs(), walls, 0.0, self.stepping.broad_phase)?;
        let stored = |link: &Link| link.stored(self.now_discs(), &self.laws);
        Ok(links.iter().map(stored).collect::<RunningSum>().value())
    }

    /// Energy of motion and of the springs that push at the last step end, J.
    fn mechanical_energy(&self) -> f64 {
        let kinetic = self.discs.iter().map(Disc::kinetic_energy);
        let stored = self.open.keys().map(|link| link.stored(&self.discs, &self.laws));
        kinetic.chain(stored).collect::<RunningSum>().value()
    }

    /// Signed relative energy error at the last step end. Without damping nothing may be lost:
    /// then this is what the steps gain or lose where contacts share discs. With it, only what is
    /// left when the contacts' own losses, as they were computed, are accounted for.
    pub fn relative_energy_drift(&self) -> f64 {
        self.energy.relative_drift(self.mechanical_energy() + self.lost.value())
    }

    /// Takes over the discs after a step, and what it did.
    fn take(&mut self, works: &[Work]) {
        self.note(works);
        let next = &mut self.neighbours.next;
        let way = |(a, b): (&Disc, &Disc)| a.position.distance_squared(b.position);
        let longest = self.discs.iter().zip(&*next).map(way).fold(0.0, f64::max);
        self.neighbours.closer += 2.0 * longest.sqrt() * (1.0 + 1e-9) + 1e-140;
        std::mem::swap(&mut self.discs, next);
        self.shown = None;
    }

    /// Largest overlap of any contact up to the last step end, m.
    pub fn largest_overlap(&self) -> f64 {
        self.deepest
    }

    /// Contacts that have begun since the start.
    pub fn contacts(&self) -> u64 {
        self.contacts
    }

    /// Moves on to `until` (s) and adds the contacts that ended on the way, each with the time and
    /// speed at which it began, its deepest overlap as gap, and its whole impulse; nothing happens
    /// if that is past.
    ///
    /// Stops short of `until` after [`limits::STEPS_PER_ADVANCE`] steps: [`Self::now`] tells, and
    /// calling again goes on.
    ///
    /// # Errors
    /// [`Refused`]; the arena stays at the last step end.
    pub fn advance(&mut self, until: f64, contacts: &mut Vec<Contact>) -> Result<(), Refused> {
        contacts.append(&mut self.ended);
        for _ in 0..limits::STEPS_PER_ADVANCE {
            let end = self.base + (self.count + 1) as f64 * self.stepping.step;
            if end > until || until.is_nan() {
                return self.show(until);
            }
            let works = self.moved(self.stepping.step)?;
            self.take(&works);
            self.count += 1;
            self.close(contacts);
            self.now = self.now.max(end);
        }
        Ok(())
    }

    /// Shows the state at a time before the next step end.
    fn show(&mut self, until: f64) -> Result<(), Refused> {
        if until > self.now {
            if until > self.time() {
                self.moved(until - self.time())?;
                self.shown = Some(self.neighbours.next.clone());
            }
            self.now = until;
        }
        Ok(())
    }

    /// Time of the last step end, s.
    fn time(&self) -> f64 {
        self.base + self.count as f64 * self.stepping.step
    }

    /// Makes the next discs those `h` (s) after the last step end; returns what the contacts did.
    fn moved(&mut self, h: f64) -> Result<Vec<Work>, Refused> {
        let mut discs = std::mem::take(&mut self.neighbours.next);
        discs.clone_from(&self.discs);
        let (walls, broad_phase) = (self.laws.walls.as_ref(), self.stepping.broad_phase);
        let works = match self.stepping.scheme {
            Scheme::ClosedForm => self.flow(&mut discs, h)?,
            Scheme::Implicit(rule) => {
                let links = links::within(&discs, walls, h, broad_phase)?;
                flow::together(&mut discs, &links, &self.laws, (h, 0.0), rule)
            }
            Scheme::Explicit(rule) => {
                self.refuse_unstable_contacts(0.0)?;
                self.step_explicitly(&mut discs, rule, h)?
            }
        };
        let finite = |disc: &Disc| disc.position.is_finite() && disc.velocity.is_finite();
        let all_finite = discs.iter().all(finite);
        self.neighbours.next = discs;
        if all_finite { Ok(works) } else { Err(Refused::NotFinite { time: self.time() }) }
    }

    /// The closed form, among those that lists show to be near; where a blow makes one so fast that
    /// they may not show all, among all.
    fn flow(&mut self, discs: &mut Vec<Disc>, h: f64) -> Result<Vec<Work>, Refused> {
        let shortest = self.stepping.step / limits::PARTS_PER_STEP as f64;
        let broad_phase = self.stepping.broad_phase;
        let flow = Flow { laws: &self.laws, broad_phase, shortest };
        let speed_max = 2.0 * links::fastest(&self.discs);
        let margin = 2.0 * speed_max * h * (1.0 + 1e-9);
        if broad_phase == BroadPhase::Grid && margin.is_finite() {
            self.neighbours.list(&self.discs, margin)?;
            let near = &self.neighbours.pairs;
            let works = flow.advance_among(&self.discs, discs, near, speed_max, h)?;
            if let Some(works) = works {
                return Ok(works);
            }
            discs.clone_from(&self.discs);
        }
        Ok(flow.advance(discs, h, 0.0)?)
    }

    fn step_explicitly(
        &self,
        discs: &mut [Disc],
        rule: Explicit,
        h: f64,
    ) -> Result<Vec<Work>, Refused> {
        let (walls, broad_phase) = (self.laws.walls.as_ref(), self.stepping.broad_phase);
        let works = pushes(discs, &links::within(discs, walls, 0.0, broad_phase)?, &self.laws, h);
        let state = State {
            positions: discs.iter().map(|disc| disc.position).collect(),
            velocities: discs.iter().map(|disc| disc.velocity).collect(),
        };
        let mut stage = discs.to_vec();
        let after = rule.step(&state, h, |state| -> Result<Vec<DVec2>, Refused> {
            put(state, &mut stage);
            if stage.iter().any(|disc| !disc.position.is_finite()) {
                return Err(Refused::NotFinite { time: self.time() });
            }
            let links = links::within(&stage, walls, 0.0, broad_phase)?;
            let mut accelerations = vec![DVec2::ZERO; stage.len()];
            for link in &links {
                let force = force(link, &stage, &self.laws) * link.normal(&stage);
                let (a, b) = link.inverse_masses(&stage);
                accelerations[link.a] -= force * a;
                if let Other::Disc(other) = link.b {
                    accelerations[other] += force * b;
                }
            }
            Ok(accelerations)
        })?;
        put(&after, discs);
        Ok(works)
    }

    /// Refuses a step that is unstable with the contacts of now, or a mode with this `omega0^2`.
    fn refuse_unstable_contacts(&mut self, mode: f64) -> Result<(), Refused> {
        if !matches!(self.stepping.scheme, Scheme::Explicit(_)) || !self.stepping.refuse_unstable {
            return Ok(());
        }
        let walls = self.laws.walls.as_ref();
        let links = links::within(&self.discs, walls, 0.0, self.stepping.broad_phase)?;
        self.refuse_unstable(stiffest_mode(&self.discs, &links, self.laws.stiffness).max(mode))
    }

    /// The same for a mode with this `omega0^2`.
    fn refuse_unstable(&mut self, mode: f64) -> Result<(), Refused> {
        let Scheme::Explicit(rule) = self.stepping.scheme else { return Ok(()) };
        if !self.stepping.refuse_unstable || mode <= self.stable_mode {
            return Ok(());
        }
        let spring =
            Oscillator::new(self.laws.stiffness, self.laws.damping, mode / self.laws.stiffness);
        let largest = rule.largest_stable_step(spring.omega0(), spring.beta());
        if self.stepping.step > largest {
            let step = self.stepping.step;
            return Err(Refused::StepTooLong { scheme: rule.name(), step, largest });
        }
        self.stable_mode = mode;
        Ok(())
    }

    /// Adds what the contacts of a step did to those that go on, or begins them.
    fn note(&mut self, works: &[Work]) {
        for work in works {
            self.deepest = self.deepest.max(work.deepest);
            let a = &self.discs[work.link.a];
            let open = self.open.entry(work.link).or_insert_with(|| {
                self.contacts += 1;
                Contact {
                    a: a.id,
                    b: match work.link.b {
                        Other::Disc(b) => Partner::Disc(self.discs[b].id),
                        Other::Wall(side) => Partner::Wall(side),
                    },
                    point: work.centre + work.normal * a.radius,
                    normal: work.normal,
                    gap: 0.0,
                    approach_speed: work.approach_speed.max(0.0),
                    impulse: 0.0,
                    energy_loss: 0.0,
                    time: self.base + self.count as f64 * self.stepping.step + work.begins,
                }
            });
            open.impulse += work.impulse;
            open.energy_loss += work.loss;
            if self.laws.damping > 0.0 {
                self.lost.add(work.loss);
            }
            open.gap = open.gap.min(-work.deepest);
        }
    }

    /// Hands over the contacts that have ended.
    fn close(&mut self, contacts: &mut Vec<Contact>) {
        let (discs, laws, lost) = (&self.discs, &self.laws, &mut self.lost);
        let first = contacts.len();
        self.open.retain(|link, contact| {
            let goes_on = link.overlap(discs, laws) > 0.0 && force(link, discs, laws) != 0.0;
            if !goes_on {
                // What the spring still holds pushes nobody.
                let held = link.stored(discs, laws);
                if laws.damping > 0.0 {
                    lost.add(held);
                }
                let energy_loss = contact.energy_loss + held;
                contacts.push(Contact { energy_loss, ..*contact });
            }
            goes_on
        });
        contacts[first..].sort_by(|a, b| a.time.total_cmp(&b.time));
    }
}

fn check_numbers(laws: &Laws, stepping: &Stepping, inverse_mass: f64) -> Result<(), Refused> {
    let positive = |what, value: f64| {
        let wanted = "a finite number above 0";
        let good = value > 0.0 && value.is_finite();
        if good { Ok(()) } else { Err(Refused::Number { what, value, wanted }) }
    };
    positive("step", stepping.step)?;
    positive("stiffness", laws.stiffness)?;
    if !(laws.damping >= 0.0 && laws.damping.is_finite()) {
        let wanted = "a finite number from 0";
        return Err(Refused::Number { what: "damping", value: laws.damping, wanted });
    }
    // Rates and their squares, and what a step makes of them, must be numbers too.
    let stiffest = laws.stiffness.max(laws.damping * laws.damping * inverse_mass) * inverse_mass;
    let bounded = |what, value: f64, wanted| {
        if value < 1e200 { Ok(()) } else { Err(Refused::Number { what, value, wanted }) }
    };
    bounded("stiffness over mass", stiffest, "below 1e200 1/s^2 for the lightest discs")?;
    let per_step = stiffest * stepping.step * stepping.step;
    let what = "stiffness over mass times step squared";
    bounded(what, per_step, "below 1e200 for the lightest discs")
}

/// The force between two bodies, N; positive = apart.
fn force(link: &Link, discs: &[Disc], laws: &Laws) -> f64 {
    let overlap = link.overlap(discs, laws).max(0.0);
    let speed = link.velocity(discs).dot(link.normal(discs));
    let force = laws.stiffness * overlap + laws.damping * speed;
    if laws.ending == Ending::NoAttraction { force.max(0.0) } else { force }
}

/// What contacts do within a step of an explicit rule, to its first order: for the record only.
fn pushes(discs: &[Disc], links: &[Link], laws: &Laws, h: f64) -> Vec<Work> {
    let work = |&link: &Link| {
        let normal = link.normal(discs);
        let speed = link.velocity(discs).dot(normal);
        Work {
            link,
            begins: 0.0,
            approach_speed: speed,
            normal,
            centre: discs[link.a].position,
            impulse: force(&link, discs, laws) * h,
            loss: laws.damping * speed * speed * h,
            deepest: link.overlap(discs, laws),
        }
    };
    links.iter().map(work).filter(|work| work.impulse != 0.0).collect()
}

fn put(state: &State, discs: &mut [Disc]) {
    for (k, disc) in discs.iter_mut().enumerate() {
        (disc.position, disc.velocity) = (state.positions[k], state.velocities[k]);
    }
}
