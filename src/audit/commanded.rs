//! Who is commanded in a bag: pucks of the recorded scene whose drive takes any velocity at once.
//!
//! A puck counts only if the bag holds a message of its `cmd_vel`: what is recorded without
//! commands is judged in full. Never judge anything here.

use super::recorded::Robot;
use crate::bag::read::{Bag, Topic};
use crate::scene::{Puck, Scene};
use crate::world::{DiscId, Drive};

/// The ids that the audit has for the pucks of this scene that take any velocity at once, and that
/// somebody commands.
pub(super) fn commanded(bag: &Bag, scene: &Scene, robots: &[Robot]) -> Vec<DiscId> {
    let pucks = scene.pucks.iter().filter(|puck| puck.driven && takes_any(&puck.drive));
    let commanded = pucks.filter(|puck| is_commanded(bag, puck));
    commanded.filter_map(|puck| audited_id(puck, robots)).collect()
}

/// Whether nothing bounds what a drive changes at once.
fn takes_any(drive: &Drive) -> bool {
    let braking = drive.braking_max.unwrap_or(drive.acceleration_max);
    drive.acceleration_max.is_infinite() || braking.is_infinite()
}

fn is_commanded(bag: &Bag, puck: &Puck) -> bool {
    let name = puck.topic("cmd_vel");
    let is_its = |topic: &Topic| is_under_some_node(&topic.name, &name);
    bag.topics().iter().filter(|topic| is_its(topic)).any(|topic| match topic.count {
        Some(count) => count > 0,
        None => bag.messages(|each| each == topic).flatten().next().is_some(),
    })
}

/// Whether a whole name is this relative one, in whatever namespace the node was.
fn is_under_some_node(whole: &str, relative: &str) -> bool {
    whole.strip_suffix(relative).is_some_and(|before| before.is_empty() || before.ends_with('/'))
}

/// Robots whose odometry is audited have ids of their own, in their order.
fn audited_id(puck: &Puck, robots: &[Robot]) -> Option<DiscId> {
    if robots.is_empty() {
        return Some(puck.disc.id);
    }
    let odometry = puck.topic("odom");
    let is_its =
        |robot: &Robot| robot.topics().iter().any(|topic| is_under_some_node(topic, &odometry));
    (0..).zip(robots).find(|(_, robot)| is_its(robot)).map(|(id, _)| id)
}
