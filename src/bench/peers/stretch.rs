//! A stretch of the gas under every engine: what it costs, and what it keeps.
//!
//! Timed runs take turns, so that a noisy machine is noisy for all. One more run of each counts
//! contacts and looks for overlaps; nobody times it.

use serde::Serialize;

use super::box2d::Box2d;
use super::own::Stepped;
use super::rapier::Rapier;
use super::{Mover, Options, REPEATS, Setup, Stepper};
use crate::bench::gas::Judgement;
use crate::bench::{BenchError, pass, seconds};
use crate::detect::grid;
use crate::detect::touching::gap;
use crate::exact::RunningSum;
use crate::motion::arena::Arena;
use crate::plan::{Method, Plan};
use crate::world::{Disc, Owner, Settings, Walls};

/// Part of a run that warms up.
const WARM_UP: f64 = 0.1;

/// Overlaps are looked for so often, times in a simulated second.
const LOOKS_HZ: f64 = 60.0;

/// Median and least of the timed runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Times {
    /// Of all runs.
    pub median: f64,
    /// The quickest run.
    pub least: f64,
}

/// What one engine did with the gas.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Who.
    pub mover: Mover,
    /// Length of the step, s; `None` = exact.
    pub step_s: Option<f64>,
    /// Time of a step for each disc, ns; `None` = no steps, or wrong.
    pub ns_per_disc_step: Option<Times>,
    /// Time of a simulated second, ms; `None` = wrong.
    pub ms_per_s: Option<Times>,
    /// Relative error of the energy after the run, signed.
    pub energy_error: f64,
    /// Contacts of pairs and walls for each disc and second.
    pub contacts_per_disc_s: f64,
    /// The same over that of the exact method, less 1: what was missed, for whatever reason.
    pub contacts_error: f64,
    /// Contacts that the engine itself knows to have never resolved, as part of all.
    pub never_resolved: Option<f64>,
    /// Largest overlap of a pair, in radii.
    pub largest_overlap: f64,
    /// Why there is no time.
    pub wrong: Option<String>,
}

/// All rows: carom's exact ones, then every engine at every step.
pub(super) fn rows(options: &Options) -> Result<Vec<Row>, BenchError> {
    let (walled, periodic) = (Stretch::melted(options, true)?, Stretch::melted(options, false)?);
    let plans: Vec<(Mover, f64)> = Mover::STEPPERS
        .into_iter()
        .flat_map(|mover| options.steps.iter().map(move |&step| (mover, step)))
        .collect();
    let mut exact: [Vec<f64>; 2] = Default::default();
    let mut runs: Vec<Vec<Run>> = vec![Vec::new(); plans.len()];
    for _ in 0..REPEATS {
        for (stretch, times) in [&walled, &periodic].into_iter().zip(&mut exact) {
            times.push(stretch.time_exact()?);
        }
        for (&(mover, step), runs) in plans.iter().zip(&mut runs) {
            runs.push(walled.run(mover, step).map_err(BenchError::Wrong)?);
        }
    }
    let [in_walls, in_period] = exact;
    let mut rows =
        vec![walled.exact_row(options, in_walls)?, periodic.exact_row(options, in_period)?];
    for (plan, runs) in plans.into_iter().zip(runs) {
        let seen = walled.watch(plan.0, plan.1).map_err(BenchError::Wrong)?;
        rows.push(walled.row(plan, &runs, &seen, &rows[0]));
    }
    Ok(rows)
}

/// The melted gas.
struct Stretch {
    settings: Settings,
    discs: Vec<Disc>,
    /// s
    seconds: f64,
}

/// One timed run.
#[derive(Clone, Copy, Debug)]
struct Run {
    /// Wall time of the part that was timed, s.
    seconds: f64,
    /// Steps of it.
    steps: u64,
    energy_error: f64,
    /// Discs that are no longer in the box, or nowhere.
    lost: usize,
}

/// What an untimed run saw.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    contacts: u64,
    missed: Option<u64>,
    /// m
    overlap: f64,
}

impl Stretch {
    fn melted(options: &Options, walled: bool) -> Result<Self, BenchError> {
        let gas = options.gas(walled);
        let (settings, discs) = gas.scene().map_err(BenchError::BadUse)?;
        let mut arena = exact_arena(&settings, &discs)?;
        pass(&mut arena, gas.step, gas.melt_collisions())?;
        let discs = arena.discs(Owner::Simulated).collect();
        Ok(Self { settings, discs, seconds: options.seconds })
    }

    /// Time of a simulated second under carom's exact method, ms.
    fn time_exact(&self) -> Result<f64, BenchError> {
        let mut arena = exact_arena(&self.settings, &self.discs)?;
        pass_until(&mut arena, WARM_UP * self.seconds)?;
        let (time, passed) = seconds(|| pass_until(&mut arena, self.seconds));
        passed?;
        Ok(1e3 * time / ((1.0 - WARM_UP) * self.seconds))
    }

    /// carom's exact method once more, judged: a wrong answer ends all.
    fn exact_row(&self, options: &Options, times: Vec<f64>) -> Result<Row, BenchError> {
        let periodic = self.settings.walls.is_none();
        let mut arena = exact_arena(&self.settings, &self.discs)?;
        pass_until(&mut arena, self.seconds)?;
        let gas = options.gas(!periodic);
        let judgement = gas.judge(Method::Events, &arena, arena.contacts(), self.seconds);
        // Not by the rate: a short run of a few discs has too few contacts for that.
        let judgement = Judgement { rate_expected: None, ..judgement };
        judgement.verdict().map_err(BenchError::Wrong)?;
        Ok(Row {
            mover: if periodic { Mover::EventsPeriodic } else { Mover::Events },
            step_s: None,
            ns_per_disc_step: None,
            ms_per_s: Some(median_and_least(times)),
            energy_error: judgement.energy_drift,
            contacts_per_disc_s: self.rate(arena.contacts()),
            contacts_error: 0.0,
            never_resolved: Some(0.0),
            largest_overlap: arena.largest_overlap(),
            wrong: None,
        })
    }

