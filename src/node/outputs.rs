//! The publishers: what the world says, sent to whoever listens. A topic without a listener costs
//! nothing: its message is not even built.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use super::complaints::Complaints;
use super::dds::{DdsError, Publisher, Ros, RosMessage};
use super::parameters::services::ParameterEvent;
use super::parts::{InParts, Waiting};
use super::peers::Peers;
use super::stage::Stage;
use crate::messages::{
    CircleStates, CircleVelocities, Clock, Contacts, Crashes, DiagnosticArray, ErrorReport, Header,
    MarkerArray, Odometry, Time,
};
use crate::motion::arena::Arena;
use crate::publish::error_report::{self, Told};
use crate::publish::markers::{Drawn, Picture};
use crate::publish::{self, odometry};
use crate::scene::{Puck, Scene};
use crate::world::{Answer, DiscId, Outcome, Owner};

/// Messages kept for a subscriber that is slow to acknowledge.
const DEPTH: usize = 100;
/// A time, or a place, that is late is of no use.
const LATEST: usize = 1;
/// As rcl has it.
const PARAMETER_EVENTS_DEPTH: usize = 1_000;
/// Nobody sees more pictures in a second of simulated time.
const PICTURES_HZ: f64 = 30.0;

/// A topic whose messages may come in parts.
struct Large<M: InParts + RosMessage> {
    publisher: Publisher<M>,
    waiting: Waiting<M>,
}

/// All publishers.
pub struct Outputs {
    corrected_velocities: Large<CircleVelocities>,
    contacts: Large<Contacts>,
    crashes: Large<Crashes>,
    arena_states: Large<CircleStates>,
    error_report: Publisher<ErrorReport>,
    diagnostics: Publisher<DiagnosticArray>,
    markers: Publisher<MarkerArray>,
    parameter_events: Publisher<ParameterEvent>,
    /// Only where there is an arena, whose time it is.
    clock: Option<Publisher<Clock>>,
    /// Of driven pucks, each with its topic: another scene gives the same id to another puck.
    odometry: BTreeMap<DiscId, (String, Publisher<Odometry>)>,
    drawn: Drawn,
    /// Simulated time of the next picture, s.
    next_picture: f64,
    peers: Peers,
    frame_id: String,
}

impl Outputs {
    /// Opens those that a scene has from the beginning.
    pub fn open(ros: &mut Ros, scene: &Scene) -> Result<Self, DdsError> {
        let mut outputs = Self {
            corrected_velocities: Large::open(ros, "corrected_velocities")?,
            contacts: Large::open(ros, "contacts")?,
            crashes: Large::open(ros, "crashes")?,
            arena_states: Large::open(ros, "arena_states")?,
            error_report: ros.publisher("error_report", DEPTH)?,
            diagnostics: ros.publisher("/diagnostics", DEPTH)?,
            markers: ros.publisher("markers", LATEST)?,
            parameter_events: ros.publisher("/parameter_events", PARAMETER_EVENTS_DEPTH)?,
            clock: None,
            odometry: BTreeMap::new(),
            drawn: Drawn::default(),
            next_picture: 0.0,
            peers: ros.peers().clone(),
            frame_id: scene.node.frame_id.clone(),
        };
        outputs.follow(ros, &scene.pucks)?;
        Ok(outputs)
    }

    /// An `odom` for every driven puck and for no other, and the time where there are any pucks.
    pub fn follow(&mut self, ros: &mut Ros, pucks: &[Puck]) -> Result<(), DdsError> {
        if !pucks.is_empty() && self.clock.is_none() {
            self.clock = Some(ros.publisher("/clock", LATEST)?);
        }
        let is_of = |puck: &Puck, id: &DiscId, topic: &str| {
            puck.driven && puck.disc.id == *id && puck.topic("odom") == topic
        };
        self.odometry.retain(|id, (topic, _)| pucks.iter().any(|puck| is_of(puck, id, topic)));
        for puck in pucks.iter().filter(|puck| puck.driven) {
            if let Entry::Vacant(place) = self.odometry.entry(puck.disc.id) {
                let topic = puck.topic("odom");
                let publisher = ros.publisher(&topic, LATEST)?;
                place.insert((topic, publisher));
            }
        }
        Ok(())
    }

