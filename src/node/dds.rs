//! The only door to DDS: a participant with one ROS node, typed publishers and subscriptions.
//!
//! ros2-client's Spinner is never started: it would subscribe to /clock with a wrong type. So the
//! parameter services are carom's own, and who listens is learnt from the participant's status
//! events.
//! Nothing here may block the caller: a publisher whose send window is full refuses the message.
//! Nothing from the network may panic: an undecodable payload is an error, and reading goes on.

use std::cell::Cell;
use std::collections::HashMap;
use std::net::Ipv4Addr;
use std::thread;
use std::time::{Duration, Instant};

use futures::Stream;
use ros2_client::action::ActionServerQosPolicies;
use ros2_client::qos::{Durability, History, QosProfile, WhenFull};
use ros2_client::service::ServiceMapping;
use ros2_client::{
    ActionTypeName, AsyncActionServer, Context, Gid, MessageInfo, MessageTypeName, Name, Node,
    NodeName, NodeOptions, ReadResult, ServiceTypeName, WriteError,
};
use rustdds::policy::{self, ResourceLimits};
use rustdds::{
    DomainParticipant, DomainParticipantBuilder, GUID, QosPolicies, QosPolicyBuilder, RTPSEntity,
    TopicDescription, TopicKind,
};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::names::{BadName, Names};
use super::parameters::services::ParameterEvent;
use super::peers::Peers;
use super::raw::Raw;
use super::recorder::{Recorder, Tap};
use super::rosout::Log;
use super::service::{RosService, Service};
use super::simulation::wire::{StepsFeedback, StepsGoal, StepsResult};
use super::{farewell, prompt};
use crate::bag::qos::Qos;
use crate::messages::{
    CircleStates, CircleVelocities, Clock, Contacts, Crashes, DiagnosticArray, ErrorReport,
    MarkerArray, Odometry, TrackedFrame, Twist, TwistStamped, VisionStateBall, VisionStateRobot,
};

/// Largest domain whose ports fit into 16 bits; RustDDS overflows silently above it.
pub const DOMAIN_ID_MAX: u16 = 232;

/// When a participant that starts has announced itself: RustDDS does it after 0.1 s. Fast DDS
/// loses for ever what it hears about endpoints of a participant that it does not know yet. (Who
/// starts in the very milliseconds in which endpoints are opened may still miss some.)
const ANNOUNCED_AFTER: Duration = Duration::from_millis(150);

/// Requests that wait for the loop, and answers for a slow client: as rmw has them.
const SERVICE_DEPTH: usize = 10;

/// Lines of the log that one who comes late hears, none of them older: as rcl has them.
const LOG_DEPTH: usize = 1_000;
const LOG_LIFESPAN: Duration = Duration::from_secs(10);
/// Messages that DDS keeps for a reader that does not acknowledge them: beyond it nobody is sent
/// any more. A dead reader is known as such after the lease of 20 s that Fast DDS gives, so that
/// this many are sent in 20 s at 1.6 kHz.
const UNACKNOWLEDGED_MAX: i32 = 32_768;

/// What can go wrong at this door.
#[derive(Debug, thiserror::Error)]
pub enum DdsError {
    /// The domain id has no UDP ports.
    #[error("domain id {0} is not in 0..=232")]
    DomainId(u16),
    /// An environment variable says something this node cannot do.
    #[error("{variable}={value} is not supported; use {allowed}")]
    Environment {
        /// The variable.
        variable: &'static str,
        /// What it was set to.
        value: String,
        /// What would be right.
        allowed: &'static str,
    },
    /// A node, topic or service name that ROS does not allow.
    #[error(transparent)]
    Name(#[from] BadName),
    /// The participant, the node or an endpoint could not be made.
    #[error("DDS cannot open {what}: {reason}")]
    Open {
        /// What was to be made.
        what: String,
        /// The middleware's words.
        reason: String,
    },
    /// A payload that is not the type of its topic. The next message can still be read.
    #[error("undecodable message: {0}")]
    Undecodable(String),
    /// A message from a publisher of another type, which `Peers` tells of.
    #[error("a message of another type")]
    WrongType,
    /// A reliable reader has stopped acknowledging and the send window is full.
    #[error("send window full: a subscriber acknowledges nothing")]
    WindowFull,
    /// The answer of a service does not fit into one datagram.
    #[error("an answer of {0} bytes is larger than one datagram: ask for less at a time")]
    TooLarge(usize),
    /// The middleware failed to send.
    #[error("DDS cannot send: {0}")]
    Send(String),
}

/// How far discovery and traffic reach.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reach {
    /// All interfaces.
    #[default]
    Subnet,
    /// The loopback interface only.
    Localhost,
}

