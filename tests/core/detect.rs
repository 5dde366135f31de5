//! Detection against its judges: exact rationals, and all pairs.

use carom::detect::impact::{Relative, may_meet_within, pair_impact, pair_impacts, wall_impact};
use carom::detect::touching::{gap, overlap, touch};
use carom::detect::{TooManyPairs, all_pairs, fused, grid};
use carom::world::{Disc, Side, Walls};
use dashu_float::FBig;
use dashu_ratio::RBig;
use glam::DVec2;

use crate::common::{Random, disc};

fn rational(x: f64) -> RBig {
    RBig::try_from(x).expect("finite")
}

/// Sign of `|d|^2 - (ra + rb)^2`, exactly.
fn exact_gap_sign(a: &Disc, b: &Disc) -> std::cmp::Ordering {
    let dx = rational(b.position.x) - rational(a.position.x);
    let dy = rational(b.position.y) - rational(a.position.y);
    let reach = rational(a.radius) + rational(b.radius);
    (&dx * &dx + &dy * &dy).cmp(&(&reach * &reach))
}

fn nudge(x: f64, ulps: i64) -> f64 {
    f64::from_bits((x.to_bits() as i64 + ulps) as u64)
}

#[test]
fn touch_is_exact_within_an_ulp() {
    let mut random = Random::new(3);
    let mut counts = [0; 3];
    for _ in 0..20_000 {
        let scale = random.wide(100.0).abs();
        let (ra, rb) = (random.uniform(0.5, 2.0) * scale, random.uniform(0.5, 2.0) * scale);
        let d = random.direction() * (ra + rb);
        let a = disc(1, (random.vector(1.0) * scale).to_array(), [0.0; 2], ra, 1.0);
        let mut b = disc(2, (a.position + d).to_array(), [0.0; 2], rb, 1.0);
        b.position.x = nudge(b.position.x, random.below(5) as i64 - 2);
        let sign = exact_gap_sign(&a, &b);
        assert_eq!(touch(&a, &b, 0.0), sign.is_le(), "{a:?} {b:?}");
        assert_eq!(overlap(&a, &b), sign.is_lt(), "{a:?} {b:?}");
        counts[(sign as i8 + 1) as usize] += 1;
    }
    assert!(counts[0] > 5_000 && counts[2] > 5_000, "both sides were tried: {counts:?}");
    // Exact touching happens, and counts.
    let (a, b) = (disc(1, [0.0; 2], [0.0; 2], 2.0, 1.0), disc(2, [3.0, 4.0], [0.0; 2], 3.0, 1.0));
    assert!(touch(&a, &b, 0.0) && !overlap(&a, &b));
}

#[test]
fn touch_holds_at_the_ends_of_the_range() {
    for scale in [5e-324, 1e-310, 1e-160, 1e160, 1e307] {
        let a = disc(1, [0.0; 2], [0.0; 2], 2.0 * scale, 1.0);
        let at = |x: f64| disc(2, [x, 0.0], [0.0; 2], 2.0 * scale, 1.0);
        assert!(touch(&a, &at(4.0 * scale), 0.0), "{scale}");
        assert!(!touch(&a, &at(nudge(4.0 * scale, 1)), 0.0), "{scale}");
    }
}

#[test]
fn margin_widens_the_reach() {
    let (a, b) = (disc(1, [0.0; 2], [0.0; 2], 1.0, 1.0), disc(2, [2.5, 0.0], [0.0; 2], 1.0, 1.0));
    assert!(!touch(&a, &b, 0.25) && touch(&a, &b, 0.5));
}

#[test]
fn gap_keeps_its_digits() {
    let a = disc(1, [0.0; 2], [0.0; 2], 1.0, 1.0);
    let b = disc(2, [2.0 + 1e-13, 0.0], [0.0; 2], 1.0, 1.0);
    let exact = (2.0 + 1e-13) - 2.0;
    assert!((gap(&a, &b) - exact).abs() <= 1e-15 * exact);
    assert_eq!(gap(&a, &disc(3, [1.0, 0.0], [0.0; 2], 1.0, 1.0)), -1.0);
}

