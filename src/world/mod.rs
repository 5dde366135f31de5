//! The world: the nouns of carom, and [`World::step`], the one page that names every stage.
//!
//! Every circle has one owner. A simulated puck is moved by the arena. An observed circle belongs
//! to whoever reports it: the world never moves it, it says what its velocity must be after its
//! contacts. Without pucks there is no arena and nothing to advance: a pure resolver.

mod ball;
mod command;
mod contact;
mod disc;
mod drives;
mod observed;
mod periodic;
mod play;
mod segments;
mod walls;

pub mod limits;

use std::collections::HashSet;

pub use ball::{Ball, BallMotion, Kick};
pub use command::{Answer, Command, Instants, NotDone, Outcome, Refusal, Report};
pub use contact::{Contact, Partner};
pub use disc::{Defect, Disc, DiscId};
pub use drives::{Drive, Frame, HOLD_GAP_M, Kicker, Model, PULL_MPS2, Pose, Wanted};
pub use periodic::Periodic;
pub use segments::{BadSegment, Segment, Segments};
pub use walls::{Side, Walls};

use glam::DVec2;

use crate::detect::{self, Pair, TooManyPairs};
use crate::motion::arena::Arena;
use crate::motion::watch::{Look, Turn, Watcher};
use crate::plan::parts::{Part, Parts};
use crate::plan::{Method, Plan};
use crate::referee::Referee;
use crate::resolve;
use drives::Drives;
use observed::Observed;

/// Whose word counts for a disc's state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Owner {
    /// The arena moves it.
    Simulated,
    /// Somebody else reports it.
    Observed,
}

/// Settings of a world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Restitution of pairs, 0 to 1.
    pub restitution: f64,
    /// The box around the arena, if there is one.
    pub walls: Option<Walls>,
    /// Line segments that bound the arena, inside of the walls if there are any; not with gravity,
    /// drag or a periodic box.
    pub segments: Option<Segments>,
    /// The periodic box around the arena, if there is one; not with walls or gravity. Observed
    /// circles meet pucks across its border, but not each other.
    pub periodic: Option<Periodic>,
    /// The same acceleration of all simulated pucks of finite mass, m/s^2, if there is one.
    pub gravity: Option<DVec2>,
    /// The same linear drag of all discs, `v' = -drag v`, 1/s; not with gravity. Observed circles
    /// slow down too until they are reported again.
    pub drag: f64,
    /// Contact time of the collapse model, s; `None` = derived from the pucks.
    pub contact_time: Option<f64>,
    /// How pucks shall move; `None` = the plan chooses.
    pub method: Option<Method>,
    /// What methods with a step of their own need.
    pub pace: Pace,
    /// Observed circles with a gap up to this count as in contact, m.
    pub contact_margin: f64,
    /// Observed circles not heard of for so long leave the world, s.
    pub stale_after: f64,
    /// A command to a driven puck is over after so long, s of simulated time, and the puck stops; 0
    /// = never.
    pub command_timeout: f64,
    /// Parts to be built though nothing needs them: no bit of a result changes.
    pub keep: Parts,
}

/// What methods with a step of their own need; the others do not look at it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Length of a step of the methods steps and springs, s.
    pub step: f64,
    /// Length of a tick of the method ticks, s: that of the commands.
    pub tick: f64,
    /// Spring constant of a contact, N/m.
    pub stiffness: f64,
    /// Dashpot constant of a contact, N s/m.
    pub damping: f64,
}

impl Default for Pace {
    fn default() -> Self {
        Self {
            step: limits::STEP_S,
            tick: limits::TICK_S,
            stiffness: limits::STIFFNESS_NPM,
            damping: 0.0,
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            restitution: 1.0,
            walls: None,
            segments: None,
            periodic: None,
            gravity: None,
            drag: 0.0,
            contact_time: None,
            method: None,
            pace: Pace::default(),
            contact_margin: 0.0,
            stale_after: limits::STALE_AFTER_S,
            command_timeout: 0.0,
            keep: Parts::NONE,
        }
    }
}

/// All circles, and the laws that they obey.
#[derive(Clone, Debug)]
pub struct World {
    settings: Settings,
    plan: Plan,
    observed: Observed,
    /// Observed circles as the last answer left them: kept for its memory only.
    scratch: Vec<Disc>,
    pucks: HashSet<DiscId>,
    drives: Drives,
    referee: Option<Referee>,
    arena: Option<Arena>,
}

