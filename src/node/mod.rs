//! The node: topics in, topics out, and the loop between them. The only room that names a ROS
//! crate, reads the clock or waits.
//!
//! | file | holds |
//! |---|---|
//! | `arguments`, `names`, `start` | what command line and environment say; names in the graph |
//! | `dds`, `peers`, `service`, `prompt`, `farewell`, `stopped` | the door to ROS 2 |
//! | `inputs` | all that arrives, as one stream |
//! | `runner` | the loop: it steps the stage, at once for a message and at every tick |
//! | [`wire`] | teams' own software, on their leagues' protocols |
//! | `soccer` | what trackers of robot soccer see, in and out |
//! | `robots` | robots that tell their own odometry, as circles |
//! | `stage`, `timeline`, `pace` | the world with its pucks by name, and which time it is there |
//! | `parameters`, `simulation` | the standard services |
//! | `outputs`, `parts` | all that leaves, to whoever listens |
//! | [`mod@record`], [`replay`], `raw` | other nodes' topics into a bag, and out of it |
//! | [`recorder`] | what is said and heard, into a bag, by a thread of its own |
//! | `live`, `status`, `complaints` | how it goes: a report, a line, a log |
//!
//! Subscriptions only hand messages over; results leave as arrays.

pub mod arguments;
mod complaints;
mod dds;
mod farewell;
mod inputs;
mod live;
mod names;
mod outputs;
mod pace;
mod parameters;
mod parts;
mod peers;
mod prompt;
mod raw;
pub mod record;
pub mod recorder;
pub mod replay;
mod robots;
mod rosout;
mod runner;
mod service;
mod simulation;
mod soccer;
mod stage;
mod start;
mod status;
#[cfg(target_os = "linux")]
mod stopped;
mod timeline;
pub mod wire;

use std::collections::BTreeMap;
use std::io::Write;
use std::path::PathBuf;

use ros2_client::ParameterValue;
use tokio::signal::unix::{Signal, SignalKind, signal};
use tracing_subscriber::EnvFilter;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

use crate::bag::journal;
use crate::bag::write::{Options, WriteError};
use crate::motion::arena::Halt;
use crate::scene::Scene;
use dds::{DdsError, Reach, Ros};
use inputs::Inputs;
use outputs::Outputs;
use parameters::{Parameters, declared};
use recorder::Recorder;
use rosout::{Lines, Rosout};
use runner::Runner;
pub use start::Start;
use wire::{Ports, Wire, WireOptions};

/// How to run.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// The scene, as it was asked for.
    pub scene: String,
    /// Name and parameters.
    pub start: Start,
    /// Ends after so many seconds of simulated time, of wall time without pucks.
    pub seconds: Option<f64>,
    /// Simulated seconds in a second of wall time; 0 = as fast as possible.
    pub rate: f64,
    /// A folder to record into.
    pub record: Option<PathBuf>,
    /// How teams are spoken to, if they are.
    pub wire: Option<WireOptions>,
}

