//! The publishers: what the world says, sent to whoever listens. A topic without a listener costs
//! nothing: its message is not even built.

use super::complaints::Complaints;
use super::dds::{DdsError, Listeners, Publisher, Ros, RosMessage};
use crate::messages::{CircleStates, CircleVelocities, Contacts, Header, Time};
use crate::motion::arena::Arena;
use crate::publish;
use crate::world::{Answer, Outcome, Owner};

/// Messages kept for a subscriber that is slow to acknowledge.
const DEPTH: usize = 100;

/// All publishers.
pub struct Outputs {
    corrected_velocities: Publisher<CircleVelocities>,
    contacts: Publisher<Contacts>,
    arena_states: Publisher<CircleStates>,
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
            complaints.refuse(publisher.topic(), &error);
        }
    }

    fn header(&self, arena: &Arena) -> Header {
        Header { stamp: Time::from_seconds(arena.now()), frame_id: self.frame_id.clone() }
    }
}
