//! The messages on the wire: mirrors of `msg/*.msg` and of the few standard types that carom uses.
//!
//! Fields stand in the order of the .msg files, which a test compares; there each has its unit and
//! frame. Nothing here computes.
#![allow(missing_docs, reason = "each field is documented in its .msg file")]

use serde::{Deserialize, Serialize};

/// builtin_interfaces/msg/Time
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Time {
    pub sec: i32,
    pub nanosec: u32,
}

impl Time {
    /// In seconds.
    pub fn as_seconds(self) -> f64 {
        f64::from(self.sec) + f64::from(self.nanosec) * 1e-9
    }

    /// The nearest nanosecond; beyond the range of the message, its ends.
    pub fn from_seconds(seconds: f64) -> Self {
        let whole = seconds.floor();
        let nanosec = ((seconds - whole) * 1e9).round() as u32;
        let carry = nanosec / 1_000_000_000;
        Self { sec: (whole as i32).saturating_add(carry as i32), nanosec: nanosec % 1_000_000_000 }
    }
}

/// std_msgs/msg/Header
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    pub stamp: Time,
    pub frame_id: String,
}

/// geometry_msgs/msg/Vector3
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Vector3 {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

/// geometry_msgs/msg/Twist
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    pub linear: Vector3,
    pub angular: Vector3,
}

/// geometry_msgs/msg/Quaternion
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub w: f64,
}

impl Quaternion {
    /// No rotation.
    pub const UPRIGHT: Self = Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 };
}

/// geometry_msgs/msg/Pose; its Point has the layout of Vector3.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    pub position: Vector3,
    pub orientation: Quaternion,
}

/// geometry_msgs/msg/TwistStamped
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TwistStamped {
    pub header: Header,
    pub twist: Twist,
}

/// geometry_msgs/msg/PoseWithCovariance; the covariance row by row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseWithCovariance {
    pub pose: Pose,
    pub covariance: [[f64; 6]; 6],
}

/// geometry_msgs/msg/TwistWithCovariance; the covariance row by row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TwistWithCovariance {
    pub twist: Twist,
    pub covariance: [[f64; 6]; 6],
}

/// nav_msgs/msg/Odometry
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Odometry {
    pub header: Header,
    pub child_frame_id: String,
    pub pose: PoseWithCovariance,
    pub twist: TwistWithCovariance,
}

/// rosgraph_msgs/msg/Clock
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Clock {
    pub clock: Time,
}

/// carom/msg/CircleState
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CircleState {
    pub id: u32,
    pub x: f64,
    pub y: f64,
    pub vx: f64,
    pub vy: f64,
    pub radius: f64,
    pub mass: f64,
}

/// carom/msg/CircleStates
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CircleStates {
    pub header: Header,
    pub part: u32,
    pub parts: u32,
    pub circles: Vec<CircleState>,
}

/// carom/msg/CircleVelocity
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CircleVelocity {
    pub id: u32,
    pub vx: f64,
    pub vy: f64,
}

/// carom/msg/CircleVelocities
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CircleVelocities {
    pub header: Header,
    pub part: u32,
    pub parts: u32,
    pub velocities: Vec<CircleVelocity>,
}

/// carom/msg/Contact
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    pub a: u32,
    pub b: u32,
    pub point_x: f64,
    pub point_y: f64,
    pub normal_x: f64,
    pub normal_y: f64,
    pub gap: f64,
    pub approach_speed: f64,
    pub impulse: f64,
    pub energy_loss: f64,
    pub time: f64,
}

impl Contact {
    /// The value of `b` where `a` has hit a wall.
    pub const WALL: u32 = 4_294_967_295;
}

/// carom/msg/Contacts
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Contacts {
    pub header: Header,
    pub part: u32,
    pub parts: u32,
    pub contacts: Vec<Contact>,
}

/// carom/msg/Crash
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Crash {
    pub a: u32,
    pub b: u32,
    pub speed_a: f64,
    pub speed_b: f64,
    pub approach_speed: f64,
    pub fault_a: bool,
    pub fault_b: bool,
    pub point_x: f64,
    pub point_y: f64,
    pub time: f64,
}

/// carom/msg/Crashes
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Crashes {
    pub header: Header,
    pub part: u32,
    pub parts: u32,
    pub crashes: Vec<Crash>,
}

/// carom/msg/ErrorReport
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorReport {
    pub header: Header,
    pub method: String,
    pub steps: u64,
    pub step_mean_s: f64,
    pub step_p99_s: f64,
    pub step_max_s: f64,
    pub contacts_per_second: f64,
    pub real_time_factor_asked: f64,
    pub real_time_factor: f64,
    pub energy: f64,
    pub relative_energy_drift: f64,
    pub momentum_drift: f64,
    pub largest_overlap: f64,
    pub refused_causes: Vec<String>,
    pub refused_counts: Vec<u64>,
    pub dropped_in: u64,
    pub dropped_out: u64,
    pub left_out: Vec<String>,
}

/// std_msgs/msg/ColorRGBA
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ColorRgba {
    pub r: f32,
    pub g: f32,
    pub b: f32,
    pub a: f32,
}