    fn run(&self, mover: Mover, step: f64) -> Result<Run, String> {
        match mover {
            Mover::Box2d => self.time::<Box2d>(step),
            Mover::Rapier => self.time::<Rapier<true>>(step),
            _ => self.time::<Stepped>(step),
        }
    }

    fn watch(&self, mover: Mover, step: f64) -> Result<Seen, String> {
        match mover {
            Mover::Box2d => self.look::<Box2d>(step),
            Mover::Rapier => self.look::<Rapier<true>>(step),
            _ => self.look::<Stepped>(step),
        }
    }

    fn setup(&self, step: f64, count: bool) -> Setup<'_> {
        Setup { discs: &self.discs, walls: self.settings.walls, step, count }
    }

    fn steps(&self, step: f64) -> u64 {
        (self.seconds / step).round() as u64
    }

    fn time<S: Stepper>(&self, step: f64) -> Result<Run, String> {
        let mut engine = S::new(&self.setup(step, false))?;
        let energy = kinetic_energy(&engine.discs());
        let warm_up = (WARM_UP * self.steps(step) as f64) as u64;
        let steps = self.steps(step) - warm_up;
        go(&mut engine, warm_up)?;
        let (seconds, gone) = seconds(|| go(&mut engine, steps));
        gone?;
        let discs = engine.discs();
        let energy_error = kinetic_energy(&discs) / energy - 1.0;
        let inside = |disc: &&Disc| {
            let finite = disc.position.is_finite() && disc.velocity.is_finite();
            finite && self.settings.walls.is_none_or(|walls| is_in(&walls, disc))
        };
        let lost = discs.len() - discs.iter().filter(inside).count();
        Ok(Run { seconds, steps, energy_error, lost })
    }

    fn look<S: Stepper>(&self, step: f64) -> Result<Seen, String> {
        let mut engine = S::new(&self.setup(step, true))?;
        let every = (1.0 / (LOOKS_HZ * step)).round().max(1.0) as u64;
        let mut seen = Seen::default();
        for k in 0..self.steps(step) {
            engine.step()?;
            seen.contacts += engine.contacts();
            if k % every == 0 {
                seen.overlap = seen.overlap.max(largest_overlap(&engine.discs()));
            }
        }
        Ok(Seen { missed: engine.missed(), ..seen })
    }

    fn row(&self, (mover, step): (Mover, f64), runs: &[Run], seen: &Seen, exact: &Row) -> Row {
        let lost = runs.iter().map(|run| run.lost).max().unwrap_or(0);
        let wrong = (lost > 0).then(|| format!("{lost} discs left the box"));
        let right = wrong.is_none();
        let ns = |run: &Run| 1e9 * run.seconds / (run.steps as f64 * self.discs.len() as f64);
        let ms = |run: &Run| 1e3 * run.seconds / (run.steps as f64 * step);
        let told = |time: &dyn Fn(&Run) -> f64| {
            right.then(|| median_and_least(runs.iter().map(time).collect()))
        };
        let (contacts, rate) = (seen.contacts as f64, self.rate(seen.contacts));
        Row {
            mover,
            step_s: Some(step),
            ns_per_disc_step: told(&ns),
            ms_per_s: told(&ms),
            energy_error: runs.last().map_or(f64::NAN, |run| run.energy_error),
            contacts_per_disc_s: rate,
            contacts_error: rate / exact.contacts_per_disc_s - 1.0,
            never_resolved: seen.missed.map(|missed| missed as f64 / (contacts + missed as f64)),
            largest_overlap: 2.0 * seen.overlap,
            wrong,
        }
    }

    fn rate(&self, contacts: u64) -> f64 {
        contacts as f64 / (self.discs.len() as f64 * self.seconds)
    }
}

fn exact_arena(settings: &Settings, discs: &[Disc]) -> Result<Arena, BenchError> {
    let mut plan = Plan::of(settings, discs);
    let method = Some(Method::Events);
    plan.choose(method, settings, discs).map_err(BenchError::BadUse)?;
    Ok(Arena::new(&plan, plan.laws(settings), discs))
}

fn pass_until(arena: &mut Arena, until: f64) -> Result<(), BenchError> {
    while arena.now() < until {
        arena.pass(until).map_err(|stall| BenchError::Wrong(stall.to_string()))?;
    }
    Ok(())
}

fn go<S: Stepper>(engine: &mut S, steps: u64) -> Result<(), String> {
    for _ in 0..steps {
        engine.step()?;
    }
    Ok(())
}

/// Whether the centre of a disc is between the walls.
fn is_in(walls: &Walls, disc: &Disc) -> bool {
    walls.contain(disc.position, 0.0)
}

fn kinetic_energy(discs: &[Disc]) -> f64 {
    discs.iter().map(Disc::kinetic_energy).collect::<RunningSum>().value()
}

/// Deepest overlap of a pair now, m; NaN where discs lie heaped on each other without end.
fn largest_overlap(discs: &[Disc]) -> f64 {
    let Ok(pairs) = grid::touching_pairs(discs, 0.0) else { return f64::NAN };
    pairs.into_iter().map(|(i, j)| -gap(&discs[i], &discs[j])).fold(0.0, f64::max)
}

fn median_and_least(mut times: Vec<f64>) -> Times {
    times.sort_by(f64::total_cmp);
    Times { median: times[times.len() / 2], least: times[0] }
}
