//! Kinds `stats_*`: long-time averages against exact or published means, with a z-score.
//!
//! Standard errors come from independent runs or from 50 blocks of one run; `<n> sigma` of the
//! tolerance bounds the z-score. Starts come from the scene generator with fixed seeds, so a
//! verdict does not change from run to run. A quick check takes fewer events, and its errors are
//! larger.

use std::f64::consts::PI;

use glam::DVec2;

use super::Effort;
use super::arena::{Run, Setup, Trouble, walls};
use super::case::{Field, Read};
use super::finding::{Finding, Tally};
use super::number;
use crate::motion::arena::Halt;
use crate::scene::batch::{Batch, Placed, Range};
use crate::world::{Contact, Disc, Partner, Settings, Walls};

type Findings = Result<Vec<Finding>, Trouble>;

/// Blocks of one run.
const BLOCKS: usize = 50;

/// Events of one run: enough for errors near 3e-4.
fn events(effort: Effort) -> f64 {
    if effort.is_full() { 2e7 } else { 1e6 }
}

/// A mean and its standard error.
pub type Estimate = (f64, f64);

/// Mean and standard error of independent values.
pub fn estimate(values: &[f64]) -> Estimate {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    (mean, (variance / (count * (count - 1.0))).sqrt())
}

/// The limit of the z-score: the number that a tolerance begins with, before "sigma".
pub fn limit(root: &Field) -> Read<f64> {
    let field = root.get("tolerance")?.get("value")?;
    let words: Vec<&str> = field.words()?.split_whitespace().collect();
    let sigma = words.iter().position(|word| word.starts_with("sigma"));
    let before = sigma.map(|k| &words[..k]).unwrap_or_default();
    let limit = before.iter().rev().find_map(|word| word.parse().ok());
    limit.ok_or_else(|| field.wrong("must say `<number> sigma`"))
}

/// Discs of these masses and radii at random places, with the kinetic energy asked for.
pub fn gas(
    bodies: &[(f64, f64)],
    walls: Walls,
    energy: f64,
    seed: u64,
    field: &Field,
) -> Read<Vec<Disc>> {
    let largest = bodies.iter().map(|(_, radius)| *radius).fold(0.0, f64::max);
    let mut placed = Placed::new(&[], largest);
    let mut discs = Vec::new();
    for (k, &(mass, radius)) in bodies.iter().enumerate() {
        let seed = seed.wrapping_mul(DISCS_MAX).wrapping_add(k as u64);
        let one = |value| Range { min: value, max: value };
        let batch = Batch {
            count: 1,
            seed,
            radius: one(radius),
            mass: one(mass),
            speed: 1.0,
            region: walls,
        };
        let found = placed.add_batch(&batch, &[k as u32]);
        discs.extend(found.map_err(|_| field.wrong("the discs find no place"))?);
    }
    let scale = (energy / discs.iter().map(Disc::kinetic_energy).sum::<f64>()).sqrt();
    discs.iter_mut().for_each(|disc| disc.velocity *= scale);
    Ok(discs)
}

/// Rates of pair and of wall contacts over so many events, after a while to forget the start.
fn rates(setup: &Setup, expected: f64, events: f64) -> Result<(Estimate, Estimate), Halt> {
    let mut run = Run::new(setup);
    let block = events / expected / BLOCKS as f64;
    run.pass(block)?;
    let (mut pairs, mut bounces) = (Vec::new(), Vec::new());
    for k in 1..=BLOCKS {
        let (start, pairs_before, walls_before) = (run.now(), run.pairs, run.walls);
        run.pass(block * (k as f64 + 1.0))?;
        let time = run.now() - start;
        pairs.push((run.pairs - pairs_before) as f64 / time);
        bounces.push((run.walls - walls_before) as f64 / time);
    }
    Ok((estimate(&pairs), estimate(&bounces)))
}

