//! What recording costs the loop: `cargo bench --bench recording [-- SECONDS [PAIRS]]`.
//!
//! Two nodes run 1000 pucks at 100 Hz in real time at the same time, one with `--record` and one
//! without, so that the noise of the machine hits both. What is compared is the time that the
//! threads of their loops were on a processor, by the kernel's account; the thread that writes is
//! another one. Figures are printed, not judged.

use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// Of the first node, and the next of the second.
const DOMAIN: u32 = 78;
const RATE_HZ: f64 = 100.0;
/// What is not looked at, s: the nodes open their topics, and the bag.
const START_S: f64 = 1.0;

fn main() {
    let numbers: Vec<f64> = std::env::args().filter_map(|word| word.parse().ok()).collect();
    let seconds = numbers.first().copied().unwrap_or(60.0);
    let pairs = numbers.get(1).map_or(3, |pairs| *pairs as usize).max(1);
    let ticks = (seconds - START_S) * RATE_HZ;
    let mut costs = Vec::new();
    for pair in 0..pairs {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("recording-{pair}"));
        let _ = fs::remove_dir_all(&folder);
        // Who starts first changes.
        let recorded = pair % 2;
        let mut nodes = [0, 1].map(|k| Node::start(k, seconds, (k == recorded).then_some(&folder)));
        let times = measure(&mut nodes);
        let line = nodes[recorded].ended();
        let _ = fs::remove_dir_all(&folder);
        let (with, without) = (times[recorded], times[1 - recorded]);
        println!(
            "{:7.1} us a tick without, {:7.1} us with: {:+.2} %   {line}",
            without * 1e6 / ticks,
            with * 1e6 / ticks,
            (with / without - 1.0) * 100.0
        );
        costs.push(with / without - 1.0);
    }
    costs.sort_by(f64::total_cmp);
    println!("median: {:+.2} % of the loop's time", costs[costs.len() / 2] * 100.0);
}

/// A node that runs.
struct Node(Child);

impl Node {
    fn start(number: usize, seconds: f64, record: Option<&Path>) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
        command.args(["run", "thousand", "--for", &seconds.to_string()]);
        if let Some(folder) = record {
            command.arg("--record").arg(folder);
        }
        let rate = format!("publish_rate_hz:={RATE_HZ:.1}");
        let child = command
            .args(["--ros-args", "-p", &rate])
            .env("ROS_DOMAIN_ID", (DOMAIN + number as u32).to_string())
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

    /// What it said about its bag.
    fn ended(&mut self) -> String {
        let mut log = String::new();
        let errors = self.0.stderr.as_mut().expect("it was asked for");
        errors.read_to_string(&mut log).expect("a log");
        let line = log.lines().find_map(|line| line.split_once("recorded "));
        line.map(|(_, line)| line.to_owned()).unwrap_or_default()
    }
}

/// Times on a processor of both, s, from the end of the start to the last look at both.
fn measure(nodes: &mut [Node; 2]) -> [f64; 2] {
    let (begin, mut first, mut last) = (Instant::now(), None, [0.0; 2]);
    while let (Some(a), Some(b)) = (nodes[0].loop_time(), nodes[1].loop_time()) {
        last = [a, b];
        if begin.elapsed().as_secs_f64() > START_S {
            first.get_or_insert(last);
        }
        thread::sleep(Duration::from_millis(5));
    }
    let [a, b] = first.expect("a run longer than the start");
    // The other one ends by itself.
    nodes.iter_mut().for_each(|node| drop(node.0.wait()));
    [last[0] - a, last[1] - b]
}
