//! The resolver over a recording, as fast as possible: circle states in, answers into another bag.
//!
//! Circles become stale by the times of the recording, and answers have the times of their
//! questions: the same bag gives the same bytes.

use std::path::Path;

use super::decode;
use super::qos::Qos;
use super::read::{Bag, Topic};
use super::write::{BagWriter, Options, Summary, WriteError};
use crate::messages::CircleStates;
use crate::publish;
use crate::receive;
use crate::scene::Scene;
use crate::world::{Command, Instants, World};

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
    let asked = |topic: &Topic| {
        let is_named =
            |name: &String| topic.name.trim_start_matches('/') == name.trim_start_matches('/');
        topic.kind == KIND && scene.node.circle_topics.iter().any(is_named)
    };
    if !bag.topics().iter().any(asked) {
        return Err(OfflineError::Nothing(nothing(bag, scene)));
    }
    let mut out = BagWriter::create(folder, Options::default(), Vec::new())?;
    let qos = Qos { depth: 100, ..Qos::default() }.to_yaml();
    let velocities = out.topic("/corrected_velocities", "carom/msg/CircleVelocities", &qos)?;
    let contacts = out.topic("/contacts", "carom/msg/Contacts", &qos)?;
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
        let states: CircleStates = match decode::message(&message.payload) {
            Ok(states) => states,
            Err(error) => {
                done.refuse(&error);
                continue;
            }
        };
        let report = match receive::report(&states) {
            Ok((report, bad)) => {
                bad.iter().for_each(|(id, why)| done.refuse(&format_args!("circle {id}: {why}")));
                report
            }
            Err(error) => {
                done.refuse(&error);
                continue;
            }
        };
        let instants = Instants { heard_at: since as f64 * 1e-9, advance_to: 0.0 };
        for answer in world.step(&[Command::Observe(report)], instants).answers {
            if answer.contacts.is_empty() {
                continue;
            }
            done.answers += 1;
            done.contacts += answer.contacts.len() as u64;
            let header = || states.header.clone();
            let message = publish::corrected_velocities(header(), &answer.velocities);
            let payload = decode::payload(&message).unwrap_or_default();
            out.write(velocities, time_ns, time_ns, &payload)?;
            let message = publish::contacts(header(), &answer.contacts);
            out.write(contacts, time_ns, time_ns, &decode::payload(&message).unwrap_or_default())?;
        }
    }
    done.written = out.finish()?;
    Ok(done)
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
