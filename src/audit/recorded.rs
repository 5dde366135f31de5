//! Frames from a bag: circle states whole or in parts, or odometry of several robots.
//!
//! One set of parts is held at a time. Stamps are those of the headers; where all of them are 0,
//! the times of recording. The law that the recorder noted with its scene is taken over. What
//! cannot be read is left out and said.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use glam::DVec2;

use super::commanded::commanded;
use super::rounds::Rounds;
use super::{Bounds, Frame, Options};
use crate::bag::decode;
use crate::bag::journal::{Asked, Entry, NOTE};
use crate::bag::read::{Bag, Message, Topic};
use crate::messages::{CircleStates, Odometry, Time};
use crate::receive;
use crate::scene;
use crate::world::{Disc, DiscId};

/// The type of circle states.
pub(super) const CIRCLES: &str = "carom/msg/CircleStates";

/// The type of odometry.
const ODOMETRY: &str = "nav_msgs/msg/Odometry";

/// Messages looked at to see whether stamps are set.
const LOOKED_AT: usize = 300;

/// Faults that are said one by one.
const SAID: usize = 20;

/// A robot whose odometry is recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// Its name: the topic is `<name>/odom`, or the name itself.
    pub name: String,
    /// Its radius, m.
    pub radius: f64,
    /// Its mass, kg.
    pub mass: f64,
}

impl Robot {
    /// Reads `NAME=RADIUS,MASS`.
    ///
    /// # Errors
    /// What would be right.
    pub fn parse(text: &str) -> Result<Self, String> {
        let wrong = || "must be NAME=RADIUS,MASS, such as red=0.09,2.5".to_owned();
        let (name, numbers) = text.split_once('=').ok_or_else(wrong)?;
        let (radius, mass) = numbers.split_once(',').ok_or_else(wrong)?;
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| *x > 0.0);
        let (Some(radius), Some(mass)) = (number(radius), number(mass)) else {
            return Err(wrong());
        };
        if name.is_empty() || !radius.is_finite() {
            return Err(wrong());
        }
        Ok(Self { name: name.to_owned(), radius, mass })
    }

    pub(super) fn topics(&self) -> [String; 2] {
        let name = self.name.trim_start_matches('/');
        [format!("/{name}/odom"), format!("/{name}")]
    }
}

/// Which topics are read.
#[derive(Clone, Debug, PartialEq)]
pub struct Chosen {
    /// Their places in [`Bag::topics`], with the robots that they are of.
    places: BTreeMap<usize, Option<DiscId>>,
    robots: Vec<Robot>,
    by_log_time: bool,
}

impl Chosen {
    /// Whether a topic is read.
    pub(super) fn has(&self, bag: &Bag, topic: &Topic) -> bool {
        let place = bag.topics().iter().position(|each| each == topic);
        place.is_some_and(|place| self.places.contains_key(&place))
    }

    /// Whether what is read is circle states at the times of their headers.
    pub(super) fn is_of_circles_with_stamps(&self) -> bool {
        self.robots.is_empty() && !self.by_log_time
    }
}

/// Chooses the topics: those of the robots, the one that is named, or the only one.
///
/// # Errors
/// What there is, and how to choose.
pub fn choose(bag: &Bag, topic: Option<&str>, robots: &[Robot]) -> Result<Chosen, String> {
    let mut chosen =
        Chosen { places: BTreeMap::new(), robots: robots.to_vec(), by_log_time: false };
    if robots.is_empty() {
        chosen.places.insert(circles(bag, topic)?, None);
    }
    let mut names = BTreeSet::new();
    if let Some(robot) = robots.iter().find(|robot| !names.insert(&robot.name)) {
        return Err(format!("--robot {}: it is named twice", robot.name));
    }
    for (robot, id) in robots.iter().zip(0..) {
        let names = robot.topics();
        let is_its = |topic: &Topic| topic.kind == ODOMETRY && names.contains(&topic.name);
        let place = bag.topics().iter().position(is_its).ok_or_else(|| {
            let there = listed(bag, ODOMETRY);
            format!("--robot {}: no topic {} of {ODOMETRY}; {there}", robot.name, names[0])
        })?;
        chosen.places.insert(place, Some(id));
    }
    chosen.by_log_time = stamps_are_zero(bag, &chosen);
    Ok(chosen)
}

