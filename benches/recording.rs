//! What recording costs the loop: `cargo bench --bench recording [-- SECONDS]`.
//!
//! 1000 pucks step at 100 Hz in real time, and all that a node says of a step is recorded, or
//! not, in turns of a second and in one process: two runs differ by more than recording costs. The
//! time is that of the loop's thread on a processor, by the kernel's account. In it is what the
//! thread that writes costs the loop by emptying its caches, for that works in the turns of
//! recording alone. By itself the time in the recorder's calls is told, which is less noisy. Both
//! are told against the loop of a node that does the same without recording. Last a node records
//! for a minute, and tells what it wrote and dropped. Figures are printed, not judged.

mod figures;

use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use carom::bag::journal::Entry;
use carom::bag::qos::Qos;
use carom::bag::write::Options;
use carom::messages::{Clock, Time};
use carom::node::recorder::{Recorder, Tap};
use carom::scene::Scene;
use carom::world::{Instants, World};
use figures::median;

const SCENE: &str = "thousand";
const DOMAIN: &str = "79";
const RATE_HZ: f64 = 100.0;
/// Ticks of a turn, and how many of the first are not measured: the writer is behind by so much.
const TURN: u32 = 100;
const UNMEASURED: u32 = 30;
/// How long a node runs, and what of that is not looked at, s: it opens its topics, and closes them.
const NODE_S: f64 = 60.0;
const START_S: f64 = 1.5;
const END_S: f64 = 0.5;
/// Turns before anything is measured.
const WARM_UP: usize = 4;

fn main() {
    let turns = std::env::args().find_map(|word| word.parse().ok()).unwrap_or(60_usize);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("recording");
    let (cost, calls) = measure(turns.max(WARM_UP + 4), &folder);
    let (turn, _) = node(NODE_S, None);
    let [cost, calls] = [cost, calls].map(|time| time / turn * 100.0);
    println!("a node's turn {turn:.1} us: {cost:+.2} % of it, in the calls {calls:.2} %");
    let (turn, said) = node(NODE_S, Some(&folder));
    println!("a node that records: {turn:.1} us a turn, {said}");
    let _ = fs::remove_dir_all(&folder);
}

/// What a node says of a step.
struct Taps {
    recorder: Recorder,
    states: Tap,
    contacts: Tap,
    clock: Tap,
}

impl Taps {
    fn open(folder: &Path) -> Self {
        let _ = fs::remove_dir_all(folder);
        let recorder = Recorder::open(folder, Options::default(), Vec::new()).expect("a folder");
        let qos = Qos::default().to_yaml();
        recorder.keep_journal("/carom/journal");
        let tap = |name: &str, kind: &str| recorder.tap(name, kind, &qos);
        Self {
            states: tap("/arena_states", "carom/msg/CircleStates"),
            contacts: tap("/contacts", "carom/msg/Contacts"),
            clock: tap("/clock", "rosgraph_msgs/msg/Clock"),
            recorder,
        }
    }
}

/// So many turns, every other one with recording; what that costs a tick in all, and in the
/// recorder's calls, us.
fn measure(turns: usize, folder: &Path) -> (f64, f64) {
    let mut world = Scene::load(SCENE).expect("shipped").world();
    let taps = Taps::open(folder);
    let (start, mut ticks) = (Instant::now(), 0_u32);
    let (mut costs, mut calls) = ([Vec::new(), Vec::new()], Vec::new());
    for turn in 0..turns {
        let records = turn % 2 == 1;
        let mut before = 0.0;
        for tick in 0..TURN {
            if tick == UNMEASURED {
                before = loop_time();
            }
            ticks += 1;
            let until = f64::from(ticks) / RATE_HZ;
            let due = start + Duration::from_secs_f64(until);
            thread::sleep(due.saturating_duration_since(Instant::now()));
            let called = step(&mut world, until, records.then_some(&taps));
            calls.extend(called.filter(|_| turn >= WARM_UP && tick >= UNMEASURED));
        }
        if turn >= WARM_UP {
            let measured = f64::from(TURN - UNMEASURED);
            costs[usize::from(records)].push((loop_time() - before) * 1e6 / measured);
        }
    }
    taps.recorder.close().expect("a bag");
    println!(
        "in the recorder's calls: mean {:.2} us a tick, median {:.2} us",
        mean(&calls),
        median(calls.clone())
    );
    (tell(costs), mean(&calls))
}