/// builtin_interfaces/msg/Duration
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Duration {
    pub sec: i32,
    pub nanosec: u32,
}

/// sensor_msgs/msg/CompressedImage
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CompressedImage {
    pub header: Header,
    pub format: String,
    pub data: Vec<u8>,
}

/// visualization_msgs/msg/UVCoordinate
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct UvCoordinate {
    pub u: f32,
    pub v: f32,
}

/// visualization_msgs/msg/MeshFile
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MeshFile {
    pub filename: String,
    pub data: Vec<u8>,
}

/// visualization_msgs/msg/Marker; `kind` is its field `type`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Marker {
    pub header: Header,
    pub ns: String,
    pub id: i32,
    pub kind: i32,
    pub action: i32,
    pub pose: Pose,
    pub scale: Vector3,
    pub color: ColorRgba,
    pub lifetime: Duration,
    pub frame_locked: bool,
    pub points: Vec<Vector3>,
    pub colors: Vec<ColorRgba>,
    pub texture_resource: String,
    pub texture: CompressedImage,
    pub uv_coordinates: Vec<UvCoordinate>,
    pub text: String,
    pub mesh_resource: String,
    pub mesh_file: MeshFile,
    pub mesh_use_embedded_materials: bool,
}

/// Values of the type of a marker.
pub mod marker_type {
    pub const CYLINDER: i32 = 3;
    pub const LINE_STRIP: i32 = 4;
    pub const LINE_LIST: i32 = 5;
    pub const SPHERE_LIST: i32 = 7;
}

/// Values of the action of a marker.
pub mod marker_action {
    pub const ADD: i32 = 0;
    pub const DELETE: i32 = 2;
}

/// visualization_msgs/msg/MarkerArray
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MarkerArray {
    pub markers: Vec<Marker>,
}

/// diagnostic_msgs/msg/KeyValue
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeyValue {
    pub key: String,
    pub value: String,
}

/// diagnostic_msgs/msg/DiagnosticStatus
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DiagnosticStatus {
    pub level: u8,
    pub name: String,
    pub message: String,
    pub hardware_id: String,
    pub values: Vec<KeyValue>,
}

impl DiagnosticStatus {
    /// The value of `level` where all is well.
    pub const OK: u8 = 0;
    /// The value of `level` where something is not as it was asked for.
    pub const WARN: u8 = 1;
}

/// diagnostic_msgs/msg/DiagnosticArray
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DiagnosticArray {
    pub header: Header,
    pub status: Vec<DiagnosticStatus>,
}

/// robocup_ssl_msgs/msg/Vector2
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlaneVector {
    pub x: f32,
    pub y: f32,
}

/// robocup_ssl_msgs/msg/Vector3
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SpaceVector {
    pub x: f32,
    pub y: f32,
    pub z: f32,
}

/// robocup_ssl_msgs/msg/RobotId
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RobotId {
    pub id: u32,
    pub team_color: u32,
}

impl RobotId {
    /// The value of `team_color` of the yellow team.
    pub const YELLOW: u32 = 1;
    /// The value of `team_color` of the blue team.
    pub const BLUE: u32 = 2;
}

/// robocup_ssl_msgs/msg/TrackedBall; what may be missing is a list of one at most.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrackedBall {
    pub pos: SpaceVector,
    pub vel: Vec<SpaceVector>,
    pub visibility: Vec<f32>,
}

/// robocup_ssl_msgs/msg/TrackedRobot; what may be missing is a list of one at most.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrackedRobot {
    pub robot_id: RobotId,
    pub pos: PlaneVector,
    pub orientation: f32,
    pub vel: Vec<PlaneVector>,
    pub vel_angular: Vec<f32>,
    pub visibility: Vec<f32>,
}

/// robocup_ssl_msgs/msg/KickedBall; what may be missing is a list of one at most.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct KickedBall {
    pub pos: PlaneVector,
    pub vel: SpaceVector,
    pub start_timestamp: f64,
    pub stop_timestamp: Vec<f64>,
    pub stop_pos: Vec<PlaneVector>,
    pub robot_id: Vec<RobotId>,
}

/// robocup_ssl_msgs/msg/TrackedFrame; what may be missing is a list of one at most.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrackedFrame {
    pub frame_number: u32,
    pub timestamp: f64,
    pub balls: Vec<TrackedBall>,
    pub robots: Vec<TrackedRobot>,
    pub kicked_ball: Vec<KickedBall>,
    pub capabilities: Vec<u32>,
}

/// geometry_msgs/msg/Accel
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Accel {
    pub linear: Vector3,
    pub angular: Vector3,
}

/// ateam_msgs/msg/VisionStateBall
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct VisionStateBall {
    pub pose: Pose,
    pub twist: Twist,
    pub accel: Accel,
    pub visible: bool,
}

/// ateam_msgs/msg/VisionStateRobot
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct VisionStateRobot {
    pub pose: Pose,
    pub twist: Twist,
    pub twist_body: Twist,
    pub accel: Accel,
    pub visible: bool,
}
