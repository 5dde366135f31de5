//! Performing: what datagrams ask becomes commands to the stage, and what that says becomes faults.
//!
//! Every change goes through the stage, so that a recording has it. What is asked of one robot and
//! cannot be leaves the others theirs.

use std::collections::BTreeMap;

use glam::DVec2;

use crate::node::stage::Stage;
use crate::scene::Puck;
use crate::wire::field::Field;
use crate::wire::grsim::Status;
use crate::wire::orders::{Orders, PlaceBall, PlaceRobot};
use crate::wire::room::Room;
use crate::wire::specs::{Specs, SpecsChange};
use crate::wire::{Code, Faults, Kicked, RobotName, Seen, Team, View};
use crate::world::{Command, Disc, DiscId, Kick, NotDone, Pose};

/// A kick is told in a robot's status for so long, s: ten frames, as in grSim.
const KICK_TOLD_S: f64 = 10.0 / 60.0;
/// Robots so near to a ball that is teleported safely stand still then, m.
const STILL_WITHIN_M: f64 = 0.2;

/// What is known of robots beside the stage.
#[derive(Clone, Debug)]
pub struct Book {
    field: Field,
    specs: BTreeMap<RobotName, Specs>,
    /// Whether the kick that a robot was last told is a chip.
    chips: BTreeMap<RobotName, bool>,
}

impl Book {
    /// Nothing beyond the league.
    pub fn new(field: Field) -> Self {
        Self { field, specs: BTreeMap::new(), chips: BTreeMap::new() }
    }

    fn specs(&self, name: RobotName) -> Specs {
        self.specs.get(&name).copied().unwrap_or_else(|| Specs::new(&self.field))
    }

    /// Whether a robot has the ball at its dribbler.
    pub fn has_ball(&self, stage: &Stage, name: RobotName) -> bool {
        robot(stage, name).is_some_and(|puck| stage.world().has_ball(puck.disc.id))
    }

    /// The status of all robots of a team.
    pub fn status(&self, stage: &Stage, team: Team) -> Vec<(RobotName, Status)> {
        let world = stage.world();
        let now = world.arena().map_or(0.0, |arena| arena.now());
        let of_team = |puck: &Puck| Some((puck.member.filter(|it| it.team == team)?, puck.disc.id));
        let status = |(name, id): (RobotName, DiscId)| {
            let has_kicked = world.kicked_at(id).is_some_and(|at| now - at <= KICK_TOLD_S);
            let is_chip = self.chips.get(&name) == Some(&true);
            let has_ball = world.has_ball(id);
            (name, Status { has_ball, kicks: has_kicked && !is_chip, chips: has_kicked && is_chip })
        };
        let mut all: Vec<_> = stage.pucks().iter().filter_map(of_team).map(status).collect();
        all.sort_unstable_by_key(|(name, _)| *name);
        all
    }

    /// The game as it is.
    pub fn view(&self, stage: &Stage) -> View {
        view(stage, |name| self.specs(name).height)
    }

    /// Gives robots their orders.
    pub fn order(&mut self, stage: &mut Stage, orders: &Orders, faults: &mut Faults) {
        for (name, mut order) in orders.iter() {
            let Some((id, radius)) = robot(stage, name).map(|it| (it.disc.id, it.disc.radius))
            else {
                faults.add(Code::Unknown, format!("there is no robot {name}"));
                continue;
            };
            // Teams say in each command that they do not kick: that need not be asked.
            let waits = stage.world().armed(id).is_some();
            order.kick = order.kick.filter(|kick| kick.speed > 0.0 || waits);
            if let Some(kick) = order.kick.filter(|kick| kick.speed > 0.0) {
                self.chips.insert(name, kick.is_chip());
            }
            for command in order.commands(id, radius, &self.specs(name)) {
                let done = stage.ask(command);
                report(faults, name, done);
            }
        }
    }

