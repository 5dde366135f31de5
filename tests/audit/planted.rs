//! One violation planted in each of many recordings: its name, time and pair must be found, and
//! nothing else.

use carom::audit::findings::{Break, Findings, Kind, Violation};
use carom::audit::{Frame, Options};
use carom::world::{Disc, Owner, Periodic};
use glam::DVec2;

use crate::audited;
use crate::clean::told;
use crate::common::{Random, disc};
use crate::recordings::{Engine, Gas, Spoil, Spoilt};

/// How often a kind was planted, found by its name, found as a wrong group with the pair in it, and
/// how many other violations there were.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Tally {
    planted: u64,
    named: u64,
    grouped: u64,
    beside: u64,
}

impl Tally {
    fn add(&mut self, findings: &Findings, spoilt: &Spoilt, wanted: &[Kind], within: f64) {
        let is_it = |time: f64, discs: &[u32]| {
            spoilt.pair.iter().all(|id| discs.contains(id)) && (time - spoilt.time).abs() < within
        };
        let all = findings.violations.iter();
        let its: Vec<_> = all.filter(|each| is_it(each.time_s, &each.discs)).collect();
        let named = its.iter().any(|each| each.discs.len() == 2 && wanted.contains(&each.kind));
        self.planted += 1;
        self.named += u64::from(named);
        self.grouped += u64::from(!named && !its.is_empty());
        self.beside += findings.violations_in_all() - its.len() as u64;
        if !named || its.len() as u64 != findings.violations_in_all() {
            println!("{spoilt:?}: {:?}", findings.violations);
        }
    }
}

/// The first collision after a while that is not grazing, of discs of unlike masses, is spoilt.
fn planted(how: Spoil, wanted: &[Kind], rate: f64) -> Tally {
    let mut tally = Tally::default();
    for seed in 1..=20 {
        let (size_ratio, mass_max, restitution) = (1.5, 4.0, 0.9);
        let gas = Gas { size_ratio, mass_max, restitution, seed, ..Gas::new(60, 0.2) };
        let (arena, settings) = gas.arena();
        let discs: Vec<Disc> = arena.discs(Owner::Simulated).collect();
        let mut engine = Engine::new(discs, restitution, settings.walls);
        let clear = |discs: &[Disc], i: usize, j: usize, now: f64| {
            let (a, b) = (&discs[i], &discs[j]);
            let n = (b.position - a.position).normalize();
            let w = b.velocity - a.velocity;
            now > 0.2 && -w.dot(n) > 0.3 * w.length() && (a.mass - b.mass).abs() > 0.3
        };
        let (frames, spoilt) = engine.record(rate, (0.8 * rate) as usize, Some(how), clear);
        let spoilt = spoilt.expect("a collision");
        let (findings, _) = audited(frames, &told(restitution, settings.walls));
        // A late answer comes when the discs overlap, not when they meet.
        let within = if matches!(how, Spoil::Late(_)) { 0.1 } else { 0.01 };
        tally.add(&findings, &spoilt, wanted, within);
    }
    tally
}

#[test]
fn what_is_planted_is_found_by_its_name_and_nothing_else() {
    for (how, wanted) in [
        (Spoil::Momentum, &[Kind::Momentum][..]),
        (Spoil::Energy, &[Kind::Energy]),
        (Spoil::Normal, &[Kind::Normal]),
        (Spoil::Sticking, &[Kind::Sticking]),
        (Spoil::SwappedMasses, &[Kind::SwappedMasses]),
        (Spoil::Scaled, &[Kind::ScaledVelocities]),
        (Spoil::Unseen, &[Kind::Missed, Kind::Tunnelling]),
        (Spoil::Late(0.2), &[Kind::Late]),
    ] {
        for rate in [240.0, 60.0] {
            let tally = planted(how, wanted, rate);
            println!("{how:?} at {rate} Hz: {tally:?}");
            assert_eq!(tally.beside, 0, "{how:?} {rate}: {tally:?}");
            assert_eq!(tally.named + tally.grouped, tally.planted, "{how:?} {rate}: {tally:?}");
            assert!(tally.named >= 18, "{how:?} {rate}: {tally:?}");
        }
    }
}

/// Two discs, from their states at each of some times.
fn film(rate: f64, frames: usize, at: impl Fn(f64) -> [Disc; 2]) -> Vec<Frame> {
    let sample = |k: usize| {
        let time = k as f64 / rate;
        Frame { time_ns: (1e9 * time).round() as i64, discs: at(time).to_vec() }
    };
    (0..frames).map(sample).collect()
}