/// Two discs in a box: both rates, exact.
pub fn two_discs(root: &Field, effort: Effort) -> Findings {
    let limit = limit(root)?;
    let mut findings = Vec::new();
    for (label, input, expected) in root.subcases()? {
        let walls = walls(&input, 1.0)?;
        let body = |field: &Field| Ok((positive(&field.get("m")?)?, positive(&field.get("r")?)?));
        let bodies: Vec<_> = input.get("bodies")?.items()?.iter().map(body).collect::<Read<_>>()?;
        let energy = positive(&input.get("energy")?)?;
        let settings = Settings { walls: Some(walls), ..Settings::default() };
        let setup = Setup { settings, discs: gas(&bodies, walls, energy, 1, &input)? };
        let pair = positive(&expected.get("pair_collision_rate")?)?;
        let wall = positive(&expected.get("wall_collision_rate")?)?;
        let ours = rates(&setup, pair + wall, events(effort))?;
        let mut tally = Tally::new(label);
        tally.z("pair rate", ours.0, (pair, 0.0), limit);
        tally.z("wall rate", ours.1, (wall, 0.0), limit);
        findings.push(tally.finish());
    }
    Ok(findings)
}

/// A number above 0.
pub fn positive(field: &Field) -> Read<f64> {
    let value = field.finite()?;
    if value > 0.0 { Ok(value) } else { Err(field.wrong("must be above 0")) }
}

/// Discs at the places that a sentence gives, in a box: both rates, published with their errors.
pub fn discs_in_box(root: &Field, effort: Effort) -> Findings {
    let (inputs, expected) = (root.get("inputs")?, root.get("expected")?);
    let (limit, walls) = (limit(root)?, walls(&inputs, 1.0)?);
    let energy = positive(&inputs.get("energy")?)?;
    let bodies = inputs.get("bodies")?;
    let (mass, radius) = (bodies.number_after("m=")?, bodies.number_after("r=")?);
    let places = places(&bodies)?;
    let mut discs = gas(&vec![(mass, radius); places.len()], walls, energy, 1, &bodies)?;
    discs.iter_mut().zip(places).for_each(|(disc, place)| disc.position = place);
    let settings = Settings { walls: Some(walls), ..Settings::default() };
    let published = |key: &str| {
        let field = expected.get(key)?;
        number::with_error(field.words()?).ok_or_else(|| field.wrong("must be like 1.234(5)"))
    };
    let (pair, wall) = (published("pair_collision_rate")?, published("wall_collision_rate")?);
    let ours = rates(&Setup { settings, discs }, pair.0 + wall.0, events(effort))?;
    let mut tally = Tally::new("rates");
    tally.z("pair rate", ours.0, pair, limit);
    tally.z("wall rate", ours.1, wall, limit);
    Ok(vec![tally.finish()])
}

/// The "(x,y)" in a sentence.
fn places(bodies: &Field) -> Read<Vec<DVec2>> {
    let words = bodies.words()?;
    let place = |text: &str| {
        let (x, y) = text.split_once(')')?.0.split_once(',')?;
        Some(DVec2::new(x.trim().parse().ok()?, y.trim().parse().ok()?))
    };
    let places: Vec<DVec2> = words.split('(').skip(1).filter_map(place).collect();
    if places.is_empty() { Err(bodies.wrong("must give places as (x,y)")) } else { Ok(places) }
}

/// Most discs of a gas: no two seeds have one in common.
const DISCS_MAX: u64 = 20_000;
/// Area fraction of the gases whose density is not given.
const AREA_FRACTION: f64 = 0.2;

/// Moments of the velocities of N discs with kT = 1, half of them twice as heavy: means over time
/// and discs.
pub fn moments(root: &Field, effort: Effort) -> Findings {
    let (limit, inputs) = (limit(root)?, root.get("inputs")?);
    let mut findings = Vec::new();
    for field in inputs.get("N")?.items()? {
        let count = field.count(DISCS_MAX)?.max(2) as usize;
        let bodies: Vec<_> = (0..count).map(|k| (1.0 + (k % 2) as f64, 0.5)).collect();
        let side = (count as f64 * 0.25 * PI / AREA_FRACTION).sqrt();
        let walls = Walls { min: DVec2::ZERO, max: DVec2::splat(side), restitution: 1.0 };
        let settings = Settings { walls: Some(walls), ..Settings::default() };
        let discs = gas(&bodies, walls, count as f64, 1, &field)?;
        let wanted = root.get("expected")?.get(&count.to_string())?;
        let mut tally = Tally::new(format!("N = {count}"));
        let ours = velocity_moments(&Setup { settings, discs }, effort)?;
        let names = ["mean_m_vx2_over_kT", "mean_m2_vx4_over_kT2"].into_iter();
        let names = names.chain(["mean_v4_over_mean_v2_sq_equal_mass"]);
        for (name, ours) in names.chain(["mean_abs_sqrtm_vx_over_sqrt_kT"]).zip(ours) {
            // The mean of m v^2 is the energy, and exact: the ratio is that of a mean.
            tally.z(name, ours, (wanted.get(name)?.finite()?, 0.0), limit);
        }
        findings.push(tally.finish());
    }
    Ok(findings)
}

