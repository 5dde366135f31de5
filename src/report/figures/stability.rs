//! Where methods hold: the exact method over masses and gaps, explicit springs over step and
//! damping.

pub mod chain;

pub mod springs;

use super::items::{decades, guide, numbers, point, short, words};
use crate::exact::UNIT_ROUNDOFF;
use crate::motion::arena::Arena;
use crate::motion::springs::Explicit;
use crate::plan::{Method, Plan};
use crate::report::page::{Item, Map, Scale, Section, Table};
use crate::report::{Effort, Progress, ReportError};
use crate::world::{Disc, Owner, Settings};
use chain::Truth;
use springs::{NAMES, TOLERANCE, outcome};

/// Contacts up to which the chain is followed.
pub const CONTACTS: usize = 12;

/// Largest error of an exact method in `u G`: 64 for each contact and one, as in the reference
/// cases.
pub const ERROR_MAX: f64 = 64.0 * (CONTACTS as f64 + 1.0);

/// Decades of the mass of the middle disc, and of the gap.
const MASSES: (f64, f64) = (-12.0, 12.0);
const GAPS: (f64, f64) = (-15.0, -1.0);
/// Decades of `h omega0`, and of `beta / omega0`.
const STEPS: (f64, f64) = (-2.0, 0.6);
const DAMPINGS: (f64, f64) = (-2.0, 1.0);

/// How fine the maps are.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    /// Masses and gaps.
    pub chain: (usize, usize),
    /// Steps and dampings.
    pub springs: (usize, usize),
    /// Places within a step at which blows begin.
    pub phases: u32,
}

impl Size {
    /// For this effort.
    pub fn of(effort: Effort) -> Self {
        match effort {
            Effort::Quick => Self { chain: (13, 8), springs: (27, 16), phases: 4 },
            Effort::Full => Self { chain: (49, 29), springs: (53, 31), phases: 16 },
        }
    }
}

/// Measures the section.
///
/// # Errors
/// [`ReportError::Wrong`] when an exact method is farther off than [`ERROR_MAX`].
pub fn section(effort: Effort, progress: Progress) -> Result<Section, ReportError> {
    section_of(Size::of(effort), progress)
}

/// The same to a given size.
///
/// # Errors
/// As [`section`].
pub fn section_of(size: Size, progress: Progress) -> Result<Section, ReportError> {
    let (chains, worst) = chains(size, &mut |part| progress(0.5 * part))?;
    let mut items: Vec<Item> = chains.into_iter().map(Item::Map).collect();
    items.push(Item::Table(chain_table(&worst)));
    for (k, rule) in Explicit::ALL.into_iter().enumerate() {
        items.push(Item::Map(springs_map(rule, size)));
        progress(0.5 + 0.5 * (k + 1) as f64 / Explicit::ALL.len() as f64);
    }
    let title = "Where it holds: masses, gaps, stiffness".to_owned();
    Ok(Section { name: "stability", title, text: text(size), items })
}

/// Values that are equally far apart in decades.
pub fn grid((first, last): (f64, f64), count: usize) -> Vec<f64> {
    let at = |k: usize| first + (last - first) * k as f64 / (count - 1).max(1) as f64;
    (0..count).map(|k| 10f64.powf(at(k))).collect()
}

/// Error in `u G` of one method.
struct Worst {
    method: Method,
    largest: f64,
    median: f64,
    growth: f64,
    left_out: usize,
}

fn chains(size: Size, progress: Progress) -> Result<([Map; 2], [Worst; 2]), ReportError> {
    let (masses, gaps) = (grid(MASSES, size.chain.0), grid(GAPS, size.chain.1));
    let methods = [Method::Events, Method::Plain];
    let mut values = [Vec::new(), Vec::new()];
    let (mut growth, mut left_out) = (0.0f64, 0);
    for (k, gap) in gaps.iter().enumerate() {
        let mut rows = [Vec::new(), Vec::new()];
        for mass in &masses {
            let discs = chain::discs(*mass, *gap);
            let truth = Truth::after(&discs, CONTACTS);
            growth = growth.max(truth.as_ref().map_or(0.0, |truth| truth.growth));
            left_out += usize::from(truth.is_none());
            for (row, method) in rows.iter_mut().zip(methods) {
                let error = truth.as_ref().map(|truth| chain_error(method, &discs, truth));
                row.push(error.transpose()?.unwrap_or(f64::NAN));
            }
        }
        for (values, row) in values.iter_mut().zip(rows) {
            values.push(row);
        }
        progress((k + 1) as f64 / gaps.len() as f64);
    }
    let worst = [0, 1].map(|k| {
        let mut all: Vec<f64> = values[k].iter().flatten().copied().collect();
        all.retain(|error| error.is_finite());
        all.sort_by(f64::total_cmp);
        let (largest, median) = (all.last().copied(), all.get(all.len() / 2).copied());
        let (largest, median) = (largest.unwrap_or(f64::NAN), median.unwrap_or(f64::NAN));
        Worst { method: methods[k], largest, median, growth, left_out }
    });
    let maps = methods
        .into_iter()
        .zip(values)
        .map(|(method, values)| chain_map(method, masses.clone(), gaps.clone(), values));
    let maps: Vec<Map> = maps.collect();
    let maps = <[Map; 2]>::try_from(maps);
    // There are two methods.
    Ok((maps.expect("two maps"), worst))
}