fn moved(disc: Disc, time: f64) -> Disc {
    Disc { position: disc.position + disc.velocity * time, ..disc }
}

/// The only violation, by name.
fn only(frames: Vec<Frame>) -> (Kind, f64, Vec<u32>) {
    let (findings, _) = audited(frames, &told(0.9, None));
    assert_eq!(findings.violations_in_all(), 1, "{:?}", findings.violations);
    let found = &findings.violations[0];
    (found.kind, found.time_s, found.discs.clone())
}

#[test]
fn small_fast_discs_that_pass_through_each_other_tunnel() {
    let discs = [
        disc(1, [-1.05, 0.0], [6.0, 0.0], 0.01, 1.0),
        disc(2, [1.0, 0.005], [-6.0, 0.0], 0.01, 1.0),
    ];
    let frames = film(60.0, 20, |time| discs.map(|disc| moved(disc, time)));
    let (kind, time, pair) = only(frames);
    let meet = (2.05 - (0.02f64.powi(2) - 0.005f64.powi(2)).sqrt()) / 12.0;
    assert_eq!((kind, pair), (Kind::Tunnelling, vec![1, 2]));
    assert!((time - meet).abs() < 1e-9, "{time} {meet}");
}

#[test]
fn large_slow_discs_that_pass_through_each_other_miss_their_collision() {
    let discs =
        [disc(1, [-0.5, 0.0], [1.0, 0.0], 0.1, 1.0), disc(2, [0.5, 0.05], [-1.0, 0.0], 0.1, 1.0)];
    let (kind, time, pair) = only(film(60.0, 60, |time| discs.map(|disc| moved(disc, time))));
    let meet = (1.0 - (0.2f64.powi(2) - 0.05f64.powi(2)).sqrt()) / 2.0;
    assert_eq!((kind, pair), (Kind::Missed, vec![1, 2]));
    assert!((time - meet).abs() < 1e-9, "{time} {meet}");
}

/// What an engine records that looks for overlaps only at the stamps and then answers them
/// lawfully, with how many it answered.
fn answered_at_stamps(mut discs: Vec<Disc>, restitution: f64, frames: usize) -> (Vec<Frame>, u64) {
    let (mut all, mut answers) = (Vec::new(), 0);
    for k in 0..frames {
        let time_ns = (1e9 * k as f64 / 60.0).round() as i64;
        all.push(Frame { time_ns, discs: discs.clone() });
        for (i, j) in (0..discs.len()).flat_map(|i| (0..i).map(move |j| (j, i))) {
            let (a, b) = (discs[i], discs[j]);
            let d = b.position - a.position;
            let (n, approach) = (d.normalize(), -d.normalize().dot(b.velocity - a.velocity));
            if d.length() >= a.radius + b.radius || approach <= 0.0 {
                continue;
            }
            let impulse = (1.0 + restitution) * approach / (1.0 / a.mass + 1.0 / b.mass) * n;
            discs[i].velocity -= impulse / a.mass;
            discs[j].velocity += impulse / b.mass;
            answers += 1;
        }
        discs.iter_mut().for_each(|disc| disc.position += disc.velocity / 60.0);
    }
    (all, answers)
}

#[test]
fn what_is_answered_at_the_sample_that_overlaps_is_late_whatever_is_known() {
    let pair =
        [disc(1, [-0.51, 0.0], [1.5, 0.0], 0.1, 1.0), disc(2, [0.5, 0.05], [-0.5, 0.1], 0.15, 3.0)];
    // The first two overlap at the sample from which the second reaches the third in time.
    let row = [
        disc(1, [-0.005, 0.0], [1.0, 0.0], 0.1, 1.0),
        disc(2, [0.2, 0.0], [0.0; 2], 0.1, 1.0),
        disc(3, [0.41, 0.0], [0.0; 2], 0.1, 1.0),
    ];
    for (discs, restitution) in [(&pair[..], 1.0), (&pair[..], 0.5), (&row[..], 1.0)] {
        let (frames, answers) = answered_at_stamps(discs.to_vec(), restitution, 60);
        assert!(answers as usize == discs.len() - 1);
        for options in [told(restitution, None), Options { no_walls: true, ..Options::default() }] {
            let (findings, collisions) = audited(frames.clone(), &options);
            let what = format!("{restitution} {options:?} {:?}", findings.violations);
            assert_eq!(findings.of_kind(Kind::Late), answers, "{what}");
            assert_eq!(findings.violations_in_all(), answers, "{what}");
            assert_eq!((findings.counts.foretold, collisions.len() as u64), (0, answers));
        }
    }
}