/// Random scenes: equal, mixed, one giant, 1:1000, clumps, outliers.
fn scenes() -> Vec<Vec<Disc>> {
    let mut random = Random::new(4);
    let mut scenes = vec![Vec::new()];
    for kind in 0..7 {
        for count in [1, 2, 40, 300] {
            let scene = (0..count).map(|id| {
                let radius = match kind {
                    0 => 0.5,
                    1 => random.uniform(0.1, 1.0),
                    2 if id == 0 => 8.0,
                    2 => 0.3,
                    3 => 10f64.powf(random.uniform(-3.0, 0.0)),
                    _ => random.uniform(0.1, 0.6),
                };
                let position = match kind {
                    4 => random.vector(1.0),
                    5 if id % 7 == 0 => random.vector(1.0) * 10f64.powf(random.uniform(0.0, 300.0)),
                    6 => (random.vector(10.0) * 2.0).round() / 2.0,
                    _ => random.vector(12.0),
                };
                disc(id, position.to_array(), [0.0; 2], radius, 1.0)
            });
            scenes.push(scene.collect());
        }
    }
    scenes
}

#[test]
fn grid_finds_the_pairs_of_all_pairs() {
    let mut found = 0;
    for scene in scenes() {
        for margin in [0.0, 0.2] {
            let judge = all_pairs::touching_pairs(&scene, margin).expect("few");
            assert_eq!(grid::touching_pairs(&scene, margin).expect("few"), judge);
            found += judge.len();
        }
    }
    assert!(found > 10_000, "the scenes have contacts: {found}");
}

#[test]
fn heaped_circles_are_refused_and_do_not_hang() {
    let heap = vec![disc(1, [0.0; 2], [0.0; 2], 1.0, 1.0); 20_000];
    assert_eq!(grid::touching_pairs(&heap, 0.0), Err(TooManyPairs));
}

/// Time of impact in 300 bits, and the exact decision.
fn exact_impact(d: DVec2, w: DVec2, s: f64) -> Option<f64> {
    let [dx, dy, wx, wy, s] = [d.x, d.y, w.x, w.y, s].map(rational);
    let b = &dx * &wx + &dy * &wy;
    let c = &dx * &dx + &dy * &dy - &s * &s;
    let w2 = &wx * &wx + &wy * &wy;
    let disc = &b * &b - &w2 * &c;
    if b >= RBig::ZERO {
        return None;
    }
    if c <= RBig::ZERO {
        return Some(0.0);
    }
    if disc < RBig::ZERO {
        return None;
    }
    let float = |x: &RBig| -> FBig { x.to_float(300).value() };
    let root = dashu_base::SquareRoot::sqrt(&float(&disc));
    Some((float(&c) / (root - float(&b))).to_f64().value())
}

/// A pair of one of the categories in which plain formulas lose digits.
fn impact_case(category: usize, random: &mut Random) -> (DVec2, DVec2, f64) {
    let s = random.uniform(0.1, 2.0);
    let normal = random.direction();
    let speed = random.uniform(0.1, 3.0);
    let distance = match category {
        1 | 4 => s * 10f64.powf(random.uniform(4.0, 6.0)),
        2 => s * (1.0 + 10f64.powf(random.uniform(-13.0, -9.0))),
        5 => s * (1.0 - random.uniform(0.0, 0.5)),
        _ => s * random.uniform(1.0, 10.0),
    };
    let sine = match category {
        3 | 4 => s / distance * (1.0 - random.wide(1.0) * 10f64.powf(random.uniform(-13.0, -7.0))),
        _ => s / distance * random.uniform(-1.2, 1.2),
    };
    let sine = sine.clamp(-1.0, 1.0);
    let along = -normal * (1.0 - sine * sine).sqrt() + normal.perp() * sine;
    (normal * distance, along * speed, s)
}

