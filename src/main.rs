//! The command line: reads what is wanted, calls the room that does it, says what went wrong in
//! one line. Exit code 0 = done, 1 = it failed, 2 = bad use.

mod bag_commands;
#[cfg(feature = "ros")]
mod wire_arguments;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

#[cfg(feature = "ros")]
use carom::bench::budget::Budget;
use carom::bench::gas::Gas;
use carom::bench::{self, BenchError};
use carom::check::{self, CheckError, Options};
#[cfg(feature = "ros")]
use carom::node::arguments::{RosArguments, split};
use carom::plan::Method;
use carom::plan::budget::{self, Wish};
use carom::plan::parts::Parts;
use carom::scene::lattice::Lattice;
use carom::scene::{Scene, shipped};
use clap::error::ErrorKind;
use clap::{Args, Parser, Subcommand};

/// Collisions between circles in the plane, as a ROS 2 node: exact, fast, honest.
#[derive(Parser)]
#[command(version, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    run: RunArguments,
}

#[derive(Subcommand)]
enum Command {
    /// Run the node: answer circle states, advance the arena (the default command).
    Run(RunArguments),
    /// Run the reference cases and say by how much they pass; exit code 1 if one fails.
    Check(CheckArguments),
    /// Say what a scene needs, what is left out, and what that saves.
    Explain(ExplainArguments),
    /// Measure error against run time of every method: CSV, plots, one HTML page.
    Report(ReportArguments),
    /// Judge the collisions of any simulator from its recording; exit code 1 if one is not lawful.
    Audit(AuditArguments),
    /// Measure one run, and check its physics before telling the time.
    #[command(subcommand)]
    Bench(BenchCommand),
    /// Record topics of other nodes into a bag.
    Record(bag_commands::RecordArguments),
    /// Play the topics of a bag.
    Replay(bag_commands::ReplayArguments),
}

#[derive(Subcommand)]
enum BenchCommand {
    /// A gas of discs that melts from a lattice.
    Gas(GasArguments),
    /// Box2D and Rapier beside carom's own methods (only in a build with the feature `peers`).
    Peers(PeersArguments),
}

#[derive(Args)]
#[command(allow_negative_numbers = true)]
struct GasArguments {
    /// How many discs.
    #[arg(long, value_name = "N", default_value = "1000")]
    #[arg(value_parser = clap::value_parser!(u32).range(4..=10_000_000))]
    discs: u32,
    /// Share of the area that they cover.
    #[arg(long, value_name = "PHI", default_value = "0.5", value_parser = fraction)]
    area_fraction: f64,
    /// What lies around them.
    #[arg(long, value_name = "B", default_value = "periodic")]
    #[arg(value_parser = ["periodic", "walls"])]
    boundary: String,
    /// How they move.
    #[arg(long, value_name = "M", default_value = "auto")]
    #[arg(value_parser = METHODS)]
    method: String,
    /// Length of a step of the methods steps and springs, s.
    #[arg(long, value_name = "S", default_value = "0.004166666666666667")]
    #[arg(value_parser = to_one_second)]
    step: f64,
    /// Collisions to be timed.
    #[arg(long, value_name = "K", default_value = "1000000")]
    #[arg(value_parser = clap::value_parser!(u64).range(1..=1_000_000_000_000))]
    collisions: u64,
    /// Seed of velocities and masses.
    #[arg(long, value_name = "S", default_value = "1")]
    seed: u64,
    /// Collisions of a disc before anything is measured.
    #[arg(long, value_name = "K", default_value = "30", value_parser = to_a_million)]
    melt: f64,
    /// Radii: every second disc larger than the others, or as much covered by every octave.
    #[arg(long, value_name = "W", default_value = "two")]
    #[arg(value_parser = ["two", "spread"])]
    sizes: String,
    /// The larger radius over the smaller.
    #[arg(long, value_name = "R", default_value = "1", value_parser = at_least_1)]
    size_ratio: f64,
    /// Masses are drawn from 1 kg to this.
    #[arg(long, value_name = "KG", default_value = "1", value_parser = at_least_1)]
    mass_max: f64,
    /// Restitution of pairs and walls.
    #[arg(long, value_name = "E", default_value = "1", value_parser = at_most_1)]
    restitution: f64,
    /// Without the vector units of the processor (method events).
    #[arg(long)]
    portable: bool,
    /// Build every part though nothing needs it: the same bits, more slowly.
    #[arg(long)]
    keep_all: bool,
    /// One JSON object instead of words.
    #[arg(long)]
    json: bool,
}

