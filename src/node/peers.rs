//! Peers: who hears the node's publishers, who begins to speak to it, and who takes its topics for
//! something else.
//!
//! Learnt from the participant's status events. Types matter here because RustDDS 0.15.1 matches
//! writers to readers by the name of the topic alone: bytes of another type may well decode, as
//! numbers that nobody meant, and a reader of another type never acknowledges what it is sent.
//! Nothing here may block, and what the network says may not fill the memory.

use std::cell::RefCell;
use std::collections::{HashMap, HashSet};
use std::future::poll_fn;
use std::rc::Rc;
use std::thread;
use std::time::{Duration, Instant};

use futures::StreamExt;
use ros2_client::Gid;
use rustdds::{
    DomainParticipantStatusEvent, DomainParticipantStatusListener, EndpointDescription, GUID,
    StatusEvented, Topic, TopicDescription,
};

/// Events waiting beyond which DDS may have dropped some (its channel holds 2048).
const EVENTS_MAX: usize = 2_000;

/// When a newcomer has been told of the participant: RustDDS does it after 10 ms, but tells it at
/// once of endpoints that are new, which Fast DDS then loses for ever.
const ANSWERED_AFTER: Duration = Duration::from_millis(30);

/// Endpoints of other types, and writers to be prompted, that are remembered.
const STRANGERS_MAX: usize = 1_000;

/// When a writer's own first HEARTBEAT has come: Fast DDS sends it after 12 ms.
const PROMPTED_AFTER: Duration = Duration::from_millis(25);

/// GUIDs of Fast DDS begin with its vendor id.
const FAST_DDS: [u8; 2] = [1, 15];

/// Everybody else, as far as it concerns this node; clones are the same.
#[derive(Clone)]
pub struct Peers(Rc<RefCell<Known>>);

struct Known {
    status: DomainParticipantStatusListener,
    readers_of_writer: HashMap<GUID, HashSet<GUID>>,
    /// Events may have been dropped: everybody may be listening.
    lost_count: bool,
    /// Types of the node's topics, by their names in DDS.
    types: HashMap<String, String>,
    /// Publishers of other types on them, with the topic.
    strangers: HashMap<GUID, String>,
    /// Subscribers of other types.
    deaf: HashSet<GUID>,
    /// When to [prompt](super::prompt) whom that a reader has come to know: reader and writer.
    unprompted: Vec<(Instant, GUID, GUID)>,
    /// When the last participant was seen to have come.
    newcomer_at: Option<Instant>,
    /// All that was told of them, and what is still to be told.
    told: HashSet<String>,
    news: Vec<String>,
}

impl Peers {
    /// Of the events of a participant that has no topics yet.
    pub fn new(status: DomainParticipantStatusListener) -> Self {
        Self(Rc::new(RefCell::new(Known {
            status,
            readers_of_writer: HashMap::new(),
            lost_count: false,
            types: HashMap::new(),
            strangers: HashMap::new(),
            deaf: HashSet::new(),
            unprompted: Vec::new(),
            newcomer_at: None,
            told: HashSet::new(),
            news: Vec::new(),
        })))
    }

    /// The node has this topic.
    pub fn add_topic(&self, topic: &Topic) {
        let type_name = topic.get_type().name().to_owned();
        self.0.borrow_mut().types.insert(topic.name(), type_name);
    }

    /// Takes note of who came and went; to be called now and then, or events are dropped.
    pub fn update(&self) {
        self.0.borrow_mut().update();
    }

    /// Ends when something was heard of others.
    pub async fn change(&self) {
        poll_fn(|context| {
            let known = &mut *self.0.borrow_mut();
            let event = known.status.as_async_status_stream().poll_next_unpin(context);
            event.map(|event| known.note_all(event))
        })
        .await;
    }

    /// When a writer is to be prompted.
    pub fn due(&self) -> Option<Instant> {
        self.0.borrow().unprompted.iter().map(|(due, ..)| *due).min()
    }

    /// Whom to prompt now: a reader of ours and the writer.
    pub fn unprompted(&self, now: Instant) -> Vec<(GUID, GUID)> {
        let unprompted = &mut self.0.borrow_mut().unprompted;
        let due = unprompted.extract_if(.., |(due, ..)| *due <= now);
        due.map(|(_, reader, writer)| (reader, writer)).collect()
    }

    /// Whether somebody hears a publisher, as of the last update.
    pub fn hear(&self, writer: GUID) -> bool {
        let known = self.0.borrow();
        let readers = known.readers_of_writer.get(&writer);
        known.lost_count || readers.is_some_and(|readers| !readers.is_empty())
    }