#[test]
fn time_of_impact_is_right_to_a_few_ulp_in_every_category() {
    const PAIRS: usize = 8_000;
    let mut random = Random::new(5);
    for category in 0..6 {
        let (mut worst, mut hits) = (0.0f64, 0);
        for _ in 0..PAIRS {
            let (d, w, s) = impact_case(category, &mut random);
            let (computed, exact) = (pair_impact(d, w, s), exact_impact(d, w, s));
            assert_eq!(computed.is_some(), exact.is_some(), "hit or miss: {d} {w} {s}");
            if let (Some(computed), Some(exact)) = (computed, exact) {
                hits += 1;
                assert!(may_meet_within(d, w, s, exact), "{d} {w} {s}");
                if exact > 0.0 {
                    worst = worst.max((computed - exact).abs() / exact * 2f64.powi(53));
                } else {
                    assert_eq!(computed, 0.0);
                }
            }
        }
        println!("category {category}: {hits} hits, largest error {worst:.2} u");
        assert!(worst <= 6.0 && hits > PAIRS / 8, "category {category}: {worst} u, {hits} hits");
    }
}

#[test]
fn both_kinds_of_processor_give_the_same_bits() {
    let mut random = Random::new(6);
    for k in 0..60_000 {
        let (d, w, s) = impact_case(k % 6, &mut random);
        let [plain, fused] = [fused::without_fused_operations(d, w, s), pair_impact(d, w, s)];
        assert_eq!(plain.map(f64::to_bits), fused.map(f64::to_bits));
    }
}

#[test]
fn many_pairs_get_the_bits_of_each_alone() {
    let mut random = Random::new(7);
    for count in (0..2_000).map(|k| k % 60) {
        let mut pairs: Vec<Relative> = (0..count)
            .map(|_| {
                let (d, w, s) = impact_case(random.uniform(0.0, 6.0) as usize, &mut random);
                Relative { d, w: if random.uniform(0.0, 1.0) < 0.2 { -w } else { w }, s }
            })
            .collect();
        // Numbers out of range give what they give alone, and disturb no neighbour.
        if let Some(pair) = pairs.get_mut(13) {
            pair.d.x = [f64::NAN, f64::INFINITY, 1e200, 1e-200, 0.0][count % 5];
        }
        let (mut wide, mut plain) = (vec![1.0; count], vec![2.0; count]);
        pair_impacts(&pairs, &mut wide);
        fused::one_by_one(&pairs, &mut plain);
        for (pair, (wide, plain)) in pairs.iter().zip(wide.iter().zip(&plain)) {
            let alone = pair_impact(pair.d, pair.w, pair.s).unwrap_or(f64::INFINITY);
            let same = |t: f64| t.to_bits() == alone.to_bits() || t.is_nan() && alone.is_nan();
            assert!(same(*wide) && same(*plain), "{pair:?}: {wide}, {plain}, alone {alone}");
        }
    }
}

#[test]
fn walls_are_met_in_the_direction_of_motion_only() {
    let walls = Walls { min: DVec2::ZERO, max: DVec2::new(4.0, 2.0), restitution: 1.0 };
    let hit = |x: [f64; 2], v: [f64; 2]| {
        wall_impact(DVec2::from_array(x), DVec2::from_array(v), 0.5, &walls)
            .map(|hit| (hit.time, hit.side))
    };
    assert_eq!(hit([1.0, 1.0], [1.0, 0.0]), Some((2.5, Side::Right)));
    assert_eq!(hit([1.0, 1.0], [-1.0, 0.5]), Some((0.5, Side::Left)));
    assert_eq!(hit([1.0, 1.0], [0.0, 0.25]), Some((2.0, Side::Top)));
    assert_eq!(hit([1.0, 1.0], [0.0, -0.25]), Some((2.0, Side::Bottom)));
    assert_eq!(hit([1.0, 1.0], [0.0, 0.0]), None);
    // One ulp beyond the wall: outwards is now, inwards is the far wall.
    let beyond = nudge(0.5, -1);
    assert_eq!(hit([beyond, 1.0], [-1.0, 0.0]), Some((0.0, Side::Left)));
    assert_eq!(hit([beyond, 1.0], [1.0, 0.0]).map(|hit| hit.1), Some(Side::Right));
}
