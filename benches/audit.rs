//! What an audit of a million samples takes: `cargo bench --bench audit [-- SAMPLES]`.
//!
//! The node records 1000 pucks at 60 Hz as fast as it can, and the bag is judged three times: wall
//! time, time on the processors and the largest memory, by the kernel's account. The recording is
//! carom's own, so a violation fails the bench; the figures are printed.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

const PUCKS: f64 = 1000.0;
const RATE_HZ: f64 = 60.0;

fn main() {
    let number = std::env::args().find_map(|word| word.parse::<f64>().ok());
    let frames = (number.unwrap_or(1e6) / PUCKS).ceil();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("audited");
    let _ = fs::remove_dir_all(&folder);
    record(frames / RATE_HZ, &folder);
    for _ in 0..3 {
        audit(&folder);
    }
    let _ = fs::remove_dir_all(&folder);
}

fn record(seconds: f64, folder: &Path) {
    let status = Command::new(env!("CARGO_BIN_EXE_carom"))
        .args(["run", "thousand", "--rate", "0", "--for", &seconds.to_string(), "--record"])
        .arg(folder)
        .args(["--ros-args", "-p", &format!("publish_rate_hz:={RATE_HZ:.1}")])
        .env("ROS_DOMAIN_ID", "78")
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .stderr(Stdio::null())
        .status();
    assert!(status.expect("the program was built").success());
}

fn audit(bag: &Path) {
    let start = Instant::now();
    let mut child = Command::new(env!("CARGO_BIN_EXE_carom"))
        .arg("audit")
        .arg(bag)
        .stdout(Stdio::null())
        .spawn()
        .expect("the program was built");
    let (cpu, peak_kib) = watch(&mut child);
    let wall = start.elapsed().as_secs_f64();
    println!("{wall:5.2} s, {cpu:5.2} s on the processors, {:5.1} MB", peak_kib / 976.5625);
    assert!(child.wait().expect("the child is ours").success(), "carom broke the law");
}

/// Time on the processors, s, and the largest memory, KiB, as last seen before the end.
fn watch(child: &mut Child) -> (f64, f64) {
    let id = child.id();
    let (mut cpu, mut peak) = (0.0, 0.0);
    while child.try_wait().expect("the child is ours").is_none() {
        let text = fs::read_to_string(format!("/proc/{id}/status")).unwrap_or_default();
        let found = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        peak = found.and_then(first_number).unwrap_or(peak);
        let tasks = fs::read_dir(format!("/proc/{id}/task")).into_iter().flatten().flatten();
        let times = tasks.filter_map(|task| {
            first_number(&fs::read_to_string(task.path().join("schedstat")).ok()?)
        });
        cpu = f64::max(cpu, times.sum::<f64>() * 1e-9);
        thread::sleep(Duration::from_millis(5));
    }
    (cpu, peak)
}

fn first_number(text: &str) -> Option<f64> {
    text.split_whitespace().next()?.parse().ok()
}
