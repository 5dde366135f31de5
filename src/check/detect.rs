//! Kinds `predicate` and `detect_*`: which discs touch? Exact, without tolerance.

use glam::DVec2;

use super::Effort;
use super::arena::{Setup, Trouble};
use super::case::{Field, Read};
use super::finding::{Finding, Tally};
use crate::detect::touching::{overlap, touch};
use crate::detect::{Pair, touching_pairs};
use crate::plan::{BroadPhase, Plan};
use crate::resolve::touching::resolve;
use crate::world::{Disc, Settings, limits};

type Findings = Result<Vec<Finding>, Trouble>;

/// Looking at all pairs beside the grid is worth its time up to so many discs.
const ALL_PAIRS_TOO: usize = 2_000;

/// Whether two discs touch, and the sign of the gap: every sub-case must be right. The lists of
/// pairs must say the same as the predicate.
pub fn predicate(root: &Field, _: Effort) -> Findings {
    let mut findings = Vec::new();
    for (label, input, expected) in root.subcases()? {
        let discs = Setup::read(&input)?.discs;
        let [a, b] = discs[..] else { return Err(input.wrong("must have two bodies").into()) };
        let mut tally = Tally::new(label);
        let touching = expected.get("touching_or_overlap")?.flag()?;
        tally.exact("touching", touch(&a, &b, 0.0), touching);
        for broad_phase in [BroadPhase::AllPairs, BroadPhase::Grid] {
            let found = touching_pairs(&discs, 0.0, broad_phase).map(|pairs| !pairs.is_empty());
            tally.exact("pair listed", found, Ok(touching));
        }
        if let Some(sign) = expected.find("exact_gap_sq_sign") {
            let ours = if overlap(&a, &b) { -1.0 } else { f64::from(!touch(&a, &b, 0.0)) };
            tally.exact("sign of the gap", ours, sign.number()?);
        }
        findings.push(tally.finish());
    }
    Ok(findings)
}

/// Discs from SplitMix64 on a lattice of 1/`scale`: the first `n_big` as large as `first5` says,
/// the others with radii from 1/2 to 3/2. Number of pairs, the first and last ones, and the hash.
pub fn generated(root: &Field, _: Effort) -> Findings {
    let (inputs, expected) = (root.get("inputs")?, root.get("expected")?);
    let discs = generate(&inputs)?;
    let mut tally = Tally::new("pairs");
    let pairs = detect(&discs, &mut tally);
    tally.exact("number", pairs.len() as u64, expected.get("contact_count")?.count(u64::MAX)?);
    for (k, field) in expected.get("first10")?.items()?.iter().enumerate() {
        tally.exact("one of the first", pairs.get(k).copied(), Some(pair_of(field)?));
    }
    tally.exact("last", pairs.last().copied(), Some(pair_of(&expected.get("last")?)?));
    let hash = expected.get("lcg_hash_over_sorted_pairs")?;
    tally.exact("hash", hash_of(&pairs).to_string().as_str(), hash.words()?);
    Ok(vec![tally.finish()])
}

fn pair_of(field: &Field) -> Read<Pair> {
    Ok((index(&field.item(0)?)?, index(&field.item(1)?)?))
}

fn index(field: &Field) -> Read<usize> {
    Ok(field.count(u64::from(u32::MAX))? as usize)
}

fn generate(inputs: &Field) -> Read<Vec<Disc>> {
    let generator = inputs.get("generator")?;
    if generator.words()? != "splitmix64" {
        return Err(generator.wrong("must be splitmix64"));
    }
    let whole = |key: &str| inputs.get(key)?.count(1 << 32);
    let (side, scale, large) = (whole("L")?, whole("scale")?, whole("n_big")?);
    let count = inputs.get("N")?.count(limits::PUCKS_PER_SCENE as u64)?;
    if side == 0 || scale == 0 || side.checked_mul(scale).is_none() {
        return Err(inputs.wrong("`L` and `scale` must be above 0"));
    }
    let first = inputs.get("first5")?;
    let radius = if large > 0 { first.item(0)?.item(2)?.finite()? } else { 1.0 };
    let mut random = SplitMix64(inputs.get("seed")?.count(u64::MAX)?);
    let unit = 1.0 / scale as f64;
    let disc = |k: u64| {
        let mut place = || (random.next() % (scale * side)) as f64 * unit;
        let position = DVec2::new(place(), place());
        let small = k >= large;
        let drawn = if small { scale / 2 + random.next() % scale } else { 0 };
        let radius = if small { drawn as f64 * unit } else { radius };
        Disc { id: k as u32, position, velocity: DVec2::ZERO, radius, mass: 1.0 }
    };
    let discs: Vec<Disc> = (0..count).map(disc).collect();
    for (field, disc) in first.items()?.iter().zip(&discs) {
        let ours = [disc.position.x, disc.position.y, disc.radius];
        for (k, value) in ours.into_iter().enumerate() {
            if field.item(k)?.number()? != value {
                return Err(field.wrong(format_args!("the generator gives {ours:?}")));
            }
        }
    }
    Ok(discs)
}

