//! The pairs that the forms of the law are tried on: the reference cases, and random ones like them
//! from a seed.

use glam::DVec2;
use serde_json::Value;

use crate::check::arena::Setup;
use crate::check::case::{Field, Read};
use crate::report::figures::random::Random;
use crate::world::Disc;

/// Two discs in contact, and their restitution.
#[derive(Clone, Copy, Debug)]
pub struct Touching {
    /// The first.
    pub a: Disc,
    /// The second.
    pub b: Disc,
    /// Restitution.
    pub restitution: f64,
}

/// Pairs with something in common.
pub struct Category {
    /// What it is.
    pub name: &'static str,
    /// Whether squares of sizes may leave the range of doubles.
    pub is_extreme: bool,
    /// The pairs.
    pub pairs: Vec<Touching>,
}

/// Draws one pair.
type Draw = fn(&mut Random) -> Touching;

/// Seed of the random pairs.
pub const SEED: u64 = 3;

/// R03 to R09 and R10 to R11: what one knows them by, and their text.
const USUAL: [&str; 9] = [
    include_str!("../../../../tests/cases/R03_mass_ratio.json"),
    include_str!("../../../../tests/cases/R04_restitution.json"),
    include_str!("../../../../tests/cases/R04_restitution_b.json"),
    include_str!("../../../../tests/cases/R05_grazing.json"),
    include_str!("../../../../tests/cases/R06_no_normal_motion.json"),
    include_str!("../../../../tests/cases/R07_galilean.json"),
    include_str!("../../../../tests/cases/R08_rotation.json"),
    include_str!("../../../../tests/cases/R08_rotation_b.json"),
    include_str!("../../../../tests/cases/R09_offset.json"),
];
const EXTREME: [&str; 3] = [
    include_str!("../../../../tests/cases/R10_unit_scale.json"),
    include_str!("../../../../tests/cases/R11_subnormal.json"),
    include_str!("../../../../tests/cases/R11_subnormal_b.json"),
];

/// All categories, with so many pairs in each random one.
///
/// # Errors
/// What is wrong with a case.
pub fn categories(count: usize) -> Result<Vec<Category>, String> {
    let category = |name, is_extreme, pairs| Category { name, is_extreme, pairs };
    let mut all = vec![
        category("cases R03 to R09", false, cases(&USUAL)?),
        category("cases R10 and R11: extreme units", true, cases(&EXTREME)?),
    ];
    let drawn: [(&'static str, Draw); 5] = [
        ("like sizes and speeds", usual),
        ("mass ratios 1e-12 to 1e12", mass_ratio),
        ("1e3 to 1e9 m from the origin", offset),
        ("grazing, to 2^-56 of the speed", grazing),
        ("frames at 10 to 1e6 times the speed", moving),
    ];
    for (name, draw) in drawn {
        let mut random = Random::new(SEED);
        all.push(category(name, false, (0..count).map(|_| draw(&mut random)).collect()));
    }
    Ok(all)
}

fn cases(texts: &[&str]) -> Result<Vec<Touching>, String> {
    let mut pairs = Vec::new();
    for text in texts {
        let document: Value = serde_json::from_str(text).map_err(|error| error.to_string())?;
        let read = read(&Field::root(&document)).map_err(|error| error.to_string())?;
        pairs.extend(read);
    }
    Ok(pairs)
}

fn read(root: &Field) -> Read<Vec<Touching>> {
    let mut pairs = Vec::new();
    for (_, input, _) in root.subcases()? {
        let inputs = input.find("inputs").unwrap_or(input);
        let Setup { settings, discs } = Setup::read(&inputs)?;
        let [a, b] = discs[..] else { return Err(inputs.wrong("must have two bodies")) };
        pairs.push(Touching { a, b, restitution: settings.restitution });
    }
    Ok(pairs)
}

/// Discs of about a metre and a kilogram that meet at about a metre a second; half are elastic.
fn usual(random: &mut Random) -> Touching {
    at_angle(random, std::f64::consts::PI * 0.49)
}

/// The same with a relative velocity at up to this angle from the line of centres.
fn at_angle(random: &mut Random, largest: f64) -> Touching {
    let angle = random.uniform(-largest, largest);
    let normal = DVec2::from_angle(random.uniform(0.0, std::f64::consts::TAU));
    let across = normal.perp() * angle.sin() - normal * angle.cos();
    with_direction(random, normal, across)
}

fn with_direction(random: &mut Random, normal: DVec2, direction: DVec2) -> Touching {
    let point =
        |random: &mut Random| DVec2::new(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
    let radii = [random.uniform(0.3, 2.0), random.uniform(0.3, 2.0)];
    let disc = |id, position, velocity, mass| Disc {
        id,
        position,
        velocity,
        radius: radii[id as usize],
        mass,
    };
    let (at, velocity) = (point(random), point(random));
    let speed = random.uniform(0.5, 2.0);
    let masses = [random.uniform(0.5, 2.0), random.uniform(0.5, 2.0)];
    let restitution = if random.sign() > 0.0 { 1.0 } else { random.uniform(0.0, 1.0) };
    Touching {
        a: disc(0, at, velocity, masses[0]),
        b: disc(1, at + normal * (radii[0] + radii[1]), velocity + direction * speed, masses[1]),
        restitution,
    }
}

fn mass_ratio(random: &mut Random) -> Touching {
    let mut pair = usual(random);
    pair.b.mass *= random.decades(-12.0, 12.0);
    pair
}

fn offset(random: &mut Random) -> Touching {
    let mut pair = usual(random);
    let by = DVec2::from_angle(random.uniform(0.0, std::f64::consts::TAU));
    let by = by * random.decades(3.0, 9.0);
    pair.a.position += by;
    pair.b.position += by;
    pair
}

/// Some of them part by as little.
fn grazing(random: &mut Random) -> Touching {
    let normal = DVec2::from_angle(random.uniform(0.0, std::f64::consts::TAU));
    let along = random.sign() * 2f64.powf(random.uniform(-56.0, -4.0));
    let side = random.sign();
    let mut pair = with_direction(random, normal, normal.perp() * side);
    // At rest, so that no other rounding hides what was asked for.
    pair.a.velocity = DVec2::ZERO;
    pair.a.position = DVec2::ZERO;
    pair.b.position = normal * (pair.a.radius + pair.b.radius);
    pair.b.velocity = (normal.perp() * side + normal * along) * random.uniform(0.5, 2.0);
    pair
}

fn moving(random: &mut Random) -> Touching {
    let mut pair = usual(random);
    let by = DVec2::from_angle(random.uniform(0.0, std::f64::consts::TAU));
    let by = by * random.decades(1.0, 6.0);
    pair.a.velocity += by;
    pair.b.velocity += by;
    pair
}
