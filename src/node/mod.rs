//! The node: topics in, topics out, and the loop between them. The only room that names a ROS
//! crate, reads the clock or waits.
//!
//! Subscriptions only hand messages over; the loop steps the world, at once for a message and at
//! every tick for the arena; results leave as arrays. `dds` is the door to ROS 2, `pace` maps
//! wall time to simulated time, `status` is the line that a person watches, `live` the report that
//! goes out once a second.

mod complaints;
mod dds;
mod farewell;
mod live;
mod outputs;
mod pace;
mod status;

use std::time::{Duration, Instant};

use futures::StreamExt;
use futures::stream::{SelectAll, select_all};
use tokio::signal::unix::{Signal, SignalKind, signal};
use tokio::time::MissedTickBehavior;

use crate::messages::{CircleStates, Header, Twist};
use crate::motion::arena::{Arena, Halt};
use crate::publish::error_report::Totals;
use crate::receive::{self, Cause};
use crate::scene::Scene;
use crate::world::{Answer, Command, DiscId, Instants, Outcome, World};
use complaints::Complaints;
use dds::{DdsError, Reach, Received, Ros};
use live::Live;
use outputs::Outputs;
use pace::Pace;
use status::Status;

/// Messages kept for the loop on each topic, 0.1 s at 1 kHz; older ones are dropped. DDS holds as
/// many payloads in memory, read or not.
const INPUT_DEPTH: usize = 100;
/// A stalled arena tries to go on after this.
const STALL_RETRY: Duration = Duration::from_millis(100);

/// How to run.
#[derive(Clone, Copy, Debug)]
pub struct RunOptions {
    /// Ends after so many seconds of simulated time, of wall time without pucks.
    pub seconds: Option<f64>,
    /// Simulated seconds in a second of wall time; 0 = as fast as possible.
    pub rate: f64,
}

