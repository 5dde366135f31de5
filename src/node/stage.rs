//! The stage: the world, the pucks by name, and whether time passes. What may be done to them while
//! the node runs is done here, whole or not at all.
//!
//! It knows no topic and no service: those who ask turn their messages into calls.

use std::collections::{BTreeSet, HashSet};
use std::time::Instant;

use glam::DVec2;

use super::timeline::Timeline;
use crate::bag::journal::{Asked, DriveLine, Entry, Line};
use crate::messages::Header;
use crate::motion::watch::{Look, Turn, Watcher};
use crate::scene::file::{is_token, no_token};
use crate::scene::{Puck, Scene};
use crate::world::{
    Command, Disc, DiscId, Drive, Instants, NotDone, Outcome, Owner, Settings, Walls, World, limits,
};

/// What the simulation does, as simulation_interfaces has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// At the start, and time stands still.
    Stopped,
    /// Time passes.
    Playing,
    /// Time stands still.
    Paused,
    /// There is no scene.
    NoWorld,
}

/// What a reset brings back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scope {
    /// Time is 0 again.
    pub time: bool,
    /// Pucks are where and as fast as they were first.
    pub state: bool,
    /// Pucks that were added are gone, and those that were taken away are back.
    pub spawned: bool,
}

/// Everything.
pub const ALL: Scope = Scope { time: true, state: true, spawned: true };

/// Why a puck is not added.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NotAdded {
    /// The name is in use.
    #[error("the name `{0}` is taken; allow renaming, or choose another")]
    Taken(String),
    /// It is no name.
    #[error("{}", no_token(.0))]
    Name(String),
    /// The arena does not take it there.
    #[error(transparent)]
    NotDone(#[from] NotDone),
}

/// The world and its pucks.
pub struct Stage {
    /// As it was loaded: a reset goes back to it.
    scene: Scene,
    /// Those that are there, as they were when they came.
    pucks: Vec<Puck>,
    spawned: HashSet<DiscId>,
    /// The next id for a puck that is added.
    next_id: DiscId,
    world: World,
    state: State,
    /// What was done to the world, where somebody keeps it.
    journal: Option<Vec<Entry>>,
    /// Simulated time.
    pub time: Timeline,
}

/// Where a report comes from.
#[derive(Clone, Debug)]
pub enum Source {
    /// It is the last message of the topic of this whole name.
    Topic(String),
    /// It was made of a message with this header.
    Made(Header),
}

impl Stage {
    /// A scene at its beginning, playing.
    pub fn new(scene: Scene, time: Timeline) -> Self {
        let (world, pucks) = (scene.world(), scene.pucks.clone());
        let next_id = first_free_id(&pucks);
        let (spawned, state) = (HashSet::new(), State::Playing);
        Self { scene, pucks, spawned, next_id, world, state, journal: None, time }
    }

    /// Keeps a journal from now on.
    pub fn keep_journal(&mut self) {
        self.journal = Some(Vec::new());
    }

    /// What was done to the world since it was last asked for.
    pub fn take_journal(&mut self) -> impl Iterator<Item = Entry> {
        self.journal.iter_mut().flat_map(|journal| journal.drain(..))
    }

    fn note(&mut self, entry: impl FnOnce() -> Entry) {
        if let Some(journal) = &mut self.journal {
            journal.push(entry());
        }
    }

    /// The scene as it was loaded.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The pucks that are there, as they were when they came, in no order.
    pub fn pucks(&self) -> &[Puck] {
        &self.pucks
    }

    /// The puck of a name.
    pub fn puck(&self, name: &str) -> Option<&Puck> {
        self.pucks.iter().find(|puck| puck.name == name)
    }

    /// Whether it was added while the node ran.
    pub fn was_spawned(&self, puck: &Puck) -> bool {
        self.spawned.contains(&puck.disc.id)
    }

    /// The world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Looks at the arena for a watcher, if there is one.
    pub fn look(&mut self, watcher: &mut Watcher, turns: &mut Vec<Turn>) -> Option<Look> {
        self.world.look(watcher, turns)
    }

    /// Keeps account of the arena's momentum from now on.
    pub fn keep_account(&mut self) {
        self.world.keep_account();
    }

