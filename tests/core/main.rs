//! Tests of everything but the node: laws first, then judges, then golden values.

mod common;
mod detect;
mod exact;
mod house;
mod invariance;
mod messages;
mod motion;
mod receive;
mod resolve;
mod scene;
mod springs;
mod steps;
mod world;
