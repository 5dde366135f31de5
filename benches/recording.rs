//! What recording costs the loop: `cargo bench --bench recording [-- SECONDS [PAIRS]]`.
//!
//! The node runs 1000 pucks at 100 Hz in real time, with `--record` and without, one after the
//! other, so that the noise of the machine hits both. What is compared is the time that the thread
//! of the loop was on a processor, by the kernel's account; the thread that writes is another one.
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
    let pairs = numbers.get(1).map_or(1, |pairs| *pairs as usize).max(1);
    let ticks = (seconds - START_S) * RATE_HZ;
    let (mut without, mut with) = (Vec::new(), Vec::new());
    for pair in 0..pairs {
        let (plain, _) = run(seconds, None);
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("recording-{pair}"));
        let _ = fs::remove_dir_all(&folder);
        let (recorded, line) = run(seconds, Some(&folder));
        let _ = fs::remove_dir_all(&folder);
        println!(
            "{:7.1} us a tick without, {:7.1} us with: {:+.2} %   {line}",
            plain * 1e6 / ticks,
            recorded * 1e6 / ticks,
            (recorded / plain - 1.0) * 100.0
        );
        without.push(plain);
        with.push(recorded);
    }
    let (without, with) = (median(without), median(with));
    println!("medians: {:+.2} % of the loop's time", (with / without - 1.0) * 100.0);
}

/// Seconds of the loop's thread, and what the node said about its bag.
fn run(seconds: f64, record: Option<&Path>) -> (f64, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
    command.args(["run", "thousand", "--for", &seconds.to_string()]);
    if let Some(folder) = record {
        command.arg("--record").arg(folder);
    }
    let rate = format!("publish_rate_hz:={RATE_HZ:.1}");
    let mut child = command
        .args(["--ros-args", "-p", &rate])
        .env("ROS_DOMAIN_ID", DOMAIN)
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program was built");
    let time = loop_time(&mut child);
    let mut log = String::new();
    let errors = child.stderr.as_mut().expect("it was asked for");
    errors.read_to_string(&mut log).expect("a log");
    let line = log.lines().find_map(|line| line.split_once("recorded ")).map(|(_, line)| line);
    (time, line.unwrap_or_default().to_owned())
}

/// Time on a processor of the first thread, s, from the end of the start to the last look at it.
fn loop_time(child: &mut Child) -> f64 {
    let id = child.id();
    let path = format!("/proc/{id}/task/{id}/schedstat");
    let (begin, mut first, mut last) = (Instant::now(), None, 0.0);
    while child.try_wait().expect("the child is ours").is_none() {
        let text = fs::read_to_string(&path).unwrap_or_default();
        let time = text.split_whitespace().next().and_then(|word| word.parse::<f64>().ok());
        last = time.filter(|time| *time > 0.0).map_or(last, |time| time * 1e-9);
        if begin.elapsed().as_secs_f64() > START_S {
            first.get_or_insert(last);
        }
        thread::sleep(Duration::from_millis(5));
    }
    last - first.expect("a run longer than the start")
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
