//! The SSL simulation protocol: commands to a simulator and to robots, and what they answer.
//!
//! Definitions alone; `control`, `robots` and `specs` say what carom makes of them.

use super::{Any, RobotId};

/// An error, for programs and for people.
#[derive(Clone, PartialEq, prost::Message)]
pub struct SimulatorError {
    #[prost(string, optional, tag = "1")]
    pub code: Option<String>,
    #[prost(string, optional, tag = "2")]
    pub message: Option<String>,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct TeleportBall {
    #[prost(float, optional, tag = "1")]
    pub x: Option<f32>,
    #[prost(float, optional, tag = "2")]
    pub y: Option<f32>,
    #[prost(float, optional, tag = "3")]
    pub z: Option<f32>,
    #[prost(float, optional, tag = "4")]
    pub vx: Option<f32>,
    #[prost(float, optional, tag = "5")]
    pub vy: Option<f32>,
    #[prost(float, optional, tag = "6")]
    pub vz: Option<f32>,
    #[prost(bool, optional, tag = "7")]
    pub teleport_safely: Option<bool>,
    #[prost(bool, optional, tag = "8")]
    pub roll: Option<bool>,
    #[prost(bool, optional, tag = "9")]
    pub by_force: Option<bool>,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct TeleportRobot {
    #[prost(message, optional, tag = "1")]
    pub id: Option<RobotId>,
    #[prost(float, optional, tag = "2")]
    pub x: Option<f32>,
    #[prost(float, optional, tag = "3")]
    pub y: Option<f32>,
    #[prost(float, optional, tag = "4")]
    pub orientation: Option<f32>,
    #[prost(float, optional, tag = "5")]
    pub v_x: Option<f32>,
    #[prost(float, optional, tag = "6")]
    pub v_y: Option<f32>,
    #[prost(float, optional, tag = "7")]
    pub v_angular: Option<f32>,
    #[prost(bool, optional, tag = "8")]
    pub present: Option<bool>,
    #[prost(bool, optional, tag = "9")]
    pub by_force: Option<bool>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct SimulatorControl {
    #[prost(message, optional, tag = "1")]
    pub teleport_ball: Option<TeleportBall>,
    #[prost(message, repeated, tag = "2")]
    pub teleport_robot: Vec<TeleportRobot>,
    #[prost(float, optional, tag = "3")]
    pub simulation_speed: Option<f32>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct SimulatorCommand {
    #[prost(message, optional, tag = "1")]
    pub control: Option<SimulatorControl>,
    #[prost(message, optional, tag = "2")]
    pub config: Option<SimulatorConfig>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct SimulatorResponse {
    #[prost(message, repeated, tag = "1")]
    pub errors: Vec<SimulatorError>,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct RobotLimits {
    #[prost(float, optional, tag = "1")]
    pub acc_speedup_absolute_max: Option<f32>,
    #[prost(float, optional, tag = "2")]
    pub acc_speedup_angular_max: Option<f32>,
    #[prost(float, optional, tag = "3")]
    pub acc_brake_absolute_max: Option<f32>,
    #[prost(float, optional, tag = "4")]
    pub acc_brake_angular_max: Option<f32>,
    #[prost(float, optional, tag = "5")]
    pub vel_absolute_max: Option<f32>,
    #[prost(float, optional, tag = "6")]
    pub vel_angular_max: Option<f32>,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct RobotWheelAngles {
    #[prost(float, optional, tag = "1")]
    pub front_right: Option<f32>,
    #[prost(float, optional, tag = "2")]
    pub back_right: Option<f32>,
    #[prost(float, optional, tag = "3")]
    pub back_left: Option<f32>,
    #[prost(float, optional, tag = "4")]
    pub front_left: Option<f32>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct RobotSpecs {
    #[prost(message, optional, tag = "1")]
    pub id: Option<RobotId>,
    #[prost(float, optional, tag = "2")]
    pub radius: Option<f32>,
    #[prost(float, optional, tag = "3")]
    pub height: Option<f32>,
    #[prost(float, optional, tag = "4")]
    pub mass: Option<f32>,
    #[prost(float, optional, tag = "7")]
    pub max_linear_kick_speed: Option<f32>,
    #[prost(float, optional, tag = "8")]
    pub max_chip_kick_speed: Option<f32>,
    #[prost(float, optional, tag = "9")]
    pub center_to_dribbler: Option<f32>,
    #[prost(message, optional, tag = "10")]
    pub limits: Option<RobotLimits>,
    #[prost(message, optional, tag = "13")]
    pub wheel_angles: Option<RobotWheelAngles>,
    #[prost(message, repeated, tag = "14")]
    pub custom: Vec<Any>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct RealismConfig {
    #[prost(message, repeated, tag = "1")]
    pub custom: Vec<Any>,
}

/// The realism of the ER-Force simulator, as teams send it.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct RealismConfigErForce {
    #[prost(float, optional, tag = "1")]
    pub stddev_ball_p: Option<f32>,
    #[prost(float, optional, tag = "2")]
    pub stddev_robot_p: Option<f32>,
    #[prost(float, optional, tag = "3")]
    pub stddev_robot_phi: Option<f32>,
    #[prost(float, optional, tag = "4")]
    pub stddev_ball_area: Option<f32>,
    #[prost(bool, optional, tag = "5")]
    pub enable_invisible_ball: Option<bool>,
    #[prost(float, optional, tag = "6")]
    pub ball_visibility_threshold: Option<f32>,
    #[prost(float, optional, tag = "7")]
    pub camera_overlap: Option<f32>,
    #[prost(float, optional, tag = "8")]
    pub dribbler_ball_detections: Option<f32>,
    #[prost(float, optional, tag = "9")]
    pub camera_position_error: Option<f32>,
    #[prost(float, optional, tag = "10")]
    pub robot_command_loss: Option<f32>,
    #[prost(float, optional, tag = "11")]
    pub robot_response_loss: Option<f32>,
    #[prost(float, optional, tag = "12")]
    pub missing_ball_detections: Option<f32>,
    #[prost(int64, optional, tag = "13")]
    pub vision_delay: Option<i64>,
    #[prost(int64, optional, tag = "14")]
    pub vision_processing_time: Option<i64>,
    #[prost(bool, optional, tag = "15")]
    pub simulate_dribbling: Option<bool>,
}

/// The geometry is read by itself: what is wrong with it leaves the rest.
#[derive(Clone, PartialEq, prost::Message)]
pub struct SimulatorConfig {
    #[prost(bytes = "vec", optional, tag = "1")]
    pub geometry: Option<Vec<u8>>,
    #[prost(message, repeated, tag = "2")]
    pub robot_specs: Vec<RobotSpecs>,
    #[prost(message, optional, tag = "3")]
    pub realism_config: Option<RealismConfig>,
    #[prost(uint32, optional, tag = "4")]
    pub vision_port: Option<u32>,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct MoveWheelVelocity {
    #[prost(float, optional, tag = "1")]
    pub front_right: Option<f32>,
    #[prost(float, optional, tag = "2")]
    pub back_right: Option<f32>,
    #[prost(float, optional, tag = "3")]
    pub back_left: Option<f32>,
    #[prost(float, optional, tag = "4")]
    pub front_left: Option<f32>,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct MoveLocalVelocity {
    #[prost(float, optional, tag = "1")]
    pub forward: Option<f32>,
    #[prost(float, optional, tag = "2")]
    pub left: Option<f32>,
    #[prost(float, optional, tag = "3")]
    pub angular: Option<f32>,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct MoveGlobalVelocity {
    #[prost(float, optional, tag = "1")]
    pub x: Option<f32>,
    #[prost(float, optional, tag = "2")]
    pub y: Option<f32>,
    #[prost(float, optional, tag = "3")]
    pub angular: Option<f32>,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct RobotMoveCommand {
    #[prost(oneof = "Move", tags = "1, 2, 3")]
    pub command: Option<Move>,
}

/// One of three ways to say how a robot shall move.
#[derive(Clone, Copy, PartialEq, prost::Oneof)]
pub enum Move {
    #[prost(message, tag = "1")]
    WheelVelocity(MoveWheelVelocity),
    #[prost(message, tag = "2")]
    LocalVelocity(MoveLocalVelocity),
    #[prost(message, tag = "3")]
    GlobalVelocity(MoveGlobalVelocity),
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct RobotCommand {
    #[prost(uint32, optional, tag = "1")]
    pub id: Option<u32>,
    #[prost(message, optional, tag = "2")]
    pub move_command: Option<RobotMoveCommand>,
    #[prost(float, optional, tag = "3")]
    pub kick_speed: Option<f32>,
    #[prost(float, optional, tag = "4")]
    pub kick_angle: Option<f32>,
    #[prost(float, optional, tag = "5")]
    pub dribbler_speed: Option<f32>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct RobotControl {
    #[prost(message, repeated, tag = "1")]
    pub robot_commands: Vec<RobotCommand>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct RobotFeedback {
    #[prost(uint32, required, tag = "1")]
    pub id: u32,
    #[prost(bool, optional, tag = "2")]
    pub dribbler_ball_contact: Option<bool>,
    #[prost(message, optional, tag = "3")]
    pub custom: Option<Any>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct RobotControlResponse {
    #[prost(message, repeated, tag = "1")]
    pub errors: Vec<SimulatorError>,
    #[prost(message, repeated, tag = "2")]
    pub feedback: Vec<RobotFeedback>,
}