#[derive(Args)]
#[command(allow_negative_numbers = true)]
struct PeersArguments {
    /// How many discs.
    #[arg(long, value_name = "N", default_value = "1000")]
    #[arg(value_parser = clap::value_parser!(u32).range(4..=1_000_000))]
    discs: u32,
    /// Share of the area that they cover.
    #[arg(long, value_name = "PHI", default_value = "0.3", value_parser = fraction)]
    area_fraction: f64,
    /// Simulated time of a run; its first tenth is not timed.
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = seconds)]
    seconds: f64,
    /// Seed of the velocities.
    #[arg(long, value_name = "S", default_value = "1")]
    seed: u64,
    /// Lengths of the step in seconds, such as 1/60 or 0.001.
    #[arg(long, value_name = "LIST", default_value = "1/60,1/240,1/1000")]
    #[arg(value_delimiter = ',', value_parser = step)]
    dt: Vec<f64>,
    /// One JSON object instead of the tables.
    #[arg(long)]
    json: bool,
}

#[derive(Args)]
struct CheckArguments {
    /// The folder of the cases (*.json), or one case file [default: tests/cases].
    #[arg(long, value_name = "DIR")]
    cases: Option<PathBuf>,
    /// Only the cases whose file name, without .json, fits this pattern (* and ? as usual).
    #[arg(long, value_name = "GLOB")]
    only: Option<String>,
    /// One JSON document with every sub-case instead of the table.
    #[arg(long)]
    json: bool,
    /// Shorter statistics and no long runs: under a minute.
    #[arg(long)]
    quick: bool,
}

#[derive(Args)]
struct ExplainArguments {
    /// A scene file, or the name of a shipped scene.
    #[arg(value_name = "SCENE", default_value = shipped::DEFAULT)]
    scene: String,
    /// How pucks move, instead of what the scene says.
    #[arg(long, value_name = "M", value_parser = METHODS)]
    method: Option<String>,
    /// Build every part though nothing needs it.
    #[arg(long)]
    keep_all: bool,
    /// Largest error of a contact of two pucks, over their relative speed: the method is chosen by
    /// it.
    #[arg(long, value_name = "E", value_parser = budget::parse_error)]
    #[arg(allow_negative_numbers = true, conflicts_with = "quick")]
    error: Option<f64>,
    /// Longest run time of a publish period, such as 2ms: the method is chosen by it.
    #[arg(long, value_name = "TIME", value_parser = budget::parse_budget)]
    #[arg(allow_negative_numbers = true, conflicts_with = "quick")]
    budget: Option<f64>,
    /// Measure nothing.
    #[arg(long)]
    quick: bool,
    /// One JSON object instead of the table.
    #[arg(long)]
    json: bool,
}

#[derive(Args)]
struct ReportArguments {
    /// The folder for the files; it is made if there is none.
    #[arg(long, value_name = "DIR", default_value = "carom-report")]
    out: PathBuf,
    /// A minute instead of 22: fewer repeats, smaller scenes.
    #[arg(long)]
    quick: bool,
    /// Only these figures, such as gas,cases; the page has nothing else then.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    only: Vec<String>,
}