/// A step; how long the recorder was called, us.
fn step(world: &mut World, until: f64, taps: Option<&Taps>) -> Option<f64> {
    let outcome = world.step(&[], Instants { heard_at: f64::NEG_INFINITY, advance_to: until });
    let taps = taps?;
    let begin = Instant::now();
    taps.recorder.journal(Entry::Step { to: until, heard: None, asked: None });
    let stamp = Time::from_seconds(until);
    let header = (stamp, "world");
    if !outcome.contacts.is_empty() {
        taps.contacts.record_contacts(header, &outcome.contacts);
    }
    taps.states.record_states(header, |watcher, turns| world.look(watcher, turns));
    taps.clock.record(&Clock { clock: stamp });
    taps.recorder.hand_over_if_due(Instant::now());
    Some(begin.elapsed().as_secs_f64() * 1e6)
}

/// Means, and medians too: a machine that is shared holds some turns up.
fn tell([without, with]: [Vec<f64>; 2]) -> f64 {
    let pairs: Vec<f64> = with.iter().zip(&without).map(|(with, without)| with - without).collect();
    let (bare, mean_of_pairs) = (mean(&without), mean(&pairs));
    let deviations: Vec<f64> = pairs.iter().map(|pair| (pair - mean_of_pairs).powi(2)).collect();
    let error = (mean(&deviations) / (pairs.len() as f64 - 1.0)).sqrt();
    let percent = 100.0 / bare;
    println!(
        "{} pairs of turns, mean: a tick {bare:.1} us; recording {mean_of_pairs:+.2} us = {:+.2} %, \
         standard error {:.2} %",
        pairs.len(),
        mean_of_pairs * percent,
        error * percent
    );
    let (bare, recorded, more) = (median(without), median(with), median(pairs));
    println!(
        "median: a tick {bare:.1} us, recorded {recorded:.1} us = {:+.2} %; of pairs {more:+.2} us",
        (recorded / bare - 1.0) * 100.0
    );
    mean_of_pairs
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Time of this thread on a processor, s.
fn loop_time() -> f64 {
    time_in("/proc/thread-self/schedstat").expect("the kernel's account")
}

fn time_in(account: &str) -> Option<f64> {
    let nanoseconds = fs::read_to_string(account).ok()?;
    Some(nanoseconds.split_whitespace().next()?.parse::<f64>().ok()? * 1e-9)
}

/// A node that runs so long: a turn of its loop, us of its first thread, and what it said of the
/// bag.
fn node(seconds: f64, record: Option<&Path>) -> (f64, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
    command.args(["run", SCENE, "--for", &seconds.to_string()]);
    if let Some(folder) = record {
        let _ = fs::remove_dir_all(folder);
        command.arg("--record").arg(folder);
    }
    command.args(["--ros-args", "-p", &format!("publish_rate_hz:={RATE_HZ:.1}")]);
    command.env("ROS_DOMAIN_ID", DOMAIN).env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST");
    let mut node = command.stderr(Stdio::piped()).spawn().expect("the program was built");
    let account = format!("/proc/{0}/task/{0}/schedstat", node.id());
    let measured = seconds - START_S - END_S;
    thread::sleep(Duration::from_secs_f64(START_S));
    let before = time_in(&account);
    thread::sleep(Duration::from_secs_f64(measured));
    let after = time_in(&account);
    let mut log = String::new();
    let errors = node.stderr.as_mut().expect("it was asked for");
    errors.read_to_string(&mut log).expect("a log");
    node.wait().expect("the child is ours");
    let (before, after) = before.zip(after).unwrap_or_else(|| panic!("it ended early: {log}"));
    let line = log.lines().find_map(|line| line.split_once("recorded "));
    let line = line.map(|(_, line)| line.to_owned()).unwrap_or_default();
    ((after - before) * 1e6 / (measured * RATE_HZ), line)
}