impl World {
    /// A world with these simulated pucks at time 0: sound, with unique ids, none overlapping. A
    /// method that does not suit them is not taken: [`Plan::choose`] says why.
    pub fn new(settings: Settings, pucks: &[Disc]) -> Self {
        let mut plan = Plan::of(&settings, pucks);
        // Scenes and the command line have asked; who did not gets what the plan chooses.
        let _ = plan.choose(settings.method, &settings, pucks);
        let arena = (!pucks.is_empty()).then(|| Arena::new(&plan, plan.laws(&settings), pucks));
        let pucks = pucks.iter().map(|puck| puck.id).collect();
        let (observed, scratch) = (Observed::default(), Vec::new());
        let drives = Drives::new(settings.pace.tick, settings.command_timeout);
        Self { settings, plan, observed, scratch, pucks, drives, referee: None, arena }
    }

    /// A puck is driven from now on: [`Command::Drive`] says where to.
    pub fn drive(&mut self, id: DiscId, drive: Drive) {
        self.drives.add(id, drive);
    }

    /// A puck is a ball from now on: it slides, rolls and stops. Its velocity is that of a ball
    /// without spin.
    pub fn add_ball(&mut self, id: DiscId, ball: Ball) {
        let Some(arena) = &mut self.arena else { return };
        let Some(disc) = arena.disc(id) else { return };
        let velocity = self.drives.add_ball(&disc, ball, arena.now());
        arena.set_velocity(id, velocity);
    }

    /// Crashes are told from now on; `None` = no longer.
    pub fn watch(&mut self, referee: Option<Referee>) {
        self.referee = referee;
    }

    /// Goals of the teams 0 and 1, where somebody [watches](Self::watch) a field.
    pub fn score(&self) -> Option<[u32; 2]> {
        self.referee.as_ref().and_then(Referee::score)
    }

    /// How a ball moves now, at this very instant: the arena has the mean velocity of the tick.
    pub fn ball(&self, id: DiscId) -> Option<BallMotion> {
        let arena = self.arena.as_ref()?;
        self.drives.motion(&arena.disc(id)?, arena.now())
    }

    /// The kick from which a ball moves, until it stands, is held or is moved by hand.
    pub fn kick_of(&self, id: DiscId) -> Option<Kick> {
        self.drives.kick_of(id)
    }

    /// Whether a ball is in the mouth of a robot: it can kick it.
    pub fn has_ball(&self, id: DiscId) -> bool {
        let discs = self.arena.as_ref().map(|arena| arena.discs(Owner::Simulated).collect());
        discs.is_some_and(|discs: Vec<Disc>| self.drives.in_mouth(id, &discs).is_some())
    }

    /// The speed of the kick with which a robot waits for a ball, m/s.
    pub fn armed(&self, id: DiscId) -> Option<f64> {
        self.drives.armed(id)
    }

    /// When a robot last kicked a ball, s.
    pub fn kicked_at(&self, id: DiscId) -> Option<f64> {
        self.drives.kicked_at(id)
    }

    /// What a driven puck can.
    pub fn drive_of(&self, id: DiscId) -> Option<Drive> {
        self.drives.drive(id)
    }

    /// Heading and turning rate of a driven puck.
    pub fn pose(&self, id: DiscId) -> Option<Pose> {
        self.drives.pose(id)
    }

    /// One step: what was asked, what touches, what that does, what time brings.
    pub fn step(&mut self, commands: &[Command], instants: Instants) -> Outcome {
        let mut outcome = Outcome::default();
        self.forget_stale(instants.heard_at);
        for (place, command) in commands.iter().enumerate() {
            if let Command::Observe(report) = command {
                let refused = self.apply(report, instants.heard_at);
                let pairs = self.detect();
                outcome.answers.push(self.resolve(pairs, report.time, refused));
            } else if let Err(error) = self.command_arena(command) {
                outcome.not_done.push((place, error));
            }
        }
        self.advance(instants.advance_to, &mut outcome);
        outcome
    }

    /// What was decided for it.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The arena, if there are simulated pucks.
    pub fn arena(&self) -> Option<&Arena> {
        self.arena.as_ref()
    }

    /// Looks at the arena for a watcher, if there are simulated pucks.
    pub fn look(&mut self, watcher: &mut Watcher, turns: &mut Vec<Turn>) -> Option<Look> {
        self.arena.as_mut().map(|arena| watcher.look(arena, turns))
    }

    /// Keeps account of the arena's momentum from now on, where its method can.
    pub fn keep_account(&mut self) {
        let Some(arena) = &mut self.arena else { return };
        arena.keep_account();
        if Part::Account.is_known_to(self.plan.method) {
            self.plan.built = self.plan.built.and(Parts::only(Part::Account));
        }
    }

