//! The commands about bags: reads what is wanted, calls the room that does it, says in one line how
//! it went.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use super::{RosArguments, RunArguments, at_least_0, complain, hertz, seconds};

/// What `carom run` does with a bag instead of running a node.
#[derive(Args)]
pub struct FromArguments {
    /// Answer the circle states of a bag instead, as fast as possible, without a node; SCENE has
    /// the laws [default: resolver].
    #[arg(long, value_name = "BAG", conflicts_with_all = ["seconds", "rate", "record"])]
    pub from: Option<PathBuf>,
    /// The folder for the bag of answers [default: the bag's name and `-answers`].
    #[arg(long, short, value_name = "DIR", requires = "from")]
    pub out: Option<PathBuf>,
    /// Repeat the run that carom recorded in the bag, and say whether the bits agree.
    #[arg(long, requires = "from", conflicts_with_all = ["out", "scene", "method", "step"])]
    #[arg(conflicts_with_all = ["error", "budget", "keep_all"])]
    pub verify: bool,
}

/// What `carom record` is told.
#[derive(Args)]
#[command(allow_negative_numbers = true)]
pub struct RecordArguments {
    /// The topics to record; as others name them, or relative to the namespace.
    #[arg(value_name = "TOPICS", required_unless_present = "all")]
    pub topics: Vec<String>,
    /// Record every topic whose type is known.
    #[arg(long, conflicts_with = "topics")]
    pub all: bool,
    /// The folder for the bag; it must not be there yet.
    #[arg(long, short, value_name = "DIR", default_value = "carom-bag")]
    pub out: PathBuf,
    /// How chunks are packed.
    #[arg(long, value_name = "HOW", default_value = "none", value_parser = ["none", "zstd"])]
    pub compression: String,
    /// A new file after so many bytes.
    #[arg(long, value_name = "BYTES", value_parser = clap::value_parser!(u64).range(1..))]
    pub split_size: Option<u64>,
    /// A new file after so many seconds.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub split_duration: Option<f64>,
    /// End after so many seconds.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub max_duration: Option<f64>,
}

/// What `carom replay` is told.
#[derive(Args)]
#[command(allow_negative_numbers = true)]
pub struct ReplayArguments {
    /// The bag: a folder, or a file of one.
    #[arg(value_name = "BAG")]
    pub bag: PathBuf,
    /// Recorded seconds in a second; 0 = as fast as possible.
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = at_least_0)]
    pub rate: f64,
    /// Publish the recorded time on /clock, so often in a second.
    #[arg(long, value_name = "HZ", num_args = 0..=1, default_missing_value = "40")]
    #[arg(value_parser = hertz)]
    pub clock: Option<f64>,
    /// Only these topics.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub topics: Vec<String>,
    /// From the beginning again at the end, until it is stopped.
    #[arg(long = "loop")]
    pub again: bool,
    /// Wait so long for subscribers before the first message.
    #[arg(long, value_name = "SECONDS", default_value = "1", value_parser = at_least_0)]
    pub delay: f64,
}

/// `carom run --from`
#[cfg(feature = "bags")]
pub fn from_bag(arguments: RunArguments, is_node: bool) -> ExitCode {
    if is_node {
        return complain(&"--ros-args are for a node, and --from runs none", 2);
    }
    let RunArguments {
        scene,
        method,
        step,
        keep_all,
        bag: FromArguments { from, out, verify },
        ..
    } = arguments;
    let path = from.unwrap_or_default();
    let bag = match carom::bag::read::Bag::open(&path) {
        Ok(bag) => bag,
        Err(error) => return complain(&error, 2),
    };
    if verify {
        return verified(&bag);
    }
    let scene = scene.as_deref().unwrap_or("resolver");
    let loaded = super::load(scene, method.as_deref(), step, keep_all)
        .and_then(|loaded| super::check_step(&loaded, step).map(|()| loaded));
    match loaded {
        Ok(scene) => answered(&bag, &scene, out),
        Err(message) => complain(&message, 2),
    }
}

