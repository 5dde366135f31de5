//! The rows of the main plot: each method at each of its settings, its error and its time.
//!
//! Never a time of a run that was looked at: errors come from an untimed run, the same every time.

use super::super::mover::{self, Error, Mover};
use super::super::timing::Timing;
use super::super::turns::{Timed, in_turns};
#[cfg(feature = "peers")]
use super::peers::Peer;
use super::scene::Stretch;
use crate::bench::seconds;
use crate::report::Effort;
use crate::world::Disc;

/// An exact method is wrong if it is off by more than so many roundings at the start.
const ROUNDINGS_MOST: f64 = 1e3;

/// Largest relative error of the energy that an exact method may have.
const ENERGY_ERROR_MAX: f64 = 1e-12;

/// Who moves the gas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Who {
    /// carom.
    Own(Mover),
    /// Another engine.
    #[cfg(feature = "peers")]
    Peer(Peer),
}

impl Who {
    /// The curve it belongs to.
    pub fn curve(self) -> &'static str {
        match self {
            Self::Own(Mover::Events) => "events (exact)",
            Self::Own(Mover::Plain) => "plain (exact)",
            Self::Own(Mover::Ticks(_)) => "ticks (exact)",
            Self::Own(Mover::Steps(_)) => "steps",
            Self::Own(Mover::Springs { step, .. }) if step == SPRING_STEP => {
                "springs, by stiffness"
            }
            Self::Own(Mover::Springs { .. }) => "springs, by step",
            #[cfg(feature = "peers")]
            Self::Peer(peer) => peer.engine.name(),
        }
    }

    /// Its settings.
    pub fn note(self) -> String {
        match self {
            Self::Own(mover) => mover.note(),
            #[cfg(feature = "peers")]
            Self::Peer(peer) => mover::seconds(peer.step),
        }
    }

    /// Whether it is carom's.
    pub fn is_own(self) -> bool {
        matches!(self, Self::Own(_))
    }

    /// Whether it resolves each contact at its instant.
    pub fn is_exact(self) -> bool {
        match self {
            Self::Own(mover) => mover.method().is_exact(),
            #[cfg(feature = "peers")]
            Self::Peer(_) => false,
        }
    }
}

/// What became of one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ended {
    /// Of places.
    pub error: Error,
    /// Relative error of the energy, signed.
    pub energy: f64,
    /// Discs that are no longer in the box, or nowhere.
    pub lost: usize,
}

/// A point of the plot.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Who.
    pub who: Who,
    /// How it went.
    pub ended: Ended,
    /// How long it took.
    pub timing: Timing,
}

/// The step of the springs while their stiffness is varied, s.
pub const SPRING_STEP: f64 = 1.0 / 240.0;

/// The stiffness of the springs while their step is varied, N/m.
const SPRING_STIFFNESS: f64 = 1e8;

/// Whom a report of this effort compares.
pub fn movers(effort: Effort) -> Vec<Who> {
    let full = effort == Effort::Full;
    let steps = |rates: &[f64], finest: &[f64]| -> Vec<f64> {
        let finest = if full { finest } else { &[] };
        rates.iter().chain(finest).map(|rate| 1.0 / rate).collect()
    };
    let springs = |stiffness, step| Mover::Springs { stiffness, step };
    let mut movers = vec![Mover::Events, Mover::Plain];
    movers.extend(steps(&[60.0, 240.0, 1e3], &[4e3]).into_iter().map(Mover::Ticks));
    let rates = [60.0, 240.0, 1e3, 4e3, 16e3];
    movers.extend(steps(&rates, &[64e3, 256e3]).into_iter().map(Mover::Steps));
    let stiff: &[f64] = if full { &[1e4, 1e5, 1e6, 1e8, 1e10, 1e12] } else { &[1e6, 1e8, 1e10] };
    movers.extend(stiff.iter().map(|&stiffness| springs(stiffness, SPRING_STEP)));
    let rates = steps(&[60.0, 1e3, 4e3], &[16e3]).into_iter();
    movers.extend(rates.map(|step| springs(SPRING_STIFFNESS, step)));
    let own = movers.into_iter().map(Who::Own);
    #[cfg(feature = "peers")]
    let own = own.chain(super::peers::peers(&steps(&[60.0, 240.0, 1e3], &[4e3])));
    own.collect()
}

/// Timed runs of each.
pub fn repeats(effort: Effort) -> usize {
    if effort == Effort::Full { 10 } else { 5 }
}

/// Runs all, judges the exact ones, and times them in turns.
///
/// # Errors
/// What is wrong with an exact method.
pub fn rows(
    stretch: &Stretch,
    movers: &[Who],
    repeats: usize,
    told: impl FnMut(f64),
) -> Result<Vec<Row>, String> {
    let mut timed: Vec<Timed> = Vec::new();
    let mut all = Vec::new();
    for &who in movers {
        let (ended, again) = one(stretch, who)?;
        judge(who, &ended, stretch)?;
        all.push((who, ended));
        timed.push(again);
    }
    let timings = in_turns(repeats, &mut timed, told)?;
    let row = |((who, ended), timing)| Row { who, ended, timing };
    Ok(all.into_iter().zip(timings).map(row).collect())
}

/// How one run ends, and how to time it again.
fn one(stretch: &Stretch, who: Who) -> Result<(Ended, Timed<'_>), String> {
    match who {
        Who::Own(mover) => {
            let start = mover.arena(&stretch.scene)?;
            let until = stretch.scene.until;
            let mut arena = start.clone();
            mover::pass(&mut arena, until)?;
            let ended = ended(stretch, &mover::discs(&arena));
            // Springs that push at the end hold energy.
            let energy = match mover {
                Mover::Springs { .. } => arena.relative_energy_drift(),
                _ => ended.energy,
            };
            let again = move || {
                let mut arena = start.clone();
                let (time, passed) = seconds(|| mover::pass(&mut arena, until));
                passed.map(|()| time)
            };
            Ok((Ended { energy, ..ended }, Box::new(again)))
        }
        #[cfg(feature = "peers")]
        Who::Peer(peer) => {
            let discs = peer.run(stretch)?.1;
            Ok((ended(stretch, &discs), Box::new(move || Ok(peer.run(stretch)?.0))))
        }
    }
}

/// Judges discs at the end.
pub fn ended(stretch: &Stretch, discs: &[Disc]) -> Ended {
    let walls = stretch.scene.settings.walls;
    let inside = |disc: &&Disc| {
        let finite = disc.position.is_finite() && disc.velocity.is_finite();
        finite && walls.is_none_or(|walls| walls.contain(disc.position, 0.0))
    };
    Ended {
        error: Error::of(discs, &stretch.truth),
        energy: mover::drift(mover::energy(&stretch.scene.discs), mover::energy(discs)),
        lost: discs.len() - discs.iter().filter(inside).count(),
    }
}

/// Whether what calls itself exact is.
///
/// # Errors
/// By how much it is not.
pub fn judge(who: Who, ended: &Ended, stretch: &Stretch) -> Result<(), String> {
    if !who.is_exact() {
        return Ok(());
    }
    let (worst, most) = (ended.error.worst, ROUNDINGS_MOST * stretch.one_rounding());
    if worst.is_nan() || worst > most {
        let name = who.curve();
        return Err(format!("{name} is off by {worst:.1e} radii, may be by {most:.1e}"));
    }
    if ended.energy.is_nan() || ended.energy.abs() > ENERGY_ERROR_MAX {
        return Err(format!("{} has an energy error of {:.1e}", who.curve(), ended.energy));
    }
    Ok(())
}
