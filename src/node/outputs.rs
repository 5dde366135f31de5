//! The publishers: what the world says, sent to whoever listens. A topic without a listener costs
//! nothing: its message is not even built.

use std::time::{SystemTime, UNIX_EPOCH};

use super::complaints::Complaints;
use super::dds::{DdsError, Listeners, Publisher, Ros, RosMessage};
use crate::messages::{
    CircleStates, CircleVelocities, Contacts, DiagnosticArray, ErrorReport, Header, Time,
};
use crate::motion::arena::Arena;
use crate::publish;
use crate::publish::error_report::{self, Told};
use crate::world::{Answer, Outcome, Owner};

/// Messages kept for a subscriber that is slow to acknowledge.
const DEPTH: usize = 100;

/// All publishers.
pub struct Outputs {
    corrected_velocities: Publisher<CircleVelocities>,
    contacts: Publisher<Contacts>,
    arena_states: Publisher<CircleStates>,
    error_report: Publisher<ErrorReport>,
    diagnostics: Publisher<DiagnosticArray>,
    listeners: Listeners,
    frame_id: String,
}

impl Outputs {
    /// Opens them; the arena's messages are in `frame_id`.
    pub fn open(ros: &mut Ros, listeners: Listeners, frame_id: &str) -> Result<Self, DdsError> {
        Ok(Self {
            corrected_velocities: ros.publisher("corrected_velocities", DEPTH)?,
            contacts: ros.publisher("contacts", DEPTH)?,
            arena_states: ros.publisher("arena_states", DEPTH)?,
            error_report: ros.publisher("error_report", DEPTH)?,
            diagnostics: ros.publisher("/diagnostics", DEPTH)?,
            listeners,
            frame_id: frame_id.to_owned(),
        })
    }

    /// Answers a message: its header is kept.
    pub fn answer(&mut self, header: &Header, answer: &Answer, complaints: &mut Complaints) {
        self.listeners.update();
        self.send(&self.corrected_velocities, complaints, || {
            publish::corrected_velocities(header.clone(), &answer.velocities)
        });
        self.send(&self.contacts, complaints, || {
            publish::contacts(header.clone(), &answer.contacts)
        });
    }

    /// The arena's contacts, and what they ask of observed circles.
    pub fn arena_outcome(&mut self, arena: &Arena, outcome: &Outcome, complaints: &mut Complaints) {
        self.listeners.update();
        if !outcome.corrections.is_empty() {
            self.send(&self.corrected_velocities, complaints, || {
                publish::corrected_velocities(self.header(arena), &outcome.corrections)
            });
        }
        if !outcome.contacts.is_empty() {
            self.send(&self.contacts, complaints, || {
                publish::contacts(self.header(arena), &outcome.contacts)
            });
        }
    }

    /// The arena as it is now.
    pub fn arena_states(&self, arena: &Arena, complaints: &mut Complaints) {
        self.send(&self.arena_states, complaints, || {
            publish::arena_states(self.header(arena), arena.discs(Owner::Simulated))
        });
    }

    /// Whether somebody hears reports.
    pub fn reports_are_heard(&mut self) -> bool {
        self.listeners.update();
        self.listeners.hear(&self.error_report) || self.listeners.hear(&self.diagnostics)
    }

    /// How the last second went.
    pub fn report(&self, told: &Told, complaints: &mut Complaints) {
        self.send(&self.error_report, complaints, || told.report.clone());
        self.send(&self.diagnostics, complaints, || {
            let wall = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
            let stamp = Time { sec: wall.as_secs() as i32, nanosec: wall.subsec_nanos() };
            error_report::diagnostics(told, stamp)
        });
    }

    /// Builds and publishes a message if somebody hears it.
    fn send<M: RosMessage>(
        &self,
        publisher: &Publisher<M>,
        complaints: &mut Complaints,
        message: impl FnOnce() -> M,
    ) {
        if !self.listeners.hear(publisher) {
            return;
        }
        if let Err(error) = publisher.publish(message()) {
            complaints.unsent(publisher.topic(), &error);
        }
    }

    fn header(&self, arena: &Arena) -> Header {
        Header { stamp: Time::from_seconds(arena.now()), frame_id: self.frame_id.clone() }
    }
}