/// Why the node could not run, or ended early.
#[derive(Debug, thiserror::Error)]
pub enum NodeError {
    /// The command line or the environment asks for something that cannot be.
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
    /// A port of the wire cannot be opened.
    #[error("wire: {0}")]
    Wire(String),
    /// The bag cannot be written.
    #[error("record: {0}")]
    Bag(#[from] WriteError),
}

impl NodeError {
    /// Whether the caller asked for something that cannot be: exit code 2.
    pub fn is_bad_use(&self) -> bool {
        matches!(
            self,
            Self::BadUse(_)
                | Self::Bag(WriteError::Exists(_) | WriteError::Folder { .. })
                | Self::Dds(
                    DdsError::Environment { .. } | DdsError::DomainId(_) | DdsError::Name(_)
                )
        )
    }
}

/// Runs a scene until the time is over or SIGINT or SIGTERM comes.
///
/// # Errors
/// [`NodeError`] when it cannot start, or when the arena stalls before the time is over.
pub fn run(scene: &Scene, options: &RunOptions) -> Result<(), NodeError> {
    let lines = start_log(options.start.log_level);
    end_by_panic();
    let mut scene = scene.clone();
    let parameters = parameters(&mut scene, options).map_err(NodeError::BadUse)?;
    let (domain_id, reach) = (start::domain_id()?, Reach::from_environment(start::environment)?);
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    // Before anybody can see the node: from its first sign of life it ends cleanly.
    let stop = runtime.block_on(async { Stop::new() })?;
    let ports = options.wire.as_ref().map(Ports::open).transpose().map_err(NodeError::Wire)?;
    let mut ros = Ros::open(options.start.names.clone(), domain_id, reach)?;
    let recorder = record(&mut ros, &scene, &parameters, options)?;
    let outcome = runtime.block_on(async {
        let inputs = Inputs::open(&mut ros, &scene)?;
        let outputs = Outputs::open(&mut ros, &scene)?;
        let rosout = Rosout::open(&mut ros, lines, &options.start.names.to_string())?;
        let wire = ports.map(Wire::new).transpose()?;
        let topics = (inputs, outputs, rosout);
        let runner = Runner::new(scene, parameters, topics, &mut ros, options)?;
        runner.record(recorder.clone()).speak(wire).run(stop).await
    });
    ros.close();
    if let Some(recorder) = recorder {
        let (written, dropped) = (recorder.close()?, recorder.dropped());
        let recorder::Summary { messages, files } = written;
        tracing::info!("recorded {messages} messages, {dropped} dropped, in {files} files");
    }
    outcome
}

/// Begins the bag that was asked for, with all that the run begins with.
fn record(
    ros: &mut Ros,
    scene: &Scene,
    parameters: &Parameters,
    options: &RunOptions,
) -> Result<Option<Recorder>, NodeError> {
    let Some(folder) = &options.record else { return Ok(None) };
    let values: BTreeMap<String, String> =
        parameters.all().map(|(name, value)| (name, text(value))).collect();
    let mut said = journal::note(scene, &values);
    for (key, topic) in [
        ("topic.journal", journal::TOPIC),
        ("topic.arena_states", "arena_states"),
        ("topic.contacts", "contacts"),
        ("topic.corrected_velocities", "corrected_velocities"),
    ] {
        said.insert(key.to_owned(), ros.topic_name(topic)?);
    }
    let journal = said["topic.journal"].clone();
    let notes = vec![(journal::NOTE.to_owned(), said)];
    let recorder = Recorder::open(folder, Options::default(), notes)?;
    recorder.keep_journal(&journal);
    ros.record(recorder.clone());
    Ok(Some(recorder))
}

/// A value as it is noted: a number so that the same bits are read back.
fn text(value: ParameterValue) -> String {
    match value {
        ParameterValue::Double(number) => number.to_string(),
        ParameterValue::Integer(number) => number.to_string(),
        ParameterValue::Boolean(flag) => flag.to_string(),
        ParameterValue::String(text) => text,
        ParameterValue::StringArray(texts) => texts.join(","),
        ParameterValue::DoubleArray(numbers) => {
            let texts: Vec<String> = numbers.iter().map(f64::to_string).collect();
            texts.join(",")
        }
        other => format!("{other:?}"),
    }
}

/// The parameters, whose values the scene then has.
fn parameters(scene: &mut Scene, options: &RunOptions) -> Result<Parameters, String> {
    let RunOptions { scene: name, start, rate, seconds, record, .. } = options;
    let values = start.values();
    let mut all = declared::declare(scene, name, *rate, *seconds);
    let record = record.as_ref().map(|folder| folder.display().to_string());
    all.push(declared::of_the_bag(record.unwrap_or_default()));
    all.extend(declared::of_robots(&values));
    all.extend(soccer::parameters(&scene.pucks));
    let parameters = Parameters::new(all, &start.names.to_string(), &values)?;
    declared::apply(&parameters, scene)?;
    Ok(parameters)
}

/// Warnings of the DDS library are many and harmless: RUST_LOG shows them.
fn start_log(level: Option<&str>) -> Lines {
    let usual = || {
        let level = level.unwrap_or("info");
        format!("{level},rustdds=off,ros2_client=off,cdr_encoding=off").into()
    };
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| usual());
    let errors = tracing_subscriber::fmt::layer()
        .with_writer(std::io::stderr)
        .with_target(false)
        // A log that nobody reads any more is no reason to stop.
        .log_internal_errors(false);
    let (tap, lines) = rosout::tap();
    // A second start in one process keeps the first log.
    let _ = tracing_subscriber::registry().with(filter).with(errors).with(tap).try_init();
    lines
}

/// A thread of DDS that fails would leave the node deaf and silent: it ends instead, and says why.
fn end_by_panic() {
    std::panic::set_hook(Box::new(|panic| {
        let thread = std::thread::current();
        let name = thread.name().unwrap_or("a thread");
        let panic = panic.to_string().replace('\n', " ");
        // Nobody may be reading.
        let _ = writeln!(std::io::stderr(), "carom: {name} has failed: {panic}");
        std::process::exit(1);
    }));
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