/// Samples of one block.
const SAMPLES: usize = 100;

fn velocity_moments(setup: &Setup, effort: Effort) -> Result<[Estimate; 4], Halt> {
    let mut run = Run::new(setup);
    let count = setup.discs.len() as f64;
    // Forget the start: some ten collisions a disc.
    while ((run.pairs + run.walls) as f64) < 20.0 * count {
        run.pass(run.now() + 1.0)?;
    }
    let rate = (run.pairs + run.walls) as f64 / run.now();
    // Many discs are many samples: a block then needs only outlast the memory of a velocity.
    let events = (0.1 * events(effort)).max(200.0 * count);
    let (start, step) = (run.now(), events / rate / (BLOCKS * SAMPLES) as f64);
    let mut blocks: [Vec<f64>; 4] = Default::default();
    for block in 0..BLOCKS {
        let mut sums = [0.0; 4];
        for sample in 1..=SAMPLES {
            run.pass(start + step * (block * SAMPLES + sample) as f64)?;
            run.discs().iter().for_each(|disc| add_moments(disc, &mut sums));
        }
        let samples = SAMPLES as f64 * count;
        blocks.iter_mut().zip(sums).for_each(|(block, sum)| block.push(sum / samples));
    }
    Ok(blocks.map(|block| estimate(&block)))
}

/// m vx^2, m^2 vx^4 (a mean of x and y), (m v^2)^2 / (2 kT)^2, sqrt(m) |vx| (a mean of x and y).
fn add_moments(disc: &Disc, sums: &mut [f64; 4]) {
    let scaled = disc.velocity * disc.mass.sqrt();
    let squares = scaled * scaled;
    sums[0] += squares.x;
    sums[1] += 0.5 * squares.length_squared();
    sums[2] += 0.25 * (squares.x + squares.y).powi(2);
    sums[3] += 0.5 * (scaled.x.abs() + scaled.y.abs());
}

/// A disc in a cage of six fixed ones: its collision rate, exact. Always the mean over many random
/// starts with equal times: in a narrow cage one trajectory mixes too slowly.
pub fn caged_disc(root: &Field, effort: Effort) -> Findings {
    let (limit, value) = (limit(root)?, root.get("tolerance")?.get("value")?);
    let share = if effort.is_full() { 1.0 } else { 0.2 };
    let starts = (value.number_after("average over >=")? * share) as u64;
    let collisions = value.number_after("one run of >=")? * share * share / starts as f64;
    let mut findings = Vec::new();
    for field in root.get("inputs")?.get("delta")?.items()? {
        let delta = positive(&field)?;
        let wanted = root.get("expected")?;
        let wanted = wanted.entry_with_number(delta)?.get("rate")?;
        let (rate, cage) = (positive(&wanted)?, cage(delta));
        let mut rates = Vec::new();
        for seed in 0..starts {
            let mut discs = vec![caged(&cage, delta, seed, &field)?];
            discs.extend(&cage);
            let mut run = Run::new(&Setup { settings: Settings::default(), discs });
            run.pass(collisions / rate)?;
            rates.push(run.pairs as f64 / run.now());
        }
        let mut tally = Tally::new(format!("delta = {delta}"));
        tally.z("rate", estimate(&rates), (rate, 0.0), limit);
        findings.push(tally.finish());
    }
    Ok(findings)
}

/// Six fixed discs of diameter 1 at distance 1 + delta.
pub fn cage(delta: f64) -> Vec<Disc> {
    let place = |k: u32| (1.0 + delta) * DVec2::from_angle(f64::from(k) * PI / 3.0);
    let velocity = DVec2::ZERO;
    let disc = |k| Disc { id: k, position: place(k), velocity, radius: 0.5, mass: f64::INFINITY };
    (1..=6).map(disc).collect()
}

