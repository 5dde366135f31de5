//! `carom bench`: one measured run, whose physics is checked before its time is told.
//!
//! A [gas] of discs melts from a lattice, untimed; then its collisions are timed in blocks. A wrong
//! answer prints no time. [`mod@explain`] measures what the plan of a scene leaves out,
//! [`budget`] what each method costs, [`collision`] how wrong it is. The only
//! stopwatch and the only look at the memory are in this file.

pub mod budget;

pub mod collision;

pub mod explain;

pub mod gas;

#[cfg(feature = "peers")]
pub mod peers;

use std::io::{self, Write};
use std::time::Instant;

use serde::Serialize;

use crate::motion::arena::Arena;
use crate::motion::events::Lanes;
use crate::plan::parts::Parts;
use crate::plan::{Method, Plan};
use gas::{Gas, Judgement};

/// Timed blocks of a run that is told.
const BLOCKS: u32 = 5;

/// Steps between two looks at the number of collisions.
const STEPS_AT_ONCE: f64 = 20.5;

/// Why there is no time.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// Options that make no scene.
    #[error("{0}")]
    BadUse(String),
    /// The run was wrong.
    #[error("no time: {0}")]
    Wrong(String),
    /// The output.
    #[error("cannot write: {0}")]
    Output(#[from] io::Error),
}

/// What is measured, and how it is told.
#[derive(Clone, Debug)]
pub struct Options {
    /// The scene.
    pub gas: Gas,
    /// The method; `None` = the plan chooses.
    pub method: Option<Method>,
    /// Whether everything is built, needed or not.
    pub keep_all: bool,
    /// Collisions of pairs and walls to be timed.
    pub collisions: u64,
    /// Without the vector units of the processor.
    pub portable: bool,
    /// One JSON object instead of words.
    pub json: bool,
}

/// What a run gave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// Which method it was.
    pub method: Method,
    /// Median of the blocks, ns for a collision.
    pub ns_per_collision: f64,
    /// Median of the blocks, ns for a step of a disc, where steps are fixed.
    pub ns_per_disc_step: Option<f64>,
    /// The quickest block, ns for a collision.
    pub ns_per_collision_min: f64,
    /// The slowest block, ns for a collision.
    pub ns_per_collision_max: f64,
    /// Until the first collision could be computed, s.
    pub start_up_s: f64,
    /// Memory that the arena took, bytes for a disc; `None` where the system does not tell.
    pub bytes_per_disc: Option<f64>,
    /// Collisions timed.
    pub collisions: u64,
    /// What was checked.
    #[serde(flatten)]
    pub judgement: Judgement,
}

/// Runs, judges and tells.
///
/// # Errors
/// [`BenchError`]; of a wrong run no time is told.
pub fn bench(options: &Options, out: &mut impl Write) -> Result<(), BenchError> {
    let measured = measure(options, BLOCKS)?;
    measured.judgement.verdict().map_err(BenchError::Wrong)?;
    if options.json {
        let text = serde_json::to_string_pretty(&measured).map_err(io::Error::from)?;
        return Ok(writeln!(out, "{text}")?);
    }
    tell(options, &measured, out)?;
    Ok(())
}