    /// The observed circles, as they were last reported.
    pub fn observed(&self) -> &[Disc] {
        self.observed.discs()
    }

    /// Observed circles held at present.
    pub fn observed_count(&self) -> usize {
        self.observed.discs().len()
    }

    /// Observed circles not heard of for so long leave from now on, s.
    pub fn set_stale_after(&mut self, stale_after: f64) {
        self.settings.stale_after = stale_after;
        self.observed.look_again();
    }

    /// Commands are over after so long from now on, s of simulated time; 0 = never.
    pub fn set_command_timeout(&mut self, timeout: f64) {
        self.settings.command_timeout = timeout;
        self.drives.set_timeout(timeout);
    }

    /// Observed circles with a gap up to this count as in contact from now on, m.
    pub fn set_contact_margin(&mut self, contact_margin: f64) {
        self.settings.contact_margin = contact_margin;
    }

    /// The walls where they are now.
    pub fn walls(&self) -> Option<Walls> {
        self.settings.walls
    }

    /// Forgets all observed circles: the clock by which they are stale has jumped back.
    pub fn forget_observed(&mut self) {
        let all = self.observed.clear();
        self.arena.iter_mut().for_each(|arena| arena.forget(&all));
    }

    fn forget_stale(&mut self, now: f64) {
        let stale = self.observed.drop_stale(now, self.settings.stale_after);
        if let Some(arena) = self.arena.as_mut().filter(|_| !stale.is_empty()) {
            arena.forget(&stale);
        }
    }

    /// Apply: what is asked of the arena.
    fn command_arena(&mut self, command: &Command) -> Result<(), NotDone> {
        let arena = match (&mut self.arena, command) {
            (Some(arena), _) => arena,
            // Nobody is there who could have a velocity.
            (None, Command::SetVelocity { .. } | Command::Drive { .. }) => return Ok(()),
            (None, _) => return Err(NotDone::NoArena),
        };
        match *command {
            Command::SetVelocity { id, velocity } => {
                arena.set_velocity(id, velocity);
                self.drives.let_go(arena, id, None);
            }
            Command::Drive { id, wanted } => {
                if let Some(velocity) = self.drives.command(id, wanted, arena.now()) {
                    arena.set_velocity(id, velocity);
                    self.drives.let_go(arena, id, None);
                }
            }
            Command::Kick { .. }
            | Command::Dribble { .. }
            | Command::Pull { .. }
            | Command::Turn { .. }
            | Command::SetDrive { .. }
            | Command::Roll { .. } => play::play(&mut self.drives, arena, command)?,
            Command::AddPuck(puck) => {
                if self.pucks.len() >= limits::PUCKS_PER_SCENE {
                    return Err(NotDone::TooMany);
                }
                if self.observed.place(puck.id).is_some() {
                    return Err(NotDone::Taken(puck.id));
                }
                arena.add(puck)?;
                self.pucks.insert(puck.id);
            }
            Command::RemovePuck { id } => {
                arena.remove(id)?;
                self.pucks.remove(&id);
                self.drives.remove(id);
                self.lose_sight(id);
            }
            Command::PlacePuck { id, position, velocity } => {
                arena.place(id, position, velocity)?;
                self.drives.pull(id, None);
                self.drives.let_go(arena, id, Some(DVec2::ZERO));
                self.lose_sight(id);
            }
            Command::MoveWalls { min, max } => {
                arena.move_walls(min, max)?;
                let moved = |walls: Walls| Walls { min, max, ..walls };
                self.settings.walls = self.settings.walls.map(moved);
            }
            // Whoever calls has looked: that is no question to the arena.
            Command::Observe(_) => {}
        }
        Ok(())
    }

    /// A puck was put elsewhere by hand: it has crossed nothing on the way.
    fn lose_sight(&mut self, id: DiscId) {
        self.referee.iter_mut().for_each(|referee| referee.lose_sight(id));
    }

    /// Apply: takes over a report, for the resolver and for the arena.
    fn apply(&mut self, report: &Report, heard_at: f64) -> Vec<(DiscId, Refusal)> {
        let Some(arena) = &mut self.arena else {
            return self.observed.take(&report.discs, heard_at);
        };
        let (simulated, discs): (Vec<Disc>, Vec<Disc>) =
            report.discs.iter().partition(|disc| self.pucks.contains(&disc.id));
        let (discs, wide): (Vec<Disc>, Vec<Disc>) =
            discs.into_iter().partition(|disc| !is_too_wide(&self.settings, disc));
        let mut refused = self.observed.take(&discs, heard_at);
        refused.extend(wide.iter().map(|disc| (disc.id, Refusal::TooWide)));
        let taken = discs.iter().filter(|disc| self.observed.place(disc.id).is_some());
        if arena.meets_observed() {
            taken.for_each(|disc| arena.observe(*disc));
        } else {
            refused.extend(taken.map(|disc| (disc.id, Refusal::NotMet)));
        }
        refused.extend(simulated.iter().map(|disc| (disc.id, Refusal::Simulated)));
        refused
    }

