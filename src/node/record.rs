//! `carom record`: what other nodes publish, as raw bytes, into a bag.
//!
//! A topic is opened when somebody offers it, and asked for as it is offered: reliably only where
//! every publisher is reliable, and with what was sent before only where every one keeps it. Types
//! that are not known are named once and left out: a bag without a definition is of no use.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::time::Duration;

use futures::stream::{LocalBoxStream, SelectAll, StreamExt};
use tokio::time::MissedTickBehavior;

use super::arguments::RosArguments;
use super::dds::{Offered, Reach, Received, Ros};
use super::names::Names;
use super::raw::Raw;
use super::recorder::{Recorder, Summary, Tap};
use super::{NodeError, Start, Stop, start, start_log};
use crate::bag::definitions;
use crate::bag::write::Options;

/// Topics are looked for so often.
const LOOK_PERIOD: Duration = Duration::from_millis(50);
/// Messages kept for the loop on each topic.
const DEPTH: usize = 1_000;

/// What to record, and where.
#[derive(Clone, Debug)]
pub struct RecordOptions {
    /// Topics, as others name them or relative.
    pub topics: Vec<String>,
    /// Every topic.
    pub all: bool,
    /// The folder, which is not there yet.
    pub folder: PathBuf,
    /// How to write.
    pub options: Options,
    /// Ends after so many seconds.
    pub seconds: Option<f64>,
}

type Messages = SelectAll<LocalBoxStream<'static, (usize, Received<Raw>)>>;

/// Records until it is stopped or the time is over; one line about it.
///
/// # Errors
/// [`NodeError`]
pub fn record(ros: RosArguments, options: &RecordOptions) -> Result<String, NodeError> {
    let start = Start::named("carom_record", ros)?;
    start_log(start.log_level);
    let (domain_id, reach) = (start::domain_id()?, Reach::from_environment(start::environment)?);
    let names = start.names.clone();
    let wanted: Result<BTreeSet<String>, _> =
        options.topics.iter().map(|topic| names.topic(topic)).collect();
    let wanted = wanted.map_err(|error| NodeError::BadUse(error.to_string()))?;
    let recorder = Recorder::open(&options.folder, options.options.clone(), Vec::new())?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let stop = runtime.block_on(async { Stop::new() })?;
    let mut ros = Ros::open(names, domain_id, reach)?;
    let mut work = Recording {
        wanted: (!options.all).then_some(wanted),
        recorder: recorder.clone(),
        opened: BTreeSet::new(),
        unknown: BTreeSet::new(),
        taps: Vec::new(),
        messages: SelectAll::new(),
        lost: 0,
    };
    let outcome = runtime.block_on(work.run(&mut ros, stop, options.seconds));
    let (lost, never) = (work.lost, work.never_offered());
    drop(work);
    ros.close();
    let Summary { messages, files } = recorder.close()?;
    outcome?;
    if !never.is_empty() {
        tracing::warn!("nobody offered {}", never.join(", "));
    }
    let (dropped, folder) = (recorder.dropped(), options.folder.display());
    Ok(format!("{messages} messages in {files} files, {dropped} dropped, {lost} lost: {folder}"))
}

struct Recording {
    /// Whole names; nothing = all.
    wanted: Option<BTreeSet<String>>,
    recorder: Recorder,
    /// Name and type.
    opened: BTreeSet<(String, String)>,
    unknown: BTreeSet<(String, String)>,
    taps: Vec<Tap>,
    messages: Messages,
    /// Messages that never reached the loop.
    lost: u64,
}

impl Recording {
    async fn run(
        &mut self,
        ros: &mut Ros,
        mut stop: Stop,
        seconds: Option<f64>,
    ) -> Result<(), NodeError> {
        let mut look = tokio::time::interval(LOOK_PERIOD);
        look.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let end = async {
            match seconds {
                // A century is no end.
                Some(seconds) if seconds < 3e9 => {
                    tokio::time::sleep(Duration::from_secs_f64(seconds)).await;
                }
                _ => std::future::pending().await,
            }
        };
        tokio::pin!(end);
        loop {
            tokio::select! {
                biased;
                () = stop.asked() => return Ok(()),
                () = &mut end => return Ok(()),
                _ = look.tick() => self.open(ros)?,
                Some((tap, received)) = self.messages.next() => self.take(tap, received),
            }
            self.recorder.hand_over();
            if let Some(why) = self.recorder.failure() {
                return Err(NodeError::BadUse(why.to_owned()));
            }
            // Signals and timers are seen when this task waits, which in a flood it never does.
            tokio::task::yield_now().await;
        }
    }

    fn take(&mut self, tap: usize, received: Received<Raw>) {
        self.lost += received.dropped;
        match received.message {
            Ok(Raw(payload)) => self.taps[tap].record_payload(&payload),
            Err(_) => self.lost += 1,
        }
    }

    /// Opens what is offered and wanted, and not yet open.
    fn open(&mut self, ros: &mut Ros) -> Result<(), NodeError> {
        let wanted = |name: &String| self.wanted.as_ref().is_none_or(|all| all.contains(name));
        let offers: Vec<Offered> =
            ros.offered().into_iter().filter(|offer| wanted(&offer.name)).collect();
        for Offered { name, kind, qos } in offers {
            let key = (name.clone(), kind.clone());
            if self.opened.contains(&key) || self.unknown.contains(&key) {
                continue;
            }
            if definitions::hash(&kind).is_none() {
                tracing::warn!("{name} is left out: its type {kind} is not known here");
                self.unknown.insert(key);
                continue;
            }
            if let Some((_, first)) = self.opened.iter().find(|(opened, _)| *opened == name) {
                // To the DDS library a topic is its name: it would mix the two.
                tracing::warn!("{name} is recorded as {first}: what comes as {kind} is left out");
                self.unknown.insert(key);
                continue;
            }
            let messages = ros.raw_subscription(&name, &kind, qos, DEPTH)?.into_stream();
            let tap = self.taps.len();
            self.taps.push(self.recorder.tap(&name, &kind, &qos.to_yaml()));
            self.messages.push(messages.map(move |received| (tap, received)).boxed_local());
            tracing::info!("records {name} ({kind})");
            self.opened.insert(key);
        }
        Ok(())
    }

    fn never_offered(&self) -> Vec<String> {
        let is_there = |name: &&String| {
            self.opened.iter().chain(&self.unknown).any(|(opened, _)| opened == *name)
        };
        self.wanted.iter().flatten().filter(|name| !is_there(name)).cloned().collect()
    }
}

impl Start {
    /// Of a command that is a node of another name.
    pub(super) fn named(node: &str, ros: RosArguments) -> Result<Self, NodeError> {
        let mut start = Self::new(RosArguments { rules: Vec::new(), ..ros.clone() })?;
        let namespace = start::environment("ROS_NAMESPACE").unwrap_or_default();
        let names = Names::new(node, &namespace, ros.rules);
        start.names = names.map_err(|error| NodeError::BadUse(error.to_string()))?;
        Ok(start)
    }
}