    /// One step of the world: what was asked, and then on.
    pub fn step(
        &mut self,
        command: Option<(Command, Option<Source>)>,
        instants: Instants,
    ) -> Outcome {
        if let Some(journal) = &mut self.journal {
            let asked = command.as_ref().map(|(command, source)| match source {
                Some(Source::Topic(topic)) => Asked::Message { topic: topic.clone() },
                Some(Source::Made(header)) => Asked::new(command, header),
                None => Asked::new(command, &Header::default()),
            });
            let asked = asked.map(Box::new);
            let heard = Some(instants.heard_at).filter(|heard| heard.is_finite());
            journal.push(Entry::Step { to: instants.advance_to, heard, asked });
        }
        let commands: Vec<Command> = command.map(|(command, _)| command).into_iter().collect();
        self.world.step(&commands, instants)
    }

    // What is set from now on holds after a reset too, and for scenes that are loaded.

    /// Observed circles not heard of for so long leave from now on, s.
    pub fn set_stale_after(&mut self, time: f64) {
        self.note(|| Entry::Setting { name: "stale_after_s".to_owned(), value: time });
        self.scene.settings.stale_after = time;
        self.world.set_stale_after(time);
    }

    /// Observed circles with a gap up to this count as in contact from now on, m.
    pub fn set_contact_margin(&mut self, margin: f64) {
        self.note(|| Entry::Setting { name: "contact_margin_m".to_owned(), value: margin });
        self.scene.settings.contact_margin = margin;
        self.world.set_contact_margin(margin);
    }

    /// Commands are over after so long from now on, s of simulated time.
    pub fn set_command_timeout(&mut self, time: f64) {
        self.note(|| Entry::Setting { name: "command_timeout_s".to_owned(), value: time });
        self.scene.settings.command_timeout = time;
        self.world.set_command_timeout(time);
    }

    /// Forgets all observed circles.
    pub fn forget_observed(&mut self) {
        self.note(|| Entry::Forget {});
        self.world.forget_observed();
    }

    /// What it does.
    pub fn state(&self) -> State {
        self.state
    }

    /// The pucks as they are now, with their names, by id.
    pub fn now(&self) -> Vec<(&Puck, Disc)> {
        let arena = self.world.arena();
        let mut discs: Vec<Disc> =
            arena.into_iter().flat_map(|arena| arena.discs(Owner::Simulated)).collect();
        discs.sort_unstable_by_key(|disc| disc.id);
        let mut pucks: Vec<&Puck> = self.pucks.iter().collect();
        pucks.sort_unstable_by_key(|puck| puck.disc.id);
        debug_assert_eq!(pucks.len(), discs.len(), "a puck a disc");
        pucks.into_iter().zip(discs).collect()
    }

    /// Adds a puck; its name is changed if it is taken and that is allowed, and made up if it is
    /// empty. Returns the name that it has.
    ///
    /// # Errors
    /// [`NotAdded`]; nothing is changed then.
    pub fn add(&mut self, mut puck: Puck, rename: bool) -> Result<String, NotAdded> {
        if puck.name.is_empty() || (rename && self.puck(&puck.name).is_some()) {
            if !rename {
                return Err(NotAdded::Name(puck.name));
            }
            puck.name = self.free_name(&puck.name);
        }
        if !is_token(&puck.name) {
            return Err(NotAdded::Name(puck.name));
        }
        if self.puck(&puck.name).is_some() {
            return Err(NotAdded::Taken(puck.name));
        }
        puck.disc.id = self.next_id;
        if self.world.arena().is_none() {
            self.found_arena(puck.disc)?;
        } else {
            self.ask(Command::AddPuck(puck.disc))?;
        }
        self.drive(&puck);
        self.next_id += 1;
        self.spawned.insert(puck.disc.id);
        self.pucks.push(puck.clone());
        Ok(puck.name)
    }

    /// Takes a puck away.
    ///
    /// # Errors
    /// [`NotDone`]; nothing is changed then.
    pub fn remove(&mut self, id: DiscId) -> Result<(), NotDone> {
        self.ask(Command::RemovePuck { id })?;
        self.pucks.retain(|puck| puck.disc.id != id);
        self.spawned.remove(&id);
        Ok(())
    }

    /// Puts a puck elsewhere.
    ///
    /// # Errors
    /// [`NotDone`]; nothing is changed then.
    pub fn place(&mut self, id: DiscId, at: DVec2, velocity: DVec2) -> Result<(), NotDone> {
        self.ask(Command::PlacePuck { id, position: at, velocity })
    }