    /// Whether this publisher is one of another type, as of the last update.
    pub fn is_stranger(&self, publisher: Gid) -> bool {
        self.0.borrow().strangers.keys().any(|guid| Gid::from(*guid) == publisher)
    }

    /// Whether there is a publisher of another type on a topic, by its name in DDS.
    pub fn has_stranger(&self, topic: &str) -> bool {
        self.0.borrow().strangers.values().any(|of| of == topic)
    }

    /// To be called before an endpoint is opened: who comes meanwhile must know the node first.
    pub fn let_newcomers_meet(&self) {
        loop {
            self.update();
            let newcomer_at = self.0.borrow().newcomer_at;
            match newcomer_at.and_then(|at| ANSWERED_AFTER.checked_sub(at.elapsed())) {
                Some(left) => thread::sleep(left),
                None => return,
            }
        }
    }

    /// A line on each other type that was found since the last call.
    pub fn news(&self) -> Vec<String> {
        std::mem::take(&mut self.0.borrow_mut().news)
    }
}

impl Known {
    fn update(&mut self) {
        self.note_all(None);
    }

    /// Takes note of an event, and of all that wait behind it.
    fn note_all(&mut self, first: Option<DomainParticipantStatusEvent>) {
        let mut events = 0;
        let mut next = first.or_else(|| self.status.try_recv_status());
        while let Some(event) = next {
            self.note(event);
            events += 1;
            next = self.status.try_recv_status();
        }
        self.lost_count |= events > EVENTS_MAX;
    }

    fn note(&mut self, event: DomainParticipantStatusEvent) {
        use DomainParticipantStatusEvent as Event;
        match event {
            Event::RemoteReaderMatched { local_writer, remote_reader }
                if !self.deaf.contains(&remote_reader) =>
            {
                self.readers_of_writer.entry(local_writer).or_default().insert(remote_reader);
            }
            Event::ParticipantDiscovered { .. } => self.newcomer_at = Some(Instant::now()),
            Event::ReaderLost { guid, .. } => self.forget(|reader| *reader == guid),
            Event::WriterDetected { writer } if self.is_other(&writer, "publishes") => {
                self.strangers.insert(writer.guid, writer.topic_name);
            }
            Event::RemoteWriterMatched { local_reader, remote_writer }
                if remote_writer.to_bytes().starts_with(&FAST_DDS)
                    && self.unprompted.len() < STRANGERS_MAX =>
            {
                let due = Instant::now() + PROMPTED_AFTER;
                self.unprompted.push((due, local_reader, remote_writer));
            }
            Event::ReaderDetected { reader } if self.is_other(&reader, "reads") => {
                self.deaf.insert(reader.guid);
            }
            Event::WriterLost { guid, .. } => drop(self.strangers.remove(&guid)),
            Event::ParticipantLost { id, .. } => {
                self.forget(|reader| reader.prefix == id);
                self.strangers.retain(|writer, _| writer.prefix != id);
            }
            _ => {}
        }
    }

    fn forget(&mut self, gone: impl Fn(&GUID) -> bool) {
        self.deaf.retain(|reader| !gone(reader));
        for readers in self.readers_of_writer.values_mut() {
            readers.retain(|reader| !gone(reader));
        }
    }

    /// Whether an endpoint takes a topic of the node for another type, which is then told once.
    fn is_other(&mut self, endpoint: &EndpointDescription, does: &str) -> bool {
        let EndpointDescription { topic_name, type_name, .. } = endpoint;
        let ours = self.types.get(topic_name).filter(|ours| *ours != type_name);
        let Some(ours) = ours.filter(|_| self.strangers.len() + self.deaf.len() < STRANGERS_MAX)
        else {
            return false;
        };
        let topic = topic_name.strip_prefix("rt").unwrap_or(topic_name);
        let (ours, theirs) = (in_ros(ours), in_ros(type_name));
        let line = format!("somebody {does} {theirs} on {topic}, not {ours}: ignored");
        if self.told.len() < STRANGERS_MAX && self.told.insert(line.clone()) {
            self.news.push(line);
        }
        true
    }
}

/// A type's name in DDS as ROS has it, on one line whatever it is.
fn in_ros(type_name: &str) -> String {
    let name = type_name.replace("::dds_::", "/").replace("::", "/");
    name.trim_end_matches('_').escape_debug().to_string()
}

#[cfg(test)]
mod tests {
    #[test]
    fn types_are_told_as_ros_has_them() {
        assert_eq!(super::in_ros("std_msgs::msg::dds_::String_"), "std_msgs/msg/String");
        assert_eq!(super::in_ros("anything\nelse"), "anything\\nelse");
    }
}