#[test]
fn a_stepping_engine_is_late_as_often_with_a_known_restitution_as_without() {
    let mut random = Random::new(7);
    let discs: Vec<Disc> = (0..36)
        .map(|k| {
            let place = [0.4 * f64::from(k % 6), 0.4 * f64::from(k / 6)];
            let velocity = DVec2::from_angle(random.uniform(0.0, std::f64::consts::TAU));
            disc(k, place, velocity.to_array(), 0.1, 1.0 + 0.2 * f64::from(k % 3))
        })
        .collect();
    let (frames, answers) = answered_at_stamps(discs, 1.0, 90);
    assert!(answers > 20, "{answers}");
    let unknown = Options { no_walls: true, ..Options::default() };
    let late = [unknown, told(1.0, None)].map(|options| {
        let (findings, _) = audited(frames.clone(), &options);
        println!("{:?} {:?}", findings.counts, findings.by_kind);
        findings.of_kind(Kind::Late)
    });
    println!("{late:?} of {answers}");
    assert!(late[1] >= late[0] && 10 * late[1] >= 9 * answers, "{late:?} {answers}");
}

/// The only violation of two discs whose velocities change at this time, when nothing is known.
fn changed(discs: [Disc; 2], time: f64, velocities: [DVec2; 2]) -> Violation {
    let at = |now: f64| {
        [0, 1].map(|k| {
            let there = moved(discs[k], now.min(time));
            let velocity = if now >= time { velocities[k] } else { discs[k].velocity };
            moved(Disc { velocity, ..there }, (now - time).max(0.0))
        })
    };
    let (findings, _) = audited(film(60.0, 40, at), &Options::default());
    assert_eq!(findings.violations_in_all(), 1, "{:?}", findings.violations);
    findings.violations[0].clone()
}

#[test]
fn severity_says_how_far_off_the_place_was_where_that_is_wrong() {
    let discs =
        [disc(1, [-0.5, 0.0], [1.0, 0.0], 0.1, 1.0), disc(2, [0.5, 0.0], [-1.0, 0.0], 0.2, 1.0)];
    let swapped = [discs[1].velocity, discs[0].velocity];
    // They would meet after 0.35 s.
    // Without a law too it is known that energy only shrinks.
    let found = changed(discs, 0.35, swapped.map(|velocity| 1.2 * velocity));
    assert_eq!(found.kind, Kind::Energy, "{found:?}");
    assert!((found.severity - 0.1).abs() < 1e-6, "{found:?}");
    for (time, kind, off) in
        [(0.1, Kind::Phantom, 5.0), (0.345, Kind::Early, 0.1), (0.4, Kind::Late, 1.0)]
    {
        let found = changed(discs, time, swapped);
        assert_eq!(found.kind, kind, "{found:?}");
        assert!((found.severity - off).abs() < 1e-5, "{off}: {found:?}");
    }
}

#[test]
fn a_severity_is_always_a_number() {
    let discs =
        [disc(1, [0.0, 0.0], [0.5, 0.1], 0.1, 1.0), disc(2, [0.2, 0.0], [0.5, 0.1], 0.1, 2.0)];
    let found = changed(discs, 0.2, discs.map(|disc| -0.1 * disc.velocity));
    assert_eq!(found.kind, Kind::ScaledVelocities);
    assert!(found.severity > 0.0 && found.severity < 10.0, "{found:?}");
}

#[test]
fn without_a_law_nothing_is_told_as_the_law_s() {
    let discs =
        [disc(1, [-0.5, 0.0], [1.0, 0.0], 0.1, 1.0), disc(2, [0.5, 0.0], [-1.0, 0.0], 0.1, 3.0)];
    let at = |now: f64| {
        let part = if now > 0.4 { -1.2 } else { 1.0 };
        discs.map(|disc| {
            let met = moved(disc, now.min(0.4));
            moved(Disc { velocity: part * disc.velocity, ..met }, (now - 0.4).max(0.0))
        })
    };
    for (options, text) in [
        (Options::default(), "(by the law unknown)"),
        (told(1.0, None), "(by the law +0.000000 J)"),
    ] {
        let (findings, _) = audited(film(60.0, 60, at), &options);
        assert!(findings.violations_in_all() > 0 && findings.ledger.pairs_j > 0.1);
        let mut told = Vec::new();
        carom::audit::tell::words(&findings, "film", &mut told).expect("memory");
        let told = String::from_utf8(told).expect("words");
        assert!(told.contains(text), "{told}");
    }
}