impl Reach {
    /// Reads ROS_LOCALHOST_ONLY (which wins, as in rmw) and ROS_AUTOMATIC_DISCOVERY_RANGE.
    pub fn from_environment(get: impl Fn(&str) -> Option<String>) -> Result<Self, DdsError> {
        if get("ROS_LOCALHOST_ONLY").as_deref() == Some("1") {
            return Ok(Self::Localhost);
        }
        let variable = "ROS_AUTOMATIC_DISCOVERY_RANGE";
        let value = get(variable).unwrap_or_default();
        match value.as_str() {
            "" | "SUBNET" | "SYSTEM_DEFAULT" => Ok(Self::Subnet),
            "LOCALHOST" => Ok(Self::Localhost),
            _ => {
                let allowed = "SUBNET, LOCALHOST or SYSTEM_DEFAULT";
                Err(DdsError::Environment { variable, value, allowed })
            }
        }
    }
}

/// A message type with its ROS name. `Vec` fields are read element by element and grow with the
/// bytes that are really there, so a forged length is an error, never a huge allocation.
pub trait RosMessage: Serialize + DeserializeOwned + Clone + Send + 'static {
    /// The interface package.
    const PACKAGE: &'static str;
    /// The name in `msg/`.
    const TYPE: &'static str;
}

macro_rules! ros_messages {
    ($($package:literal $name:ident)*) => {$(
        impl RosMessage for $name {
            const PACKAGE: &'static str = $package;
            const TYPE: &'static str = stringify!($name);
        }
        impl ros2_client::Message for $name {}
    )*};
}

ros_messages! {
    "carom" CircleStates
    "carom" CircleVelocities
    "carom" Contacts
    "carom" Crashes
    "carom" ErrorReport
    "diagnostic_msgs" DiagnosticArray
    "visualization_msgs" MarkerArray
    "nav_msgs" Odometry
    "geometry_msgs" Twist
    "geometry_msgs" TwistStamped
    "rosgraph_msgs" Clock
    "rcl_interfaces" ParameterEvent
    "rcl_interfaces" Log
    "robocup_ssl_msgs" TrackedFrame
    "ateam_msgs" VisionStateBall
    "ateam_msgs" VisionStateRobot
}

/// One ROS node on a DDS participant of its own. Drop it last; dropping it leaves the graph.
pub struct Ros {
    // Dropped in this order: the node says goodbye, then the participant goes.
    node: Node,
    _context: Context,
    participant: DomainParticipant,
    peers: Peers,
    names: Names,
    guid: [u8; 16],
    reach: Reach,
    /// What is opened from now on goes into a bag too.
    recorder: Option<Recorder>,
}

/// What can be drawn again from the rest is not recorded.
const UNRECORDED: &str = "MarkerArray";

impl Ros {
    /// Opens a participant in `domain_id` and a node of this name without rosout and parameter
    /// services.
    pub fn open(names: Names, domain_id: u16, reach: Reach) -> Result<Self, DdsError> {
        if domain_id > DOMAIN_ID_MAX {
            return Err(DdsError::DomainId(domain_id));
        }
        let name = NodeName::new(names.namespace(), names.node())
            .map_err(|e| cannot_open("the node", &e))?;
        let mut builder = DomainParticipantBuilder::new(domain_id);
        if reach == Reach::Localhost {
            builder = builder.with_only_networks([Ipv4Addr::LOCALHOST]);
        }
        let participant = builder.build().map_err(|e| cannot_open("the participant", &e))?;
        warn_of_a_crowd(participant.participant_id(), domain_id);
        let peers = Peers::new(participant.status_listener());
        thread::sleep(ANNOUNCED_AFTER);
        peers.let_newcomers_meet();
        let guid = participant.guid().to_bytes();
        let context = Context::from_domain_participant(participant.clone())
            .map_err(|e| cannot_open("the context", &e))?;
        let options = NodeOptions::new().enable_rosout(false).start_parameter_services(false);
        let node = context.new_node(name, options).map_err(|e| cannot_open("the node", &e))?;
        let recorder = None;
        Ok(Self { node, _context: context, participant, peers, names, guid, reach, recorder })
    }

