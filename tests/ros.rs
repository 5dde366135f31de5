//! The node against real rclpy: each script of tests/ros runs against the built binary.
//!
//! Python is the other side because it is what users run: what rclpy, on another DDS, cannot read
//! does not work. Each script runs on two distributions, in a ROS domain of its own, so that they
//! can run side by side, and fails by its exit code. A test never ends a process that it has not
//! started.

#[path = "ros/colcon.rs"]
mod colcon;
#[path = "ros/environment.rs"]
mod environment;

use environment::Distribution;
use std::fs::{self, File};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{PoisonError, RwLock};
use std::thread;
use std::time::{Duration, Instant};

/// By distribution; a script's domain is its index more. Domains up to 101 stay clear of the ports
/// that Linux gives to others.
const FIRST_DOMAIN: [u32; 2] = [70, 40];
const RUN_TIME_MAX: Duration = Duration::from_secs(120);
/// For a script that was asked to end: it ends its node first.
const GRACE: Duration = Duration::from_secs(10);

/// Held for writing by a script that needs the machine for itself.
static MACHINE: RwLock<()> = RwLock::new(());

macro_rules! tests {
    ($distribution:expr; beside_others: $($index:literal $script:ident)*;
     alone: $($index_alone:literal $script_alone:ident)*) => {
        $(#[test]
        fn $script() {
            crate::beside_others($distribution, stringify!($script), $index);
        })*
        $(#[test]
        fn $script_alone() {
            crate::alone($distribution, stringify!($script_alone), $index_alone);
        })*
    };
}

macro_rules! suite {
    ($module:ident $distribution:expr) => {
        mod $module {
            use crate::environment::Distribution;

            tests! { $distribution;
                beside_others:
                    1 resolver_values
                    2 publishers
                    3 thousand_circles
                    4 arena
                    5 observed_and_simulated
                    6 restart
                    7 refused
                    8 readme
                    9 names
                    10 parameters
                    11 clock
                    12 error_report
                    13 simulation
                    14 markers
                    16 robots
                    17 killed
                    18 crowd
                    19 payloads
                    20 datagrams
                    23 endurance
                    25 bags_others
                    26 bags_own
                    27 bags_replayed
                    28 bags_killed;
                alone:
                    0 kilohertz
                    15 large
                    21 flood
                    22 deaf
            }
        }
    };
}

suite!(kilted Distribution::Kilted);
suite!(jazzy Distribution::Jazzy);

fn beside_others(distribution: Distribution, script: &str, index: u32) {
    environment::environment(distribution);
    let _shared = MACHINE.read().unwrap_or_else(PoisonError::into_inner);
    run(distribution, script, index);
}

fn alone(distribution: Distribution, script: &str, index: u32) {
    environment::environment(distribution);
    let _alone = MACHINE.write().unwrap_or_else(PoisonError::into_inner);
    run(distribution, script, index);
}

/// Runs one script and fails with its whole output if it does.
fn run(distribution: Distribution, script: &str, index: u32) {
    // To a file and not a pipe: a pipe would stay open for as long as any grandchild.
    let log = format!("ros-{}-{script}.log", distribution.name());
    let log = Path::new(env!("CARGO_TARGET_TMPDIR")).join(log);
    let domain = FIRST_DOMAIN[distribution as usize] + index;
    let output = File::create(&log).expect("cargo's scratch directory is writable");
    let errors = output.try_clone().expect("a handle of an open file");
    let mut child = Command::new(environment::environment(distribution).join("bin/python"))
        .arg(environment::scripts().join(format!("{script}.py")))
        .env("CAROM_BIN", env!("CARGO_BIN_EXE_carom"))
        .env("CAROM_ROOT", env!("CARGO_MANIFEST_DIR"))
        .env("ROS_DOMAIN_ID", domain.to_string())
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("PYTHONUNBUFFERED", "1")
        .env_remove("PYTHONPATH")
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
        Some(status) => panic!("{script}.py: {status}\n{text}"),
        None => panic!("{script}.py: still running after {RUN_TIME_MAX:?}\n{text}"),
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
