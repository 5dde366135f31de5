//! Scripts of other programs against the node: one process, its whole output, a time to end.
//!
//! A test never ends a process that it has not started.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

const RUN_TIME_MAX: Duration = Duration::from_secs(120);
/// For a script that was asked to end: it ends its node first.
const GRACE: Duration = Duration::from_secs(10);

/// Runs one script in a ROS domain and fails with its whole output if it does.
pub fn run(name: &str, domain: u32, python: &Path, script: &Path, variables: &[(&str, &Path)]) {
    // To a file and not a pipe: a pipe would stay open for as long as any grandchild.
    let log = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.log"));
    let output = File::create(&log).expect("cargo's scratch directory is writable");
    let errors = output.try_clone().expect("a handle of an open file");
    let mut child = Command::new(python)
        .arg(script)
        .env("CAROM_BIN", env!("CARGO_BIN_EXE_carom"))
        .env("CAROM_ROOT", env!("CARGO_MANIFEST_DIR"))
        .env("ROS_DOMAIN_ID", domain.to_string())
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("PYTHONUNBUFFERED", "1")
        .env_remove("PYTHONPATH")
        .envs(variables.iter().copied())
        .stdin(Stdio::null())
        .stdout(output)
        .stderr(errors)
        .spawn()
        .expect("the environment has a Python");
    let status = wait(&mut child, RUN_TIME_MAX);
    if status.is_none() {
        end(&mut child);
    }
    let text = fs::read_to_string(&log).unwrap_or_default();
    match status {
        Some(status) if status.success() => println!("{text}"),
        Some(status) => panic!("{name}: {status}\n{text}"),
        None => panic!("{name}: still running after {RUN_TIME_MAX:?}\n{text}"),
    }
}

/// The exit status, or nothing when the time is over.
fn wait(child: &mut Child, time_max: Duration) -> Option<ExitStatus> {
    let deadline = Instant::now() + time_max;
    while Instant::now() < deadline {
        if let Some(status) = child.try_wait().expect("the child is ours") {
            return Some(status);
        }
        thread::sleep(Duration::from_millis(20));
    }
    None
}

/// By SIGTERM first, for the script to end its node; std has no call for it.
fn end(child: &mut Child) {
    let _ = Command::new("kill").args(["-TERM", &child.id().to_string()]).status();
    if wait(child, GRACE).is_none() {
        let _ = child.kill();
        let _ = child.wait();
    }
}