#[cfg(feature = "bags")]
fn verified(bag: &carom::bag::read::Bag) -> ExitCode {
    match carom::bag::verify::verify(bag) {
        Ok(verdict) => super::say(&verdict, u8::from(!verdict.is_sound())),
        Err(message) => complain(&format!("{}: {message}", bag.path().display()), 2),
    }
}

#[cfg(feature = "bags")]
fn answered(
    bag: &carom::bag::read::Bag,
    scene: &carom::scene::Scene,
    out: Option<PathBuf>,
) -> ExitCode {
    use carom::bag::offline::{self, Answered, OfflineError};
    use carom::bag::write::WriteError;
    let beside = || {
        let name = bag.path().file_stem()?.to_string_lossy();
        Some(PathBuf::from(format!("{name}-answers")))
    };
    let Some(out) = out.or_else(beside) else {
        // From within the bag the answers would go into it.
        return complain(&"the bag has no name to go by: name a folder for the answers, -o DIR", 2);
    };
    bag.faults().iter().for_each(|fault| super::tell(fault));
    match offline::answer(bag, scene, &out) {
        Ok(Answered { messages, answers, contacts, refused, told, .. }) => {
            told.iter().for_each(|told| super::tell(told));
            super::say(
                &format_args!(
                    "{messages} messages, {answers} of them with {contacts} contacts, {refused} \
                 refusals: {}",
                    out.display()
                ),
                0,
            )
        }
        Err(error @ OfflineError::Write(WriteError::Output { .. })) => complain(&error, 1),
        Err(error) => complain(&error, 2),
    }
}

/// `carom run --from`
#[cfg(not(feature = "bags"))]
pub fn from_bag(_arguments: RunArguments, _is_node: bool) -> ExitCode {
    complain(&"this build reads no bags: build it with the feature `bags`", 2)
}

/// `carom record`
#[cfg(feature = "ros")]
pub fn record(arguments: RecordArguments, ros: RosArguments) -> ExitCode {
    use carom::bag::write::Options;
    use carom::node::record::{RecordOptions, record};
    let ns = |seconds: f64| (seconds * 1e9) as u64;
    let RecordArguments { topics, all, out: folder, compression, .. } = arguments;
    let RecordArguments { split_size, split_duration, max_duration, .. } = arguments;
    let options = Options {
        packed: compression == "zstd",
        split_bytes: split_size,
        split_ns: split_duration.map(ns),
    };
    let options = RecordOptions { topics, all, folder, options, seconds: max_duration };
    done(record(ros, &options))
}

/// `carom replay`
#[cfg(feature = "ros")]
pub fn replay(arguments: ReplayArguments, ros: RosArguments) -> ExitCode {
    use carom::node::replay::{ReplayOptions, replay};
    let ReplayArguments { bag, rate, clock, topics, again, delay } = arguments;
    let bag = match carom::bag::read::Bag::open(&bag) {
        Ok(bag) => bag,
        Err(error) => return complain(&error, 2),
    };
    done(replay(ros, &ReplayOptions { bag, rate, clock_hz: clock, topics, again, delay }))
}

#[cfg(feature = "ros")]
fn done(outcome: Result<String, carom::node::NodeError>) -> ExitCode {
    match outcome {
        Ok(line) => super::say(&line, 0),
        Err(error) => complain(&error, if error.is_bad_use() { 2 } else { 1 }),
    }
}

/// `carom record`
#[cfg(not(feature = "ros"))]
pub fn record(_arguments: RecordArguments, _ros: RosArguments) -> ExitCode {
    complain(&"this build has no ROS 2 node: build it with the feature `ros`", 2)
}

/// `carom replay`
#[cfg(not(feature = "ros"))]
pub fn replay(_arguments: ReplayArguments, _ros: RosArguments) -> ExitCode {
    complain(&"this build has no ROS 2 node: build it with the feature `ros`", 2)
}