/// The topic of circle states.
fn circles(bag: &Bag, wanted: Option<&str>) -> Result<usize, String> {
    let of_kind = |topic: &Topic| topic.kind == CIRCLES;
    let named = |topic: &Topic| {
        wanted.is_none_or(|name| topic.name.trim_start_matches('/') == name.trim_start_matches('/'))
    };
    let all = bag.topics().iter().enumerate();
    let fitting: Vec<usize> =
        all.filter(|(_, topic)| of_kind(topic) && named(topic)).map(|(k, _)| k).collect();
    match (fitting.as_slice(), wanted) {
        ([one], _) => Ok(*one),
        ([], Some(name)) => {
            Err(format!("--topic {name}: there is none of {CIRCLES}; {}", listed(bag, CIRCLES)))
        }
        ([], None) => {
            let faults = bag.faults().iter().map(|fault| format!("; {fault}"));
            Err(format!(
                "{}: no topic of {CIRCLES}; for odometry name the robots: --robot \
                 NAME=RADIUS,MASS; {}{}",
                bag.path().display(),
                listed(bag, ODOMETRY),
                faults.collect::<String>()
            ))
        }
        (several, None) if several.iter().any(|&k| is_arena(bag, k)) => {
            Ok(several.iter().copied().find(|&k| is_arena(bag, k)).unwrap_or(several[0]))
        }
        _ => Err(format!("choose one with --topic; {}", listed(bag, CIRCLES))),
    }
}

/// Whether a topic is that of carom's own arena: of several it is the one with all discs.
fn is_arena(bag: &Bag, place: usize) -> bool {
    bag.topics()[place].name.ends_with("arena_states")
}

fn listed(bag: &Bag, kind: &str) -> String {
    let of_kind = bag.topics().iter().filter(|topic| topic.kind == kind);
    let names: Vec<&str> = of_kind.map(|topic| topic.name.as_str()).collect();
    if names.is_empty() {
        format!("the bag has no topic of {kind}")
    } else {
        format!("the bag has {}", names.join(", "))
    }
}

fn stamps_are_zero(bag: &Bag, chosen: &Chosen) -> bool {
    let messages = bag.messages(|topic| chosen.has(bag, topic));
    let (mut first, mut spread) = (None, false);
    for message in messages.flatten().take(LOOKED_AT) {
        if stamp(&message) != Some(0) {
            return false;
        }
        spread |= *first.get_or_insert(message.log_time_ns) != message.log_time_ns;
    }
    spread
}

/// The stamp of a message that begins with a header, ns.
fn stamp(message: &Message) -> Option<i64> {
    let (head, body) = message.payload.split_first_chunk::<4>()?;
    let (sec, rest) = body.split_first_chunk::<4>()?;
    let (nanosec, _) = rest.split_first_chunk::<4>()?;
    let little = head[1] & 1 == 1;
    let time = if little {
        Time { sec: i32::from_le_bytes(*sec), nanosec: u32::from_le_bytes(*nanosec) }
    } else {
        Time { sec: i32::from_be_bytes(*sec), nanosec: u32::from_be_bytes(*nanosec) }
    };
    Some(nanoseconds(time))
}

fn nanoseconds(time: Time) -> i64 {
    i64::from(time.sec) * 1_000_000_000 + i64::from(time.nanosec)
}

/// The law that the recorder noted, where nothing else was told, and whom the bag shows commanded.
pub fn noted_law(bag: &Bag, chosen: &Chosen, options: &mut Options) -> Option<String> {
    let text = bag.note(NOTE)?.get("scene")?;
    let scene = match scene::file::parse(text, "the scene in the bag") {
        Ok(scene) => scene,
        Err(error) => return Some(format!("the scene in the bag is not taken: {error}")),
    };
    options.take_surroundings(&scene);
    options.surroundings.commanded = commanded(bag, &scene, &chosen.robots);
    let settings = scene.settings;
    options.restitution = options.restitution.or(Some(settings.restitution));
    if options.walls.is_none() && !options.no_walls {
        options.periodic = settings.periodic;
        options.walls = settings.walls.map(|walls| Bounds {
            min: walls.min,
            max: walls.max,
            restitution: Some(walls.restitution),
        });
        options.no_walls = settings.walls.is_none();
    }
    options.gravity = options.gravity.or(Some(settings.gravity.unwrap_or(DVec2::ZERO)));
    options.drag = options.drag.or(Some(settings.drag));
    Some("law from the scene in the bag".to_owned())
}