    /// Opens anew what a subscriber has brought to a halt.
    pub fn free(&mut self, ros: &mut Ros) -> Result<(), DdsError> {
        ros.free(&mut self.corrected_velocities.publisher)?;
        ros.free(&mut self.contacts.publisher)?;
        ros.free(&mut self.crashes.publisher)?;
        ros.free(&mut self.arena_states.publisher)?;
        ros.free(&mut self.error_report)?;
        ros.free(&mut self.diagnostics)?;
        ros.free(&mut self.markers)?;
        ros.free(&mut self.parameter_events)?;
        self.clock.iter_mut().try_for_each(|clock| ros.free(clock))?;
        self.odometry.values_mut().try_for_each(|(_, odometry)| ros.free(odometry))
    }

    /// Answers a message: its header is kept.
    pub fn answer(&mut self, header: &Header, answer: &Answer, complaints: &mut Complaints) {
        let Self { peers, corrected_velocities, contacts, .. } = self;
        peers.update();
        corrected_velocities.send(peers, complaints, || {
            publish::corrected_velocities(header.clone(), &answer.velocities)
        });
        contacts.send(peers, complaints, || publish::contacts(header.clone(), &answer.contacts));
    }

    /// The arena's contacts, which are taken, and what they ask of observed circles.
    pub fn arena_outcome(
        &mut self,
        arena: &Arena,
        outcome: &mut Outcome,
        complaints: &mut Complaints,
    ) {
        let header = || Header { stamp: stamp(arena), frame_id: self.frame_id.clone() };
        self.peers.update();
        if !outcome.corrections.is_empty() {
            self.corrected_velocities.send(&self.peers, complaints, || {
                publish::corrected_velocities(header(), &outcome.corrections)
            });
        }
        if !outcome.contacts.is_empty() {
            let contacts = &mut self.contacts;
            if self.peers.hear(contacts.publisher.guid()) {
                let message = publish::contacts(header(), &outcome.contacts);
                contacts.publish(message, complaints);
            }
            if let Some(tap) = contacts.publisher.tap() {
                tap.record_contacts((stamp(arena), &self.frame_id), &outcome.contacts);
            }
        }
        if !outcome.crashes.is_empty() {
            self.crashes
                .send(&self.peers, complaints, || publish::crashes(header(), &outcome.crashes));
        }
    }

    /// The arena as it is at a tick.
    pub fn tick(&mut self, stage: &mut Stage, complaints: &mut Complaints) {
        let Some(arena) = stage.world().arena() else { return };
        let stamp = stamp(arena);
        let header = || Header { stamp, frame_id: self.frame_id.clone() };
        let states = &mut self.arena_states;
        if let Some(tap) = states.publisher.tap() {
            let look = |watcher: &mut _, turns: &mut _| stage.look(watcher, turns);
            tap.record_states((stamp, &self.frame_id), look);
        }
        let Some(arena) = stage.world().arena() else { return };
        if self.peers.hear(states.publisher.guid()) {
            let discs = arena.discs(Owner::Simulated);
            states.publish(publish::arena_states(header(), discs), complaints);
        }
        self.clock(stage, complaints);
        self.odometry(stage, arena, complaints);
        if arena.now() >= self.next_picture && self.peers.hear(self.markers.guid()) {
            self.next_picture = arena.now() + 1.0 / PICTURES_HZ;
            let picture = Picture {
                pucks: stage.now(),
                observed: stage.world().observed(),
                walls: stage.world().walls(),
                segments: stage.scene().settings.segments,
                periodic: stage.scene().settings.periodic,
            };
            let markers = self.drawn.draw(&header(), &picture);
            send(&self.peers, &self.markers, complaints, || markers);
        }
    }

    fn odometry(&self, stage: &Stage, arena: &Arena, complaints: &mut Complaints) {
        let is_wanted = |publisher: &Publisher<Odometry>| {
            publisher.tap().is_some() || self.peers.hear(publisher.guid())
        };
        if !self.odometry.values().any(|(_, publisher)| is_wanted(publisher)) {
            return;
        }
        for (puck, disc) in stage.now() {
            let Some((_, publisher)) = self.odometry.get(&disc.id) else { continue };
            send(&self.peers, publisher, complaints, || {
                let header = Header { stamp: stamp(arena), frame_id: self.frame_id.clone() };
                let pose = stage.world().pose(disc.id).unwrap_or_default();
                odometry::of_puck(header, &puck.name, &disc, pose)
            });
        }
    }

    /// The arena's time.
    pub fn clock(&self, stage: &Stage, complaints: &mut Complaints) {
        let (Some(clock), Some(arena)) = (&self.clock, stage.world().arena()) else { return };
        send(&self.peers, clock, complaints, || Clock { clock: stamp(arena) });
    }

