//! What listening costs the node: `cargo bench --bench listeners`.
//!
//! An arena of 100 pucks at 60 Hz runs while rclpy hears nothing, then one topic after the other.
//! Figures are printed; the one with nobody listening is judged.

#[path = "../tests/ros/environment.rs"]
#[allow(dead_code, unused_imports, reason = "one distribution is enough here")]
mod environment;

use std::process::Command;

use environment::Distribution;

fn main() {
    let status = Command::new(environment::environment(Distribution::Kilted).join("bin/python"))
        .arg(environment::scripts().join("listeners.py"))
        .env("CAROM_BIN", env!("CARGO_BIN_EXE_carom"))
        .env("CAROM_ROOT", env!("CARGO_MANIFEST_DIR"))
        .env("ROS_DOMAIN_ID", "39")
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .status();
    assert!(status.expect("Python runs").success(), "listeners.py failed");
}