/// Steele, Lea, Flood, doi:10.1145/2714064.2660195.
pub struct SplitMix64(pub u64);

impl SplitMix64 {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }
}

/// The hash that the files define over sorted pairs.
fn hash_of(pairs: &[Pair]) -> u64 {
    pairs.iter().fold(0, |hash: u64, &(i, j)| {
        let pair = ((i as u64) << 32).wrapping_add(j as u64);
        let hash = hash.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(pair);
        hash.wrapping_add(1_442_695_040_888_963_407)
    })
}

/// A hexagonal lattice at rest: the number of pairs; resolving them leaves everything at rest.
pub fn hexagonal(root: &Field, _: Effort) -> Findings {
    let (inputs, expected) = (root.get("inputs")?, root.get("expected")?);
    let mut discs = lattice(&inputs)?;
    let mut tally = Tally::new("pairs");
    let pairs = detect(&discs, &mut tally);
    tally.exact("number", pairs.len() as u64, expected.get("contact_count")?.count(u64::MAX)?);
    let resolved = resolve(&mut discs, &pairs, 1.0, 0.0);
    tally.exact("contacts resolved", resolved.contacts.len(), 0);
    let resting = |disc: &Disc| disc.velocity.to_array().map(f64::to_bits) == [0, 0];
    tally.exact("at rest", discs.iter().all(resting), true);
    Ok(vec![tally.finish()])
}

fn lattice(inputs: &Field) -> Read<Vec<Disc>> {
    let most = limits::PUCKS_PER_SCENE as u64;
    let (rows, columns) = (inputs.get("rows")?.count(most)?, inputs.get("cols")?.count(most)?);
    if rows * columns > most {
        return Err(inputs.wrong(format_args!("at most {most} discs")));
    }
    let radius = inputs.get("radius")?.finite()?;
    let (pitch_x, shift) = (inputs.get("pitch_x")?.finite()?, inputs.get("shift_odd")?.finite()?);
    let pitch = inputs.get("pitch_y")?;
    let pitch_y = match pitch.words() {
        Ok(words) => {
            let formula = words.trim_end_matches("rounded to double");
            super::formula::evaluate(formula, &[]).map_err(|error| pitch.wrong(error))?
        }
        Err(_) => pitch.finite()?,
    };
    let place = |k: u64| {
        let (row, column) = (k / columns, k % columns);
        let x = column as f64 * pitch_x + if row % 2 == 1 { shift } else { 0.0 };
        DVec2::new(x, row as f64 * pitch_y)
    };
    let velocity = DVec2::ZERO;
    let disc = |k: u64| Disc { id: k as u32, position: place(k), velocity, radius, mass: 1.0 };
    let discs: Vec<Disc> = (0..rows * columns).map(disc).collect();
    let defect = discs.iter().find_map(Disc::defect);
    defect.map_or(Ok(discs), |defect| Err(inputs.wrong(defect)))
}

/// The touching pairs by the way that the plan chooses; for few discs, the judge must agree.
fn detect(discs: &[Disc], tally: &mut Tally) -> Vec<Pair> {
    let broad_phase = Plan::of(&Settings::default(), discs).broad_phase(discs.len());
    let pairs = touching_pairs(discs, 0.0, broad_phase).unwrap_or_else(|error| {
        tally.fail(error.to_string());
        Vec::new()
    });
    if discs.len() <= ALL_PAIRS_TOO {
        let judge = touching_pairs(discs, 0.0, BroadPhase::AllPairs);
        tally.exact("all pairs looked at", judge.as_ref() == Ok(&pairs), true);
    }
    pairs
}