    /// Who else there is.
    pub fn peers(&self) -> &Peers {
        &self.peers
    }

    /// Asks again for the first message of writers that have come.
    pub fn prompt(&self, now: Instant) {
        let participant = (self.node.domain_id(), self.participant.participant_id());
        for (reader, writer) in self.peers.unprompted(now) {
            prompt::send(reader, writer, participant);
        }
    }

    /// Whatever is opened from now on is recorded.
    pub fn record(&mut self, recorder: Recorder) {
        self.recorder = Some(recorder);
    }

    /// The whole name of a topic.
    pub fn topic_name(&self, topic: &str) -> Result<String, DdsError> {
        Ok(self.names.topic(topic)?)
    }

    fn tap<M: RosMessage>(&self, topic: &str, depth: usize) -> Result<Option<Tap>, DdsError> {
        let Some(recorder) = self.recorder.as_ref().filter(|_| M::TYPE != UNRECORDED) else {
            return Ok(None);
        };
        let kind = format!("{}/msg/{}", M::PACKAGE, M::TYPE);
        let qos = Qos { depth, ..Qos::default() };
        Ok(Some(recorder.tap(&self.topic_name(topic)?, &kind, &qos.to_yaml())))
    }

    /// A reliable, volatile publisher on a topic of this name, as the command line renames it.
    pub fn publisher<M: RosMessage>(
        &mut self,
        topic: &str,
        depth: usize,
    ) -> Result<Publisher<M>, DdsError> {
        let qos = QosProfile::publisher_default()
            .reliability_reliable(WhenFull::Fail)
            .history(History::KeepLast { depth });
        self.publish_with(topic, depth, qos)
    }

    /// The publisher of `/rosout`, as rcl has it: who comes late hears what was said.
    pub fn log_publisher(&mut self) -> Result<Publisher<Log>, DdsError> {
        let qos = QosProfile::publisher_default()
            .reliability_reliable(WhenFull::Fail)
            .durability(Durability::TransientLocal)
            .lifespan(Some(LOG_LIFESPAN))
            .history(History::KeepLast { depth: LOG_DEPTH });
        self.publish_with("/rosout", LOG_DEPTH, qos)
    }

    fn publish_with<M: RosMessage>(
        &mut self,
        topic: &str,
        depth: usize,
        qos: QosProfile,
    ) -> Result<Publisher<M>, DdsError> {
        self.peers.let_newcomers_meet();
        let bounds = QosPolicyBuilder::new()
            .resource_limits(ResourceLimits {
                max_samples: UNACKNOWLEDGED_MAX,
                max_instances: 1,
                max_samples_per_instance: UNACKNOWLEDGED_MAX,
            })
            .build();
        let topic_handle = self.topic::<M>(topic, &QosPolicies::from(&qos).modify_by(&bounds))?;
        self.peers.add_topic(&topic_handle);
        let inner = self
            .node
            .create_publisher(&topic_handle, Some(qos))
            .map_err(|e| cannot_open(topic, &e))?;
        let tap = self.tap::<M>(topic, depth)?;
        let (topic, is_stuck) = (topic.to_owned(), Cell::new(false));
        Ok(Publisher { inner, topic, depth, is_stuck, tap })
    }

    /// Opens a publisher anew if a subscriber that acknowledges nothing has brought it to a halt:
    /// the others then get on.
    pub fn free<M: RosMessage>(&mut self, publisher: &mut Publisher<M>) -> Result<(), DdsError> {
        if publisher.is_stuck.get() {
            *publisher = self.publisher(&publisher.topic, publisher.depth)?;
        }
        Ok(())
    }

