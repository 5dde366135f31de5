//! What the robust time of impact costs and how exact it is: `cargo bench --bench impact`.
//!
//! Six categories of pairs in which plain formulas lose digits. Errors in units of 2^-53 against
//! 300-bit arithmetic, wrong decisions between hit and miss, and nanoseconds a pair: of many side by
//! side as the engine asks for them, of one by one, and of the plain formula inlined into a loop
//! over the same pairs, in turns in the same run. The ratio is that of many to plain.
//! With `-- --full`, 2e6 pairs a category.

use std::hint::black_box;
use std::time::Instant;

use carom::detect::impact::{Relative, pair_impact, pair_impacts};
use dashu_float::FBig;
use dashu_ratio::RBig;
use glam::DVec2;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

const CATEGORIES: [&str; 6] =
    ["generic", "far", "gap 1e-9..1e-13", "grazing", "far and grazing", "overlapping"];
const TURNS: usize = 41;

fn main() {
    let full = std::env::args().any(|argument| argument == "--full");
    let count = if full { 2_000_000 } else { 20_000 };
    println!("{count} pairs a category");
    println!(
        "{:>16} {:>10} {:>8} {:>8} {:>8} {:>8} {:>6}",
        "", "largest u", "wrong", "many ns", "one ns", "plain ns", "ratio"
    );
    let mut random = Random(Pcg64::seed_from_u64(1));
    for (category, name) in CATEGORIES.iter().enumerate() {
        let pairs: Vec<Relative> = (0..count).map(|_| pair(category, &mut random)).collect();
        let (worst, wrong) = errors(&pairs);
        let [many, one, plain] = times(&pairs[..pairs.len().min(4_096)]);
        let ratio = many / plain;
        println!(
            "{name:>16} {worst:>10.3} {wrong:>8} {many:>8.2} {one:>8.2} {plain:>8.2} {ratio:>6.2}"
        );
    }
}

struct Random(Pcg64);

impl Random {
    fn uniform(&mut self, min: f64, max: f64) -> f64 {
        min + (max - min) * (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn decades(&mut self, min: f64, max: f64) -> f64 {
        10f64.powf(self.uniform(min, max))
    }
}

/// A pair of a category: position and velocity of the second seen from the first, sum of radii.
fn pair(category: usize, random: &mut Random) -> Relative {
    let s = random.uniform(0.1, 2.0);
    let normal = DVec2::from_angle(random.uniform(0.0, std::f64::consts::TAU));
    let distance = match category {
        1 | 4 => s * random.decades(4.0, 6.0),
        2 => s * (1.0 + random.decades(-13.0, -9.0)),
        5 => s * random.uniform(0.5, 1.0),
        _ => s * random.uniform(1.0, 10.0),
    };
    let sine = match category {
        3 | 4 => 1.0 + random.uniform(-1.0, 1.0).signum() * random.decades(-12.0, -6.0),
        _ => random.uniform(-1.2, 1.2),
    };
    let sine = (s / distance * sine).clamp(-1.0, 1.0);
    let along = normal.perp() * sine - normal * (1.0 - sine * sine).sqrt();
    Relative { d: normal * distance, w: along * random.uniform(0.1, 3.0), s }
}

/// Largest relative error in 2^-53, and how often hit and miss were taken for each other.
fn errors(pairs: &[Relative]) -> (f64, usize) {
    let (mut worst, mut wrong) = (0.0f64, 0);
    let mut times = vec![0.0; pairs.len()];
    pair_impacts(pairs, &mut times);
    for (&Relative { d, w, s }, &t) in pairs.iter().zip(&times) {
        assert_eq!(t.to_bits(), pair_impact(d, w, s).unwrap_or(f64::INFINITY).to_bits());
        match exact(d, w, s) {
            Some(exact) if exact > 0.0 && t.is_finite() => {
                worst = worst.max((t - exact).abs() / exact * 2f64.powi(53));
            }
            exact => wrong += usize::from(t != exact.unwrap_or(f64::INFINITY)),
        }
    }
    (worst, wrong)
}

/// The judge: decisions in exact rationals, the root in 300 bits.
fn exact(d: DVec2, w: DVec2, s: f64) -> Option<f64> {
    let [dx, dy, wx, wy, s] = [d.x, d.y, w.x, w.y, s].map(|x| RBig::try_from(x).expect("finite"));
    let b = &dx * &wx + &dy * &wy;
    let c = &dx * &dx + &dy * &dy - &s * &s;
    let discriminant = &b * &b - (&wx * &wx + &wy * &wy) * &c;
    if b >= RBig::ZERO {
        return None;
    }
    if c <= RBig::ZERO {
        return Some(0.0);
    }
    if discriminant < RBig::ZERO {
        return None;
    }
    let float = |x: &RBig| -> FBig { x.to_float(300).value() };
    let root = dashu_base::SquareRoot::sqrt(&float(&discriminant));
    Some((float(&c) / (root - float(&b))).to_f64().value())
}

/// The yardstick: the textbook formula in its stable arrangement.
fn plain(d: DVec2, w: DVec2, s: f64) -> Option<f64> {
    let b = d.dot(w);
    if b >= 0.0 {
        return None;
    }
    let c = d.length_squared() - s * s;
    if c <= 0.0 {
        return Some(0.0);
    }
    let discriminant = b * b - w.length_squared() * c;
    (discriminant >= 0.0).then(|| c / (discriminant.sqrt() - b))
}

/// Median nanoseconds a pair: robust, of many and of one by one, and plain.
fn times(pairs: &[Relative]) -> [f64; 3] {
    let mut times = vec![0.0; pairs.len()];
    let mut turns: [Vec<f64>; 3] = Default::default();
    for _ in 0..TURNS {
        turns[0].push(time(pairs.len(), || pair_impacts(black_box(pairs), black_box(&mut times))));
        turns[1].push(time(pairs.len(), || one_by_one(pairs, pair_impact)));
        turns[2].push(time(pairs.len(), || one_by_one(pairs, plain)));
    }
    turns.map(median)
}

#[inline(always)]
fn one_by_one(pairs: &[Relative], formula: impl Fn(DVec2, DVec2, f64) -> Option<f64>) {
    for &Relative { d, w, s } in pairs {
        black_box(formula(d, w, s));
    }
}

fn time(count: usize, mut all: impl FnMut()) -> f64 {
    let start = Instant::now();
    (0..16).for_each(|_| all());
    start.elapsed().as_secs_f64() * 1e9 / (16 * count) as f64
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