/// Reads all frames; `tell` is told the part of the bag that is read. What was left out.
pub fn read(
    bag: &Bag,
    chosen: &Chosen,
    mut hear: impl FnMut(Frame),
    mut tell: impl FnMut(f64),
) -> Vec<String> {
    let journal = journal(bag);
    let wanted = |topic: &Topic| {
        let place = bag.topics().iter().position(|each| each == topic);
        place.is_some_and(|place| chosen.places.contains_key(&place) || journal == Some(place))
    };
    let mut said = Vec::new();
    let mut messages = bag.messages(wanted);
    let mut joined = Joined::new(chosen);
    let size = bag.size().max(1) as f64;
    let mut faults = Faults::default();
    bag.faults().iter().for_each(|fault| faults.add(fault.to_string()));
    while let Some(message) = messages.next() {
        match message {
            Ok(message) if journal == Some(message.topic) => {
                if is_another_world(&message) {
                    let what = "another scene was loaded, or walls were moved";
                    said.push(format!("{what}: only what was before that is judged"));
                    break;
                }
            }
            Ok(message) => match joined.add(&message) {
                Ok(()) => joined.ready.drain(..).for_each(&mut hear),
                Err(what) => {
                    let name = &bag.topics()[message.topic].name;
                    faults.add(format!("{name} at {} ns: {what}", message.log_time_ns));
                }
            },
            Err(fault) => faults.add(fault.to_string()),
        }
        tell(messages.bytes_read() as f64 / size);
    }
    joined.end().into_iter().for_each(hear);
    said.extend(faults.finish());
    said.extend(joined.said());
    said
}

/// The topic of the journal, in carom's own bags.
fn journal(bag: &Bag) -> Option<usize> {
    let name = bag.note(NOTE)?.get("topic.journal")?;
    bag.topics().iter().position(|topic| topic.name == *name)
}

/// Whether the law of the scene in the bag ends with this entry of the journal.
fn is_another_world(message: &Message) -> bool {
    match Entry::read(&message.payload) {
        Ok(Entry::Scene { .. }) => true,
        Ok(Entry::Step { asked: Some(asked), .. }) => matches!(*asked, Asked::Walls { .. }),
        _ => false,
    }
}

/// What was wrong, the first of it in full.
#[derive(Default)]
struct Faults {
    said: Vec<String>,
    more: u64,
}

impl Faults {
    fn add(&mut self, what: String) {
        if self.said.len() < SAID {
            self.said.push(what);
        } else {
            self.more += 1;
        }
    }

    fn finish(mut self) -> Vec<String> {
        if self.more > 0 {
            self.said.push(format!("{} more messages or parts could not be read", self.more));
        }
        self.said
    }
}

/// Parts to frames, robots to frames.
struct Joined<'a> {
    chosen: &'a Chosen,
    ready: Vec<Frame>,
    /// Parts of one stamp, and how many there should be.
    parts: Frame,
    have: Vec<bool>,
    incomplete: u64,
    /// The last stamp, until it is known that nobody else speaks of it, and whom it has, if anybody
    /// did.
    held: Option<Frame>,
    held_ids: HashSet<DiscId>,
    /// Messages that were added to another.
    added: u64,
    rounds: Rounds,
    /// In which messages say where discs are.
    frame_ids: BTreeSet<String>,
}

impl<'a> Joined<'a> {
    fn new(chosen: &'a Chosen) -> Self {
        Self {
            chosen,
            ready: Vec::new(),
            parts: Frame::default(),
            have: Vec::new(),
            incomplete: 0,
            held: None,
            held_ids: HashSet::new(),
            added: 0,
            rounds: Rounds::new(chosen.robots.len()),
            frame_ids: BTreeSet::new(),
        }
    }

    fn add(&mut self, message: &Message) -> Result<(), String> {
        match self.chosen.places.get(&message.topic) {
            Some(Some(robot)) => self.add_robot(*robot, message),
            _ => self.add_circles(message),
        }
    }

    fn time(&self, stamp: Time, message: &Message) -> i64 {
        if self.chosen.by_log_time {
            i64::try_from(message.log_time_ns).unwrap_or(i64::MAX)
        } else {
            nanoseconds(stamp)
        }
    }

    fn note_frame(&mut self, frame_id: String) {
        if self.frame_ids.len() < SAID && !self.frame_ids.contains(&frame_id) {
            self.frame_ids.insert(frame_id);
        }
    }

