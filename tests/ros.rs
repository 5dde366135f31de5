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
#[path = "environment/script.rs"]
mod script;

use environment::Distribution;
use std::sync::{PoisonError, RwLock};

/// By distribution; a script's domain is its index more. Domains up to 101 stay clear of the ports
/// that Linux gives to others.
const FIRST_DOMAIN: [u32; 2] = [70, 40];

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
                    28 bags_killed
                    29 soccer;
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

fn run(distribution: Distribution, script: &str, index: u32) {
    let python = environment::environment(distribution).join("bin/python");
    let domain = FIRST_DOMAIN[distribution as usize] + index;
    let path = environment::scripts().join(format!("{script}.py"));
    script::run(&format!("ros-{}-{script}", distribution.name()), domain, &python, &path, &[]);
}