    /// Changes what robots are.
    pub fn change(&mut self, stage: &mut Stage, changes: &[SpecsChange], faults: &mut Faults) {
        for change in changes {
            let name = change.name;
            let Some(puck) = robot(stage, name) else {
                faults.add(Code::Unknown, format!("robot_specs: there is no robot {name}"));
                continue;
            };
            let id = puck.disc.id;
            if let Some(drive) = stage.world().drive_of(id).filter(|_| change.limits.is_some()) {
                let drive = change.limits.apply(drive);
                let done = stage.ask(Command::SetDrive { id, drive });
                report(faults, name, done);
            }
            if change.radius.is_some() || change.mass.is_some() {
                let changed = |disc: Disc| Disc {
                    radius: change.radius.unwrap_or(disc.radius),
                    mass: change.mass.unwrap_or(disc.mass),
                    ..disc
                };
                let now = stage.world().arena().and_then(|arena| arena.disc(id)).map(changed);
                let done = now.map_or(Ok(()), |disc| stage.replace(&[disc]));
                report(faults, name, done);
            }
            let mut specs = self.specs(name);
            specs.change(change);
            self.specs.insert(name, specs);
        }
    }

    /// Puts robots and ball where they shall be; whether pucks have come or gone.
    pub fn place(
        &mut self,
        stage: &mut Stage,
        robots: &[PlaceRobot],
        ball: Option<&PlaceBall>,
        faults: &mut Faults,
    ) -> bool {
        let mut have_changed = false;
        let mut moving = Vec::new();
        for place in robots {
            let there = robot(stage, place.name).map(|puck| puck.disc.id);
            match (there, place.present) {
                (Some(id), Some(false)) => {
                    have_changed |= report(faults, place.name, stage.remove(id));
                }
                (None, Some(false)) => {}
                (None, Some(true)) => have_changed |= add(stage, place, faults),
                (None, None) => {
                    faults.add(Code::Unknown, format!("there is no robot {}", place.name));
                }
                (Some(_), _) if place.moves() && !place.by_force => moving.push(*place),
                (Some(id), _) => {
                    let to = place.by_force.then_some((place.x, place.y));
                    report(faults, place.name, pull(stage, id, to));
                }
            }
        }
        let ball = ball.filter(|it| !pull_ball(stage, it, faults));
        // Out of the way first, if it goes elsewhere; the robots may come to where it was.
        let first = |ball: &PlaceBall| PlaceBall { safely: false, ..*ball };
        let is_put = ball.is_some_and(|ball| put_ball(stage, &first(ball)).is_ok());
        move_all(stage, moving, faults);
        if let Some(ball) = ball.filter(|ball| !is_put || ball.safely) {
            match put_ball(stage, ball) {
                Ok(()) => {}
                Err(Some(why)) => faults.add(Code::NotDone, format!("ball: {why}")),
                Err(None) => faults.add(Code::Unknown, "there is no ball in this scene"),
            }
        }
        have_changed
    }
}

/// The game as it is on a stage, with robots so high (m).
pub fn view(stage: &Stage, height: impl Fn(RobotName) -> f64) -> View {
    let world = stage.world();
    let time = world.arena().map_or(0.0, |arena| arena.now());
    let score = world.score().unwrap_or_default();
    let mut view = View { time, score, ..View::default() };
    for (puck, Disc { id, position, velocity, radius, .. }) in stage.now() {
        if puck.ball.is_some() {
            let velocity = world.ball(id).map_or(velocity, |motion| motion.velocity);
            view.ball = Some((position, velocity));
            view.kicked = kicked(stage, puck, position);
        } else if let Some(name) = puck.member {
            let Pose { heading, turn } = world.pose(id).unwrap_or_default();
            let height = height(name);
            view.robots.push(Seen { name, position, velocity, heading, turn, radius, height });
        }
    }
    view.robots.sort_unstable_by_key(|robot| robot.name);
    view
}

/// The last kick of a ball that is here now, if it still moves from there.
fn kicked(stage: &Stage, ball: &Puck, here: DVec2) -> Option<Kicked> {
    let world = stage.world();
    let Kick { robot, position, velocity, time } = world.kick_of(ball.disc.id)?;
    let now = world.arena()?.now();
    let (law, motion) = (ball.ball?, world.ball(ball.disc.id)?);
    let rest = law.rests_after(motion);
    let stop = rest.is_finite().then(|| (now + rest, here + law.after(motion, rest).1));
    let by = stage.pucks().iter().find(|puck| puck.disc.id == robot).and_then(|it| it.member);
    Some(Kicked { by, position, velocity, time, stop })
}

