//! `carom explain`: the plan of a scene as a table, and what each part that was left out saves.
//!
//! The first stretch of the scene is run again and again, in turns as planned and with one part
//! more, each time from a copy of the same start. Both go through the same contacts, since a part
//! that is not needed changes no bit; so the ratio of their times is what the part costs. Told is
//! the median of the blocks; below noise is what its 99 % interval does not tell from nothing.

use std::hint::black_box;
use std::io::{self, Write};

use serde::Serialize;
use serde_json::json;

use super::{BenchError, seconds};
use crate::detect;
use crate::motion::arena::Arena;
use crate::plan::parts::{Part, Parts};
use crate::plan::why::{Row, Told};
use crate::plan::{BroadPhase, Plan};
use crate::scene::Scene;
use crate::world::{Disc, Settings};

/// Blocks in turns, of which the median is told.
const BLOCKS: usize = 25;
/// From which block to which, in order, the median lies with 99 %.
const INTERVAL: (usize, usize) = (5, 19);
/// A stretch ends after so many contacts, or seconds of run time.
const CONTACTS: u64 = 20_000;
const STRETCH_S: f64 = 0.008;
/// Longest stretch of simulated time, s.
const SIMULATED_S: f64 = 1e4;
/// Run time of a block at least, s, unless that takes too many runs.
const BLOCK_S: f64 = 0.004;
const RUNS: f64 = 200.0;

/// How a plan is told.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// Whether nothing is measured.
    pub quick: bool,
    /// One JSON object instead of the table.
    pub json: bool,
}

/// By how much longer a part would make it, in percent of the time of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Saving {
    /// The median of the blocks.
    pub percent: f64,
    /// Where its 99 % interval begins, and ends.
    pub from: f64,
    /// Its end.
    pub to: f64,
    /// Whether that holds 0.
    pub below_noise: bool,
}

/// Tells the plan of a scene.
///
/// # Errors
/// When the output cannot be written.
pub fn explain(scene: &Scene, options: Options, out: &mut impl Write) -> Result<(), BenchError> {
    let pucks: Vec<Disc> = scene.pucks.iter().map(|puck| puck.disc).collect();
    let world = scene.world();
    let told = Told { plan: world.plan(), settings: &scene.settings, pucks: &pucks };
    let measure = if options.quick { None } else { Stopwatch::new(&told) };
    let saving = |part: Part| match (part, measure.as_ref()?) {
        (Part::Grid, watch) => watch.saving_of_all_pairs(),
        (_, watch) if told.is_measured(part) => watch.saving(Parts::only(part)),
        _ => None,
    };
    let rows: Vec<(Row, Option<Saving>)> = told
        .rows()
        .into_iter()
        .map(|row| {
            let saving = saving(row.part);
            (row, saving)
        })
        .collect();
    let all = measure.as_ref().and_then(|watch| watch.saving(Parts::ALL));
    let told = Explained { scene: &scene.name, told, rows, all, measure };
    if options.json {
        told.write_json(out)?
    } else {
        told.write_table(out)?
    }
    Ok(())
}

/// Everything that is told.
struct Explained<'a> {
    scene: &'a str,
    told: Told<'a>,
    rows: Vec<(Row, Option<Saving>)>,
    /// With all parts.
    all: Option<Saving>,
    measure: Option<Stopwatch>,
}

impl Explained<'_> {
    fn write_json(&self, out: &mut impl Write) -> io::Result<()> {
        let part = |(row, saving): &(Row, Option<Saving>)| {
            json!({
                "part": row.part.name(), "verdict": row.verdict, "why": row.why, "saves": saving
            })
        };
        let moves = !self.told.pucks.is_empty();
        let document = json!({
            "scene": self.scene,
            "pucks": self.told.pucks.len(),
            "method": moves.then_some(self.told.plan.method),
            "why": moves.then(|| self.told.why_method()),
            "ns_per_contact": self.measure.as_ref().map(Stopwatch::ns_per_contact),
            "parts": self.rows.iter().map(part).collect::<Vec<_>>(),
            "all_parts": self.all,
        });
        writeln!(out, "{document:#}")
    }

    fn write_table(&self, out: &mut impl Write) -> io::Result<()> {
        let Told { plan, pucks, .. } = &self.told;
        if pucks.is_empty() {
            writeln!(out, "{}: no pucks, so no method: circles are answered", self.scene)?;
        } else {
            let why = self.told.why_method();
            writeln!(out, "{}: method {}, {why}", self.scene, plan.method)?;
        }
        if let Some(watch) = &self.measure {
            writeln!(
                out,
                "{:.0} ns a contact over the first {} contacts",
                watch.ns_per_contact(),
                watch.contacts
            )?;
        }
        writeln!(out, "\n{:<21} {:<13} {:<16} why", "part", "", "saves")?;
        for (row, saving) in &self.rows {
            let Row { part, verdict, why } = row;
            let saved = saved(saving.as_ref());
            writeln!(out, "{:<21} {:<13} {saved:<16} {why}", part.name(), verdict.name())?;
        }
        if let Some(all) = &self.all {
            let saved = saved(Some(all));
            writeln!(out, "\n--keep-all, which gives the same bits: {saved} more time a contact")?;
        }
        Ok(())
    }
}