    fn add_circles(&mut self, message: &Message) -> Result<(), String> {
        let states: CircleStates = decode::message(&message.payload).map_err(|e| e.to_string())?;
        let time_ns = self.time(states.header.stamp, message);
        self.note_frame(states.header.frame_id);
        let disc = |circle: &crate::messages::CircleState| Disc {
            id: circle.id,
            position: DVec2::new(circle.x, circle.y),
            velocity: DVec2::new(circle.vx, circle.vy),
            radius: circle.radius,
            mass: circle.mass,
        };
        let discs = states.circles.iter().map(disc);
        let (part, parts) = (states.part as usize, (states.parts as usize).max(1));
        if parts > 100_000 || part >= parts {
            return Err(format!("part {part} of {parts}"));
        }
        let goes_on = self.parts.time_ns == time_ns || self.chosen.by_log_time;
        let fits = goes_on && self.have.len() == parts && !self.have[part];
        if !self.have.is_empty() && !fits {
            self.incomplete += 1;
            let frame = std::mem::take(&mut self.parts);
            self.have.clear();
            self.complete(frame);
        }
        if self.have.is_empty() {
            self.have = vec![false; parts];
            self.parts.time_ns = time_ns;
        }
        self.have[part] = true;
        self.parts.discs.extend(discs);
        if self.have.iter().all(|have| *have) {
            self.have.clear();
            let frame = std::mem::take(&mut self.parts);
            self.complete(frame);
        }
        Ok(())
    }

    /// Takes all of a message; one with the stamp of the last and other discs belongs to it.
    fn complete(&mut self, frame: Frame) {
        if let Some(held) = self.held.as_mut().filter(|held| held.time_ns == frame.time_ns) {
            if self.held_ids.is_empty() {
                self.held_ids.extend(held.discs.iter().map(|disc| disc.id));
            }
            if frame.discs.iter().all(|disc| !self.held_ids.contains(&disc.id)) {
                self.held_ids.extend(frame.discs.iter().map(|disc| disc.id));
                held.discs.extend(&frame.discs);
                self.added += 1;
                return;
            }
        }
        self.held_ids.clear();
        self.ready.extend(self.held.replace(frame));
    }

    fn add_robot(&mut self, id: DiscId, message: &Message) -> Result<(), String> {
        let odometry: Odometry = decode::message(&message.payload).map_err(|e| e.to_string())?;
        let standing = receive::standing(&odometry).map_err(|defect| defect.to_string())?;
        let time_ns = self.time(odometry.header.stamp, message);
        let Robot { radius, mass, .. } = self.chosen.robots[id as usize];
        let (position, velocity) = (standing.position, standing.velocity);
        let disc = Disc { id, position, velocity, radius, mass };
        self.note_frame(odometry.header.frame_id);
        self.ready.extend(self.rounds.hear(time_ns, disc));
        Ok(())
    }

    fn end(&mut self) -> Vec<Frame> {
        if !self.have.is_empty() {
            self.incomplete += 1;
            let frame = std::mem::take(&mut self.parts);
            self.complete(frame);
        }
        self.ready.extend(self.held.take());
        self.ready.extend(self.rounds.end());
        std::mem::take(&mut self.ready)
    }

    fn said(&self) -> Vec<String> {
        let mut said = Vec::new();
        if self.chosen.by_log_time {
            said.push("stamps are 0: times are those of recording".to_owned());
        }
        if self.incomplete > 0 {
            said.push(format!("{} stamps lack parts: their discs are missing", self.incomplete));
        }
        if self.added > 0 {
            let added = self.added;
            said.push(format!(
                "{added} messages are of the stamp before, and of other discs: added"
            ));
        }
        if self.frame_ids.len() > 1 {
            let names: Vec<String> = self.frame_ids.iter().map(|id| format!("'{id}'")).collect();
            let who = if self.chosen.robots.is_empty() { "messages" } else { "robots" };
            let names = names.join(", ");
            said.push(format!("{who} speak of different frames, taken for one: {names}"));
        }
        let Rounds { moved, moved_ns, .. } = self.rounds;
        if moved > 0 {
            said.push(format!(
                "{moved} states of robots were moved along their flight to a common stamp, by up \
                 to {:.3} ms",
                1e-6 * moved_ns as f64
            ));
        }
        for (robot, id) in self.chosen.robots.iter().zip(0..) {
            said.push(format!("{id} is {}, {} m, {} kg", robot.name, robot.radius, robot.mass));
        }
        said
    }
}
