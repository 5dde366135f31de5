//! Bags: recordings of ROS 2 topics, as `ros2 bag` makes and plays them.
//!
//! | file | holds |
//! |---|---|
//! | [`read`] | a bag as topics and messages, whatever it is stored in |
//! | [`decode`] | payloads to messages, and back |
//! | [`mod@write`] | a bag that `ros2 bag` accepts |
//! | [`definitions`], `standard` | what types are made of, and their hashes |
//! | [`qos`] | the quality of service of a topic, as bags write it down |
//! | [`offline`] | the resolver over a recording |
//! | [`journal`], [`verify`] | what a run depended on; whether it comes again bit by bit |
//! | `mcap_file`, `sqlite_file` | the two storages |
//! | `metadata` | the file `metadata.yaml` of a bag |
//! | `files` | the files of a bag, opened for reading only |
//!
//! What is read was written by others: every length in it is checked before it is believed, what is
//! damaged is named and left out, and no input is ever changed. Knows no ROS crate and no clock.

pub mod decode;
pub mod definitions;
pub mod journal;
pub mod offline;
pub mod qos;
pub mod read;
pub mod verify;
pub mod write;

mod fault;
mod files;
mod mcap_file;
mod metadata;
mod sqlite_file;
mod standard;

pub use fault::{BagError, Fault};