    /// Pucks that are there are like this from now on, all at once: where they stand in each
    /// other's way now, they may not then. Those that are driven go on as they look, with no
    /// command.
    ///
    /// # Errors
    /// [`NotDone`]; all are as before then, but for their commands.
    pub fn replace(&mut self, discs: &[Disc]) -> Result<(), NotDone> {
        let ids: BTreeSet<DiscId> = discs.iter().map(|disc| disc.id).collect();
        let as_is: Vec<(Disc, Option<Drive>)> = self
            .now()
            .into_iter()
            .filter(|(_, disc)| ids.contains(&disc.id))
            .map(|(_, disc)| (disc, self.drive_as_it_looks(disc.id)))
            .collect();
        for id in &ids {
            self.ask(Command::RemovePuck { id: *id })?;
        }
        let added: Result<(), NotDone> =
            discs.iter().try_for_each(|disc| self.ask(Command::AddPuck(*disc)));
        if added.is_err() {
            for (disc, _) in &as_is {
                // Of those that were added some are there.
                let _ = self.ask(Command::RemovePuck { id: disc.id });
            }
            // Where they have been there is room.
            as_is.iter().try_for_each(|(disc, _)| self.ask(Command::AddPuck(*disc)))?;
        }
        for (disc, drive) in &as_is {
            drive.iter().for_each(|drive| self.give(disc.id, *drive));
        }
        if added.is_ok() {
            for puck in &mut self.pucks {
                if let Some(disc) = discs.iter().find(|disc| disc.id == puck.disc.id) {
                    (puck.disc.radius, puck.disc.mass) = (disc.radius, disc.mass);
                }
            }
        }
        added
    }

    /// What a driven puck can, looking where it looks now.
    fn drive_as_it_looks(&self, id: DiscId) -> Option<Drive> {
        let (drive, pose) = (self.world.drive_of(id)?, self.world.pose(id)?);
        Some(Drive { heading: pose.heading, ..drive })
    }

    /// Goes back to the beginning, in part or in all. Observed circles are forgotten where time is.
    ///
    /// # Errors
    /// Why not; nothing is changed then.
    pub fn reset(&mut self, scope: Scope, now: Instant) -> Result<(), String> {
        let before: Vec<(Puck, Disc)> =
            self.now().into_iter().map(|(puck, disc)| (puck.clone(), disc)).collect();
        let is_spawned = |puck: &Puck| self.spawned.contains(&puck.disc.id);
        let mut after: Vec<(Puck, Disc)> =
            before.into_iter().filter(|(puck, _)| !scope.spawned || !is_spawned(puck)).collect();
        if scope.spawned {
            let is_there = |puck: &Puck| after.iter().any(|(other, _)| other.name == puck.name);
            let back: Vec<&Puck> = self.scene.pucks.iter().filter(|puck| !is_there(puck)).collect();
            after.extend(back.into_iter().map(|puck| (puck.clone(), puck.disc)));
        }
        if scope.state {
            after.iter_mut().for_each(|(puck, disc)| *disc = puck.disc);
        }
        after.sort_by_key(|(puck, _)| puck.disc.id);
        self.rebuild(after, scope.time, now)
    }

    /// Another scene instead of this one, stopped.
    pub fn load(&mut self, scene: Scene, now: Instant) {
        let text = Some(scene.text.to_string());
        self.take_over(scene, text, now);
    }