#[derive(Args)]
#[command(allow_negative_numbers = true)]
#[cfg_attr(
    not(all(feature = "bags", feature = "report")),
    allow(dead_code, reason = "this build only says that it has no audit")
)]
struct AuditArguments {
    /// A recording of ROS 2: a folder, an .mcap or a .db3 file.
    #[arg(value_name = "BAG")]
    bag: PathBuf,
    /// The topic of carom/msg/CircleStates, if there are several.
    #[arg(long, value_name = "TOPIC", conflicts_with = "robot")]
    topic: Option<String>,
    /// A robot whose nav_msgs/Odometry is recorded on NAME/odom; once for each.
    #[arg(long, value_name = "NAME=RADIUS,MASS")]
    robot: Vec<String>,
    /// Restitution of pairs [default: of the scene in the bag, or estimated].
    #[arg(long, value_name = "E", value_parser = at_most_1)]
    restitution: Option<f64>,
    /// The box around, in m [default: of the scene in the bag, or where discs turn round].
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = numbers::<4>)]
    #[arg(allow_hyphen_values = true)]
    walls: Option<[f64; 4]>,
    /// Restitution of the walls [default: that of pairs].
    #[arg(long, value_name = "E", value_parser = at_most_1, requires = "walls")]
    wall_restitution: Option<f64>,
    /// There are no walls: a change of velocity without a partner is none of theirs.
    #[arg(long, conflicts_with = "walls")]
    no_walls: bool,
    /// The same acceleration of all discs, m/s^2 [default: estimated].
    #[arg(long, value_name = "X,Y", value_parser = numbers::<2>, conflicts_with = "drag")]
    #[arg(allow_hyphen_values = true)]
    gravity: Option<[f64; 2]>,
    /// The same linear drag of all discs, 1/s [default: estimated].
    #[arg(long, value_name = "C", value_parser = at_least_0)]
    drag: Option<f64>,
    /// Acceleration that drives may add at any time, m/s^2 [default: of the bag's scene, or 0].
    #[arg(long, value_name = "A", value_parser = at_least_0)]
    acceleration: Option<f64>,
    /// Deviation of positions, m [default: measured].
    #[arg(long, value_name = "M", value_parser = at_least_0)]
    position_noise: Option<f64>,
    /// Deviation of velocities, m/s [default: measured].
    #[arg(long, value_name = "MPS", value_parser = at_least_0)]
    velocity_noise: Option<f64>,
    /// What is no violation though it can be seen: part of the momentum exchanged, of the
    /// restitution, of the smaller radius; of angles in rad.
    #[arg(long, value_name = "PART", default_value = "0.001", value_parser = at_least_0)]
    tolerance: f64,
    /// List collisions faster than this along the line of centres, m/s.
    #[arg(long, value_name = "MPS", value_parser = at_least_0)]
    crash_speed: Option<f64>,
    /// A folder for the page, the plots and the data.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// One JSON object instead of words.
    #[arg(long)]
    json: bool,
}

#[derive(Args)]
struct RunArguments {
    /// A scene file, or the name of a shipped scene: arena, break_shot, newtons_cradle, head_on,
    /// thousand, teams, ssl-a, ssl-b, vsss-3v3, vsss-5v5, league-2d, resolver [default: arena].
    #[arg(value_name = "SCENE")]
    scene: Option<String>,
    /// End after so many seconds of simulated time (of wall time without pucks).
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    #[arg(allow_negative_numbers = true)]
    seconds: Option<f64>,
    /// Simulated seconds in a second of wall time; 0 = as fast as possible [default: 1].
    #[arg(long, value_name = "FACTOR", value_parser = at_least_0)]
    #[arg(allow_negative_numbers = true)]
    rate: Option<f64>,
    /// How pucks move, instead of what the scene says.
    #[arg(long, value_name = "M", value_parser = METHODS)]
    method: Option<String>,
    /// Length of a step of the methods steps and springs, s.
    #[arg(long, value_name = "S", value_parser = seconds)]
    #[arg(allow_negative_numbers = true)]
    step: Option<f64>,
    /// Largest error of a contact of two pucks, over their relative speed: the method is chosen by
    /// it.
    #[arg(long, value_name = "E", value_parser = budget::parse_error)]
    #[arg(allow_negative_numbers = true, conflicts_with = "step")]
    error: Option<f64>,
    /// Longest run time of a publish period, such as 2ms: the method is chosen by it.
    #[arg(long, value_name = "TIME", value_parser = budget::parse_budget)]
    #[arg(allow_negative_numbers = true, conflicts_with = "step")]
    budget: Option<f64>,
    /// Build every part though nothing needs it: the same bits, more slowly.
    #[arg(long)]
    keep_all: bool,
    /// Record what the node says and hears into a bag, a folder that is not there yet.
    #[arg(long, value_name = "DIR")]
    record: Option<PathBuf>,
    #[command(flatten)]
    bag: bag_commands::FromArguments,
    #[cfg(feature = "ros")]
    #[command(flatten)]
    wire: wire_arguments::WireArguments,
}