/// The robot of a name, if it is there.
pub fn robot(stage: &Stage, name: RobotName) -> Option<&Puck> {
    stage.pucks().iter().find(|puck| puck.member == Some(name))
}

/// The ball, if there is one.
pub fn ball(stage: &Stage) -> Option<&Puck> {
    stage.pucks().iter().find(|puck| puck.ball.is_some())
}

/// Whether it was done; if not, that is a fault.
fn report(faults: &mut Faults, name: RobotName, done: Result<(), NotDone>) -> bool {
    match done {
        Ok(()) => true,
        Err(why) => {
            faults.add(Code::NotDone, format!("{name}: {why}"));
            false
        }
    }
}

/// Adds a robot like another of its team.
fn add(stage: &mut Stage, place: &PlaceRobot, faults: &mut Faults) -> bool {
    let PlaceRobot { name, x, y, .. } = *place;
    let (Some(x), Some(y)) = (x, y) else {
        faults.add(Code::Unreadable, format!("{name}: x and y are missing: where shall it be?"));
        return false;
    };
    let is_of_team = |puck: &&Puck| puck.member.is_some_and(|other| other.team == name.team);
    let all = || stage.scene().pucks.iter();
    let itself = all().find(|puck| puck.member == Some(name));
    let like = itself.or_else(|| all().find(is_of_team));
    let Some(mut puck) = like.cloned() else {
        faults.add(Code::Unknown, format!("{name}: the scene has no robot of its team"));
        return false;
    };
    if puck.member != Some(name) {
        (puck.name, puck.member) = (name.to_string(), Some(name));
    }
    (puck.disc.position, puck.disc.velocity) = (DVec2::new(x, y), place.velocity);
    puck.drive.heading = place.heading.unwrap_or(puck.drive.heading);
    match stage.add(puck, true) {
        Ok(_) => true,
        Err(why) => {
            faults.add(Code::NotDone, format!("{name}: {why}"));
            false
        }
    }
}

/// Lets a force draw a ball that is not put anywhere, or no more; whether that was asked.
fn pull_ball(stage: &mut Stage, ball: &PlaceBall, faults: &mut Faults) -> bool {
    let Some(id) = self::ball(stage).map(|puck| puck.disc.id) else { return false };
    let is_pulled = ball.by_force || !ball.moves();
    if is_pulled && let Err(why) = pull(stage, id, ball.by_force.then_some((ball.x, ball.y))) {
        faults.add(Code::NotDone, format!("ball: {why}"));
    }
    is_pulled
}

/// Draws a puck to a place, whose coordinates (m) are as they are where they are not said, or no
/// more.
fn pull(
    stage: &mut Stage,
    id: DiscId,
    to: Option<(Option<f64>, Option<f64>)>,
) -> Result<(), NotDone> {
    let now = stage.world().arena().and_then(|arena| arena.disc(id)).ok_or(NotDone::Unknown(id))?;
    let at = now.position;
    let to = to.map(|(x, y)| DVec2::new(x.unwrap_or(at.x), y.unwrap_or(at.y)));
    stage.ask(Command::Pull { id, to })
}

/// Where the ball shall be; nothing without a ball.
fn put_ball(stage: &mut Stage, ball: &PlaceBall) -> Result<(), Option<NotDone>> {
    let Some(puck) = self::ball(stage) else { return Err(None) };
    let id = puck.disc.id;
    let now = stage.world().arena().and_then(|arena| arena.disc(id)).ok_or(None)?;
    let velocity = stage.world().ball(id).map_or(now.velocity, |motion| motion.velocity);
    let at = DVec2::new(ball.x.unwrap_or(now.position.x), ball.y.unwrap_or(now.position.y));
    let velocity = DVec2::new(ball.vx.unwrap_or(velocity.x), ball.vy.unwrap_or(velocity.y));
    if ball.safely {
        make_way(stage, &Disc { position: at, ..now })?;
    }
    stage.place(id, at, velocity)?;
    if ball.roll {
        stage.ask(Command::Roll { id })?;
    }
    Ok(())
}

