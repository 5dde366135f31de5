//! Kinds `stats_*` in a periodic box: collision rates, virial pressure, cooling.
//!
//! The pressure is that of the collisions: `Z = 1 + W / (2 t N kT)` with `W` the sum of reach times
//! impulse and `kT` from the 2N - 2 degrees of freedom that are left without total momentum. Errors
//! come from blocks of one run with a fixed seed. The plain method looks at all discs for each
//! event, so runs are short of the errors that the cases could be judged to: the row says which
//! error was reached.

use std::f64::consts::PI;

use glam::DVec2;

use super::Effort;
use super::arena::{Run, Setup, Trouble};
use super::case::{Field, Read};
use super::finding::{Finding, Tally};
use super::number;
use super::statistics::{Estimate, estimate, gas, limit, positive};
use crate::motion::arena::Halt;
use crate::scene::lattice::Lattice;
use crate::world::{Disc, Periodic, Settings, Walls, limits};

type Findings = Result<Vec<Finding>, Trouble>;

/// Blocks of one run.
const BLOCKS: usize = 20;

/// Discs where a case asks for no number, or for at least so many.
const COUNT: usize = 1000;

/// Collisions measured for each disc.
fn collisions(effort: Effort) -> f64 {
    if effort.is_full() { 2_000.0 } else { 200.0 }
}

/// Collisions measured for each disc of a large system near its transition: fewer do not relax it
/// (after 240 the pressure of 512^2 discs is still 2 to 9 % off). Hours for each density.
const LONG_COLLISIONS: f64 = 100_000.0;

/// Discs of diameter 1 and mass 1 in a periodic box of this size, at kT = 1.
fn setup(mut discs: Vec<Disc>, size: DVec2) -> Setup {
    let count = discs.len() as f64;
    let drift = discs.iter().map(|disc| disc.velocity).sum::<DVec2>() / count;
    discs.iter_mut().for_each(|disc| disc.velocity -= drift);
    let scale = ((count - 1.0) / discs.iter().map(Disc::kinetic_energy).sum::<f64>()).sqrt();
    discs.iter_mut().for_each(|disc| disc.velocity *= scale);
    let periodic = Some(Periodic { min: DVec2::ZERO, max: size });
    Setup { settings: Settings { periodic, ..Settings::default() }, discs }
}

/// At random places.
fn random_gas(area_fraction: f64, seed: u64, field: &Field) -> Read<Setup> {
    if !(area_fraction > 0.0 && area_fraction < 0.5) {
        return Err(field.wrong("must be above 0 and below 0.5"));
    }
    let size = DVec2::splat((COUNT as f64 * 0.25 * PI / area_fraction).sqrt());
    let region = Walls { min: DVec2::ZERO, max: size, restitution: 1.0 };
    let discs = gas(&vec![(1.0, 0.5); COUNT], region, COUNT as f64, seed, field)?;
    Ok(setup(discs, size))
}

/// On a triangular lattice of so many columns and (even) rows.
fn lattice(columns: usize, rows: usize, area_fraction: f64, field: &Field) -> Read<Setup> {
    let few = |number: usize| (2..=1000).contains(&number);
    if !few(columns) || !few(rows) || !rows.is_multiple_of(2) {
        return Err(field.wrong("must be columns and an even number of rows"));
    }
    let spacing = (0.5 * PI / (area_fraction * 3f64.sqrt())).sqrt();
    if spacing <= 1.0 || !spacing.is_finite() {
        return Err(field.wrong("is denser than discs can lie"));
    }
    let (count, height) = (columns * rows, spacing * 0.75f64.sqrt());
    let size = DVec2::new(columns as f64 * spacing, rows as f64 * height);
    let wide = DVec2::splat(4.0 * count as f64);
    let region = Walls { min: DVec2::ZERO, max: wide, restitution: 1.0 };
    let mut discs = gas(&vec![(1.0, 0.5); count], region, count as f64, 1, field)?;
    for (k, disc) in discs.iter_mut().enumerate() {
        let (column, row) = ((k % columns) as f64, k / columns);
        let x = spacing * (column + 0.25 + 0.5 * (row % 2) as f64);
        disc.position = DVec2::new(x, height * (row as f64 + 0.5));
    }
    Ok(setup(discs, size))
}

