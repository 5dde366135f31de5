//! What recording costs the loop: `cargo bench --bench recording [-- SECONDS [PAIRS]]`.
//!
//! The node runs 1000 pucks at 100 Hz in real time, with `--record` and without, in turn and each
//! first as often, its loop always on the same processor. What is compared is the time that the
//! thread of the loop was on it, by the kernel's account; the thread that writes is another one.
//! Figures are printed, not judged.

use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

const DOMAIN: &str = "79";
const RATE_HZ: f64 = 100.0;
/// What is not looked at, s: the node opens its topics, and the bag.
const START_S: f64 = 1.0;

fn main() {
    let numbers: Vec<f64> = std::env::args().filter_map(|word| word.parse().ok()).collect();
    let seconds = numbers.first().copied().unwrap_or(60.0);
    let pairs = numbers.get(1).map_or(4, |pairs| *pairs as usize).max(1);
    let ticks = (seconds - START_S) * RATE_HZ;
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("recording");
    let mut costs = Vec::new();
    for pair in 0..pairs {
        let (mut times, mut line) = ([0.0; 2], String::new());
        for turn in [pair % 2, 1 - pair % 2] {
            let _ = fs::remove_dir_all(&folder);
            let mut node = Node::start(seconds, (turn == 1).then_some(&folder));
            times[turn] = node.measure() * 1e6 / ticks;
            line = if turn == 1 { node.ended() } else { line };
        }
        let [without, with] = times;
        let cost = (with / without - 1.0) * 100.0;
        println!("{without:7.1} us a tick without, {with:7.1} us with: {cost:+.2} %   {line}");
        costs.push(times);
    }
    let _ = fs::remove_dir_all(&folder);
    let mean = |k: usize| costs.iter().map(|times| times[k]).sum::<f64>() / costs.len() as f64;
    let mut ratios: Vec<f64> = costs.iter().map(|times| times[1] / times[0]).collect();
    ratios.sort_by(f64::total_cmp);
    println!(
        "of the loop's time: median of pairs {:+.2} %, of all {:+.2} %",
        (ratios[ratios.len() / 2] - 1.0) * 100.0,
        (mean(1) / mean(0) - 1.0) * 100.0
    );
}

/// A node that runs.
struct Node(Child);

impl Node {
    fn start(seconds: f64, record: Option<&Path>) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
        command.args(["run", "thousand", "--for", &seconds.to_string()]);
        if let Some(folder) = record {
            command.arg("--record").arg(folder);
        }
        let rate = format!("publish_rate_hz:={RATE_HZ:.1}");
        let child = command
            .args(["--ros-args", "-p", &rate])
            .env("ROS_DOMAIN_ID", DOMAIN)
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program was built");
        Self(child)
    }

    /// Time on a processor of its first thread, s, while it is there.
    fn loop_time(&mut self) -> Option<f64> {
        let id = self.0.id();
        if self.0.try_wait().expect("the child is ours").is_some() {
            return None;
        }
        let text = fs::read_to_string(format!("/proc/{id}/task/{id}/schedstat")).ok()?;
        let time = text.split_whitespace().next()?.parse::<f64>().ok()?;
        Some(time * 1e-9)
    }

    /// Puts the loop on one processor, for two are not alike; the other threads, which are there by
    /// now, stay free. Where there is no such program there is more noise.
    fn pin(&self) {
        let mut pin = Command::new("taskset");
        let pin = pin.args(["-p", "-c", "0", &self.0.id().to_string()]).stdout(Stdio::null());
        let _ = pin.status();
    }

    /// Time on a processor, s, from the end of the start to the last look at it.
    fn measure(&mut self) -> f64 {
        let (begin, mut first, mut last) = (Instant::now(), None, 0.0);
        while let Some(time) = self.loop_time() {
            last = time;
            if first.is_none() && begin.elapsed().as_secs_f64() > START_S {
                self.pin();
                first = Some(last);
            }
            thread::sleep(Duration::from_millis(5));
        }
        last - first.expect("a run longer than the start")
    }

    /// What it said about its bag.
    fn ended(&mut self) -> String {
        let mut log = String::new();
        let errors = self.0.stderr.as_mut().expect("it was asked for");
        errors.read_to_string(&mut log).expect("a log");
        let line = log.lines().find_map(|line| line.split_once("recorded "));
        line.map(|(_, line)| line.to_owned()).unwrap_or_default()
    }
}
