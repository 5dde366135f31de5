//! The leagues' messages, with the names and field numbers of their published definitions.
//!
//! What a definition requires is required here where carom sends it, so that it is on the wire even
//! if it is 0; where carom hears it, it is optional, so that its absence is seen and told. Nothing
//! here computes, and no text of the definitions is repeated: names and numbers only.
#![allow(missing_docs, reason = "each field is documented in the published definitions")]

/// VSSS, as FIRASim has it: messages of `fira_message` and `fira_message.sim_to_ref`.
pub mod fira;
/// SSL: the older packets of grSim.
pub mod grsim;
/// SSL: the simulation protocol.
pub mod simulation;
/// SSL: what trackers tell.
pub mod tracked;
/// SSL: what cameras see, and the field.
pub mod vision;

/// Any message, with its name: `google.protobuf.Any`.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Any {
    #[prost(string, tag = "1")]
    pub type_url: String,
    #[prost(bytes = "vec", tag = "2")]
    pub value: Vec<u8>,
}

/// The number of a robot and its team.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct RobotId {
    #[prost(uint32, optional, tag = "1")]
    pub id: Option<u32>,
    #[prost(enumeration = "Team", optional, tag = "2")]
    pub team: Option<i32>,
}

/// Which team.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, prost::Enumeration)]
#[repr(i32)]
pub enum Team {
    Unknown = 0,
    Yellow = 1,
    Blue = 2,
}
