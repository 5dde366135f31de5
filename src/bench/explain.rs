//! `carom explain`: the plan of a scene as a table, and what each part that was left out saves.
//!
//! The first stretch of the scene is run again and again, in turns as planned and with one part
//! more, each time from a copy of the same start. Both go through the same contacts, since a part
//! that is not needed changes no bit; so the ratio of their times is what the part costs. Of the
//! few runs in a block the quickest counts, for others may be using the processor. Told is the
//! median of the blocks. Below noise is what its 99 % interval does not tell from nothing, and what
//! is no more than an index of ids seems to cost that nothing asks: it moves the rest in memory.

use std::hint::black_box;
use std::io::{self, Write};

use serde::Serialize;
use serde_json::json;

use super::budget::Budget;
use super::{BenchError, seconds};
use crate::detect;
use crate::motion::arena::Arena;
use crate::plan::budget::Wish;
use crate::plan::parts::{Part, Parts};
use crate::plan::why::{Row, Told};
use crate::plan::{BroadPhase, Method, Plan};
use crate::scene::Scene;
use crate::world::{Contact, Disc, Owner, Settings};

/// A stretch ends after so many contacts, or seconds of run time.
const CONTACTS: u64 = 4_000;
const STRETCH_S: f64 = 0.006;
/// Part of its time that is not timed, for copies begin with cold caches.
const WARM_UP: f64 = 0.25;
/// Longest stretch of simulated time, s.
const SIMULATED_S: f64 = 1e4;
/// Run time of a block, s, if that takes neither too few runs nor too many.
const BLOCK_S: f64 = 0.003;
const RUNS: (f64, f64) = (4.0, 40.0);

/// Least cost that is told, percent.
const FLOOR: f64 = 2.0;

/// Blocks in turns, of which the median is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Blocks {
    /// How many.
    pub count: usize,
    /// From which to which, in order, the median lies with 99 %.
    interval: (usize, usize),
}

impl Blocks {
    /// As they are told by `carom explain`.
    pub const MANY: Self = Self { count: 25, interval: (5, 19) };
    /// For those who have less time: from the least to the largest.
    pub const FEW: Self = Self { count: 9, interval: (0, 8) };
}

/// How a plan is told.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// Whether nothing is measured.
    pub quick: bool,
    /// One JSON object instead of the table.
    pub json: bool,
    /// Bounds of error and run time, instead of what the scene says.
    pub wish: Wish,
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
    /// Whether that holds 0, or is too little to tell.
    pub below_noise: bool,
}

/// A part of a scene's plan, and what was measured of it.
#[derive(Clone, Debug)]
pub struct PartSaving {
    /// The part and what was decided.
    pub row: Row,
    /// What leaving it out saves, where that can be measured.
    pub saving: Option<Saving>,
    /// Whether the stretch came out the same to the last bit with it, where it can be run so.
    pub same_bits: Option<bool>,
}

/// What the plan of a scene saves.
#[derive(Clone, Debug)]
pub struct Savings {
    /// How the pucks move; `None` without pucks.
    pub method: Option<Method>,
    /// Time of a contact as planned, ns; `None` where nothing happens.
    pub ns_per_contact: Option<f64>,
    /// Contacts of the stretch, all of which were compared.
    pub contacts: u64,
    /// Every part.
    pub parts: Vec<PartSaving>,
    /// What leaving all of them out saves.
    pub all: Option<Saving>,
    /// Whether the stretch came out the same with all of them.
    pub same_bits: Option<bool>,
}

/// Measures what the plan of a scene saves, and that what it leaves out changes no bit.
pub fn savings(scene: &Scene, blocks: Blocks) -> Savings {
    let pucks: Vec<Disc> = scene.pucks.iter().map(|puck| puck.disc).collect();
    let world = scene.world();
    let told = Told { plan: world.plan(), settings: &scene.settings, pucks: &pucks };
    let watch = Stopwatch::new(&told, blocks);
    let parts = rows(&told, watch.as_ref()).into_iter().map(|(row, saving)| {
        let watch = watch.as_ref().filter(|_| told.is_measured(row.part));
        let same_bits = watch.and_then(|watch| watch.same_bits(Parts::only(row.part)));
        PartSaving { row, saving, same_bits }
    });
    let parts: Vec<PartSaving> = parts.collect();
    let of_watch = |of: fn(&Stopwatch) -> Option<bool>| watch.as_ref().and_then(of);
    Savings {
        method: (!pucks.is_empty()).then_some(told.plan.method),
        ns_per_contact: watch.as_ref().map(Stopwatch::ns_per_contact),
        contacts: watch.as_ref().map_or(0, |watch| watch.all_contacts),
        parts,
        all: watch.as_ref().and_then(|watch| watch.saving(Parts::ALL)),
        same_bits: of_watch(|watch| watch.same_bits(Parts::ALL)),
    }
}

/// Tells the plan of a scene.
///
/// # Errors
/// When the output cannot be written.
pub fn explain(scene: &Scene, options: Options, out: &mut impl Write) -> Result<(), BenchError> {
    let wish = if options.wish.is_none() { scene.node.wish } else { options.wish };
    let budget = if options.quick { None } else { Budget::of(scene, wish) };
    let mut scene = scene.clone();
    budget.iter().for_each(|budget| budget.apply(&mut scene));
    let pucks: Vec<Disc> = scene.pucks.iter().map(|puck| puck.disc).collect();
    let world = scene.world();
    let told = Told { plan: world.plan(), settings: &scene.settings, pucks: &pucks };
    let measure = if options.quick { None } else { Stopwatch::new(&told, Blocks::MANY) };
    let rows = rows(&told, measure.as_ref());
    let all = measure.as_ref().and_then(|watch| watch.saving(Parts::ALL));
    let told = Explained { scene: &scene.name, told, rows, all, measure, budget };
    if options.json {
        told.write_json(out)?
    } else {
        told.write_table(out)?
    }
    Ok(())
}