const METHODS: [&str; 6] = ["auto", "events", "plain", "ticks", "steps", "springs"];

fn main() -> ExitCode {
    let words = std::env::args_os().map(std::ffi::OsString::into_string).collect();
    let words = match words {
        Ok(words) => words,
        Err(word) => return complain(&format!("{} is not UTF-8", word.display()), 2),
    };
    let (words, ros) = match split(words) {
        Ok(split) => split,
        Err(message) => return complain(&message, 2),
    };
    let cli = match Cli::try_parse_from(words) {
        Ok(cli) => cli,
        Err(error) => return refuse(&error),
    };
    match (cli.command.unwrap_or(Command::Run(cli.run)), ros) {
        (Command::Run(arguments), ros) if arguments.bag.from.is_some() => {
            bag_commands::from_bag(arguments, ros.is_some())
        }
        (Command::Run(arguments), ros) => run(arguments, ros.unwrap_or_default()),
        (Command::Record(arguments), ros) => {
            bag_commands::record(arguments, ros.unwrap_or_default())
        }
        (Command::Replay(arguments), ros) => {
            bag_commands::replay(arguments, ros.unwrap_or_default())
        }
        (_, Some(_)) => complain(&"--ros-args are for nodes: carom run, record, replay", 2),
        (Command::Check(arguments), None) => check(arguments),
        (Command::Explain(arguments), None) => explain(&arguments),
        (Command::Report(arguments), None) => report(arguments),
        (Command::Audit(arguments), None) => audit(arguments),
        (Command::Bench(BenchCommand::Gas(arguments)), None) => bench_gas(&arguments),
        (Command::Bench(BenchCommand::Peers(arguments)), None) => bench_peers(arguments),
    }
}

/// Chooses the method by error and run time, if that is asked for, and says how.
#[cfg(feature = "ros")]
fn keep_to_budget(scene: &mut Scene, wish: Wish) {
    if !wish.is_none() {
        scene.node.wish = wish;
    }
    if let Some(budget) = Budget::of(scene, scene.node.wish) {
        budget.apply(scene);
        tell(&budget.verdict());
    }
}

fn explain(arguments: &ExplainArguments) -> ExitCode {
    let ExplainArguments { scene, method, error, budget, keep_all, quick, json } = arguments;
    let wish = Wish { error: *error, budget: *budget };
    let options = bench::explain::Options { quick: *quick, json: *json, wish };
    match load(scene, method.as_deref(), None, *keep_all) {
        Ok(scene) => {
            measured(bench::explain::explain(&scene, options, &mut std::io::stdout().lock()))
        }
        Err(message) => complain(&message, 2),
    }
}

/// The scene that was asked for, with what the command line says otherwise.
fn load(
    name: &str,
    method: Option<&str>,
    step: Option<f64>,
    keep_all: bool,
) -> Result<Scene, String> {
    let mut scene = Scene::load(name).map_err(|error| error.to_string())?;
    scene.settings.keep = if keep_all { Parts::ALL } else { Parts::NONE };
    scene.choose(method.map(named), step).map_err(|message| format!("{name}: {message}"))?;
    Ok(scene)
}

