//! What SSL trackers tell: positions with velocities, in metres.
//!
//! Definitions alone; `tracked` fills them.

use super::RobotId;

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Vector2 {
    #[prost(float, required, tag = "1")]
    pub x: f32,
    #[prost(float, required, tag = "2")]
    pub y: f32,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Vector3 {
    #[prost(float, required, tag = "1")]
    pub x: f32,
    #[prost(float, required, tag = "2")]
    pub y: f32,
    #[prost(float, required, tag = "3")]
    pub z: f32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, prost::Enumeration)]
#[repr(i32)]
pub enum Capability {
    Unknown = 0,
    DetectFlyingBalls = 1,
    DetectMultipleBalls = 2,
    DetectKickedBalls = 3,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct TrackedBall {
    #[prost(message, required, tag = "1")]
    pub pos: Vector3,
    #[prost(message, optional, tag = "2")]
    pub vel: Option<Vector3>,
    #[prost(float, optional, tag = "3")]
    pub visibility: Option<f32>,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct TrackedRobot {
    #[prost(message, required, tag = "1")]
    pub robot_id: RobotId,
    #[prost(message, required, tag = "2")]
    pub pos: Vector2,
    #[prost(float, required, tag = "3")]
    pub orientation: f32,
    #[prost(message, optional, tag = "4")]
    pub vel: Option<Vector2>,
    #[prost(float, optional, tag = "5")]
    pub vel_angular: Option<f32>,
    #[prost(float, optional, tag = "6")]
    pub visibility: Option<f32>,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct KickedBall {
    #[prost(message, required, tag = "1")]
    pub pos: Vector2,
    #[prost(message, required, tag = "2")]
    pub vel: Vector3,
    #[prost(double, required, tag = "3")]
    pub start_timestamp: f64,
    #[prost(double, optional, tag = "4")]
    pub stop_timestamp: Option<f64>,
    #[prost(message, optional, tag = "5")]
    pub stop_pos: Option<Vector2>,
    #[prost(message, optional, tag = "6")]
    pub robot_id: Option<RobotId>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct TrackedFrame {
    #[prost(uint32, required, tag = "1")]
    pub frame_number: u32,
    #[prost(double, required, tag = "2")]
    pub timestamp: f64,
    #[prost(message, repeated, tag = "3")]
    pub balls: Vec<TrackedBall>,
    #[prost(message, repeated, tag = "4")]
    pub robots: Vec<TrackedRobot>,
    #[prost(message, optional, tag = "5")]
    pub kicked_ball: Option<KickedBall>,
    #[prost(enumeration = "Capability", repeated, packed = "false", tag = "6")]
    pub capabilities: Vec<i32>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct TrackerWrapperPacket {
    #[prost(string, required, tag = "1")]
    pub uuid: String,
    #[prost(string, optional, tag = "2")]
    pub source_name: Option<String>,
    #[prost(message, optional, tag = "3")]
    pub tracked_frame: Option<TrackedFrame>,
}
