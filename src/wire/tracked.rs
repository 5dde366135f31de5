//! Tracked frames: places with velocities, in metres, as a tracker tells them.
//!
//! carom need not track: it knows. Of a kicked ball it tells where it will stop by the closed form
//! of its motion, as long as nobody is in the way.

use prost::Message;

use super::proto::RobotId;
use super::proto::tracked::{
    Capability, KickedBall, TrackedBall, TrackedFrame, TrackedRobot, TrackerWrapperPacket, Vector2,
    Vector3,
};
use super::{Kicked, RobotName, Team, View, proto};
use glam::DVec2;

/// The name of the source.
pub const SOURCE_NAME: &str = "carom";

/// The frame of a view, seen at a time (s since the Unix epoch).
pub fn frame(view: &View, number: u32, timestamp: f64) -> TrackedFrame {
    let ball = view.ball.map(|(at, velocity)| TrackedBall {
        pos: space(at),
        vel: Some(space(velocity)),
        visibility: Some(1.0),
    });
    let robots = view.robots.iter().map(|robot| TrackedRobot {
        robot_id: id(robot.name),
        pos: plane(robot.position),
        orientation: robot.heading as f32,
        vel: Some(plane(robot.velocity)),
        vel_angular: Some(robot.turn as f32),
        visibility: Some(1.0),
    });
    TrackedFrame {
        frame_number: number,
        timestamp,
        balls: ball.into_iter().collect(),
        robots: robots.collect(),
        kicked_ball: view.kicked.map(|kick| kicked(&kick, timestamp - view.time)),
        capabilities: vec![Capability::DetectKickedBalls as i32],
    }
}

/// A kick, with the time (s since the Unix epoch) at which the simulation began.
fn kicked(kick: &Kicked, epoch: f64) -> KickedBall {
    KickedBall {
        pos: plane(kick.position),
        vel: space(kick.velocity),
        start_timestamp: epoch + kick.time,
        stop_timestamp: kick.stop.map(|(time, _)| epoch + time),
        stop_pos: kick.stop.map(|(_, place)| plane(place)),
        robot_id: kick.by.map(id),
    }
}

/// A frame as a datagram of the source with this id.
pub fn packet(uuid: &str, frame: TrackedFrame) -> Vec<u8> {
    TrackerWrapperPacket {
        uuid: uuid.to_owned(),
        source_name: Some(SOURCE_NAME.to_owned()),
        tracked_frame: Some(frame),
    }
    .encode_to_vec()
}

fn id(name: RobotName) -> RobotId {
    let team = match name.team {
        Team::Blue => proto::Team::Blue,
        Team::Yellow => proto::Team::Yellow,
    };
    RobotId { id: Some(name.number), team: Some(team as i32) }
}

fn plane(vector: DVec2) -> Vector2 {
    Vector2 { x: vector.x as f32, y: vector.y as f32 }
}

fn space(vector: DVec2) -> Vector3 {
    Vector3 { x: vector.x as f32, y: vector.y as f32, z: 0.0 }
}
