//! `carom replay`: the topics of a bag, published again as they were, at their pace.
//!
//! Payloads go out as they stand in the bag, with the quality of service that was recorded; only a
//! list that is larger than what a subscriber receives by default goes out in parts.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use super::arguments::RosArguments;
use super::dds::{DdsError, Publisher, RawPublisher, Reach, Ros, RosMessage};
use super::parts::{self, InParts};
use super::raw::Raw;
use super::{NodeError, Start, Stop, start, start_log};
use crate::bag::decode;
use crate::bag::qos::Qos;
use crate::bag::read::{Bag, Message, Topic};
use crate::messages::{CircleStates, CircleVelocities, Clock, Contacts, Time};

/// A subscriber that is slow is waited for so long before a message is given up.
const FULL_WAIT: Duration = Duration::from_secs(1);
/// More than this within the time of a pause overflows what a subscriber receives by default.
/// Each message takes a datagram's worth besides its content, bytes.
const BURST_BYTES: usize = 48 << 10;
const MESSAGE_BYTES: usize = 1 << 10;
const BURST_PAUSE: Duration = Duration::from_millis(1);
/// So long after the last message reliable subscribers can still ask for what they have lost.
const LINGER: Duration = Duration::from_millis(500);
/// Payloads above this go out in parts, bytes.
const WHOLE_BYTES_MAX: usize = 50_100;

/// What to play, and how.
#[derive(Debug)]
pub struct ReplayOptions {
    /// The bag.
    pub bag: Bag,
    /// Recorded seconds in a second; 0 = as fast as possible.
    pub rate: f64,
    /// Rate of `/clock`, 1/s, where it is published.
    pub clock_hz: Option<f64>,
    /// Only these topics; none = all.
    pub topics: Vec<String>,
    /// Begins again at the end.
    pub again: bool,
    /// Before the first message, s.
    pub delay: f64,
}

/// Plays to the end or until it is stopped; one line about it.
///
/// # Errors
/// [`NodeError`]
pub fn replay(ros: RosArguments, options: &ReplayOptions) -> Result<String, NodeError> {
    let start = Start::named("carom_replay", ros)?;
    start_log(start.log_level);
    let (domain_id, reach) = (start::domain_id()?, Reach::from_environment(start::environment)?);
    let bag = &options.bag;
    bag.faults().iter().for_each(|fault| tracing::warn!("{fault}"));
    let missing =
        options.topics.iter().find(|name| !bag.topics().iter().any(|topic| is(topic, name)));
    if let Some(name) = missing {
        let names: Vec<&str> = bag.topics().iter().map(|topic| topic.name.as_str()).collect();
        let what = format!("no topic {name} in the bag; there are {}", names.join(", "));
        return Err(NodeError::BadUse(what));
    }
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let mut stop = runtime.block_on(async { Stop::new() })?;
    let mut ros = Ros::open(start.names.clone(), domain_id, reach)?;
    let mut player = Player::open(&mut ros, options)?;
    runtime.block_on(async {
        tokio::select! {
            biased;
            () = stop.asked() => {}
            () = async { player.play(options).await; player.linger(bag).await } => {}
        }
    });
    let line = player.line();
    drop(player);
    ros.close();
    Ok(line)
}

fn is(topic: &Topic, name: &str) -> bool {
    topic.name.trim_start_matches('/') == name.trim_start_matches('/')
}

struct Player {
    /// By topic; nothing of those that are not played.
    publishers: Vec<Option<RawPublisher>>,
    clock: Option<Publisher<Clock>>,
    burst_began: Instant,
    burst_bytes: usize,
    /// That some messages cannot be sent was said.
    is_order_told: bool,
    sent: u64,
    unsent: u64,
    faults: u64,
}

impl Player {
    fn open(ros: &mut Ros, options: &ReplayOptions) -> Result<Self, NodeError> {
        let mut publishers = Vec::new();
        for topic in options.bag.topics() {
            let is_named = options.topics.iter().any(|name| is(topic, name));
            let is_wanted = is_named || options.topics.is_empty();
            let is_clock = options.clock_hz.is_some() && topic.name == "/clock";
            let can = topic.encoding == "cdr" && topic.kind.split('/').count() == 3;
            if is_wanted && !can {
                tracing::warn!("{} is left out: no messages of ROS 2", topic.name);
            }
            let plays = is_wanted && can && !is_clock;
            let mut open = || ros.raw_publisher(&topic.name, &topic.kind, Qos::of_yaml(&topic.qos));
            publishers.push(if plays { Some(open()?) } else { None });
        }
        let clock = options.clock_hz.map(|_| ros.publisher("/clock", 1)).transpose()?;
        let faults = options.bag.faults().len() as u64;
        let burst_began = Instant::now();
        Ok(Self {
            publishers,
            clock,
            burst_began,
            burst_bytes: 0,
            is_order_told: false,
            sent: 0,
            unsent: 0,
            faults,
        })
    }

    async fn play(&mut self, options: &ReplayOptions) {
        tokio::time::sleep(Duration::from_secs_f64(options.delay.min(86_400.0))).await;
        loop {
            let sent_before = self.sent;
            self.play_once(options).await;
            if !options.again || self.sent == sent_before {
                return;
            }
        }
    }

