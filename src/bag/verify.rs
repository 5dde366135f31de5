//! Repeats a recorded run, and says whether the bits agree.
//!
//! The scene is built again from the text in the bag, the journal says what was asked of it and to
//! which instants it moved, and every message that the run gave must come again, byte by byte.

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::fmt;

use glam::DVec2;

use super::decode;
use super::fault::{BagError, Fault};
use super::journal::{Asked, Entry, NOTE};
use super::read::{Bag, Message};
use crate::messages::{CircleStates, Header, Time};
use crate::plan::Method;
use crate::plan::parts::Parts;
use crate::publish;
use crate::receive;
use crate::scene::{Scene, file};
use crate::world::{Command, Disc, Instants, Outcome, Owner, Settings, World};

/// Differences that are told in words; the others are counted.
const TOLD_MAX: usize = 10;

/// Steps may be missing.
const HOLE: &str = "the journal has a hole";

/// What came of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdict {
    /// Messages that were compared, by topic.
    pub compared: BTreeMap<String, u64>,
    /// The first differences, with their places.
    pub told: Vec<String>,
    /// All differences.
    pub differences: u64,
    /// Where the bag is damaged or contradicts itself: no difference of the run.
    pub damage: Vec<String>,
    /// What of the bag is not there; it may have been killed.
    pub missing: Vec<String>,
    /// From where on nothing could be repeated and compared, and why.
    pub lost: Option<String>,
    /// The version that recorded, if it is not this one.
    pub other_version: Option<String>,
    /// Simulated time that was reached, s.
    pub reached: f64,
}

impl Verdict {
    /// Whether all that could be compared was the same in every bit.
    pub fn agrees(&self) -> bool {
        self.differences == 0 && self.compared.values().any(|count| *count > 0)
    }

    /// Whether it agrees, nothing is damaged, and all that is there could be compared.
    pub fn is_sound(&self) -> bool {
        self.agrees() && self.damage.is_empty() && self.lost.is_none()
    }

    /// What is wrong with the bag is no difference: what is there can still agree.
    fn take_fault(&mut self, fault: &BagError) {
        match fault.fault {
            Fault::Missing(_) | Fault::Cut { .. } => self.missing.push(fault.to_string()),
            _ => self.damage.push(fault.to_string()),
        }
    }

    fn differ(&mut self, what: String) {
        self.differences += 1;
        if self.told.len() < TOLD_MAX {
            self.told.push(what);
        }
    }

    fn result(&self) -> String {
        let places = |count: u64| if count == 1 { "place" } else { "places" };
        let mut result = match (self.agrees(), self.differences) {
            (true, _) => "every bit agrees".to_owned(),
            (false, 0) => "nothing can be compared".to_owned(),
            (false, count) => format!("it differs in {count} {}", places(count)),
        };
        if !self.damage.is_empty() {
            let count = self.damage.len() as u64;
            result += &format!("; the bag is damaged in {count} {}", places(count));
        }
        result
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(version) = &self.other_version {
            let this = env!("CARGO_PKG_VERSION");
            writeln!(f, "recorded by carom {version}; this is {this}: its bits may be others")?;
        }
        for missing in &self.missing {
            writeln!(f, "{missing}")?;
        }
        let damage = self.damage.len() as u64;
        for (told, count) in [(&self.damage, damage), (&self.told, self.differences)] {
            for told in told.iter().take(TOLD_MAX) {
                writeln!(f, "{told}")?;
            }
            let more = count.saturating_sub(TOLD_MAX as u64);
            if more > 0 {
                writeln!(f, "... and {more} more")?;
            }
        }
        if let Some(lost) = &self.lost {
            writeln!(f, "{lost}")?;
        }
        let counts: Vec<String> =
            self.compared.iter().map(|(topic, count)| format!("{count} {topic}")).collect();
        let compared = if counts.is_empty() { "nothing".to_owned() } else { counts.join(", ") };
        write!(f, "{compared} compared up to {} s: {}", self.reached, self.result())
    }
}