fn saved(saving: Option<&Saving>) -> String {
    match saving {
        Some(saving) if saving.below_noise => "below noise".to_owned(),
        Some(Saving { percent, from, to, .. }) => {
            format!("{percent:.1} +- {:.1} %", 0.5 * (to - from))
        }
        None => "-".to_owned(),
    }
}

/// The stretch that is run.
struct Stopwatch {
    settings: Settings,
    pucks: Vec<Disc>,
    plan: Plan,
    until: f64,
    contacts: u64,
    seconds: f64,
}

impl Stopwatch {
    /// Finds the stretch; `None` where nothing happens.
    fn new(told: &Told) -> Option<Self> {
        if told.pucks.is_empty() {
            return None;
        }
        let settings = Settings { keep: Parts::NONE, ..*told.settings };
        let mut watch = Self {
            settings,
            pucks: told.pucks.to_vec(),
            plan: *told.plan,
            until: told.plan.epoch,
            contacts: 0,
            seconds: 0.0,
        };
        let mut arena = watch.arena(Parts::NONE)?;
        loop {
            watch.seconds += run(&mut arena, watch.until)?;
            watch.contacts = arena.contacts();
            let enough = watch.contacts >= CONTACTS || watch.seconds >= STRETCH_S;
            if enough || watch.until >= SIMULATED_S {
                return (watch.contacts > 0).then_some(watch);
            }
            watch.until *= 2.0;
        }
    }

    fn ns_per_contact(&self) -> f64 {
        1e9 * self.seconds / self.contacts as f64
    }

    /// The arena as planned, with these parts besides.
    fn arena(&self, keep: Parts) -> Option<Arena> {
        let settings = Settings { keep, ..self.settings };
        let mut plan = Plan::of(&settings, &self.pucks);
        plan.choose(Some(self.plan.method), &settings, &self.pucks).ok()?;
        Arena::build(&plan, plan.laws(&settings), &self.pucks).ok()
    }

    /// What parts cost where they are not needed.
    fn saving(&self, parts: Parts) -> Option<Saving> {
        let (bare, full) = (self.arena(Parts::NONE)?, self.arena(parts)?);
        let without = || run(&mut bare.clone(), self.until);
        compare(self.seconds, without, || run(&mut full.clone(), self.until))
    }

    /// What a grid costs where so few circles are reported as there are pucks.
    fn saving_of_all_pairs(&self) -> Option<Saving> {
        let (count, pucks) = (self.pucks.len(), &self.pucks);
        if count < 2 || self.plan.broad_phase(count) == BroadPhase::Grid {
            return None;
        }
        let time = |broad_phase| {
            let find = || detect::touching_pairs(pucks, 0.0, broad_phase);
            seconds(|| (0..100).try_for_each(|_| black_box(find()).map(drop))).0
        };
        let (all_pairs, grid) = (BroadPhase::AllPairs, BroadPhase::Grid);
        compare(time(all_pairs), || Some(time(all_pairs)), || Some(time(grid)))
    }
}

/// By how much longer one run takes than another, which takes about `expected` s.
fn compare(
    expected: f64,
    without: impl Fn() -> Option<f64>,
    with: impl Fn() -> Option<f64>,
) -> Option<Saving> {
    let runs = (BLOCK_S / expected).clamp(1.0, RUNS) as usize;
    let mut changes = Vec::with_capacity(BLOCKS);
    for block in 0..BLOCKS {
        let (mut bare, mut full) = (0.0, 0.0);
        for turn in 0..runs {
            // Who goes first has the colder caches.
            if (block + turn).is_multiple_of(2) {
                (bare, full) = (bare + without()?, full + with()?);
            } else {
                (full, bare) = (full + with()?, bare + without()?);
            }
        }
        changes.push(100.0 * (full / bare - 1.0));
    }
    changes.sort_by(f64::total_cmp);
    let (from, to) = (changes[INTERVAL.0], changes[INTERVAL.1]);
    let below_noise = from <= 0.0 && to >= 0.0;
    Some(Saving { percent: changes[BLOCKS / 2], from, to, below_noise })
}

/// Run time of an arena until then, s; `None` if it does not get there.
fn run(arena: &mut Arena, until: f64) -> Option<f64> {
    let mut contacts = Vec::new();
    let (time, arrived) = seconds(|| {
        while arena.now() < until {
            contacts.clear();
            arena.advance(until, &mut contacts).ok()?;
        }
        Some(())
    });
    arrived.map(|()| time)
}