    /// A best-effort subscription, which matches every publisher of the type.
    /// DDS keeps the last max(64, `depth`) payloads in memory, read or not.
    pub fn subscription<M: RosMessage>(
        &mut self,
        topic: &str,
        depth: usize,
    ) -> Result<Subscription<M>, DdsError> {
        self.peers.let_newcomers_meet();
        let qos = QosProfile::subscription_default().history(History::KeepLast { depth });
        let topic_handle = self.topic::<M>(topic, &QosPolicies::from(&qos))?;
        self.peers.add_topic(&topic_handle);
        let inner = self
            .node
            .create_subscription(&topic_handle, Some(qos))
            .map_err(|e| cannot_open(topic, &e))?;
        let tap = self.tap::<M>(topic, depth)?;
        Ok(self.reading(inner, &topic_handle, tap))
    }

    fn reading<M: DeserializeOwned + 'static>(
        &self,
        inner: ros2_client::Subscription<M>,
        topic: &rustdds::Topic,
        tap: Option<Tap>,
    ) -> Subscription<M> {
        let (numbers, peers) = (Numbers::default(), self.peers.clone());
        Subscription { inner, numbers, peers, topic: topic.name(), tap }
    }

    /// A publisher of any type, such as `carom/msg/Contacts`.
    pub fn raw_publisher(
        &mut self,
        topic: &str,
        kind: &str,
        qos: Qos,
    ) -> Result<RawPublisher, DdsError> {
        self.peers.let_newcomers_meet();
        let profile = profile(QosProfile::publisher_default(), qos, qos.depth.max(100));
        let handle = self.raw_topic(topic, kind, &QosPolicies::from(&profile))?;
        let inner = self.node.create_publisher(&handle, Some(profile));
        Ok(RawPublisher(inner.map_err(|e| cannot_open(topic, &e))?))
    }

    /// A subscription of any type.
    pub fn raw_subscription(
        &mut self,
        topic: &str,
        kind: &str,
        qos: Qos,
        depth: usize,
    ) -> Result<Subscription<Raw>, DdsError> {
        self.peers.let_newcomers_meet();
        let profile = profile(QosProfile::subscription_default(), qos, depth);
        let handle = self.raw_topic(topic, kind, &QosPolicies::from(&profile))?;
        self.peers.add_topic(&handle);
        let inner = self.node.create_subscription(&handle, Some(profile));
        let inner = inner.map_err(|e| cannot_open(topic, &e))?;
        Ok(self.reading(inner, &handle, None))
    }

    /// The topics that other nodes offer, each with what all its publishers have in common.
    pub fn offered(&self) -> Vec<Offered> {
        let own = GUID::from_bytes(self.guid).prefix;
        let mut found: Vec<Offered> = Vec::new();
        for writer in self.participant.discovered_writers() {
            let said = writer.publication_topic_data;
            let name = said.topic_name.strip_prefix("rt/").map(|name| format!("/{name}"));
            let kind = said.type_name.replacen("::dds_::", "::", 1).replace("::", "/");
            let (Some(name), Some(kind)) = (name, kind.strip_suffix('_')) else { continue };
            if said.key.prefix == own {
                continue;
            }
            let reliable = matches!(said.reliability, Some(policy::Reliability::Reliable { .. }));
            let transient_local = said
                .durability
                .is_some_and(|durability| durability != policy::Durability::Volatile);
            let other = found.iter_mut().find(|other| other.name == name && other.kind == kind);
            match other {
                Some(Offered { qos, .. }) => {
                    qos.reliable &= reliable;
                    qos.transient_local &= transient_local;
                }
                None => {
                    let qos = Qos { reliable, transient_local, ..Qos::default() };
                    found.push(Offered { name, kind: kind.to_owned(), qos });
                }
            }
        }
        found
    }

    /// A service of this name, as the command line renames it, as Fast DDS maps it to topics.
    pub fn service<S: RosService>(&mut self, name: &str) -> Result<Service<S>, DdsError> {
        self.peers.let_newcomers_meet();
        let full = self.names.service(name)?;
        let full = Name::parse(&full).map_err(|e| cannot_open(name, &e))?;
        let kind = ServiceTypeName::new(S::PACKAGE, S::TYPE);
        let qos = QosProfile::publisher_default()
            .reliability_reliable(WhenFull::Fail)
            .history(History::KeepLast { depth: SERVICE_DEPTH });
        let server =
            self.node.create_server(ServiceMapping::Enhanced, &full, &kind, qos.clone(), qos);
        Ok(Service::new(server.map_err(|e| cannot_open(name, &e))?))
    }

    /// The action `simulate_steps`.
    pub fn simulate_steps(
        &mut self,
    ) -> Result<AsyncActionServer<StepsGoal, StepsResult, StepsFeedback>, DdsError> {
        let name = "simulate_steps";
        self.peers.let_newcomers_meet();
        let full = self.names.service(name)?;
        let full = Name::parse(&full).map_err(|e| cannot_open(name, &e))?;
        let kind = ActionTypeName::new("simulation_interfaces", "SimulateSteps");
        let qos = QosProfile::publisher_default()
            .reliability_reliable(WhenFull::Fail)
            .history(History::KeepLast { depth: SERVICE_DEPTH });
        let policies = ActionServerQosPolicies {
            goal_service: qos.clone(),
            result_service: qos.clone(),
            cancel_service: qos.clone(),
            feedback_publisher: qos.clone(),
            status_publisher: qos.durability(Durability::TransientLocal),
        };
        let server =
            self.node.create_action_server(ServiceMapping::Enhanced, &full, &kind, policies);
        Ok(AsyncActionServer::new(server.map_err(|e| cannot_open(name, &e))?))
    }

    /// Leaves the graph at once: call it when all publishers and subscriptions are dropped.
    pub fn close(self) {
        let (guid, domain_id, reach) = (self.guid, self.node.domain_id(), self.reach);
        // Joins RustDDS's threads, so that nothing announces the participant again.
        drop(self);
        farewell::send(guid, domain_id, reach == Reach::Subnet);
    }

    fn topic<M: RosMessage>(
        &self,
        topic: &str,
        qos: &QosPolicies,
    ) -> Result<rustdds::Topic, DdsError> {
        self.open_topic(topic, MessageTypeName::new(M::PACKAGE, M::TYPE), qos)
    }

    fn raw_topic(
        &self,
        topic: &str,
        kind: &str,
        qos: &QosPolicies,
    ) -> Result<rustdds::Topic, DdsError> {
        let (package, name) = kind.split_once("/msg/").unwrap_or((kind, ""));
        self.open_topic(topic, MessageTypeName::new(package, name), qos)
    }

    fn open_topic(
        &self,
        topic: &str,
        type_name: MessageTypeName,
        qos: &QosPolicies,
    ) -> Result<rustdds::Topic, DdsError> {
        // Not through ros2-client, which knows no bounds and makes `rt//name` of a relative name
        // in the namespace `/`.
        let name = format!("rt{}", self.names.topic(topic)?);
        let type_name = type_name.dds_msg_type();
        let made = self.participant.create_topic(name, type_name, qos, TopicKind::NoKey);
        made.map_err(|e| cannot_open(topic, &e))
    }
}