    async fn play_once(&mut self, options: &ReplayOptions) {
        let bag = &options.bag;
        let index = |topic: &Topic| bag.topics().iter().position(|other| other == topic);
        let plays: Vec<bool> = self.publishers.iter().map(Option::is_some).collect();
        let messages = bag.messages(|topic| index(topic).is_some_and(|index| plays[index]));
        let mut pace: Option<Pace> = None;
        for next in messages {
            let message = match next {
                Ok(message) => message,
                Err(fault) => {
                    self.faults += 1;
                    tracing::warn!("{fault}");
                    continue;
                }
            };
            let time_ns = message.log_time_ns;
            let pace = pace.get_or_insert_with(|| Pace::new(time_ns, options));
            while let Some(tick_ns) = pace.tick_before(time_ns) {
                pace.wait(tick_ns).await;
                self.tell(tick_ns);
            }
            pace.wait(time_ns).await;
            self.send(message, bag.topics()).await;
        }
    }

    fn tell(&mut self, time_ns: u64) {
        let sec = i32::try_from(time_ns / 1_000_000_000).unwrap_or(i32::MAX);
        let clock = Clock { clock: Time { sec, nanosec: (time_ns % 1_000_000_000) as u32 } };
        let sent = self.clock.as_ref().map(|publisher| publisher.publish(clock));
        self.unsent += u64::from(sent.is_some_and(|sent| sent.is_err()));
    }

    async fn send(&mut self, message: Message, topics: &[Topic]) {
        let kind = topics[message.topic].kind.as_str();
        let mut parts: VecDeque<Vec<u8>> = match kind {
            _ if message.payload.len() <= WHOLE_BYTES_MAX => VecDeque::new(),
            "carom/msg/CircleStates" => split::<CircleStates>(&message.payload),
            "carom/msg/CircleVelocities" => split::<CircleVelocities>(&message.payload),
            "carom/msg/Contacts" => split::<Contacts>(&message.payload),
            _ => VecDeque::new(),
        };
        if parts.is_empty() {
            parts.push_back(message.payload);
        }
        let mut is_whole = true;
        while let Some(part) = parts.pop_front() {
            is_whole &= self.send_part(message.topic, part).await;
            if !parts.is_empty() {
                tokio::time::sleep(parts::PAUSE_MIN).await;
            }
        }
        *(if is_whole { &mut self.sent } else { &mut self.unsent }) += 1;
    }

    /// A window that is full is waited for, as a recording does not come again.
    async fn send_part(&mut self, topic: usize, payload: Vec<u8>) -> bool {
        if self.burst_began.elapsed() > BURST_PAUSE {
            (self.burst_began, self.burst_bytes) = (Instant::now(), 0);
        }
        self.burst_bytes += MESSAGE_BYTES + payload.len();
        if self.burst_bytes > BURST_BYTES {
            tokio::time::sleep(BURST_PAUSE).await;
        }
        let Some(raw) = Raw::of(payload) else {
            if !std::mem::replace(&mut self.is_order_told, true) {
                tracing::warn!(
                    "messages in another order of bytes than little-endian are not sent"
                );
            }
            return false;
        };
        let Some(publisher) = self.publishers.get(topic).and_then(Option::as_ref) else {
            return false;
        };
        let deadline = Instant::now() + FULL_WAIT;
        loop {
            match publisher.publish(raw.clone()) {
                Ok(()) => return true,
                Err(DdsError::WindowFull) if Instant::now() < deadline => {
                    tokio::time::sleep(Duration::from_millis(1)).await;
                }
                Err(_) => return false,
            }
        }
    }

    /// Stays for those who have not got everything yet.
    async fn linger(&self, bag: &Bag) {
        let mut played = bag.topics().iter().zip(&self.publishers);
        if played.any(|(topic, publisher)| publisher.is_some() && Qos::of_yaml(&topic.qos).reliable)
        {
            tokio::time::sleep(LINGER).await;
        }
    }

    fn line(&self) -> String {
        let Self { sent, unsent, faults, .. } = self;
        format!("{sent} messages played, {unsent} could not be sent, {faults} faults of the bag")
    }
}

/// The parts of a list that is too large for one message.
fn split<M: InParts + RosMessage>(payload: &[u8]) -> VecDeque<Vec<u8>> {
    let Ok(message) = decode::message::<M>(payload) else { return VecDeque::new() };
    parts::split(message).iter().filter_map(|part| decode::payload(part).ok()).collect()
}

/// Which instant a recorded time belongs to.
struct Pace {
    begin: Instant,
    first_ns: u64,
    rate: f64,
    next_tick_ns: u64,
    tick_ns: u64,
}

impl Pace {
    fn new(first_ns: u64, options: &ReplayOptions) -> Self {
        // Ticks are of wall time: at another rate they are further apart in the recording.
        let rate = if options.rate > 0.0 { options.rate } else { 1.0 };
        let tick_ns = options.clock_hz.map_or(u64::MAX, |hz| (1e9 * rate / hz).max(1e3) as u64);
        let next_tick_ns = if options.clock_hz.is_some() { first_ns } else { u64::MAX };
        Self { begin: Instant::now(), first_ns, rate: options.rate, next_tick_ns, tick_ns }
    }

    /// The next tick of the clock, if it is not after a time.
    fn tick_before(&mut self, time_ns: u64) -> Option<u64> {
        let tick = self.next_tick_ns;
        if tick > time_ns {
            return None;
        }
        self.next_tick_ns = tick.saturating_add(self.tick_ns);
        Some(tick)
    }

    async fn wait(&self, time_ns: u64) {
        if self.rate == 0.0 {
            tokio::task::yield_now().await;
            return;
        }
        let since = time_ns.saturating_sub(self.first_ns) as f64 * 1e-9 / self.rate;
        let due = self.begin + Duration::from_secs_f64(since.min(1e9));
        if due > Instant::now() {
            tokio::time::sleep_until(due.into()).await;
        } else {
            // So that a signal is heard.
            tokio::task::yield_now().await;
        }
    }
}