/// The mobile disc, uniform over the free area and over all directions.
pub fn caged(cage: &[Disc], delta: f64, seed: u64, field: &Field) -> Read<Disc> {
    // The free area reaches to where two unit circles meet, on the line between two fixed discs.
    let distance = 1.0 + delta;
    let reach = distance * (PI / 6.0).cos() - (1.0 - 0.25 * distance * distance).max(0.0).sqrt();
    let one = Range { min: 1.0, max: 1.0 };
    let (half, radius) = (DVec2::splat(reach + 0.5), Range { min: 0.5, max: 0.5 });
    let region = Walls { min: -half, max: half, restitution: 1.0 };
    let batch = Batch { count: 1, seed, radius, mass: one, speed: 1.0, region };
    let found = Placed::new(cage, 0.5).add_batch(&batch, &[0]);
    let disc = found.map_err(|_| field.wrong("no place in the cage"))?[0];
    Ok(Disc { velocity: disc.velocity.normalize(), ..disc })
}

/// A gas that begins with equal speeds: K = <v^4>/<v^2>^2 over the discs, a mean over runs, when so
/// many collisions a disc have happened.
pub fn relaxation(root: &Field, effort: Effort) -> Findings {
    let (inputs, limit) = (root.get("inputs")?, limit(root)?);
    let count = inputs.get("N")?.count(DISCS_MAX)? as usize;
    let (radius, speed) = (positive(&inputs.get("r")?)?, positive(&inputs.get("speed")?)?);
    let (walls, runs) = (walls(&inputs, 1.0)?, inputs.get("runs")?.count(1 << 20)?.max(2));
    let runs = if effort.is_full() { runs } else { (runs / 5).max(2) };
    let expected = root.get("expected")?.get("K")?.entries()?;
    let number = |text: &str, field: &Field| text.parse().map_err(|_| field.wrong("no number"));
    let mut at: Vec<f64> = expected.iter().map(|(k, f)| number(k, f)).collect::<Read<_>>()?;
    at.sort_by(f64::total_cmp);
    let settings = Settings { walls: Some(walls), ..Settings::default() };
    let mut seen = vec![Vec::new(); at.len()];
    for seed in 1..=runs {
        let mut discs = gas(&vec![(1.0, radius); count], walls, 1.0, seed, &inputs)?;
        discs.iter_mut().for_each(|disc| disc.velocity = speed * disc.velocity.normalize());
        let ratios = speed_ratios(&Setup { settings, discs }, &at)?;
        seen.iter_mut().zip(ratios).for_each(|(seen, ratio)| seen.push(ratio));
    }
    let mut findings = Vec::new();
    for (collisions, values) in at.iter().zip(&seen) {
        let wanted = root.get("expected")?.get("K")?.entry_with_number(*collisions)?;
        let wanted = (wanted.get("mean")?.finite()?, wanted.get("sigma")?.finite()?);
        let mut tally = Tally::new(format!("{collisions} collisions per disc"));
        tally.z("K", estimate(values), wanted, limit);
        findings.push(tally.finish());
    }
    Ok(findings)
}

/// K at these numbers of collisions per disc, interpolated between short steps.
fn speed_ratios(setup: &Setup, at: &[f64]) -> Result<Vec<f64>, Halt> {
    let mut run = Run::new(setup);
    let per_pair = 2.0 / setup.discs.len() as f64;
    let ratio = |discs: &[Disc]| {
        let mean = |power: i32| {
            let powers = discs.iter().map(|disc| disc.velocity.length_squared().powi(power));
            powers.sum::<f64>() / discs.len() as f64
        };
        mean(2) / mean(1).powi(2)
    };
    let speed = setup.discs[0].velocity.length();
    let step = 0.05 * setup.discs[0].radius / speed;
    let mut before = (0.0, ratio(&setup.discs));
    let mut ratios = Vec::new();
    while ratios.len() < at.len() {
        run.pass(run.now() + step)?;
        let now = (per_pair * run.pairs as f64, ratio(&run.discs()));
        while let Some(&wanted) = at.get(ratios.len()).filter(|&&wanted| wanted <= now.0) {
            let share = (wanted - before.0) / (now.0 - before.0);
            ratios.push(before.1 + share * (now.1 - before.1));
        }
        before = now;
    }
    Ok(ratios)
}

