//! The resolver over a recording, as fast as possible: circle states in, answers into another bag.
//!
//! Circles become stale by the times of the recording, and answers have the times of their
//! questions: the same bag gives the same bytes.

use std::path::Path;

use super::decode;
use super::qos::Qos;
use super::read::{Bag, Topic};
use super::write::{BagWriter, Options, Summary, WriteError};
use crate::messages::{CircleStates, Header};
use crate::publish;
use crate::receive;
use crate::scene::Scene;
use crate::world::{Answer, Command, Instants, Report, World};

/// The type that is answered.
const KIND: &str = "carom/msg/CircleStates";

/// Why there are no answers.
#[derive(Debug, thiserror::Error)]
pub enum OfflineError {
    /// Nothing in the bag is to be answered.
    #[error("{0}")]
    Nothing(String),
    /// The answers cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// What was done.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answered {
    /// Messages that were read.
    pub messages: u64,
    /// Those that had contacts.
    pub answers: u64,
    /// Contacts in them.
    pub contacts: u64,
    /// What was refused or could not be read, the first of it in words.
    pub refused: u64,
    /// The first refusals.
    pub told: Vec<String>,
    /// What was written.
    pub written: Summary,
}

/// Answers the circle states of a bag, as a scene has its laws, into a new folder.
///
/// # Errors
/// [`OfflineError`]
pub fn answer(bag: &Bag, scene: &Scene, folder: &Path) -> Result<Answered, OfflineError> {
    let slashless = |name: &str| name.trim_start_matches('/').to_owned();
    let asked = |topic: &Topic| {
        let is_named = |name: &String| slashless(name) == slashless(&topic.name);
        topic.kind == KIND && scene.node.circle_topics.iter().any(is_named)
    };
    if !bag.topics().iter().any(asked) {
        return Err(OfflineError::Nothing(nothing(bag, scene)));
    }
    let mut out = Out::create(folder)?;
    let mut world = World::new(scene.settings, &[]);
    let mut done = Answered::default();
    let mut first_ns = None;
    for next in bag.messages(asked) {
        let message = match next {
            Ok(message) => message,
            Err(fault) => {
                done.refuse(&fault);
                continue;
            }
        };
        done.messages += 1;
        let time_ns = message.log_time_ns;
        let since = time_ns.saturating_sub(*first_ns.get_or_insert(time_ns));
        let Some((header, report)) = read(&message.payload, &mut done) else { continue };
        let instants = Instants { heard_at: since as f64 * 1e-9, advance_to: 0.0 };
        for answer in world.step(&[Command::Observe(report)], instants).answers {
            for (id, why) in &answer.refused {
                done.refuse(&format_args!("circle {id}: {why}"));
            }
            if let Some(why) = &answer.unresolved {
                done.refuse(why);
            }
            if !answer.contacts.is_empty() {
                done.answers += 1;
                done.contacts += answer.contacts.len() as u64;
                out.write(time_ns, &header, &answer)?;
            }
        }
    }
    done.written = out.bag.finish()?;
    Ok(done)
}

/// The good circles of a message, and its header.
fn read(payload: &[u8], done: &mut Answered) -> Option<(Header, Report)> {
    let message: CircleStates =
        decode::message(payload).inspect_err(|error| done.refuse(error)).ok()?;
    let (report, bad) = receive::report(&message).inspect_err(|error| done.refuse(error)).ok()?;
    bad.iter().for_each(|(id, why)| done.refuse(&format_args!("circle {id}: {why}")));
    Some((message.header, report))
}

/// The bag of answers.
struct Out {
    bag: BagWriter,
    velocities: usize,
    contacts: usize,
}

impl Out {
    fn create(folder: &Path) -> Result<Self, WriteError> {
        let mut bag = BagWriter::create(folder, Options::default(), Vec::new())?;
        let qos = Qos { depth: 100, ..Qos::default() }.to_yaml();
        let velocities = bag.topic("/corrected_velocities", "carom/msg/CircleVelocities", &qos)?;
        let contacts = bag.topic("/contacts", "carom/msg/Contacts", &qos)?;
        Ok(Self { bag, velocities, contacts })
    }

    fn write(&mut self, time_ns: u64, header: &Header, answer: &Answer) -> Result<(), WriteError> {
        let velocities = publish::corrected_velocities(header.clone(), &answer.velocities);
        let contacts = publish::contacts(header.clone(), &answer.contacts);
        // Messages of ours can be encoded.
        let velocities = decode::payload(&velocities).unwrap_or_default();
        let contacts = decode::payload(&contacts).unwrap_or_default();
        self.bag.write(self.velocities, time_ns, time_ns, &velocities)?;
        self.bag.write(self.contacts, time_ns, time_ns, &contacts)
    }
}

impl Answered {
    fn refuse(&mut self, what: &dyn std::fmt::Display) {
        self.refused += 1;
        if self.told.len() < 10 {
            self.told.push(what.to_string());
        }
    }
}

fn nothing(bag: &Bag, scene: &Scene) -> String {
    let wanted = scene.node.circle_topics.join(", ");
    let there: Vec<&str> = bag
        .topics()
        .iter()
        .filter(|topic| topic.kind == KIND)
        .map(|topic| topic.name.as_str())
        .collect();
    let there = if there.is_empty() { "none".to_owned() } else { there.join(", ") };
    format!(
        "{}: no topic {wanted} of {KIND} (of that type: {there}); name others in the scene's \
         circle_topics",
        bag.path().display()
    )
}
