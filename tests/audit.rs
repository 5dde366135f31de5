//! The audit on recordings in memory: no false alarm, and every planted violation by its name.

#[path = "core/common.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod common;

#[path = "audit/recordings.rs"]
mod recordings;

#[path = "audit/clean.rs"]
mod clean;

#[path = "audit/planted.rs"]
mod planted;

#[path = "audit/noisy.rs"]
mod noisy;

#[path = "audit/leagues.rs"]
mod leagues;

use carom::audit::findings::{Collision, Findings};
use carom::audit::{Audit, Frame, Options};

fn audited(frames: Vec<Frame>, options: &Options) -> (Findings, Vec<Collision>) {
    let mut collisions = Vec::new();
    let mut audit = Audit::new(options.clone(), Box::new(|each| collisions.push(*each)));
    frames.into_iter().for_each(|frame| audit.hear(frame));
    let findings = audit.finish();
    (findings, collisions)
}