/// On a triangular lattice that fits a square, with evenly spread empty places.
fn square_crystal(count: usize, area_fraction: f64, field: &Field) -> Read<Setup> {
    let lattice =
        Lattice { count, area_fraction, size_ratio: 1.0, mass_max: 1.0, walled: false, seed: 1 };
    let crowded = || field.wrong("is denser than discs can lie");
    let (discs, side) = lattice.discs().ok_or_else(crowded)?;
    Ok(setup(discs, DVec2::splat(side)))
}

/// What a run gives: the compressibility factor and the collision rate of a disc.
struct Measured {
    factor: Estimate,
    rate: Estimate,
}

/// Measures so many collisions a disc, after a fifth as many, at least 30, to forget the start: at
/// area fraction 0.4 random places show for some 20.
fn measure(setup: &Setup, collisions: f64) -> Result<Measured, Halt> {
    let count = setup.discs.len() as f64;
    let mut run = Run::new(setup);
    // kT = m = d = 1: no mean free time is longer than a few hundred.
    let step = 0.05;
    let forget = (0.2 * collisions).max(30.0) * 0.5 * count;
    while (run.pairs as f64) < forget {
        run.pass(run.now() + step)?;
    }
    let block = run.now() * 0.5 * collisions * count / run.pairs as f64 / BLOCKS as f64;
    let (mut factors, mut rates) = (Vec::new(), Vec::new());
    for _ in 0..BLOCKS {
        let (mut virial, start, before) = (0.0, run.now(), run.pairs);
        run.advance(start + block, |contact| virial += contact.impulse)?;
        let time = run.now() - start;
        factors.push(1.0 + virial / (2.0 * time * count));
        rates.push(2.0 * (run.pairs - before) as f64 / (time * count));
    }
    Ok(Measured { factor: estimate(&factors), rate: estimate(&rates) })
}

/// Shows a mean with its error and z-score, judged by a bound of its own.
fn judge(tally: &mut Tally, what: &str, ours: Estimate, wanted: f64, bound: f64) {
    tally.within(what, (ours.0 - wanted).abs(), bound);
    let z = (ours.0 - wanted) / ours.1;
    tally.note(format!("{what} {:.6} +- {:.1e} z={z:+.2}", ours.0, ours.1));
}

/// Collision rate of a disc: that of the virial series, within `<n> sigma + 2/N` of itself.
pub fn enskog(root: &Field, effort: Effort) -> Findings {
    let (limit, inputs) = (limit(root)?, root.get("inputs")?);
    let unit = |key: &str| positive(&inputs.get(key)?);
    // Simulated in units of d, m and kT.
    let per_time = (unit("kT")? / unit("m")?).sqrt() / unit("d")?;
    let mut findings = Vec::new();
    for field in inputs.get("eta")?.items()? {
        let area_fraction = positive(&field)?;
        let wanted = root.get("expected")?.entry_with_number(area_fraction)?;
        let wanted = positive(&wanted.get("rate_from_virial_Z")?)?;
        let (rate, sigma) =
            measure(&random_gas(area_fraction, 1, &field)?, collisions(effort))?.rate;
        let ours = (rate * per_time, sigma * per_time);
        let mut tally = Tally::new(format!("eta = {area_fraction}"));
        judge(&mut tally, "rate", ours, wanted, limit * ours.1 + 2.0 / COUNT as f64 * wanted);
        findings.push(tally.finish());
    }
    Ok(findings)
}

