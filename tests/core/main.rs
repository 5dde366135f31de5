//! Tests of everything but the node: laws first, then judges, then golden values.

mod common;
mod detect;
mod drag;
mod events;
mod exact;
mod gravity;
mod gravity_events;
mod house;
mod invariance;
mod messages;
mod methods;
mod motion;
mod near;
mod periodic;
mod plan;
mod precise;
mod receive;
mod resolve;
mod scene;
mod sizes;
mod springs;
mod steps;
mod ticks;
mod world;