    /// What of a scene's `node` this node does otherwise, and goes on to, by its keys.
    pub fn does_otherwise(&self, scene: &Scene) -> Vec<&'static str> {
        let (own, its) = (&self.scene.settings, &scene.settings);
        let (node, its_node) = (&self.scene.node, &scene.node);
        let all = [
            ("publish_rate_hz", node.publish_rate_hz != its_node.publish_rate_hz),
            ("frame_id", node.frame_id != its_node.frame_id),
            ("circle_topics", node.circle_topics != its_node.circle_topics),
            ("contact_margin_m", own.contact_margin != its.contact_margin),
            ("stale_after_s", own.stale_after != its.stale_after),
            ("command_timeout_s", own.command_timeout != its.command_timeout),
        ];
        all.into_iter().filter(|(_, differs)| *differs).map(|(key, _)| key).collect()
    }

    /// `text`: what the journal is told, from which the scene can be made again.
    fn take_over(&mut self, scene: Scene, text: Option<String>, now: Instant) {
        // How the node runs is the node's affair, whatever it runs.
        let settings = Settings {
            stale_after: self.scene.settings.stale_after,
            contact_margin: self.scene.settings.contact_margin,
            command_timeout: self.scene.settings.command_timeout,
            ..scene.settings
        };
        self.scene = Scene { settings, node: self.scene.node.clone(), ..scene };
        (self.world, self.pucks) = (self.scene.world(), self.scene.pucks.clone());
        self.note(|| Entry::Scene { text });
        self.spawned.clear();
        self.next_id = first_free_id(&self.pucks);
        self.time.restart(now);
        self.time.pause();
        self.state = State::Stopped;
    }

    /// No scene: observed circles are still answered.
    pub fn unload(&mut self, now: Instant) {
        let nothing = Scene { name: String::new(), pucks: Vec::new(), ..self.scene.clone() };
        self.take_over(nothing, None, now);
        self.state = State::NoWorld;
    }

    /// Time passes.
    pub fn play(&mut self, now: Instant) {
        self.state = State::Playing;
        self.time.resume(now);
    }

    /// Time stands still.
    pub fn pause(&mut self) {
        self.state = State::Paused;
        self.time.pause();
    }

    /// Time stands still, at the beginning.
    ///
    /// # Errors
    /// As [`Stage::reset`].
    pub fn stop(&mut self, now: Instant) -> Result<(), String> {
        self.reset(ALL, now)?;
        self.time.pause();
        self.state = State::Stopped;
        Ok(())
    }

    /// The first puck of a world that had none: time begins.
    fn found_arena(&mut self, disc: Disc) -> Result<(), NotDone> {
        if let Some(defect) = disc.refusal() {
            return Err(NotDone::Defect(defect));
        }
        let inside = |walls: &Walls| walls.contain(disc.position, disc.radius);
        let Settings { walls, segments, .. } = &self.scene.settings;
        let is_in_segment = segments.is_some_and(|segments| segments.refuse(&disc, walls.as_ref()));
        if is_in_segment || !walls.as_ref().is_none_or(inside) {
            return Err(NotDone::OutsideWalls);
        }
        self.world = World::new(self.scene.settings, &[disc]);
        self.note(|| Entry::World { pucks: vec![Line::new(&disc)] });
        Ok(())
    }

    /// One command, between two steps.
    ///
    /// # Errors
    /// [`NotDone`]; nothing is changed then.
    pub fn ask(&mut self, command: Command) -> Result<(), NotDone> {
        let reached = self.world.arena().map_or(0.0, |arena| arena.now());
        // What is heard now is not what makes circles stale.
        let instants = Instants { heard_at: f64::NEG_INFINITY, advance_to: reached };
        let mut outcome = self.step(Some((command, None)), instants);
        outcome.not_done.pop().map_or(Ok(()), |(_, why)| Err(why))
    }

    fn rebuild(
        &mut self,
        pucks: Vec<(Puck, Disc)>,
        time: bool,
        now: Instant,
    ) -> Result<(), String> {
        let discs: Vec<Disc> = pucks.iter().map(|(_, disc)| *disc).collect();
        if let Some((a, b)) = overlapping(&pucks)? {
            return Err(format!("`{a}` and `{b}` would overlap: reset what was spawned too"));
        }
        if time || self.world.arena().is_none() {
            self.world = World::new(self.scene.settings, &discs);
            self.world.watch(self.scene.referee());
            self.note(|| Entry::World { pucks: discs.iter().map(Line::new).collect() });
            self.time.restart(now);
        } else {
            let wrong = |error: NotDone| error.to_string();
            self.move_walls_back().map_err(wrong)?;
            let gone: Vec<DiscId> = self.pucks.iter().map(|puck| puck.disc.id).collect();
            for id in gone {
                self.ask(Command::RemovePuck { id }).map_err(wrong)?;
            }
            for disc in discs {
                self.ask(Command::AddPuck(disc)).map_err(wrong)?;
            }
        }
        self.pucks = pucks.into_iter().map(|(puck, _)| puck).collect();
        let all = self.pucks.clone();
        all.iter().for_each(|puck| self.drive(puck));
        let left: HashSet<DiscId> = self.pucks.iter().map(|puck| puck.disc.id).collect();
        self.spawned.retain(|id| left.contains(id));
        Ok(())
    }

    /// A puck that has come follows its commands, if it is driven.
    fn drive(&mut self, puck: &Puck) {
        if let Some(ball) = puck.ball {
            let id = puck.disc.id;
            self.note(|| Entry::Ball { id, ball });
            self.world.add_ball(id, ball);
        }
        if puck.driven {
            self.give(puck.disc.id, puck.drive);
        }
    }

    fn give(&mut self, id: DiscId, drive: Drive) {
        self.note(|| Entry::Driven { id, drive: Box::new(DriveLine::new(&drive)) });
        self.world.drive(id, drive);
    }

    /// To where the scene has them.
    fn move_walls_back(&mut self) -> Result<(), NotDone> {
        match self.scene.settings.walls {
            Some(Walls { min, max, .. }) if self.scene.settings.walls != self.world.walls() => {
                self.ask(Command::MoveWalls { min, max })
            }
            _ => Ok(()),
        }
    }

    fn free_name(&self, wished: &str) -> String {
        let base = if is_token(wished) { wished.trim_end_matches('_') } else { "puck" };
        // There are fewer pucks than numbers.
        let mut names = (1u32..).map(|k| format!("{base}_{k}"));
        names.find(|name| self.puck(name).is_none()).unwrap_or_default()
    }
}