/// Equation of state of the fluid: within the largest of `<n> sigma`, `tail_added/2`, `1.5/N`.
pub fn fluid(root: &Field, effort: Effort) -> Findings {
    let limit = root.get("tolerance")?.get("value")?.number_after("max(")?;
    let mut findings = Vec::new();
    for field in root.get("inputs")?.get("eta")?.items()? {
        let area_fraction = positive(&field)?;
        let wanted = root.get("expected")?.entry_with_number(area_fraction)?;
        let (factor, tail) = (positive(&wanted.get("Z")?)?, wanted.get("tail_added")?.finite()?);
        let ours = measure(&random_gas(area_fraction, 1, &field)?, collisions(effort))?.factor;
        let bound = (limit * ours.1).max(0.5 * tail).max(1.5 / COUNT as f64);
        let mut tally = Tally::new(format!("eta = {area_fraction}"));
        judge(&mut tally, "Z", ours, factor, bound);
        findings.push(tally.finish());
    }
    Ok(findings)
}

/// Equation of state of the crystal, 16 x 18: the bound after `<=` in `N`, `alpha` and `sigma`.
pub fn crystal(root: &Field, effort: Effort) -> Findings {
    let tolerance = root.get("tolerance")?.get("value")?;
    let mut findings = Vec::new();
    for field in root.get("inputs")?.get("eta")?.items()? {
        let area_fraction = positive(&field)?;
        let wanted = root.get("expected")?.entry_with_number(area_fraction)?;
        let (factor, alpha) = (positive(&wanted.get("Z")?)?, positive(&wanted.get("alpha")?)?);
        let setup = lattice(16, 18, area_fraction, &field)?;
        let ours = measure(&setup, collisions(effort))?.factor;
        let names = [("N", setup.discs.len() as f64), ("alpha", alpha), ("sigma", ours.1)];
        let mut tally = Tally::new(format!("eta = {area_fraction}"));
        judge(&mut tally, "Z", ours, factor, tolerance.formula_after("<=", &names)?);
        findings.push(tally.finish());
    }
    Ok(findings)
}

/// Published pressures of N discs in a box of the lattice's aspect, at some area fractions.
pub fn pressure(root: &Field, effort: Effort) -> Findings {
    let (limit, inputs) = (limit(root)?, root.get("inputs")?);
    let (aspect, count) = (inputs.get("aspect")?, inputs.get("N")?);
    let columns = aspect.words()?.split(':').next().and_then(|word| word.trim().parse().ok());
    let columns = columns.ok_or_else(|| aspect.wrong("must begin with the columns"))?;
    let rows = number::after(aspect.words()?, ":").unwrap_or(0.0) as usize;
    if count.count(limits::PUCKS_PER_SCENE as u64)? as usize != rows.saturating_mul(columns) {
        return Err(count.wrong("must be that of the lattice in `aspect`").into());
    }
    let mut findings = Vec::new();
    for (name, wanted) in root.get("expected")?.entries()? {
        let area_fraction = name.parse().map_err(|_| wanted.wrong("must be named by a number"))?;
        let of = |key: &str| positive(&wanted.get(key)?);
        // Z = beta P d^2 pi / (4 eta).
        let per_pressure = 0.25 * PI / area_fraction;
        let wanted = (of("betaP_d2")?, of("sigma")?);
        let setup = lattice(columns, rows, area_fraction, &aspect)?;
        let (factor, sigma) =
            measure(&setup, if effort.is_full() { 100_000.0 } else { 10_000.0 })?.factor;
        let mut tally = Tally::new(format!("eta = {name}"));
        tally.z("pressure", (factor / per_pressure, sigma / per_pressure), wanted, limit);
        findings.push(tally.finish());
    }
    Ok(findings)
}

/// Published pressures of so many discs squared (`<method>_<columns>`) in a square box: a crystal
/// with a few empty places, which melts where it must.
pub fn pressure_of_many(root: &Field, _: Effort) -> Findings {
    let limit = limit(root)?;
    let mut findings = Vec::new();
    for (name, table) in root.get("expected")?.entries()? {
        let side = name.rsplit('_').next().and_then(|word| word.parse().ok());
        let side: usize = side.ok_or_else(|| table.wrong("must end with the discs of a side"))?;
        for (eta, wanted) in table.entries()? {
            let area_fraction =
                eta.parse().map_err(|_| wanted.wrong("must be named by a number"))?;
            let of = |key: &str| positive(&wanted.get(key)?);
            let per_pressure = 0.25 * PI / area_fraction;
            let wanted = (of("betaP_d2")?, of("sigma")?);
            let setup = square_crystal(side * side, area_fraction, &table)?;
            let (factor, sigma) = measure(&setup, LONG_COLLISIONS)?.factor;
            let mut tally = Tally::new(format!("{name} eta = {eta}"));
            tally.z("pressure", (factor / per_pressure, sigma / per_pressure), wanted, limit);
            findings.push(tally.finish());
        }
    }
    Ok(findings)
}