/// Why the node could not run, or ended early.
#[derive(Debug, thiserror::Error)]
pub enum NodeError {
    /// The environment asks for something that cannot be.
    #[error("{0}")]
    BadUse(String),
    /// DDS does not do its part.
    #[error(transparent)]
    Dds(#[from] DdsError),
    /// The arena cannot get to the end that was asked for.
    #[error(transparent)]
    Stalled(#[from] Halt),
    /// The operating system does not do its part.
    #[error("cannot start: {0}")]
    System(#[from] std::io::Error),
}

impl NodeError {
    /// Whether the caller asked for something that cannot be: exit code 2.
    pub fn is_bad_use(&self) -> bool {
        matches!(
            self,
            Self::BadUse(_)
                | Self::Dds(
                    DdsError::Environment { .. } | DdsError::DomainId(_) | DdsError::Name { .. }
                )
        )
    }
}

/// Runs a scene until the time is over or SIGINT or SIGTERM comes.
///
/// # Errors
/// [`NodeError`] when it cannot start, or when the arena stalls before the time is over.
pub fn run(scene: &Scene, options: RunOptions) -> Result<(), NodeError> {
    start_log();
    let (domain_id, reach) = (domain_id()?, Reach::from_environment(environment)?);
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    // Before anybody can see the node: from its first sign of life it ends cleanly.
    let stop = runtime.block_on(async { Stop::new() })?;
    let (mut ros, listeners) = Ros::open("carom", domain_id, reach)?;
    let outcome = runtime.block_on(async {
        let inputs = Inputs::open(&mut ros, scene)?;
        let outputs = Outputs::open(&mut ros, listeners, &scene.node.frame_id)?;
        Runner::new(scene, outputs, options).run(inputs, stop).await
    });
    ros.close();
    outcome
}

/// Warnings of the DDS library are many and harmless: RUST_LOG shows them.
fn start_log() {
    let filter = tracing_subscriber::EnvFilter::try_from_default_env()
        .unwrap_or_else(|_| "info,rustdds=off,ros2_client=off,cdr_encoding=off".into());
    // A second start in one process keeps the first log.
    let _ = tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .with_target(false)
        .with_env_filter(filter)
        // A log that nobody reads any more is no reason to stop.
        .log_internal_errors(false)
        .try_init();
}

fn environment(name: &str) -> Option<String> {
    std::env::var(name).ok()
}

fn domain_id() -> Result<u16, NodeError> {
    let Some(text) = environment("ROS_DOMAIN_ID").filter(|text| !text.is_empty()) else {
        return Ok(0);
    };
    let id = text.parse().ok().filter(|id| *id <= dds::DOMAIN_ID_MAX);
    id.ok_or_else(|| {
        NodeError::BadUse(format!("ROS_DOMAIN_ID={text}: must be 0 to {}", dds::DOMAIN_ID_MAX))
    })
}

/// Sleeps until an instant; what is past costs no turn of the timer wheel, which is a millisecond.
async fn wake_at(instant: Instant) {
    if instant <= Instant::now() {
        tokio::task::yield_now().await;
    } else {
        tokio::time::sleep_until(instant.into()).await;
    }
}

/// SIGINT and SIGTERM.
struct Stop {
    interrupt: Signal,
    terminate: Signal,
}

impl Stop {
    fn new() -> std::io::Result<Self> {
        let [interrupt, terminate] = [SignalKind::interrupt(), SignalKind::terminate()];
        Ok(Self { interrupt: signal(interrupt)?, terminate: signal(terminate)? })
    }

    async fn asked(&mut self) {
        tokio::select! {
            _ = self.interrupt.recv() => {}
            _ = self.terminate.recv() => {}
        }
    }
}

/// Something that arrived.
enum Input {
    Circles { topic: String, received: Received<CircleStates> },
    Velocity { topic: String, id: DiscId, received: Received<Twist> },
}

/// All subscriptions as one stream.
struct Inputs(SelectAll<futures::stream::LocalBoxStream<'static, Input>>);

impl Inputs {
    fn open(ros: &mut Ros, scene: &Scene) -> Result<Self, DdsError> {
        let mut streams = Vec::new();
        for topic in &scene.node.circle_topics {
            let messages = ros.subscription::<CircleStates>(topic, INPUT_DEPTH)?.into_stream();
            let topic = topic.clone();
            let input = move |received| Input::Circles { topic: topic.clone(), received };
            streams.push(messages.map(input).boxed_local());
        }
        for puck in scene.pucks.iter().filter(|puck| puck.driven) {
            let topic = format!("pucks/{}/cmd_vel", puck.name);
            let messages = ros.subscription::<Twist>(&topic, 1)?.into_stream();
            let id = puck.disc.id;
            let input = move |received| Input::Velocity { topic: topic.clone(), id, received };
            streams.push(messages.map(input).boxed_local());
        }
        Ok(Self(select_all(streams)))
    }
}

/// The loop and all that it keeps.
struct Runner<'a> {
    scene: &'a Scene,
    world: World,
    outputs: Outputs,
    end: Option<f64>,
    start: Instant,
    pace: Pace,
    /// Arena states published so far.
    ticks: u64,
    stall: Option<Halt>,
    retry_at: Instant,
    status: Status,
    complaints: Complaints,
    live: Live,
    /// Messages that never reached the loop.
    dropped: u64,
    /// When the last step ended.
    stepped_at: Instant,
}

impl<'a> Runner<'a> {
    fn new(scene: &'a Scene, outputs: Outputs, options: RunOptions) -> Self {
        let world = scene.world();
        let start = Instant::now();
        let (status, complaints) = (Status::new(start), Complaints::new(start));
        let (pace, end) = (Pace::new(options.rate, start), options.seconds);
        Self {
            scene,
            world,
            outputs,
            end,
            start,
            pace,
            ticks: 0,
            stall: None,
            retry_at: start,
            status,
            complaints,
            live: Live::new(scene, options.rate, start),
            dropped: 0,
            stepped_at: start,
        }
    }

    async fn run(mut self, mut inputs: Inputs, mut stop: Stop) -> Result<(), NodeError> {
        let mut status = tokio::time::interval(self.status.period());
        status.set_missed_tick_behavior(MissedTickBehavior::Delay);
        status.tick().await;
        tracing::info!("{}: {} pucks", self.scene.name, self.scene.pucks.len());
        while !self.is_over() {
            tokio::select! {
                biased;
                () = stop.asked() => break,
                _ = status.tick() => self.status.write(self.world.arena(), Instant::now()),
                Some(input) = inputs.0.next() => self.handle(input),
                () = wake_at(self.next_wake().min(self.live.due())) => {}
            }
            let now = Instant::now();
            self.tick_if_due(now);
            self.report_if_due(now);
        }
        self.complaints.settle();
        self.status.finish(self.world.arena(), Instant::now());
        match (self.stall, self.end) {
            (Some(stall), Some(_)) => Err(stall.into()),
            _ => Ok(()),
        }
    }

    fn is_over(&self) -> bool {
        let Some(end) = self.end else { return false };
        match self.world.arena() {
            Some(arena) => arena.now() >= end || self.stall.is_some(),
            None => self.start.elapsed().as_secs_f64() >= end,
        }
    }

    /// Simulated time of the next arena state, s.
    fn next_tick(&self) -> f64 {
        let tick = self.ticks as f64 / self.scene.node.publish_rate_hz;
        self.end.map_or(tick, |end| tick.min(end))
    }

    /// When the loop has something to do without a message.
    fn next_wake(&self) -> Instant {
        match self.world.arena() {
            Some(_) if self.stall.is_none() => self.pace.instant_of(self.next_tick()),
            Some(_) => Instant::now() + STALL_RETRY,
            None => {
                let end = self.end.unwrap_or(f64::INFINITY);
                let left = (end - self.start.elapsed().as_secs_f64()).clamp(0.0, 3_600.0);
                Instant::now() + Duration::from_secs_f64(left)
            }
        }
    }

    /// Advances the arena to its next tick when that is due, and publishes its state there.
    fn tick_if_due(&mut self, now: Instant) {
        let tick = self.next_tick();
        if self.world.arena().is_none() || self.pace.due(now) < tick || now < self.retry_at {
            return;
        }
        let outcome = self.step(&[], tick);
        self.arena_outcome(&outcome);
        let Some(arena) = self.world.arena() else { return };
        let reached = arena.now();
        if reached >= tick {
            self.outputs.arena_states(arena, &mut self.complaints);
            self.ticks += 1;
            self.stall = None;
        }
        self.pace.reached(reached, self.stepped_at);
    }

    /// Says how the last second went, if somebody listens.
    fn report_if_due(&mut self, now: Instant) {
        if now < self.live.due() {
            return;
        }
        let arena = self.world.arena();
        let totals = Totals {
            simulated: arena.map_or(0.0, Arena::now),
            contacts: self.status.contacts(arena),
            refused: self.complaints.refused(),
            dropped_in: self.dropped,
            dropped_out: self.complaints.unsent_count(),
        };
        let is_heard = self.outputs.reports_are_heard();
        let told = self.live.tell(is_heard, totals, (self.scene, &mut self.world), now);
        told.iter().for_each(|told| self.outputs.report(told, &mut self.complaints));
    }

    fn handle(&mut self, input: Input) {
        match input {
            Input::Circles { topic, received } => {
                if let Some(message) = self.read(&topic, received) {
                    self.observe(&topic, message);
                }
            }
            Input::Velocity { topic, id, received } => {
                let Some(twist) = self.read(&topic, received) else { return };
                match receive::velocity(&twist) {
                    Ok(velocity) => drop(self.command(Command::SetVelocity { id, velocity })),
                    Err(error) => self.complaints.refuse(&topic, Cause::from(&error), &error),
                }
            }
        }
    }

    /// The message, if it can be read.
    fn read<M>(&mut self, topic: &str, received: Received<M>) -> Option<M> {
        self.dropped += received.dropped;
        let refuse = |error| self.complaints.refuse(topic, Cause::Undecodable, &error);
        received.message.map_err(refuse).ok()
    }

    fn observe(&mut self, topic: &str, message: CircleStates) {
        let (report, bad) = match receive::report(&message) {
            Ok(read) => read,
            Err(error) => return self.complaints.refuse(topic, Cause::from(&error), &error),
        };
        for (id, reason) in bad {
            let what = format_args!("circle {id}: {reason}");
            self.complaints.refuse(topic, Cause::from(&reason), &what);
        }
        for answer in self.command(Command::Observe(report)).answers {
            for (id, reason) in &answer.refused {
                let what = format_args!("circle {id}: {reason}");
                self.complaints.refuse(topic, Cause::from(reason), &what);
            }
            if let Some(error) = &answer.unresolved {
                self.complaints.refuse(topic, Cause::from(error), error);
            }
            self.answer(&message.header, &answer);
        }
    }

    fn answer(&mut self, header: &Header, answer: &Answer) {
        self.status.count_message(answer.contacts.len());
        if answer.contacts.is_empty() {
            return;
        }
        self.outputs.answer(header, answer, &mut self.complaints);
    }

    /// Brings the arena to the present and gives it the command there.
    fn command(&mut self, command: Command) -> Outcome {
        let present = self.pace.due(Instant::now()).min(self.next_tick());
        if self.world.arena().is_some() {
            let before = self.step(&[], present);
            self.arena_outcome(&before);
        }
        let outcome = self.step(&[command], present);
        self.arena_outcome(&outcome);
        outcome
    }

    fn step(&mut self, commands: &[Command], advance_to: f64) -> Outcome {
        let begin = Instant::now();
        let heard_at = (begin - self.start).as_secs_f64();
        let outcome = self.world.step(commands, Instants { heard_at, advance_to });
        self.stepped_at = Instant::now();
        self.live.note(begin, self.stepped_at);
        if let Some(stall) = outcome.stall {
            if self.stall.is_none() {
                self.complaints.say("arena_states", &stall);
            }
            // It ends when discs are moved, or leave: that is tried now and then.
            self.stall = Some(stall);
            self.retry_at = Instant::now() + STALL_RETRY;
        }
        outcome
    }

    fn arena_outcome(&mut self, outcome: &Outcome) {
        if let Some(arena) = self.world.arena() {
            self.outputs.arena_outcome(arena, outcome, &mut self.complaints);
        }
    }
}