/// A topic that somebody offers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Offered {
    /// Its whole name.
    pub name: String,
    /// Its type, such as `carom/msg/Contacts`.
    pub kind: String,
    /// What a subscription may ask of every publisher.
    pub qos: Qos,
}

fn profile(from: QosProfile, qos: Qos, depth: usize) -> QosProfile {
    let from = from.history(History::KeepLast { depth });
    let from = if qos.reliable {
        from.reliability_reliable(WhenFull::Fail)
    } else {
        from.reliability_best_effort()
    };
    let kept = if qos.transient_local { Durability::TransientLocal } else { Durability::Volatile };
    from.durability(kept)
}

/// Sends messages of one type on one topic.
pub struct Publisher<M: RosMessage> {
    inner: ros2_client::Publisher<M>,
    topic: String,
    depth: usize,
    is_stuck: Cell<bool>,
    tap: Option<Tap>,
}

impl<M: RosMessage> Publisher<M> {
    /// Its name in DDS.
    pub fn guid(&self) -> GUID {
        self.inner.guid()
    }

    /// Its topic, as it was asked for.
    pub fn topic(&self) -> &str {
        &self.topic
    }

    /// Where its messages go in a bag, if they do.
    pub fn tap(&self) -> Option<&Tap> {
        self.tap.as_ref()
    }