    /// The world began anew: pictures too.
    pub fn restart(&mut self) {
        self.next_picture = 0.0;
    }

    /// What happened to parameters.
    pub fn parameter_event(&self, event: ParameterEvent, complaints: &mut Complaints) {
        send(&self.peers, &self.parameter_events, complaints, || event);
    }

    /// Who listens, as of the last look.
    pub fn peers(&self) -> &Peers {
        &self.peers
    }

    /// Of messages about the arena, now.
    pub fn header(&self, arena: &Arena) -> Header {
        Header { stamp: stamp(arena), frame_id: self.frame_id.clone() }
    }

    /// Takes note of who listens.
    pub fn update_peers(&mut self) {
        self.peers.update();
    }

    /// Whether somebody hears reports.
    pub fn reports_are_heard(&mut self) -> bool {
        self.peers.update();
        self.peers.hear(self.error_report.guid()) || self.peers.hear(self.diagnostics.guid())
    }

    /// How the last second went.
    pub fn report(&self, told: &Told, complaints: &mut Complaints) {
        send(&self.peers, &self.error_report, complaints, || told.report.clone());
        send(&self.peers, &self.diagnostics, complaints, || {
            let wall = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
            let stamp = Time { sec: wall.as_secs() as i32, nanosec: wall.subsec_nanos() };
            error_report::diagnostics(told, stamp)
        });
    }

    /// When a part of a large message is to be sent.
    pub fn due(&self) -> Option<Instant> {
        let dues = [
            self.corrected_velocities.waiting.due(),
            self.contacts.waiting.due(),
            self.crashes.waiting.due(),
            self.arena_states.waiting.due(),
        ];
        dues.into_iter().flatten().min()
    }

    /// Sends the parts whose time has come.
    pub fn send_waiting(&mut self, now: Instant, complaints: &mut Complaints) {
        self.corrected_velocities.send_waiting(now, complaints);
        self.contacts.send_waiting(now, complaints);
        self.crashes.send_waiting(now, complaints);
        self.arena_states.send_waiting(now, complaints);
    }

    /// Large messages that were skipped, since the start.
    pub fn dropped(&self) -> u64 {
        self.corrected_velocities.waiting.dropped()
            + self.contacts.waiting.dropped()
            + self.crashes.waiting.dropped()
            + self.arena_states.waiting.dropped()
    }
}

impl<M: InParts + RosMessage> Large<M> {
    fn open(ros: &mut Ros, topic: &str) -> Result<Self, DdsError> {
        Ok(Self { publisher: ros.publisher(topic, DEPTH)?, waiting: Waiting::default() })
    }

    /// Builds and publishes a message, or its first part, if somebody hears it or it is recorded.
    fn send(&mut self, peers: &Peers, complaints: &mut Complaints, message: impl FnOnce() -> M) {
        // A bag has messages whole: parts are for the network.
        if let Some(message) = wanted(peers, &self.publisher, message) {
            self.publish(message, complaints);
        }
    }

    fn publish(&mut self, message: M, complaints: &mut Complaints) {
        let first = self.waiting.take(message, Instant::now());
        first.into_iter().for_each(|part| put(&self.publisher, part, complaints));
    }

    fn send_waiting(&mut self, now: Instant, complaints: &mut Complaints) {
        let part = self.waiting.next(now);
        part.into_iter().for_each(|part| put(&self.publisher, part, complaints));
    }
}

/// Builds a message if somebody wants it, and records it; what is to be published.
fn wanted<M: RosMessage>(
    peers: &Peers,
    publisher: &Publisher<M>,
    message: impl FnOnce() -> M,
) -> Option<M> {
    let is_heard = peers.hear(publisher.guid());
    if !is_heard && publisher.tap().is_none() {
        return None;
    }
    let message = message();
    publisher.tap().inspect(|tap| tap.record(&message));
    is_heard.then_some(message)
}

/// Builds and publishes a message if somebody hears it, or it is recorded.
pub(super) fn send<M: RosMessage>(
    peers: &Peers,
    publisher: &Publisher<M>,
    complaints: &mut Complaints,
    message: impl FnOnce() -> M,
) {
    if let Some(message) = wanted(peers, publisher, message) {
        put(publisher, message, complaints);
    }
}

fn put<M: RosMessage>(publisher: &Publisher<M>, message: M, complaints: &mut Complaints) {
    if let Err(error) = publisher.publish(message) {
        complaints.unsent(publisher.topic(), &error);
    }
}

fn stamp(arena: &Arena) -> Time {
    Time::from_seconds(arena.now())
}