/// Every part, and what leaving it out saves where that can be measured.
fn rows(told: &Told, watch: Option<&Stopwatch>) -> Vec<(Row, Option<Saving>)> {
    let saving = |part: Part| match (part, watch?) {
        (Part::Grid, watch) => watch.saving_of_all_pairs(),
        (_, watch) if told.is_measured(part) => watch.saving(Parts::only(part)),
        _ => None,
    };
    told.rows()
        .into_iter()
        .map(|row| {
            let saving = saving(row.part);
            (row, saving)
        })
        .collect()
}

/// Everything that is told.
struct Explained<'a> {
    scene: &'a str,
    told: Told<'a>,
    rows: Vec<(Row, Option<Saving>)>,
    /// With all parts.
    all: Option<Saving>,
    measure: Option<Stopwatch>,
    budget: Option<Budget>,
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
            "budget": self.budget.as_ref().map(Budget::document),
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
                "{:.0} ns a contact, over {} of the first contacts",
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
        if let Some(budget) = &self.budget {
            budget.write_table(out)?;
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
    /// Contacts of the part that is timed.
    contacts: u64,
    /// Of the whole stretch.
    all_contacts: u64,
    seconds: f64,
    /// Least cost that is told, percent.
    floor: f64,
    blocks: Blocks,
}

impl Stopwatch {
    /// Finds the stretch; `None` where nothing happens.
    fn new(told: &Told, blocks: Blocks) -> Option<Self> {
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
            all_contacts: 0,
            seconds: 0.0,
            floor: FLOOR,
            blocks,
        };
        let mut arena = watch.arena(Parts::NONE)?;
        loop {
            watch.seconds += advance(&mut arena, watch.until)?;
            watch.contacts = arena.contacts();
            let enough = watch.contacts >= CONTACTS || watch.seconds >= STRETCH_S;
            if enough || watch.until >= SIMULATED_S {
                break;
            }
            watch.until *= 2.0;
        }
        let arena = watch.arena(Parts::NONE)?;
        let mut warm = arena.clone();
        advance(&mut warm, WARM_UP * watch.until)?;
        watch.all_contacts = watch.contacts;
        watch.contacts -= warm.contacts();
        let times = (0..blocks.count).filter_map(|_| watch.run(&arena));
        watch.seconds = times.fold(f64::INFINITY, f64::min);
        let moved = watch.saving(Parts::only(Part::Commands));
        let moved = moved.map_or(0.0, |saving| saving.from.abs().max(saving.to.abs()));
        watch.floor = moved.max(FLOOR);
        (watch.contacts > 0).then_some(watch)
    }

    /// Run time of the stretch, s, from a copy of an arena on; `None` if it does not get there.
    fn run(&self, arena: &Arena) -> Option<f64> {
        let mut arena = arena.clone();
        advance(&mut arena, WARM_UP * self.until)?;
        advance(&mut arena, self.until)
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
        let about = (self.seconds, self.floor);
        compare(self.blocks, about, || self.run(&bare), || self.run(&full))
    }

    /// Whether the stretch has the same contacts and ends in the same states with these parts, to
    /// the last bit.
    fn same_bits(&self, parts: Parts) -> Option<bool> {
        let story = |keep: Parts| -> Option<(Vec<Contact>, Vec<Disc>, u64)> {
            let (mut arena, mut contacts) = (self.arena(keep)?, Vec::new());
            while arena.now() < self.until {
                arena.advance(self.until, &mut contacts).ok()?;
            }
            let discs = arena.discs(Owner::Simulated).collect();
            Some((contacts, discs, arena.relative_energy_drift().to_bits()))
        };
        // As they are written out, numbers that look alike are the same, but for the sign of 0,
        // which is written too.
        Some(format!("{:?}", story(Parts::NONE)?) == format!("{:?}", story(parts)?))
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
        let about = (time(all_pairs), FLOOR);
        compare(self.blocks, about, || Some(time(all_pairs)), || Some(time(grid)))
    }
}

/// By how much longer one run takes than another, which takes about `expected` s; below the floor,
/// in percent, is noise.
fn compare(
    blocks: Blocks,
    (expected, floor): (f64, f64),
    without: impl Fn() -> Option<f64>,
    with: impl Fn() -> Option<f64>,
) -> Option<Saving> {
    let runs = (BLOCK_S / expected).clamp(RUNS.0, RUNS.1) as usize;
    let mut changes = Vec::with_capacity(blocks.count);
    for block in 0..blocks.count {
        let (mut bare, mut full) = (f64::INFINITY, f64::INFINITY);
        for turn in 0..runs {
            // Who goes first has the colder caches.
            if (block + turn).is_multiple_of(2) {
                (bare, full) = (bare.min(without()?), full.min(with()?));
            } else {
                (full, bare) = (full.min(with()?), bare.min(without()?));
            }
        }
        changes.push(100.0 * (full / bare - 1.0));
    }
    changes.sort_by(f64::total_cmp);
    let (from, to) = (changes[blocks.interval.0], changes[blocks.interval.1]);
    let percent = changes[blocks.count / 2];
    let below_noise = (from <= 0.0 && to >= 0.0) || percent.abs() <= floor;
    Some(Saving { percent, from, to, below_noise })
}

/// Run time of an arena until then, s; `None` if it does not get there.
fn advance(arena: &mut Arena, until: f64) -> Option<f64> {
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