/// Repeats the run of a bag.
///
/// # Errors
/// Why it cannot be repeated.
pub fn verify(bag: &Bag) -> Result<Verdict, String> {
    let Some(said) = bag.note(NOTE) else {
        return Err("no run of carom: record it with `carom run --record DIR`".to_owned());
    };
    let mut run = Run::new(said)?;
    run.verdict.other_version =
        said.get("version").filter(|version| *version != env!("CARGO_PKG_VERSION")).cloned();
    bag.faults().iter().for_each(|fault| run.verdict.take_fault(fault));
    let mut messages = bag.messages(|_| true);
    // Where a file ends too early, what is in the next one has a hole before it.
    let mut is_cut = false;
    while let Some(next) = messages.next() {
        if is_cut || messages.follows_gap() {
            run.lose(HOLE);
        }
        match next {
            Ok(message) if !run.is_lost() => {
                run.take(&bag.topics()[message.topic].name, message);
            }
            // What is damaged besides is still told.
            Ok(_) => {}
            Err(fault) => {
                run.verdict.take_fault(&fault);
                match fault.fault {
                    Fault::Cut { .. } | Fault::Unreadable(_) => is_cut = true,
                    Fault::Damaged { .. } => run.lose(HOLE),
                    _ => {}
                }
            }
        }
    }
    run.end();
    Ok(run.verdict)
}

/// The run, as far as it has been repeated.
struct Run {
    world: World,
    settings: Settings,
    frame_id: String,
    /// Names of topics by what they carry.
    journal: String,
    states: String,
    contacts: String,
    velocities: String,
    /// By topic of the bag, the number of the last message.
    sequences: HashMap<usize, u32>,
    /// The last message of every other topic.
    heard: HashMap<String, Vec<u8>>,
    /// Payloads that must come, by topic.
    expected: HashMap<String, VecDeque<Vec<u8>>>,
    verdict: Verdict,
    /// Differences when the journal last spoke: all, and those in words.
    at_last_step: (u64, usize),
}

impl Run {
    fn new(said: &BTreeMap<String, String>) -> Result<Self, String> {
        let get = |key: &str| said.get(key).ok_or_else(|| format!("its note lacks `{key}`"));
        let scene =
            file::parse(get("scene")?, "the scene in the bag").map_err(|e| e.to_string())?;
        let settings = settings(&scene, said)?;
        let scene = Scene { settings, ..scene };
        Ok(Self {
            world: scene.world(),
            settings,
            frame_id: get("parameter.frame_id")?.clone(),
            journal: get("topic.journal")?.clone(),
            states: get("topic.arena_states")?.clone(),
            contacts: get("topic.contacts")?.clone(),
            velocities: get("topic.corrected_velocities")?.clone(),
            sequences: HashMap::new(),
            heard: HashMap::new(),
            expected: HashMap::new(),
            verdict: Verdict::default(),
            at_last_step: (0, 0),
        })
    }

    fn take(&mut self, topic: &str, message: Message) {
        if !self.is_next(topic, &message) {
            return;
        }
        if *topic == self.journal {
            self.at_last_step = (self.verdict.differences, self.verdict.told.len());
            match Entry::read(&message.payload) {
                Ok(entry) => self.act(entry),
                Err(error) => self.lose(format!("the journal cannot be read: {error}")),
            }
        } else if *topic == self.states {
            let header = self.header();
            if let Some(arena) = self.world.arena() {
                let states = publish::arena_states(header, arena.discs(Owner::Simulated));
                let expected = decode::payload(&states).unwrap_or_default();
                self.compare(topic, &expected, &message.payload);
            }
        } else if *topic == self.contacts || *topic == self.velocities {
            let waiting = self.expected.entry(topic.to_owned()).or_default();
            match waiting.pop_front() {
                Some(expected) => self.compare(topic, &expected, &message.payload),
                None => {
                    let at = self.now();
                    self.verdict.differ(format!("{topic} at {at} s: recorded, but not repeated"));
                }
            }
        } else {
            self.heard.insert(topic.to_owned(), message.payload);
        }
    }

    /// Whether a message comes in its turn. The recorder counts those of a topic from 1 on: what
    /// was taken out later is missed, and what was put in is not compared.
    fn is_next(&mut self, topic: &str, message: &Message) -> bool {
        let (number, at) = (message.sequence, self.now());
        // Others that wrote the bag again may not count.
        if number == 0 {
            return true;
        }
        let last = self.sequences.get(&message.topic).copied().unwrap_or(0);
        if number <= last {
            let what = format!("{topic} at {at} s: message {number} comes behind number {last}");
            self.verdict.damage.push(what);
            return false;
        }
        self.sequences.insert(message.topic, number);
        let gone = number - last - 1;
        if gone > 0 {
            let what = format!("{topic} at {at} s: {gone} messages are not there");
            self.verdict.damage.push(what);
            if *topic == self.journal {
                // What was told since the last step came of one that is not there.
                let (differences, told) = self.at_last_step;
                self.verdict.differences = differences;
                self.verdict.told.truncate(told);
                self.lose(HOLE);
                return false;
            }
            // What was repeated of them is compared with nothing.
            if let Some(waiting) = self.expected.get_mut(topic) {
                waiting.drain(..waiting.len().min(gone as usize));
            }
        }
        true
    }