/// Robots that stand where the ball shall be go to the nearest place that is free, one after the
/// other by their names, and those beside it stand still. If there is no place for one, none moves.
fn make_way(stage: &mut Stage, ball: &Disc) -> Result<(), NotDone> {
    let mut robots: Vec<(RobotName, Disc)> =
        stage.now().iter().filter_map(|(puck, disc)| Some((puck.member?, *disc))).collect();
    robots.sort_unstable_by_key(|(name, _)| *name);
    let (walls, segments) = (stage.world().walls(), stage.scene().settings.segments);
    let others = stage.now().into_iter().map(|(_, disc)| disc).chain([*ball]).collect();
    let mut room = Room { walls, segments, others };
    if !room.holds(ball) {
        return Err(NotDone::OutsideWalls);
    }
    let gap = |disc: &Disc| disc.position.distance(ball.position) - disc.radius - ball.radius;
    let mut moved = Vec::new();
    for (_, robot) in robots.iter_mut().filter(|(_, robot)| gap(robot) < 0.0) {
        room.others.retain(|other| other.id != robot.id);
        robot.position = room.nearest(robot, ball.position).ok_or(NotDone::Overlaps(robot.id))?;
        room.others.push(*robot);
        moved.push((robot.id, robot.position));
    }
    for (id, at) in moved {
        stage.place(id, at, DVec2::ZERO)?;
    }
    for (_, robot) in robots.iter().filter(|(_, robot)| gap(robot) <= STILL_WITHIN_M) {
        let (id, heading) = (robot.id, stage.world().pose(robot.id).map(|pose| pose.heading));
        stage.ask(Command::SetVelocity { id, velocity: DVec2::ZERO })?;
        if let Some(heading) = heading {
            stage.ask(Command::Turn { id, heading, turn: 0.0 })?;
        }
    }
    Ok(())
}

/// Each robot that is in the way of another may itself be moving: those that cannot go yet are
/// tried again, and those that stand in each other's places go all at once.
fn move_all(stage: &mut Stage, mut waiting: Vec<PlaceRobot>, faults: &mut Faults) {
    let mut why = None;
    loop {
        let before = waiting.len();
        waiting.retain(|place| match move_one(stage, place) {
            Ok(()) => false,
            Err(error) => {
                why = Some(error);
                true
            }
        });
        if waiting.is_empty() {
            return;
        }
        if waiting.len() == before {
            break;
        }
    }
    let discs: Vec<Disc> = waiting.iter().filter_map(|place| goal(stage, place)).collect();
    if waiting.len() > 1 && stage.replace(&discs).is_ok() {
        waiting.iter().for_each(|place| turn(stage, place));
        return;
    }
    for place in waiting {
        let why = move_one(stage, &place).err().or(why);
        report(faults, place.name, why.map_or(Ok(()), Err));
    }
}

/// What a robot shall be like.
fn goal(stage: &Stage, place: &PlaceRobot) -> Option<Disc> {
    let id = robot(stage, place.name)?.disc.id;
    let now = stage.world().arena()?.disc(id)?;
    let position = DVec2::new(place.x.unwrap_or(now.position.x), place.y.unwrap_or(now.position.y));
    Some(Disc { position, velocity: place.velocity, ..now })
}

fn move_one(stage: &mut Stage, place: &PlaceRobot) -> Result<(), NotDone> {
    if let Some(Disc { id, position, velocity, .. }) = goal(stage, place) {
        stage.place(id, position, velocity)?;
        turn(stage, place);
    }
    Ok(())
}

fn turn(stage: &mut Stage, place: &PlaceRobot) {
    let Some(id) = robot(stage, place.name).map(|puck| puck.disc.id) else { return };
    let Some(pose) = stage.world().pose(id) else { return };
    let heading = place.heading.unwrap_or(pose.heading);
    // A robot that has a pose can be given one.
    let _ = stage.ask(Command::Turn { id, heading, turn: place.turn });
}