/// Whether a step that was asked for on the command line is one that the method takes.
#[cfg(feature = "bags")]
fn check_step(scene: &Scene, step: Option<f64>) -> Result<(), String> {
    let method = scene.method();
    if step.is_none() || matches!(method, Method::Steps | Method::Springs) {
        return Ok(());
    }
    Err(format!("--step: method {method} has no step; leave it out, or say --method steps"))
}

/// The method of a name that was checked; `None` = the plan chooses.
fn named(name: &str) -> Option<Method> {
    Method::named(name).ok().flatten()
}

fn check(arguments: CheckArguments) -> ExitCode {
    let CheckArguments { cases, only, json, quick } = arguments;
    match check::check(&Options { cases, only, quick, json }, &mut std::io::stdout().lock()) {
        Ok(summary) => ExitCode::from(u8::from(summary.failed > 0)),
        Err(error @ CheckError::BadUse(_)) => complain(&error, 2),
        Err(error) => complain(&error, 1),
    }
}

#[cfg(feature = "report")]
fn report(arguments: ReportArguments) -> ExitCode {
    use carom::report::{self, Effort, ReportError};
    let ReportArguments { out, quick, only } = arguments;
    let effort = if quick { Effort::Quick } else { Effort::Full };
    let options = report::Options { folder: out, effort, only };
    match report::report(&options, &mut std::io::stdout().lock()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error @ ReportError::BadUse(_)) => complain(&error, 2),
        Err(error) => complain(&error, 1),
    }
}

#[cfg(not(feature = "report"))]
fn report(_arguments: ReportArguments) -> ExitCode {
    complain(&"this build has no report in it: build it with the feature `report`", 2)
}

#[cfg(all(feature = "bags", feature = "report"))]
fn audit(arguments: AuditArguments) -> ExitCode {
    use carom::audit::command::{self, Wanted};
    use carom::audit::recorded::Robot;
    use carom::audit::{Bounds, Options};
    let robots = arguments.robot.iter().map(|text| Robot::parse(text)).collect();
    let robots = match robots {
        Ok(robots) => robots,
        Err(error) => return complain(&format!("--robot {error}"), 2),
    };
    let bounds = |[x0, y0, x1, y1]: [f64; 4]| Bounds {
        min: [x0.min(x1), y0.min(y1)].into(),
        max: [x0.max(x1), y0.max(y1)].into(),
        restitution: arguments.wall_restitution,
    };
    let options = Options {
        restitution: arguments.restitution,
        walls: arguments.walls.map(bounds),
        no_walls: arguments.no_walls,
        gravity: arguments.gravity.map(Into::into),
        drag: arguments.drag,
        position_noise: arguments.position_noise,
        velocity_noise: arguments.velocity_noise,
        acceleration_max: arguments.acceleration,
        tolerance: arguments.tolerance,
        crash_speed: arguments.crash_speed,
        ..Options::default()
    };
    let AuditArguments { bag, topic, out: folder, json, .. } = arguments;
    let wanted = Wanted { bag, topic, robots, options, folder, json };
    match command::audit(&wanted, &mut std::io::stdout().lock()) {
        Ok(violations) => ExitCode::from(u8::from(violations > 0)),
        // 1 is for violations alone.
        Err(error) => complain(&error, 2),
    }
}

#[cfg(not(all(feature = "bags", feature = "report")))]
fn audit(_arguments: AuditArguments) -> ExitCode {
    complain(&"this build has no audit in it: build it with the features `bags` and `report`", 2)
}

fn bench_gas(arguments: &GasArguments) -> ExitCode {
    let lattice = Lattice {
        count: arguments.discs as usize,
        area_fraction: arguments.area_fraction,
        size_ratio: arguments.size_ratio,
        mass_max: arguments.mass_max,
        walled: arguments.boundary == "walls",
        seed: arguments.seed,
    };
    let GasArguments { restitution, melt, step, collisions, portable, json, .. } = *arguments;
    let spread = arguments.sizes == "spread";
    let gas = Gas { lattice, spread, restitution, melt, step };
    let (method, keep_all) = (named(&arguments.method), arguments.keep_all);
    let options = bench::Options { gas, method, keep_all, collisions, portable, json };
    measured(bench::bench(&options, &mut std::io::stdout().lock()))
}

