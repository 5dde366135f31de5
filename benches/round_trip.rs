//! Round trip rclpy -> carom -> rclpy beside a bare echo: `cargo bench --bench round_trip`.
//!
//! Both nodes run at once and messages to them alternate, so that the noise of the machine hits
//! both. The echo is this program with the argument `echo`: the same DDS library and the same
//! runtime, and nothing between reading and writing. Figures are printed, not judged.

#[path = "../tests/ros/environment.rs"]
#[allow(dead_code, unused_imports, reason = "one distribution is enough here")]
mod environment;

use std::net::Ipv4Addr;
use std::process::{Child, Command, Stdio};

use carom::messages::{CircleState, CircleStates, CircleVelocities, CircleVelocity};
use ros2_client::qos::{History, QosProfile};
use ros2_client::{Context, MessageTypeName, Name, Node, NodeName, NodeOptions};
use rustdds::DomainParticipantBuilder;

use environment::Distribution;

const DOMAIN: u16 = 79;

fn main() {
    if std::env::args().any(|argument| argument == "echo") {
        return echo();
    }
    let python = environment::environment(Distribution::Kilted).join("bin/python");
    let this = std::env::current_exe().expect("this program has a path");
    let node = |program: &str, argument: &[&str]| -> Child {
        Command::new(program)
            .args(argument)
            .env("ROS_DOMAIN_ID", DOMAIN.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .stderr(Stdio::null())
            .spawn()
            .expect("the program was built")
    };
    let mut nodes = [
        node(env!("CARGO_BIN_EXE_carom"), &["run", "resolver"]),
        node(&this.to_string_lossy(), &["echo"]),
    ];
    let status = Command::new(python)
        .arg(environment::scripts().join("round_trip.py"))
        .arg("--pids")
        .args(nodes.iter().map(|node| node.id().to_string()))
        .env("CAROM_BIN", env!("CARGO_BIN_EXE_carom"))
        .env("CAROM_ROOT", env!("CARGO_MANIFEST_DIR"))
        .env("ROS_DOMAIN_ID", DOMAIN.to_string())
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .status();
    for node in &mut nodes {
        // Only the two that were started here.
        let _ = node.kill();
        let _ = node.wait();
    }
    assert!(status.expect("Python runs").success(), "round_trip.py failed");
}

/// Reads circle states and answers with their velocities at once.
fn echo() {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let participant = DomainParticipantBuilder::new(DOMAIN)
        .with_only_networks([Ipv4Addr::LOCALHOST])
        .build()
        .expect("a participant");
    let context = Context::from_domain_participant(participant).expect("a context");
    let options = NodeOptions::new().enable_rosout(false).start_parameter_services(false);
    let name = NodeName::new("/", "echo").expect("a name");
    let mut node = context.new_node(name, options).expect("a node");
    let keep = History::KeepLast { depth: 100 };
    let (input, output) = (
        QosProfile::subscription_default().history(keep),
        QosProfile::publisher_default().history(keep),
    );
    let topic = |node: &Node, name: &str, kind: &str, qos: &QosProfile| {
        let name = Name::parse(name).expect("a topic name");
        node.create_topic(&name, MessageTypeName::new("carom", kind), qos).expect("a topic")
    };
    let read = topic(&node, "/echo_in", "CircleStates", &input);
    let write = topic(&node, "/echo_out", "CircleVelocities", &output);
    let reader = node.create_subscription::<CircleStates>(&read, Some(input)).expect("a reader");
    let writer = node.create_publisher::<CircleVelocities>(&write, Some(output)).expect("a writer");
    runtime.expect("a runtime").block_on(async {
        loop {
            let Ok((states, _)) = reader.async_take().await else { continue };
            let velocity = |c: &CircleState| CircleVelocity { id: c.id, vx: c.vx, vy: c.vy };
            let velocities = states.circles.iter().map(velocity).collect();
            let header = states.header;
            let _ = writer.publish(CircleVelocities { header, part: 0, parts: 0, velocities });
        }
    });
}
