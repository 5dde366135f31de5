//! grSim's older packets, which some teams still send: commands of one team, and replacements; and
//! the status of robots that it sends back.
//!
//! Definitions alone; `grsim` reads and fills them.

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct GrSimRobotCommand {
    #[prost(uint32, optional, tag = "1")]
    pub id: Option<u32>,
    #[prost(float, optional, tag = "2")]
    pub kickspeedx: Option<f32>,
    #[prost(float, optional, tag = "3")]
    pub kickspeedz: Option<f32>,
    #[prost(float, optional, tag = "4")]
    pub veltangent: Option<f32>,
    #[prost(float, optional, tag = "5")]
    pub velnormal: Option<f32>,
    #[prost(float, optional, tag = "6")]
    pub velangular: Option<f32>,
    #[prost(bool, optional, tag = "7")]
    pub spinner: Option<bool>,
    #[prost(bool, optional, tag = "8")]
    pub wheelsspeed: Option<bool>,
    #[prost(float, optional, tag = "9")]
    pub wheel1: Option<f32>,
    #[prost(float, optional, tag = "10")]
    pub wheel2: Option<f32>,
    #[prost(float, optional, tag = "11")]
    pub wheel3: Option<f32>,
    #[prost(float, optional, tag = "12")]
    pub wheel4: Option<f32>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct GrSimCommands {
    #[prost(double, optional, tag = "1")]
    pub timestamp: Option<f64>,
    #[prost(bool, optional, tag = "2")]
    pub isteamyellow: Option<bool>,
    #[prost(message, repeated, tag = "3")]
    pub robot_commands: Vec<GrSimRobotCommand>,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct GrSimRobotReplacement {
    #[prost(double, optional, tag = "1")]
    pub x: Option<f64>,
    #[prost(double, optional, tag = "2")]
    pub y: Option<f64>,
    #[prost(double, optional, tag = "3")]
    pub dir: Option<f64>,
    #[prost(uint32, optional, tag = "4")]
    pub id: Option<u32>,
    #[prost(bool, optional, tag = "5")]
    pub yellowteam: Option<bool>,
    #[prost(bool, optional, tag = "6")]
    pub turnon: Option<bool>,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct GrSimBallReplacement {
    #[prost(double, optional, tag = "1")]
    pub x: Option<f64>,
    #[prost(double, optional, tag = "2")]
    pub y: Option<f64>,
    #[prost(double, optional, tag = "3")]
    pub vx: Option<f64>,
    #[prost(double, optional, tag = "4")]
    pub vy: Option<f64>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct GrSimReplacement {
    #[prost(message, optional, tag = "1")]
    pub ball: Option<GrSimBallReplacement>,
    #[prost(message, repeated, tag = "2")]
    pub robots: Vec<GrSimRobotReplacement>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct GrSimPacket {
    #[prost(message, optional, tag = "1")]
    pub commands: Option<GrSimCommands>,
    #[prost(message, optional, tag = "2")]
    pub replacement: Option<GrSimReplacement>,
}

#[derive(Clone, Copy, PartialEq, Eq, prost::Message)]
pub struct RobotStatus {
    #[prost(int32, required, tag = "1")]
    pub robot_id: i32,
    #[prost(bool, required, tag = "2")]
    pub infrared: bool,
    #[prost(bool, required, tag = "3")]
    pub flat_kick: bool,
    #[prost(bool, required, tag = "4")]
    pub chip_kick: bool,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct RobotsStatus {
    #[prost(message, repeated, tag = "1")]
    pub robots_status: Vec<RobotStatus>,
}