#[cfg(feature = "peers")]
fn bench_peers(arguments: PeersArguments) -> ExitCode {
    use carom::bench::peers;
    let options = peers::Options {
        discs: arguments.discs as usize,
        area_fraction: arguments.area_fraction,
        seconds: arguments.seconds,
        seed: arguments.seed,
        steps: arguments.dt,
        json: arguments.json,
    };
    measured(peers::bench(&options, &mut std::io::stdout().lock()))
}

#[cfg(not(feature = "peers"))]
fn bench_peers(_arguments: PeersArguments) -> ExitCode {
    let how = "cargo run --release --no-default-features --features peers -- bench peers";
    complain(&format!("this build has no other engines in it: {how}"), 2)
}

fn measured(outcome: Result<(), BenchError>) -> ExitCode {
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error @ BenchError::BadUse(_)) => complain(&error, 2),
        Err(error) => complain(&error, 1),
    }
}

#[cfg(feature = "ros")]
fn run(mut arguments: RunArguments, ros: RosArguments) -> ExitCode {
    use carom::node::{self, RunOptions, Start};
    // A step among the parameters waits for a method that takes one.
    let step_said = arguments.step;
    let start = Start::new(ros).and_then(|start| {
        fill(&mut arguments, &start)?;
        Ok(start)
    });
    let start = match start {
        Ok(start) => start,
        Err(error) => return complain(&error, 2),
    };
    let RunArguments {
        scene,
        seconds,
        rate,
        method,
        step,
        keep_all,
        error,
        budget,
        record,
        wire,
        ..
    } = arguments;
    let scene = scene.unwrap_or_else(|| shipped::DEFAULT.to_owned());
    let rate = rate.unwrap_or(1.0);
    let loaded = load(&scene, method.as_deref(), step, keep_all)
        .and_then(|loaded| check_step(&loaded, step_said).map(|()| loaded))
        .and_then(|loaded| Ok((wire.options(&scene, &loaded)?, loaded)));
    match loaded {
        Err(message) => complain(&message, 2),
        Ok((wire, mut loaded)) => {
            let options = RunOptions { scene, start, seconds, rate, record, wire };
            keep_to_budget(&mut loaded, Wish { error, budget });
            match node::run(&loaded, &options) {
                Ok(()) => ExitCode::SUCCESS,
                Err(error) => complain(&error, if error.is_bad_use() { 2 } else { 1 }),
            }
        }
    }
}

/// Takes from the parameters what the command line does not say itself.
#[cfg(feature = "ros")]
fn fill(
    arguments: &mut RunArguments,
    start: &carom::node::Start,
) -> Result<(), carom::node::NodeError> {
    let wrong = |error: String| carom::node::NodeError::BadUse(error);
    let number = |name, right: fn(&str) -> Result<f64, String>| {
        let text = start.number(name)?.map(|number| number.to_string());
        let checked = text.as_deref().map(right).transpose();
        checked.map_err(|error| wrong(format!("parameter '{name}': {error}")))
    };
    arguments.scene = arguments.scene.take().or(start.text("scene")?);
    arguments.rate = arguments.rate.or(number("rate", at_least_0)?);
    arguments.step = arguments.step.or(number("step_s", seconds)?);
    let end = number("for_s", at_least_0)?.filter(|end| *end > 0.0);
    arguments.seconds = arguments.seconds.or(end);
    arguments.error = arguments.error.or(number("error", budget::parse_error)?);
    arguments.budget = arguments.budget.or(number("budget", budget::parse_budget)?);
    arguments.keep_all |= start.flag("keep_all")?.unwrap_or(false);
    let folder = start.text("record")?.filter(|folder| !folder.is_empty());
    arguments.record = arguments.record.take().or(folder.map(PathBuf::from));
    if let (None, Some(method)) = (&arguments.method, start.text("method")?) {
        Method::named(&method).map_err(|error| wrong(format!("parameter 'method': {error}")))?;
        arguments.method = Some(method);
    }
    Ok(())
}