    fn compare(&mut self, topic: &str, expected: &[u8], recorded: &[u8]) {
        *self.verdict.compared.entry(topic.to_owned()).or_default() += 1;
        if expected == recorded {
            return;
        }
        let what = where_states_differ(expected, recorded).unwrap_or_else(|| {
            let place = expected.iter().zip(recorded).position(|(a, b)| a != b);
            let place = place.unwrap_or(expected.len().min(recorded.len()));
            format!(
                "{} bytes repeated, {} recorded, {place} the same",
                expected.len(),
                recorded.len()
            )
        });
        let at = self.now();
        self.verdict.differ(format!("{topic} at {at} s: {what}"));
    }

    fn act(&mut self, entry: Entry) {
        match entry {
            Entry::Step { to, heard, asked } => self.step(to, heard, asked.map(|asked| *asked)),
            Entry::World { pucks } => {
                let discs: Vec<Disc> = pucks.into_iter().map(|puck| puck.disc()).collect();
                self.world = World::new(self.settings, &discs);
            }
            Entry::Driven { id, drive } => self.world.drive(id, drive.drive()),
            Entry::Ball { id, ball } => self.world.add_ball(id, ball),
            Entry::Scene { text: None } => self.world = World::new(self.settings, &[]),
            Entry::Scene { text: Some(text) } => match file::parse(&text, "a scene in the bag") {
                Ok(scene) => {
                    self.settings = Settings {
                        stale_after: self.settings.stale_after,
                        contact_margin: self.settings.contact_margin,
                        command_timeout: self.settings.command_timeout,
                        ..scene.settings
                    };
                    self.world = Scene { settings: self.settings, ..scene }.world();
                }
                Err(error) => self.lose(error.to_string()),
            },
            Entry::Setting { name, value } => self.set(&name, value),
            Entry::Forget {} => self.world.forget_observed(),
            Entry::Dropped { messages } => {
                self.lose(format!(
                    "{messages} messages were not recorded; what follows is unknown"
                ));
            }
        }
    }

    fn step(&mut self, to: f64, heard: Option<f64>, asked: Option<Asked>) {
        let instants = Instants { heard_at: heard.unwrap_or(f64::NEG_INFINITY), advance_to: to };
        let (header, command) = match asked {
            None => (Header::default(), None),
            Some(Asked::Message { topic }) => match self.heard_report(&topic) {
                Ok((header, command)) => (header, Some(command)),
                Err(why) => return self.lose(format!("{topic}: {why}")),
            },
            Some(asked) => {
                let mut header = Header::default();
                if let Asked::Circles { sec, nanosec, frame_id, .. } = &asked {
                    header.stamp = Time { sec: *sec, nanosec: *nanosec };
                    header.frame_id.clone_from(frame_id);
                }
                let command = asked.command(header.stamp.as_seconds());
                (header, command)
            }
        };
        let commands: Vec<Command> = command.into_iter().collect();
        let outcome = self.world.step(&commands, instants);
        self.verdict.reached = self.now();
        self.demand(&header, &outcome);
    }

    fn heard_report(&self, topic: &str) -> Result<(Header, Command), String> {
        let payload = self.heard.get(topic).ok_or("the message that was heard is not there")?;
        let message: CircleStates = decode::message(payload).map_err(|error| error.to_string())?;
        let (report, _) = receive::report(&message).map_err(|error| error.to_string())?;
        Ok((message.header, Command::Observe(report)))
    }