/// Starts over which Haff's law is a mean: of fewer the standard error is itself a matter of luck.
const STARTS: u64 = 8;

/// Haff's law: at the listed multiples of `t0`, and at the end of the collisions per disc up to
/// which the tolerance holds. The percentage bounds the law; 4 standard errors of our mean over
/// starts are added to it.
pub fn haff(root: &Field, _: Effort) -> Findings {
    let (inputs, tolerance) = (root.get("inputs")?, root.get("tolerance")?.get("value")?);
    let percent = tolerance.words()?.split('%').next().and_then(|word| word.trim().parse().ok());
    let percent: f64 = percent.ok_or_else(|| tolerance.wrong("must begin with a percentage"))?;
    let most = tolerance.number_after("up to")?.clamp(0.0, 1000.0);
    let (_, fraction) = (inputs.get("N")?.number_after(">=")?, inputs.get("eta")?);
    let gas = |seed| random_gas(positive(&fraction)?, seed, &fraction);
    let gases: Vec<Setup> = (1..=STARTS).map(gas).collect::<Read<_>>()?;
    let gases: Vec<Setup> = gases.iter().map(equilibrated).collect::<Result<_, _>>()?;
    let mut findings = Vec::new();
    for field in inputs.get("e")?.items()? {
        let restitution = positive(&field)?.min(1.0);
        let wanted = root.get("expected")?.entry_with_number(restitution)?;
        let t0 = positive(&wanted.get("t0")?)?;
        let mut tally = Tally::new(format!("e = {restitution}"));
        let cooling = |gas: &Setup| {
            let settings = Settings { restitution, ..gas.settings };
            Run::new(&Setup { settings, discs: gas.discs.clone() })
        };
        let mut runs: Vec<Run> = gases.iter().map(cooling).collect();
        let step = t0 / 400.0;
        for k in 1..100_000 {
            for run in &mut runs {
                run.pass(step * f64::from(k))?;
            }
            let at = f64::from(k) / 400.0;
            let law = (1.0 + at).powi(-2);
            let ours: Vec<f64> = runs.iter().map(|run| temperature(&run.discs())).collect();
            let ours = estimate(&ours);
            let pairs: u64 = runs.iter().map(|run| run.pairs).sum();
            let collisions = 2.0 * pairs as f64 / (COUNT * runs.len()) as f64;
            if collisions > most {
                judge_cooling(&mut tally, at, ours, law, percent);
                break;
            }
            if let Ok(listed) = wanted.get("T_at_t0_times")?.entry_with_number(at) {
                judge_cooling(&mut tally, at, ours, positive(&listed)?, percent);
            }
        }
        findings.push(tally.finish());
    }
    Ok(findings)
}

fn judge_cooling(tally: &mut Tally, at: f64, ours: Estimate, wanted: f64, percent: f64) {
    let bound = 0.01 * percent + 4.0 * ours.1 / wanted;
    tally.within(format!("T at {at} t0"), (ours.0 / wanted - 1.0).abs(), bound);
    tally.note(format!("T({at:.3} t0) {:.5} +- {:.5} of {wanted:.5}", ours.0, ours.1));
}

/// A gas after ten elastic collisions a disc.
fn equilibrated(setup: &Setup) -> Result<Setup, Halt> {
    let mut run = Run::new(setup);
    while (run.pairs as usize) < 5 * COUNT {
        run.pass(run.now() + 1.0)?;
    }
    Ok(setup.with(run.discs()))
}

/// kT of discs of mass 1 without total momentum.
fn temperature(discs: &[Disc]) -> f64 {
    discs.iter().map(Disc::kinetic_energy).sum::<f64>() / (discs.len() as f64 - 1.0)
}