/// Nothing without a node.
#[cfg(not(feature = "ros"))]
#[derive(Default)]
struct RosArguments;

#[cfg(not(feature = "ros"))]
fn split(words: Vec<String>) -> Result<(Vec<String>, Option<RosArguments>), String> {
    Ok((words, None))
}

#[cfg(not(feature = "ros"))]
fn run(_arguments: RunArguments, _ros: RosArguments) -> ExitCode {
    complain(&"this build has no ROS 2 node: build it with the feature `ros`", 2)
}

/// What came of it, on stdout, and the exit code; 2 where it cannot be said. Whoever closes a pipe
/// has read enough.
#[cfg(feature = "bags")]
fn say(what: &dyn std::fmt::Display, code: u8) -> ExitCode {
    match writeln!(std::io::stdout(), "{what}") {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            complain(&format!("cannot write: {error}"), 2)
        }
        _ => ExitCode::from(code),
    }
}

/// One line on stderr.
fn tell(what: &dyn std::fmt::Display) {
    // Nobody may be reading.
    let _ = writeln!(std::io::stderr(), "carom: {what}");
}

/// One line on stderr, and the exit code.
fn complain(error: &dyn std::fmt::Display, code: u8) -> ExitCode {
    tell(error);
    ExitCode::from(code)
}

/// Help and version go out as they are; of an error the first line says it.
fn refuse(error: &clap::Error) -> ExitCode {
    if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) {
        // A closed pipe is the reader's wish.
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        return complain(
            &"bench needs to know what to measure: gas or peers; see carom bench --help",
            2,
        );
    }
    let text = error.to_string();
    let what: Vec<&str> = text.lines().take_while(|line| !line.is_empty()).map(str::trim).collect();
    let what = what.join(" ");
    complain(&format!("{}; see carom --help", what.trim_start_matches("error: ")), 2)
}

fn seconds(text: &str) -> Result<f64, String> {
    number(text, |x| x > 0.0, "a number of seconds above 0")
}

fn hertz(text: &str) -> Result<f64, String> {
    number(text, |x| x > 0.0, "a rate above 0, in 1/s; say --clock last, or --clock=40")
}

/// A number, or one over another.
fn step(text: &str) -> Result<f64, String> {
    let (above, below) = text.split_once('/').unwrap_or((text, "1"));
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let step = number(above).zip(number(below)).map(|(above, below)| above / below);
    let step = step.filter(|step| step.is_finite() && *step > 0.0);
    step.ok_or_else(|| "must be a number of seconds above 0, such as 1/60".to_owned())
}

fn at_least_0(text: &str) -> Result<f64, String> {
    number(text, |x| x >= 0.0, "a number of 0 or more")
}

fn at_least_1(text: &str) -> Result<f64, String> {
    number(text, |x| x >= 1.0, "a number of 1 or more")
}

fn at_most_1(text: &str) -> Result<f64, String> {
    number(text, |x| (0.0..=1.0).contains(&x), "a number from 0 to 1")
}

/// So many numbers with commas between them.
fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    let all: Option<Vec<f64>> = text.split(',').map(number).collect();
    let all = all.and_then(|all| <[f64; N]>::try_from(all).ok());
    all.ok_or_else(|| format!("must be {N} numbers with commas between them"))
}

fn fraction(text: &str) -> Result<f64, String> {
    number(text, |x| (1e-6..0.9).contains(&x), "a number from 1e-6 to below 0.9")
}

fn to_one_second(text: &str) -> Result<f64, String> {
    number(text, |x| x > 0.0 && x <= 1.0, "a number of seconds above 0, up to 1")
}

fn to_a_million(text: &str) -> Result<f64, String> {
    number(text, |x| (0.0..=1e6).contains(&x), "a number from 0 to 1e6")
}

fn number(text: &str, right: impl Fn(f64) -> bool, wanted: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|x: &f64| x.is_finite() && right(*x));
    value.ok_or_else(|| format!("must be {wanted}"))
}