fn first_free_id(pucks: &[Puck]) -> DiscId {
    let last = pucks.iter().map(|puck| puck.disc.id).max();
    last.map_or(limits::FIRST_PUCK_ID, |last| (last + 1).max(limits::FIRST_PUCK_ID))
}

/// The names of two pucks that overlap by more than rounding.
fn overlapping(pucks: &[(Puck, Disc)]) -> Result<Option<(String, String)>, String> {
    let discs: Vec<Disc> = pucks.iter().map(|(_, disc)| *disc).collect();
    let pairs = crate::detect::touching_pairs(&discs, 0.0, crate::plan::BroadPhase::Grid)
        .map_err(|error| error.to_string())?;
    let deep = |&(i, j): &(usize, usize)| {
        let (a, b) = (&discs[i], &discs[j]);
        let sum = a.radius + b.radius;
        a.position.distance(b.position) < sum * (1.0 - limits::OVERLAP_OF_ROUNDING)
    };
    let names = |(i, j): (usize, usize)| (pucks[i].0.name.clone(), pucks[j].0.name.clone());
    Ok(pairs.into_iter().find(deep).map(names))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::file;
    use crate::world::Wanted;

    const SCENE: &str = "pucks:\n  - name: alice\n    position: [0, 0]\n    radius: 0.1\n    \
        drive: {model: holonomic, acceleration_max: 1.0}\n";

    /// Speed of alice after a tenth of a second at full drive.
    fn speed(stage: &mut Stage) -> f64 {
        let begin = stage.world().arena().map_or(0.0, |arena| arena.now());
        let (id, heard_at) = (stage.pucks()[0].disc.id, f64::NEG_INFINITY);
        let wanted = Wanted { linear: DVec2::X, ..Wanted::default() };
        let asked = Some((Command::Drive { id, wanted }, None));
        stage.step(asked, Instants { heard_at, advance_to: begin });
        stage.step(None, Instants { heard_at, advance_to: begin + 0.1 });
        stage.now()[0].1.velocity.length()
    }

    #[test]
    fn what_was_set_holds_after_a_reset() {
        // It is written above.
        let scene = file::parse(SCENE, "test").expect("a sound scene");
        let now = Instant::now();
        for time in [true, false] {
            let mut stage = Stage::new(scene.clone(), Timeline::new(1.0, 10.0, None, now));
            stage.set_command_timeout(0.01);
            // What is reset overlaps nothing.
            stage.reset(Scope { time, ..ALL }, now).expect("nobody is in the way");
            let moved = speed(&mut stage);
            assert!(moved < 0.05, "{moved}: it goes on after its command is over");
        }
    }

    #[test]
    fn a_drive_keeps_its_limits_after_a_reset() {
        // It is written above.
        let scene = file::parse(SCENE, "test").expect("a sound scene");
        let now = Instant::now();
        let mut stage = Stage::new(scene, Timeline::new(1.0, 10.0, None, now));
        for time in [true, false] {
            let moved = speed(&mut stage);
            assert!((0.05..0.15).contains(&moved), "{moved}");
            // What is reset overlaps nothing.
            stage.reset(Scope { time, ..ALL }, now).expect("nobody is in the way");
        }
        let moved = speed(&mut stage);
        assert!((0.05..0.15).contains(&moved), "{moved}");
    }
}
