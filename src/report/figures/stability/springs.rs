//! What explicit integrators make of a contact with a spring and a dashpot, by step and damping:
//! runs in the arena of springs, beside the theoretical limit of the step.

use glam::DVec2;

use crate::motion::springs::integrators::spectral_radius;
use crate::motion::springs::{Ending, Explicit, Laws, Scheme, Springs, Stepping};
use crate::plan::BroadPhase;
use crate::world::Disc;

/// What became of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It is stable, and a blow gives the right restitution.
    Right = 0,
    /// It is stable, but a blow gives a wrong restitution.
    Wrong = 1,
    /// A disc that stays in contact moves ever more.
    BlowsUp = 2,
}

/// The outcomes in words, by number.
pub const NAMES: [&str; 3] = ["right restitution", "stable, wrong restitution", "blows up"];

/// How far the restitution may be off.
pub const TOLERANCE: f64 = 0.05;

/// Steps whose matrix is looked at.
const STEPS: u32 = 20;
/// The deviation at first, m and m/s, and how many times that is far.
const START: f64 = 1e-3;
const FAR: f64 = 1e4;

/// How a step of `h` fares where `omega0` is 1/s and `beta` is the damping, 1/s; blows begin at so
/// many places within a step.
pub fn outcome(rule: Explicit, h: f64, beta: f64, phases: u32) -> Outcome {
    if blows_up(rule, h, beta) {
        return Outcome::BlowsUp;
    }
    let exact = restitution(beta);
    let off = |phase: u32| {
        let part = (f64::from(phase) + 0.5) / f64::from(phases);
        blow(rule, h, beta, part).is_none_or(|e| (e - exact).abs() > TOLERANCE)
    };
    if (0..phases).any(off) { Outcome::Wrong } else { Outcome::Right }
}

fn stepping(rule: Explicit, step: f64) -> Stepping {
    Stepping {
        step,
        scheme: Scheme::Explicit(rule),
        refuse_unstable: false,
        broad_phase: BroadPhase::AllPairs,
    }
}

fn disc(id: u32, x: f64, v: f64, radius: f64, mass: f64) -> Disc {
    let (position, velocity) = (DVec2::new(x, 0.0), DVec2::new(v, 0.0));
    Disc { id, position, velocity, radius, mass }
}

/// Whether a disc squeezed between two fixed ones, so that it stays in contact, moves ever more:
/// what some steps in the arena make of two deviations is a matrix, and its largest eigenvalue is
/// above 1.
pub fn blows_up(rule: Explicit, h: f64, beta: f64) -> bool {
    let from = |x: f64, v: f64| after_some_steps(rule, h, beta, [x, v]);
    let (Some(first), Some(second)) = (from(START, 0.0), from(0.0, START)) else { return true };
    spectral_radius(first, second) > START * (1.0 + 1e-10)
}

/// Place and velocity of the disc after some steps; `None` when it has gone far.
fn after_some_steps(rule: Explicit, h: f64, beta: f64, start: [f64; 2]) -> Option<[f64; 2]> {
    // Two springs of half the stiffness, two dashpots of half the constant: omega0 = 1/s.
    let laws = Laws { stiffness: 0.5, damping: beta, ending: Ending::OverlapGone, walls: None };
    let discs = [
        disc(0, start[0], start[1], 64.0, 1.0),
        disc(1, -96.0, 0.0, 64.0, f64::INFINITY),
        disc(2, 96.0, 0.0, 64.0, f64::INFINITY),
    ];
    let mut arena = Springs::new(laws, &discs, stepping(rule, h)).ok()?;
    for step in 1..=STEPS {
        let until = h * f64::from(step);
        while arena.now() < until {
            arena.advance(until, &mut Vec::new()).ok()?;
        }
        let squeezed = arena.discs().next()?;
        let now = [squeezed.position.x, squeezed.velocity.x];
        let size = now[0].hypot(now[1]);
        if size.is_nan() || size > FAR * START {
            return None;
        }
        if step == STEPS {
            return Some(now);
        }
    }
    None
}

/// Restitution of a blow that begins at this part of a step; `None` if it does not end.
fn blow(rule: Explicit, h: f64, beta: f64, part: f64) -> Option<f64> {
    // Masses of 2 kg each: omega0 = 1/s again, at closing speed 1 m/s.
    let laws =
        Laws { stiffness: 1.0, damping: 2.0 * beta, ending: Ending::NoAttraction, walls: None };
    let gap = part * h;
    let discs = [disc(0, 0.0, 0.5, 1.0, 2.0), disc(1, 2.0 + gap, -0.5, 1.0, 2.0)];
    let mut arena = Springs::new(laws, &discs, stepping(rule, h)).ok()?;
    let until = gap + 1.5 * contact_time(beta) + 4.0 * h;
    while arena.now() < until {
        arena.advance(until, &mut Vec::new()).ok()?;
    }
    let discs: Vec<Disc> = arena.discs().collect();
    let speed = discs[1].velocity.x - discs[0].velocity.x;
    (speed > 0.0).then_some(speed)
}

/// How long a blow lasts until the force would become attractive, s, with `omega0 = 1/s`:
/// `tan(omega t) = 2 beta omega / (beta^2 - omega^2)`, overdamped
/// `t = ln((beta + Omega) / (beta - Omega)) / Omega` (cf. Schwager, Poschel,
/// doi:10.1007/s10035-007-0065-z).
fn contact_time(beta: f64) -> f64 {
    let squared = (1.0 - beta) * (1.0 + beta);
    if squared > 0.0 {
        let omega = squared.sqrt();
        return (2.0 * beta * omega).atan2(beta * beta - squared) / omega;
    }
    let rate = (-squared).sqrt();
    // beta - Omega is a difference of near numbers, its inverse is not.
    if rate > 0.0 { 2.0 * (beta + rate).ln() / rate } else { 2.0 }
}

/// Restitution of such a blow: `exp(-beta t)`.
pub fn restitution(beta: f64) -> f64 {
    (-beta * contact_time(beta)).exp()
}
