//! What SSL cameras see, in millimetres, and the field that they look at.
//!
//! Definitions alone; `vision` and `geometry` fill them.

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct SslDetectionBall {
    #[prost(float, required, tag = "1")]
    pub confidence: f32,
    #[prost(uint32, optional, tag = "2")]
    pub area: Option<u32>,
    #[prost(float, required, tag = "3")]
    pub x: f32,
    #[prost(float, required, tag = "4")]
    pub y: f32,
    #[prost(float, optional, tag = "5")]
    pub z: Option<f32>,
    #[prost(float, required, tag = "6")]
    pub pixel_x: f32,
    #[prost(float, required, tag = "7")]
    pub pixel_y: f32,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct SslDetectionRobot {
    #[prost(float, required, tag = "1")]
    pub confidence: f32,
    #[prost(uint32, optional, tag = "2")]
    pub robot_id: Option<u32>,
    #[prost(float, required, tag = "3")]
    pub x: f32,
    #[prost(float, required, tag = "4")]
    pub y: f32,
    #[prost(float, optional, tag = "5")]
    pub orientation: Option<f32>,
    #[prost(float, required, tag = "6")]
    pub pixel_x: f32,
    #[prost(float, required, tag = "7")]
    pub pixel_y: f32,
    #[prost(float, optional, tag = "8")]
    pub height: Option<f32>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct SslDetectionFrame {
    #[prost(uint32, required, tag = "1")]
    pub frame_number: u32,
    #[prost(double, required, tag = "2")]
    pub t_capture: f64,
    #[prost(double, required, tag = "3")]
    pub t_sent: f64,
    #[prost(uint32, required, tag = "4")]
    pub camera_id: u32,
    #[prost(message, repeated, tag = "5")]
    pub balls: Vec<SslDetectionBall>,
    #[prost(message, repeated, tag = "6")]
    pub robots_yellow: Vec<SslDetectionRobot>,
    #[prost(message, repeated, tag = "7")]
    pub robots_blue: Vec<SslDetectionRobot>,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Vector2f {
    #[prost(float, required, tag = "1")]
    pub x: f32,
    #[prost(float, required, tag = "2")]
    pub y: f32,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct SslFieldLineSegment {
    #[prost(string, required, tag = "1")]
    pub name: String,
    #[prost(message, required, tag = "2")]
    pub p1: Vector2f,
    #[prost(message, required, tag = "3")]
    pub p2: Vector2f,
    #[prost(float, required, tag = "4")]
    pub thickness: f32,
    #[prost(enumeration = "SslFieldShapeType", optional, tag = "5")]
    pub r#type: Option<i32>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct SslFieldCircularArc {
    #[prost(string, required, tag = "1")]
    pub name: String,
    #[prost(message, required, tag = "2")]
    pub center: Vector2f,
    #[prost(float, required, tag = "3")]
    pub radius: f32,
    #[prost(float, required, tag = "4")]
    pub a1: f32,
    #[prost(float, required, tag = "5")]
    pub a2: f32,
    #[prost(float, required, tag = "6")]
    pub thickness: f32,
    #[prost(enumeration = "SslFieldShapeType", optional, tag = "7")]
    pub r#type: Option<i32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, prost::Enumeration)]
#[repr(i32)]
pub enum SslFieldShapeType {
    Undefined = 0,
    CenterCircle = 1,
    TopTouchLine = 2,
    BottomTouchLine = 3,
    LeftGoalLine = 4,
    RightGoalLine = 5,
    HalfwayLine = 6,
    CenterLine = 7,
    LeftPenaltyStretch = 8,
    RightPenaltyStretch = 9,
    LeftFieldLeftPenaltyStretch = 10,
    LeftFieldRightPenaltyStretch = 11,
    RightFieldLeftPenaltyStretch = 12,
    RightFieldRightPenaltyStretch = 13,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct SslGeometryFieldSize {
    #[prost(int32, required, tag = "1")]
    pub field_length: i32,
    #[prost(int32, required, tag = "2")]
    pub field_width: i32,
    #[prost(int32, required, tag = "3")]
    pub goal_width: i32,
    #[prost(int32, required, tag = "4")]
    pub goal_depth: i32,
    #[prost(int32, required, tag = "5")]
    pub boundary_width: i32,
    #[prost(message, repeated, tag = "6")]
    pub field_lines: Vec<SslFieldLineSegment>,
    #[prost(message, repeated, tag = "7")]
    pub field_arcs: Vec<SslFieldCircularArc>,
    #[prost(int32, optional, tag = "8")]
    pub penalty_area_depth: Option<i32>,
    #[prost(int32, optional, tag = "9")]
    pub penalty_area_width: Option<i32>,
    #[prost(int32, optional, tag = "10")]
    pub center_circle_radius: Option<i32>,
    #[prost(int32, optional, tag = "11")]
    pub line_thickness: Option<i32>,
    #[prost(int32, optional, tag = "12")]
    pub goal_center_to_penalty_mark: Option<i32>,
    #[prost(int32, optional, tag = "13")]
    pub goal_height: Option<i32>,
    #[prost(float, optional, tag = "14")]
    pub ball_radius: Option<f32>,
    #[prost(float, optional, tag = "15")]
    pub max_robot_radius: Option<f32>,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct SslGeometryCameraCalibration {
    #[prost(uint32, required, tag = "1")]
    pub camera_id: u32,
    #[prost(float, required, tag = "2")]
    pub focal_length: f32,
    #[prost(float, required, tag = "3")]
    pub principal_point_x: f32,
    #[prost(float, required, tag = "4")]
    pub principal_point_y: f32,
    #[prost(float, required, tag = "5")]
    pub distortion: f32,
    #[prost(float, required, tag = "6")]
    pub q0: f32,
    #[prost(float, required, tag = "7")]
    pub q1: f32,
    #[prost(float, required, tag = "8")]
    pub q2: f32,
    #[prost(float, required, tag = "9")]
    pub q3: f32,
    #[prost(float, required, tag = "10")]
    pub tx: f32,
    #[prost(float, required, tag = "11")]
    pub ty: f32,
    #[prost(float, required, tag = "12")]
    pub tz: f32,
    #[prost(float, optional, tag = "13")]
    pub derived_camera_world_tx: Option<f32>,
    #[prost(float, optional, tag = "14")]
    pub derived_camera_world_ty: Option<f32>,
    #[prost(float, optional, tag = "15")]
    pub derived_camera_world_tz: Option<f32>,
    #[prost(uint32, optional, tag = "16")]
    pub pixel_image_width: Option<u32>,
    #[prost(uint32, optional, tag = "17")]
    pub pixel_image_height: Option<u32>,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct SslBallModelStraightTwoPhase {
    #[prost(double, required, tag = "1")]
    pub acc_slide: f64,
    #[prost(double, required, tag = "2")]
    pub acc_roll: f64,
    #[prost(double, required, tag = "3")]
    pub k_switch: f64,
}

/// Without the model of chipped balls, which do not fly here.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct SslGeometryModels {
    #[prost(message, optional, tag = "1")]
    pub straight_two_phase: Option<SslBallModelStraightTwoPhase>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct SslGeometryData {
    #[prost(message, required, tag = "1")]
    pub field: SslGeometryFieldSize,
    #[prost(message, repeated, tag = "2")]
    pub calib: Vec<SslGeometryCameraCalibration>,
    #[prost(message, optional, tag = "3")]
    pub models: Option<SslGeometryModels>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct SslWrapperPacket {
    #[prost(message, optional, tag = "1")]
    pub detection: Option<SslDetectionFrame>,
    #[prost(message, optional, tag = "2")]
    pub geometry: Option<SslGeometryData>,
}