    /// Hands the message to DDS at once or not at all.
    pub fn publish(&self, message: M) -> Result<(), DdsError> {
        self.inner.publish(message).map_err(|error| {
            let error = refused(error);
            self.is_stuck.set(matches!(error, DdsError::WindowFull));
            error
        })
    }
}

/// Sends payloads as they are on one topic.
pub struct RawPublisher(ros2_client::Publisher<Raw>);

impl RawPublisher {
    /// Hands the message to DDS at once or not at all.
    pub fn publish(&self, message: Raw) -> Result<(), DdsError> {
        self.0.publish(message).map_err(refused)
    }
}

fn refused<M>(error: WriteError<M>) -> DdsError {
    match error.forget_data() {
        WriteError::WouldBlock { .. } => DdsError::WindowFull,
        other => DdsError::Send(other.to_string()),
    }
}

/// Reads messages of one type from one topic.
pub struct Subscription<M> {
    inner: ros2_client::Subscription<M>,
    numbers: Numbers,
    peers: Peers,
    /// Its name in DDS.
    topic: String,
    tap: Option<Tap>,
}

/// What was read, and how many messages before it never were.
pub struct Received<M> {
    /// The message.
    pub message: Result<M, DdsError>,
    /// Lost on the way, or overwritten unread.
    pub dropped: u64,
}

impl<M: Serialize + DeserializeOwned + 'static> Subscription<M> {
    /// All messages from now on; it never ends.
    pub fn into_stream(self) -> impl Stream<Item = Received<M>> {
        futures::stream::unfold(self, async |mut subscription| {
            let received = subscription.received(subscription.inner.async_take().await);
            Some((received, subscription))
        })
    }

    fn received(&mut self, taken: ReadResult<(M, MessageInfo)>) -> Received<M> {
        match taken {
            Ok((message, info)) => {
                let publisher = info.publisher_gid();
                if !self.numbers.last.contains_key(&publisher) {
                    // DDS tells of a publisher before it delivers its first message.
                    self.peers.update();
                }
                let dropped = self.numbers.missing_before(&info);
                if self.peers.is_stranger(publisher) {
                    return Received { message: Err(DdsError::WrongType), dropped };
                }
                if let Some(tap) = &self.tap {
                    tap.record(&message);
                }
                Received { message: Ok(message), dropped }
            }
            Err(error) => {
                self.numbers.unknown += 1;
                let error = match self.peers.has_stranger(&self.topic) {
                    true => DdsError::WrongType,
                    false => DdsError::Undecodable(error.to_string()),
                };
                Received { message: Err(error), dropped: 0 }
            }
        }
    }
}

/// Publishers whose numbers are kept: those that come and go must not fill the memory.
const PUBLISHERS_KNOWN: usize = 1_000;

/// The numbers that publishers give to their messages: what is missing between two was lost, or
/// overwritten before it was read. DDS tells neither in another way here.
#[derive(Default)]
struct Numbers {
    last: HashMap<Gid, i64>,
    /// Messages read that told no number.
    unknown: u64,
}

impl Numbers {
    /// How many messages of its publisher are missing before this one; none before the first.
    fn missing_before(&mut self, info: &MessageInfo) -> u64 {
        self.missing(info.publisher_gid(), info.sequence_number())
    }

    fn missing(&mut self, publisher: Gid, number: i64) -> u64 {
        if self.last.len() >= PUBLISHERS_KNOWN && !self.last.contains_key(&publisher) {
            self.last.clear();
        }
        let last = self.last.insert(publisher, number).unwrap_or(number);
        let gap = number.saturating_sub(last).saturating_sub(1).max(0).unsigned_abs();
        let read = gap.min(self.unknown);
        self.unknown -= read;
        gap - read
    }
}

/// Beyond those that announce themselves to each other it is a matter of luck who is found.
fn warn_of_a_crowd(participant_id: u16, domain_id: u16) {
    let told = farewell::PARTICIPANTS_TOLD;
    if participant_id >= told {
        tracing::warn!(
            "participant {} of domain {domain_id} on this host: some of those beyond {told} may \
             not find each other; use another ROS_DOMAIN_ID",
            participant_id + 1
        );
    }
}

fn cannot_open(what: &str, error: &dyn std::fmt::Display) -> DdsError {
    DdsError::Open { what: what.to_owned(), reason: error.to_string() }
}