#[test]
fn a_violation_of_discs_at_rest_to_each_other_has_a_severity_of_a_sound_size() {
    let discs =
        [disc(1, [0.0, 0.0], [0.5, 0.0], 0.1, 1.0), disc(2, [0.2, 0.0], [0.5, 0.0], 0.1, 2.0)];
    // Both fly off the same way, or only one does.
    for (first, second) in [(1.0, 1.0), (0.0, 1.0), (-1.0, 1.0)] {
        let at = |time: f64| {
            let by = (time - 0.2).max(0.0) * DVec2::Y;
            let [mut a, mut b] = discs.map(|disc| moved(disc, time));
            (a.position, b.position) = (a.position + first * by, b.position + second * by);
            if time >= 0.2 {
                (a.velocity.y, b.velocity.y) = (first, second);
            }
            [a, b]
        };
        let (findings, collisions) = audited(film(70.0, 40, at), &told(0.9, None));
        for violation in &findings.violations {
            assert!(violation.severity < 10.0, "{violation:?}");
        }
        assert!(collisions.iter().all(|each| each.momentum <= 2.0), "{collisions:?}");
        assert!(first == second || !findings.violations.is_empty(), "{first} {second}");
    }
}

/// What a wrong collision across the border of a periodic box is called, if the discs part with
/// this restitution; `None` = they run through each other.
fn across_the_border(restitution: Option<f64>) -> (Kind, f64, Vec<u32>) {
    let periodic = Periodic { min: DVec2::ZERO, max: DVec2::ONE };
    // They meet after 0.1 s at the border.
    let discs =
        [disc(1, [0.9, 0.5], [0.5, 0.0], 0.05, 1.0), disc(2, [0.1, 0.5], [-0.5, 0.0], 0.05, 1.0)];
    let at = |time: f64| {
        let left = (time - 0.1).max(0.0);
        discs.map(|disc| {
            let mut disc = Disc { position: disc.position + disc.velocity * time, ..disc };
            if let (Some(e), true) = (restitution, time >= 0.1) {
                disc.position -= (1.0 + e) * disc.velocity * left;
                disc.velocity *= -e;
            }
            Disc { position: periodic.inside(disc.position), ..disc }
        })
    };
    let options = Options { periodic: Some(periodic), ..told(1.0, None) };
    let (findings, _) = audited(film(70.0, 40, at), &options);
    assert_eq!(findings.violations_in_all(), 1, "{:?}", findings.violations);
    let found = &findings.violations[0];
    (found.kind, found.time_s, found.discs.clone())
}

#[test]
fn a_wrong_collision_across_the_border_of_a_periodic_box_is_found_by_its_name() {
    for (restitution, wanted) in
        [(Some(0.5), Kind::Energy), (Some(1.2), Kind::Energy), (None, Kind::Missed)]
    {
        let (kind, time, pair) = across_the_border(restitution);
        assert_eq!((kind, pair), (wanted, vec![1, 2]), "{restitution:?}");
        assert!((time - 0.1).abs() < 1e-9, "{time}");
    }
}

#[test]
fn a_row_that_passes_a_blow_on_wrongly_is_found() {
    // The last of the row flies off too slowly, too fast, or not at all.
    for speed in [0.5, 1.5, 0.0] {
        let frame = |k: usize| {
            let time = k as f64 / 70.0;
            let left = (time - 0.1).max(0.0);
            let mut discs = vec![disc(1, [-0.3 + time.min(0.1), 0.0], [1.0, 0.0], 0.1, 1.0)];
            let row = (0..4).map(|k| disc(2 + k, [0.2 * f64::from(k), 0.0], [0.0; 2], 0.1, 1.0));
            discs.extend(row);
            if time >= 0.1 {
                discs[0].velocity = DVec2::ZERO;
                discs[4].velocity.x = speed;
                discs[4].position.x += speed * left;
            }
            Frame { time_ns: (1e9 * time).round() as i64, discs }
        };
        let (findings, _) = audited((0..40).map(frame).collect(), &told(1.0, None));
        assert_eq!(findings.violations_in_all(), 1, "{speed}: {:?}", findings.violations);
        let found = &findings.violations[0];
        assert!(found.severity < 10.0 && (found.time_s - 0.1).abs() < 0.02, "{found:?}");
        assert!(found.discs.contains(&5) || found.discs.contains(&1), "{found:?}");
    }
}

