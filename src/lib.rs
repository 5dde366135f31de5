//! Collisions between circles in the plane: exact, fast, honest.
//!
//! The path of a message, which is also the order of the rooms:
//!
//! ```text
//! topics -> receive -> world.step: apply -> detect -> resolve -> advance -> publish -> topics
//!             |          |                    |          |          |          |
//!      messages become   the nouns, and   what touches,  the pair   motion:   results
//!      commands, or a    the one page     and when       law        an arena  become
//!      refusal           that steps                                 moves on  messages
//! ```
//!
//! | room | holds |
//! |---|---|
//! | [`messages`] | mirrors of `msg/*.msg` |
//! | [`receive`] | messages to reports and commands |
//! | [`world`] | the nouns, the limits, [`World::step`](world::World::step) |
//! | [`detect`] | touching now, touching when |
//! | [`resolve`] | the pair law, walls, many contacts at once |
//! | [`motion`] | the methods that advance an arena |
//! | [`referee`] | which collisions of robots are crashes, and whose fault |
//! | [`plan`] | what a scene needs, and what is left out |
//! | [`publish`] | results to messages |
//! | [`scene`] | YAML scenes, random pucks from a seed |
//! | [`check`] | the reference cases: by how much they pass |
//! | [`mod@bench`] | one measured run, whose physics is checked before its time is told |
//! | [`audit`] | the collisions of any simulator, judged from its recording |
//! | `report` | error against run time: CSV, plots, one HTML page (feature `report`) |
//! | `bag` | recordings of topics, read and written (feature `bags`) |
//! | `wire` | robot soccer on its leagues' own protocols (feature `wire`) |
//! | [`exact`] | error-free arithmetic, under all of the above |
//! | `node` | the ROS 2 node; the only room that names a ROS crate (feature `ros`) |
//!
//! All but the node knows no ROS and no topic; only the node and the stopwatches of [`check`] and
//! [`mod@bench`] read a clock. Units are SI, vectors are in one fixed frame.
#![warn(missing_docs)]
#![deny(unsafe_code)]

pub mod messages;

pub mod receive;

pub mod world;

pub mod detect;

pub mod resolve;

pub mod motion;

pub mod referee;

pub mod plan;

pub mod publish;

pub mod scene;

pub mod check;

pub mod bench;

pub mod audit;

#[cfg(feature = "report")]
pub mod report;

#[cfg(feature = "bags")]
pub mod bag;

#[cfg(feature = "wire")]
pub mod wire;

pub mod exact;

#[cfg(feature = "ros")]
pub mod node;