/// Error of a method on a chain, in `u G`.
///
/// # Errors
/// When it is too large, or other contacts took place.
pub fn chain_error(method: Method, discs: &[Disc], truth: &Truth) -> Result<f64, ReportError> {
    let settings = Settings { walls: Some(chain::WALLS), ..Settings::default() };
    let wrong = |what: String| {
        let (mass, gap) = (discs[1].mass, discs[2].position.x - 1.0);
        ReportError::Wrong(format!("stability, {method}, mass {mass:e}, gap {gap:e}: {what}"))
    };
    let mut plan = Plan::of(&settings, discs);
    plan.choose(Some(method), &settings, discs).map_err(wrong)?;
    let mut arena = Arena::build(&plan, plan.laws(&settings), discs).map_err(wrong)?;
    while arena.now() < truth.time {
        arena.pass(truth.time).map_err(|halt| wrong(halt.to_string()))?;
    }
    if arena.contacts() != truth.contacts as u64 {
        return Err(wrong(format!("{} contacts, not {}", arena.contacts(), truth.contacts)));
    }
    let after: Vec<Disc> = arena.discs(Owner::Simulated).collect();
    let error = truth.error(&after) / (UNIT_ROUNDOFF * truth.growth);
    if error.is_nan() || error > ERROR_MAX {
        return Err(wrong(format!("{error} u G off")));
    }
    Ok(error)
}

fn chain_map(method: Method, xs: Vec<f64>, ys: Vec<f64>, values: Vec<Vec<f64>>) -> Map {
    Map {
        name: format!("stability_chain_{method}"),
        title: format!("Error of the exact method {method} over mass ratio and gap"),
        caption: format!(
            "A disc strikes the second of three, of varied mass, which stands a gap from the \
             third; told is the largest distance of a disc from its true place after {CONTACTS} \
             contacts, in radii, over u = 2^-53 and the growth G of a perturbation until then."
        ),
        x: decades("mass of the middle disc over that of the others", "1"),
        y: decades("gap between the middle and the last disc", "m"),
        xs,
        ys,
        scale: Scale::Continuous(decades("error over u G", "1")),
        values,
        lines: Vec::new(),
    }
}

fn chain_table(worst: &[Worst; 2]) -> Table {
    let row = |worst: &Worst| {
        vec![
            worst.method.to_string(),
            short(worst.largest),
            short(worst.median),
            short(worst.growth),
            worst.left_out.to_string(),
        ]
    };
    Table {
        name: "stability_chain".to_owned(),
        title: "The same in numbers".to_owned(),
        caption: format!("The report ends where an error is above {ERROR_MAX} u G."),
        columns: vec![
            words("method"),
            numbers("largest error (u G)"),
            numbers("median (u G)"),
            numbers("largest G"),
            numbers("cells left out"),
        ],
        rows: worst.iter().map(row).collect(),
    }
}

/// What an integrator makes of contacts over step and damping.
pub fn springs_map(rule: Explicit, size: Size) -> Map {
    let (steps, dampings) = (grid(STEPS, size.springs.0), grid(DAMPINGS, size.springs.1));
    let row = |beta: &f64| -> Vec<f64> {
        let cell = |h: &f64| f64::from(outcome(rule, *h, *beta, size.phases) as u8);
        steps.iter().map(cell).collect()
    };
    let limit = |beta: f64| point(rule.largest_stable_step(1.0, beta), beta);
    let fine = grid(DAMPINGS, 121);
    let in_sight = fine.into_iter().map(limit).filter(|at| at.x >= 10f64.powf(STEPS.0));
    Map {
        name: format!("stability_{}", rule.name().to_lowercase().replace([' ', '-'], "_")),
        title: format!("A spring and a dashpot stepped by {}", rule.name()),
        caption: format!(
            "Line: the longest stable step, from the spectral radius of one step. Right: \
             restitution within {TOLERANCE} for blows that begin at {} places within a step.",
            size.phases
        ),
        x: decades("step times frequency, h omega0", "1"),
        y: decades("damping, beta / omega0", "1"),
        values: dampings.iter().map(row).collect(),
        xs: steps,
        ys: dampings,
        scale: Scale::Classes(NAMES.map(str::to_owned).to_vec()),
        lines: vec![guide("theoretical limit", in_sight.collect())],
    }
}

fn text(size: Size) -> Vec<String> {
    vec![
        "An engine that is right on billiard balls may fail on a puck beside a wall of lead, or on \
         discs a hair apart. Exact motion has no such corner: over 24 decades of mass and 14 of \
         the gap its error is the rounding of doubles, grown as any perturbation grows, and no \
         more."
            .to_owned(),
        format!(
            "Measured: {} x {} cells, no random numbers. The true path is computed with 400 bits; \
             G is the growth of a change by 2^-130 in the worst of the twelve coordinates. 1 would \
             be one rounding at the start and none after it; every contact adds some. Both methods \
             must have the same {CONTACTS} contacts as the truth. The method plain carries twice \
             the digits, so that what is left is the rounding of what it tells.",
            size.chain.0, size.chain.1
        ),
        format!(
            "Contacts that give way are another matter. Six explicit integrators, {} x {} cells \
             each, all in the arena of springs: a disc squeezed between two fixed ones is let go \
             from two deviations, and blows up where the matrix of twenty steps has an eigenvalue \
             above 1. Where it has not, two discs meet at {} places within a step and must part \
             with the restitution of the closed form. Stable is not right: there is a wide belt in \
             which nothing blows up and the restitution is wrong. carom's own springs are a closed \
             form and have no such map.",
            size.springs.0, size.springs.1, size.phases
        ),
        "Left out: the undamped line beta = 0, which has no place on an axis of decades; the \
         longest stable steps there are 2 (semi-implicit Euler, Verlet), sqrt 3 (RK3), 2 sqrt 2 \
         (RK4) over omega0, none for forward Euler and RK2 (reference case P02). Nothing here is a \
         run time."
            .to_owned(),
    ]
}