#[test]
fn discs_that_exchange_momentum_out_of_reach_are_a_phantom() {
    let discs =
        [disc(1, [-0.5, 0.0], [1.0, 0.0], 0.1, 1.0), disc(2, [0.5, 0.05], [-1.0, 0.0], 0.1, 2.0)];
    // At 0.2 s their centres are 0.6 m apart.
    let at = |time: f64| {
        let by = (time - 0.2).max(0.0) * DVec2::X;
        let [mut a, mut b] = discs.map(|disc| moved(disc, time));
        a.position -= 2.4 * by;
        b.position += 1.2 * by;
        if time >= 0.2 {
            a.velocity.x -= 2.4;
            b.velocity.x += 1.2;
        }
        [a, b]
    };
    let (kind, time, pair) = only(film(70.0, 40, at));
    assert_eq!((kind, pair), (Kind::Phantom, vec![1, 2]));
    assert!((time - 0.2).abs() < 1e-6, "{time}");
}

#[test]
fn discs_that_overlap_from_the_start_are_named_with_depth_and_end() {
    let discs =
        [disc(1, [0.0, 0.0], [-0.1, 0.0], 0.1, 1.0), disc(2, [0.17, 0.0], [0.1, 0.0], 0.1, 2.0)];
    let frames = film(100.0, 40, |time| discs.map(|disc| moved(disc, time)));
    let (findings, _) = audited(frames, &told(0.9, None));
    assert_eq!(findings.violations_in_all(), 1, "{:?}", findings.violations);
    let found = &findings.violations[0];
    assert_eq!((found.kind, &found.discs[..]), (Kind::Overlap, &[1, 2][..]));
    // 3 cm deep at 0 s, 2.8 cm at the first sample after it, apart after 0.15 s.
    assert!((findings.deepest_overlap - 0.28).abs() < 0.03, "{}", findings.deepest_overlap);
    assert!(found.detail.contains("0.140000 s"), "{}", found.detail);
}

#[test]
fn holes_leaps_and_resets_are_told_and_no_violation() {
    let discs =
        [disc(1, [-0.5, 0.0], [1.0, 0.0], 0.1, 1.0), disc(2, [0.5, 1.0], [-1.0, 0.0], 0.1, 2.0)];
    let mut frames = film(100.0, 60, |time| discs.map(|disc| moved(disc, time)));
    frames.iter_mut().skip(40).for_each(|frame| frame.discs[0].position.y += 3.0);
    frames.drain(20..23);
    let again = frames[..5].to_vec();
    frames.extend(again);
    let (findings, _) = audited(frames, &told(0.9, None));
    assert_eq!(findings.violations_in_all(), 0, "{:?}", findings.violations);
    let gap = Break::Gap { time_s: 0.19, missing: 3 };
    let teleport = Break::Teleport { time_s: 0.4, disc: 1 };
    let Break::Gap { time_s, missing } = findings.breaks[0] else { panic!("{gap:?}") };
    assert!((time_s - 0.19).abs() < 1e-9 && missing == 3, "{:?}", findings.breaks);
    assert_eq!(findings.breaks[1], teleport);
    assert!(matches!(findings.breaks[2], Break::Reset { .. }), "{:?}", findings.breaks);
    assert_eq!(findings.breaks.len(), 3);
}

#[test]
fn collisions_in_a_hole_of_samples_are_still_judged() {
    let (arena, settings) = Gas { restitution: 0.9, ..Gas::new(60, 0.2) }.arena();
    let discs: Vec<Disc> = arena.discs(Owner::Simulated).collect();
    let mut engine = Engine::new(discs, 0.9, settings.walls);
    let (mut frames, _) = engine.record(240.0, 480, None, |_, _, _, _| false);
    let mut place = 0;
    frames.retain(|_| {
        place += 1;
        place % 7 > 2
    });
    let (findings, collisions) = audited(frames, &told(0.9, settings.walls));
    assert_eq!(findings.violations_in_all(), 0, "{:?}", findings.violations);
    assert!(findings.counts.gaps > 60 && collisions.len() > 100, "{:?}", findings.counts);
}

#[test]
fn discs_that_come_and_go_are_judged_while_they_are_there() {
    let (arena, settings) = Gas { restitution: 0.9, ..Gas::new(60, 0.2) }.arena();
    let discs: Vec<Disc> = arena.discs(Owner::Simulated).collect();
    let mut engine = Engine::new(discs, 0.9, settings.walls);
    let (mut frames, _) = engine.record(240.0, 240, None, |_, _, _, _| false);
    // Their order is no matter either.
    for (k, frame) in frames.iter_mut().enumerate() {
        frame.discs.rotate_left(k % 60);
        frame.discs.retain(|disc| disc.id % 10 != 3 || !(100..150).contains(&k));
    }
    let (findings, collisions) = audited(frames, &told(0.9, settings.walls));
    assert_eq!(findings.violations_in_all(), 0, "{:?}", findings.violations);
    assert!(collisions.len() > 50, "{}", collisions.len());
}