    /// Detect: touching pairs of observed circles, at least one of them in the last report.
    fn detect(&self) -> Result<Vec<Pair>, TooManyPairs> {
        let discs = self.observed.discs();
        let broad_phase = self.plan.broad_phase(discs.len());
        let mut pairs = detect::touching_pairs(discs, self.settings.contact_margin, broad_phase)?;
        let fresh = |k: usize| self.observed.is_in_last_report(k);
        pairs.retain(|&(i, j)| fresh(i) || fresh(j));
        Ok(pairs)
    }

    /// Resolve: what the contacts do to the velocities that were reported.
    fn resolve(
        &mut self,
        pairs: Result<Vec<Pair>, TooManyPairs>,
        time: f64,
        refused: Vec<(DiscId, Refusal)>,
    ) -> Answer {
        let pairs = match pairs {
            Ok(pairs) if !pairs.is_empty() => pairs,
            Ok(_) => return Answer { refused, ..Answer::default() },
            Err(error) => return Answer { refused, unresolved: Some(error), ..Answer::default() },
        };
        self.scratch.clear();
        self.scratch.extend_from_slice(self.observed.discs());
        let (discs, restitution) = (&mut self.scratch, self.settings.restitution);
        let resolved = resolve::touching::resolve(discs, &pairs, restitution, time);
        let velocity = |k: usize| (discs[k].id, discs[k].velocity);
        let velocities = resolved.touched.into_iter().map(velocity).collect();
        Answer { contacts: resolved.contacts, velocities, refused, unresolved: None }
    }

    /// Advance: moves the arena on; contacts with observed circles become corrections.
    fn advance(&mut self, until: f64, outcome: &mut Outcome) {
        let Some(arena) = &mut self.arena else { return };
        let mut noted = 0;
        let mut note =
            |drives: &mut Drives, referee: &mut Option<Referee>, outcome: &mut Outcome| {
                let new = &outcome.contacts[noted..];
                drives.note(new);
                referee.iter_mut().for_each(|referee| referee.hear(new, &mut outcome.crashes));
                noted = outcome.contacts.len();
            };
        let watch = |referee: &mut Option<Referee>, arena: &Arena| {
            referee.iter_mut().for_each(|referee| referee.see(arena.discs(Owner::Simulated)));
        };
        watch(&mut self.referee, arena);
        while let (Some(tick), None) = (self.drives.due(arena.now(), until), outcome.stall) {
            outcome.stall = arena.advance(tick, &mut outcome.contacts).err();
            note(&mut self.drives, &mut self.referee, outcome);
            // A storm of contacts may have kept it from getting there.
            if outcome.stall.is_some() || arena.now() < tick {
                break;
            }
            let discs: Vec<Disc> = arena.discs(Owner::Simulated).collect();
            let told = &mut outcome.goals;
            self.referee.iter_mut().for_each(|referee| referee.look(&discs, tick, told));
            let driven = self.drives.follow(tick, &discs);
            driven.into_iter().for_each(|(id, velocity)| arena.set_velocity(id, velocity));
            watch(&mut self.referee, arena);
        }
        if outcome.stall.is_none() && self.drives.due(arena.now(), until).is_none() {
            outcome.stall = arena.advance(until, &mut outcome.contacts).err();
            note(&mut self.drives, &mut self.referee, outcome);
        }
        if self.observed.discs().is_empty() {
            return;
        }
        let touched: HashSet<DiscId> = outcome.contacts.iter().flat_map(Contact::discs).collect();
        let observed = arena.discs(Owner::Observed).filter(|disc| touched.contains(&disc.id));
        outcome.corrections = observed.map(|disc| (disc.id, disc.velocity)).collect();
        outcome.corrections.sort_unstable_by_key(|(id, _)| *id);
    }
}

/// Whether a circle is too wide to meet pucks in a periodic box.
fn is_too_wide(settings: &Settings, disc: &Disc) -> bool {
    let side = settings.periodic.map(|periodic| periodic.size().min_element());
    side.is_some_and(|side| disc.radius > limits::RADIUS_IN_PERIODIC_BOX * side)
}