/// Runs, in so many timed blocks, and looks at what is to be judged.
///
/// # Errors
/// [`BenchError`]; the verdict on the run is for the caller to ask for.
pub(crate) fn measure(options: &Options, blocks: u32) -> Result<Measured, BenchError> {
    let before = resident();
    let (mut settings, discs) = options.gas.scene().map_err(BenchError::BadUse)?;
    settings.keep = if options.keep_all { Parts::ALL } else { Parts::NONE };
    let count = discs.len() as f64;
    let mut plan = Plan::of(&settings, &discs);
    let chosen = plan.choose(options.method, &settings, &discs);
    chosen.map_err(|error| BenchError::BadUse(advice(options, error)))?;
    let start = Instant::now();
    let mut arena = Arena::new(&plan, plan.laws(&settings), &discs);
    let start_up_s = start.elapsed().as_secs_f64();
    if options.portable
        && let Arena::Events(events) = &mut arena
    {
        events.use_lanes(Lanes::portable());
    }
    drop(discs);
    pass(&mut arena, options.gas.step, options.gas.melt_collisions())?;
    let (contacts, began) = (arena.contacts(), arena.now());
    let count_of_blocks = blocks.max(1);
    let (mut blocks, mut step_blocks) = (Vec::new(), Vec::new());
    for _ in 0..count_of_blocks {
        let (first, steps, start) = (arena.contacts(), arena.steps(), Instant::now());
        pass(&mut arena, options.gas.step, options.collisions / u64::from(count_of_blocks))?;
        let seconds = start.elapsed().as_secs_f64();
        blocks.push(1e9 * seconds / (arena.contacts() - first) as f64);
        let steps = arena.steps().zip(steps).map(|(now, before)| (now - before) as f64);
        step_blocks.extend(steps.map(|steps| 1e9 * seconds / (steps * count)));
    }
    blocks.sort_by(f64::total_cmp);
    step_blocks.sort_by(f64::total_cmp);
    let taken = before.zip(resident()).map(|(before, after)| (after - before) / count);
    let contacts = arena.contacts() - contacts;
    Ok(Measured {
        method: plan.method,
        ns_per_collision: blocks[blocks.len() / 2],
        ns_per_disc_step: step_blocks.get(step_blocks.len() / 2).copied(),
        ns_per_collision_min: blocks[0],
        ns_per_collision_max: blocks[blocks.len() - 1],
        start_up_s,
        bytes_per_disc: taken,
        collisions: contacts,
        judgement: options.gas.judge(plan.method, &arena, contacts, arena.now() - began),
    })
}

/// Goes on for so many collisions.
pub(crate) fn pass(arena: &mut Arena, step: f64, collisions: u64) -> Result<(), BenchError> {
    let target = arena.contacts() + collisions.max(1);
    let mut idle = 0;
    while arena.contacts() < target {
        let before = arena.contacts();
        // No wall and no partner left is a scene in which nothing more happens. Methods with fixed
        // steps are stopped after a few.
        let way = arena.steps().map_or(1e9, |_| STEPS_AT_ONCE * step);
        arena.pass(arena.now() + way).map_err(|halt| BenchError::Wrong(halt.to_string()))?;
        idle = if arena.contacts() == before { idle + 1 } else { 0 };
        if idle > 10_000 {
            return Err(BenchError::Wrong("the discs meet no more".to_owned()));
        }
    }
    Ok(())
}

/// What is wrong with a method, and what else would be right here.
fn advice(options: &Options, error: String) -> String {
    match options.method {
        Some(Method::Springs) if !options.gas.lattice.walled => {
            format!("{error}, or --boundary walls")
        }
        _ => error,
    }
}

/// How long something takes, s, and what comes of it.
pub(crate) fn seconds<T>(run: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let result = run();
    (start.elapsed().as_secs_f64(), result)
}

/// Memory that this process occupies, bytes, where the system tells.
fn resident() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kilobytes: f64 = line.split_whitespace().next()?.parse().ok()?;
    Some(1024.0 * kilobytes)
}

fn tell(options: &Options, measured: &Measured, out: &mut impl Write) -> io::Result<()> {
    let Measured { judgement, .. } = measured;
    let kept = if options.keep_all { ", all parts kept" } else { "" };
    writeln!(out, "{}, method {}{kept}", options.gas, measured.method)?;
    writeln!(
        out,
        "{:>10.1} ns per collision (median of {BLOCKS} blocks, least {:.1}; {} collisions)",
        measured.ns_per_collision, measured.ns_per_collision_min, measured.collisions
    )?;
    if let Some(time) = measured.ns_per_disc_step {
        writeln!(out, "{time:>10.1} ns per disc and step of {} s", options.gas.step)?;
    }
    writeln!(out, "{:>10.3} s to start", measured.start_up_s)?;
    if let Some(bytes) = measured.bytes_per_disc {
        writeln!(out, "{bytes:>10.0} bytes a disc")?;
    }
    writeln!(out, "{judgement}")
}