    /// What the run must have told after a step.
    fn demand(&mut self, header: &Header, outcome: &Outcome) {
        let own = self.header();
        let mut told = Vec::new();
        if !outcome.corrections.is_empty() {
            let message = publish::corrected_velocities(own.clone(), &outcome.corrections);
            told.push((&self.velocities, decode::payload(&message)));
        }
        if !outcome.contacts.is_empty() {
            told.push((
                &self.contacts,
                decode::payload(&publish::contacts(own, &outcome.contacts)),
            ));
        }
        for answer in outcome.answers.iter().filter(|answer| !answer.contacts.is_empty()) {
            let message = publish::corrected_velocities(header.clone(), &answer.velocities);
            told.push((&self.velocities, decode::payload(&message)));
            let message = publish::contacts(header.clone(), &answer.contacts);
            told.push((&self.contacts, decode::payload(&message)));
        }
        for (topic, payload) in told {
            let waiting = self.expected.entry(topic.clone()).or_default();
            waiting.push_back(payload.unwrap_or_default());
        }
    }

    fn set(&mut self, name: &str, value: f64) {
        match name {
            "stale_after_s" => {
                self.settings.stale_after = value;
                self.world.set_stale_after(value);
            }
            "contact_margin_m" => {
                self.settings.contact_margin = value;
                self.world.set_contact_margin(value);
            }
            "command_timeout_s" => {
                self.settings.command_timeout = value;
                self.world.set_command_timeout(value);
            }
            other => self.lose(format!("the journal knows a setting that is none: {other}")),
        }
    }

    /// What the run told last need not have reached the bag: no more than one step of it.
    fn end(&mut self) {
        for (topic, waiting) in &self.expected {
            if waiting.len() > 1 && self.verdict.lost.is_none() {
                let count = waiting.len();
                self.verdict.differ(format!("{topic}: {count} repeated, but not recorded"));
            }
        }
    }

    /// Nothing is compared any more; the first reason is told.
    fn lose(&mut self, why: impl fmt::Display) {
        if self.is_lost() {
            return;
        }
        let at = self.now();
        self.verdict.lost = Some(format!("cannot be repeated from {at} s on: {why}"));
    }

    fn is_lost(&self) -> bool {
        self.verdict.lost.is_some()
    }

    fn now(&self) -> f64 {
        self.world.arena().map_or(0.0, |arena| arena.now())
    }

    fn header(&self) -> Header {
        Header { stamp: Time::from_seconds(self.now()), frame_id: self.frame_id.clone() }
    }
}

/// The settings of the run: the scene's, but for what the command line said otherwise.
fn settings(scene: &Scene, said: &BTreeMap<String, String>) -> Result<Settings, String> {
    let text = |name: &str| {
        let key = format!("parameter.{name}");
        said.get(&key).ok_or_else(|| format!("its note lacks `{key}`"))
    };
    let number = |name: &str| {
        let text = text(name)?;
        text.parse::<f64>().map_err(|_| format!("{name} is no number: {text}"))
    };
    let mut settings = scene.settings;
    settings.method = Method::named(text("method")?).map_err(|error| error.clone())?;
    settings.pace.step = number("step_s")?;
    settings.stale_after = number("stale_after_s")?;
    settings.contact_margin = number("contact_margin_m")?;
    settings.command_timeout = number("command_timeout_s")?;
    let sides = said.get("parameter.walls").map_or("", String::as_str);
    let sides: Vec<f64> = sides.split(',').flat_map(str::parse).collect();
    if let (Some(walls), &[left, right, bottom, top]) = (&mut settings.walls, &*sides) {
        (walls.min, walls.max) = (DVec2::new(left, bottom), DVec2::new(right, top));
    }
    settings.keep = if text("keep_all")? == "true" { Parts::ALL } else { Parts::NONE };
    Ok(settings)
}

/// The first circle and field in which two states differ.
fn where_states_differ(expected: &[u8], recorded: &[u8]) -> Option<String> {
    let expected: CircleStates = decode::message(expected).ok()?;
    let recorded: CircleStates = decode::message(recorded).ok()?;
    for (a, b) in expected.circles.iter().zip(&recorded.circles) {
        let pairs = [
            ("x", a.x, b.x),
            ("y", a.y, b.y),
            ("vx", a.vx, b.vx),
            ("vy", a.vy, b.vy),
            ("radius", a.radius, b.radius),
            ("mass", a.mass, b.mass),
        ];
        for (name, a_value, b_value) in pairs {
            if a_value.to_bits() != b_value.to_bits() {
                let id = b.id;
                return Some(format!("{name} of {id} is {a_value:?}, recorded {b_value:?}"));
            }
        }
    }
    None
}