/// Sinai's billiard as a disc in a square of free side 1 round a fixed disc, radii R/2 each: free
/// path and Lyapunov exponent by the curvature of the front, `k' = k / (1 + k t) + 2 / (R cos)`.
pub fn lyapunov(root: &Field, effort: Effort) -> Findings {
    let limit = limit(root)?;
    let mut findings = Vec::new();
    for field in root.get("inputs")?.get("R")?.items()? {
        let reach = positive(&field)?;
        let expected = root.get("expected")?.entry_with_number(reach)?;
        let path = positive(&expected.get("mean_free_path")?)?;
        let published = |key: &str| {
            let field = expected.get(key)?;
            number::with_error(field.words()?).ok_or_else(|| field.wrong("must be `x +- y`"))
        };
        // Four wall contacts in pi units of length.
        let collisions = 0.5 * events(effort) / (1.0 + 4.0 / PI * path);
        let ours = billiard(reach, path, collisions)?;
        let mut tally = Tally::new(format!("R = {reach}"));
        tally.z("mean free path", ours[0], (path, 0.0), limit);
        tally.z("exponent per collision", ours[1], published("lyapunov_per_collision")?, limit);
        tally.z("exponent per time", ours[2], published("lyapunov_per_time")?, limit);
        findings.push(tally.finish());
    }
    Ok(findings)
}

/// Sinai's billiard: the mobile disc first, beginning somewhere at speed 1.
pub fn billiard_scene(reach: f64) -> Setup {
    let radius = 0.5 * reach;
    let half = DVec2::splat(0.5 + radius);
    let walls = Walls { min: -half, max: half, restitution: 1.0 };
    let disc = |id, position, velocity, mass| Disc { id, position, velocity, radius, mass };
    let (place, velocity) = (DVec2::new(0.43, 0.41), DVec2::from_angle(0.7));
    let mobile = disc(0, place, velocity, 1.0);
    let fixed = disc(1, DVec2::ZERO, DVec2::ZERO, f64::INFINITY);
    let settings = Settings { walls: Some(walls), ..Settings::default() };
    Setup { settings, discs: vec![mobile, fixed] }
}

/// Free path, exponent per collision, exponent per time.
fn billiard(reach: f64, path: f64, collisions: f64) -> Result<[Estimate; 3], Halt> {
    let mut run = Run::new(&billiard_scene(reach));
    let block = collisions * path / BLOCKS as f64;
    let mut front = Front { curvature: 0.0, last: None, reach, sums: [0.0; 3] };
    run.advance(block, |contact| front.pass(contact))?;
    let mut blocks: [Vec<f64>; 3] = Default::default();
    for k in 1..=BLOCKS {
        front.sums = [0.0; 3];
        run.advance(block * (k as f64 + 1.0), |contact| front.pass(contact))?;
        let [count, time, stretch] = front.sums;
        let means = [time / count, stretch / count, stretch / time];
        blocks.iter_mut().zip(means).for_each(|(block, mean)| block.push(mean));
    }
    Ok(blocks.map(|block| estimate(&block)))
}

/// A front of trajectories beside the one that is followed.
struct Front {
    curvature: f64,
    last: Option<f64>,
    reach: f64,
    /// Collisions, time, logarithm of the stretching.
    sums: [f64; 3],
}

impl Front {
    /// Flies to a contact and is reflected; flat walls leave it as it is.
    fn pass(&mut self, contact: &Contact) {
        if matches!(contact.b, Partner::Wall(_)) {
            return;
        }
        if let Some(last) = self.last {
            let time = contact.time - last;
            let stretch = 1.0 + self.curvature * time;
            self.curvature /= stretch;
            let [count, times, stretches] = &mut self.sums;
            (*count, *times, *stretches) = (*count + 1.0, *times + time, *stretches + stretch.ln());
        }
        // The speed is 1: the approach speed is the cosine.
        self.curvature += 2.0 / (self.reach * contact.approach_speed);
        self.last = Some(contact.time);
    }
}
