//! Drag: closed forms in 300 bits, the motion without drag told in other time, and what must not
//! change it: frames, stages, the method.

use carom::motion::arena::Arena;
use carom::motion::drag::slowing::{Slowing, straight_span};
use carom::motion::drag::{Drag, Straight};
use carom::motion::events::Events;
use carom::motion::plain::Plain;
use carom::plan::parts::{Part, Parts};
use carom::plan::{Method, Plan};
use carom::scene::file;
use carom::world::{Command, Contact, Disc, Instants, Owner, Partner, Periodic, Report};
use carom::world::{Settings, World};
use dashu_float::FBig;
use dashu_ratio::RBig;
use glam::DVec2;

use crate::common::{Random, box_settings, disc, gas};

fn big(x: f64) -> FBig {
    RBig::try_from(x).expect("finite").to_float(300).value()
}

fn double(x: &FBig) -> f64 {
    x.to_f64().value()
}

/// `1 - exp(-drag t)`.
fn part_done(drag: f64, time: f64) -> FBig {
    -(-big(drag) * big(time)).exp_m1()
}

/// When discs are where they would be after `straight` without drag.
fn real_time(drag: f64, straight: &FBig) -> FBig {
    -(-(big(drag) * straight)).ln_1p() / big(drag)
}

fn error(found: f64, wanted: &FBig) -> f64 {
    double(&((big(found) - wanted) / wanted)).abs()
}

fn plain(settings: &Settings, discs: &[Disc]) -> Drag<Plain> {
    let plan = Plan::of(settings, discs);
    Drag::new(Plain::new(plan.laws(settings), discs, plan.epoch))
}

fn events(settings: &Settings, discs: &[Disc]) -> Drag<Events> {
    Drag::new(Events::new(Plan::of(settings, discs).laws(settings), discs))
}

fn run<M: Straight>(arena: &mut Drag<M>, until: f64) -> Vec<Contact> {
    let mut contacts = Vec::new();
    while arena.now() < until {
        arena.advance(until, &mut contacts).expect("no stall");
    }
    contacts
}

fn states<M: Straight>(arena: &Drag<M>) -> Vec<Disc> {
    arena.discs(Owner::Simulated).collect()
}

fn periodic(side: f64) -> Settings {
    let periodic = Some(Periodic { min: DVec2::ZERO, max: DVec2::splat(side) });
    Settings { periodic, ..Settings::default() }
}

#[test]
fn one_disc_follows_the_closed_form() {
    for drag in [1e-12, 0.3, 1.0, 1.7, 1e6] {
        for ages in [1e-9, 0.1, 0.69, 0.7, 1.0, 5.0, 36.0, 100.0, 700.0, 1000.0] {
            let settings = Settings { drag, ..Settings::default() };
            let discs = [disc(1, [0.0, -0.25], [3.0 * drag, 0.1 * drag], 0.5, 1.0)];
            let time = ages / drag;
            let done = part_done(drag, time);
            let wanted = &done * big(discs[0].velocity.x) / big(drag);
            let speed = (-big(drag) * big(time)).exp() * big(discs[0].velocity.x);
            let judge = |name: &str, found: Disc| {
                let (x, v) = (found.position.x, found.velocity.x);
                assert!(error(x, &wanted) < 5e-16, "{name} {drag} {ages}: {}", error(x, &wanted));
                let tiny = double(&speed) < f64::MIN_POSITIVE;
                assert!(tiny || error(v, &speed) < 5e-16, "{name} {drag} {ages}: {v:e}");
                assert!(!tiny || v.abs() <= f64::MIN_POSITIVE, "{name} {drag} {ages}: {v:e}");
            };
            let (mut a, mut b) = (plain(&settings, &discs), events(&settings, &discs));
            assert!(run(&mut a, time).is_empty() && run(&mut b, time).is_empty());
            judge("plain", states(&a)[0]);
            judge("events", states(&b)[0]);
        }
    }
}

#[test]
fn two_discs_meet_when_the_closed_form_says() {
    let mut random = Random::new(1);
    let mut worst = (0.0f64, 0.0f64);
    for round in 0..2_000 {
        let aside = if round % 2 == 0 { 0.0 } else { random.uniform(-0.9, 0.9) };
        let (gap, v) = (random.uniform(0.01, 5.0), random.uniform(0.1, 3.0));
        let a = disc(1, [random.uniform(-1.0, 1.0), 0.0], [v, 0.0], 0.5, 1.0);
        let x = a.position.x + 1.0 + gap;
        let b = disc(2, [x, aside], [-random.uniform(0.1, 3.0), 0.0], 0.5, 2.0);
        // Without drag, exactly.
        let (d, w) = (big(x) - big(a.position.x), big(a.velocity.x) - big(b.velocity.x));
        let across = big(aside) * big(aside);
        let straight = (d - (big(1.0) - &across).sqrt()) / &w;
        // So much of the way is left when they meet.
        let left = 10f64.powf(random.uniform(-12.0, 0.0));
        let drag = (1.0 - left) / double(&straight);
        if drag * double(&straight) >= 1.0 || drag < 1e-3 {
            continue;
        }
        let settings = Settings { drag, ..Settings::default() };
        let wanted = real_time(drag, &straight);
        let speed = (big(1.0) - big(drag) * &straight) * &w * (big(1.0) - across).sqrt();
        let contacts = run(&mut plain(&settings, &[a, b]), 40.0 / drag);
        assert_eq!(contacts.len(), 1, "{round} {left}");
        worst.0 = worst.0.max(error(contacts[0].time, &wanted));
        worst.1 = worst.1.max(error(contacts[0].approach_speed, &speed));
        assert!(error(contacts[0].time, &wanted) < 1e-15, "{round} {left}: {worst:?}");
        let steep = if aside == 0.0 { 2e-15 } else { 1e-13 };
        assert!(error(contacts[0].approach_speed, &speed) < steep, "{round} {left}: {worst:?}");
        // Coordinates in plain doubles know less of a place so near the stop.
        let contacts = run(&mut events(&settings, &[a, b]), 40.0 / drag);
        if left > 1e-9 {
            assert_eq!(contacts.len(), 1, "{round} {left}");
            let doubt = 1e-14 / (left * double(&w) * double(&straight));
            assert!(error(contacts[0].time, &wanted) < 1e-15 + doubt, "{round} {left}");
        }
    }
    println!("times, approach speeds of two discs, relative error: {worst:?}");
}

#[test]
fn what_a_contact_does_is_told_in_real_time() {
    let discs =
        [disc(1, [0.0; 2], [2.0, 0.0], 0.5, 1.0), disc(2, [2.0, 0.0], [0.0, 0.0], 0.5, 3.0)];
    let settings = Settings { drag: 1.5, restitution: 0.5, ..Settings::default() };
    for contact in
        [run(&mut plain(&settings, &discs), 9.0), run(&mut events(&settings, &discs), 9.0)]
    {
        // After the way 1 of 2 / 1.5 a quarter of the speed is left.
        let contact = &contact[0];
        assert!((contact.approach_speed - 0.5).abs() < 1e-15);
        assert!((contact.impulse - 0.75 * 1.5 * 0.5).abs() < 1e-15);
        assert!((contact.energy_loss - 0.5 * 0.75 * 0.75 * 0.25).abs() < 1e-15);
        assert!((contact.time - 4f64.ln() / 1.5).abs() < 1e-15);
    }
}

#[test]
fn a_disc_between_walls_stops_where_it_must() {
    let drag = 0.01;
    let settings = Settings { drag, ..box_settings(4.0, 1.0) };
    let discs = [disc(1, [1.0, 2.0], [1.0, 0.0], 0.5, 1.0)];
    let (mut a, mut b) = (plain(&settings, &discs), events(&settings, &discs));
    for (name, contacts) in [("plain", run(&mut a, 5e3)), ("events", run(&mut b, 5e3))] {
        // 100 m in all: 2.5 to the first wall, then 3 each.
        assert_eq!(contacts.len(), 33, "{name}");
        for (k, contact) in contacts.iter().enumerate() {
            let wanted = real_time(drag, &big(2.5 + 3.0 * k as f64));
            assert!(error(contact.time, &wanted) < 4e-15, "{name} {k}: {}", contact.time);
        }
    }
    for found in [states(&a)[0], states(&b)[0]] {
        // 1.5 m after the last wall, the left one.
        assert!((found.position.x - 2.0).abs() < 1e-13, "{found:?}");
        assert!(found.velocity.length() < 1e-20);
    }
}

#[test]
fn a_gas_under_drag_is_a_gas_in_other_time() {
    let free = |settings: &Settings| Settings { drag: 0.0, ..*settings };
    let lossy = Settings { restitution: 0.9, ..periodic(14.0) };
    for (k, base) in [box_settings(12.0, 1.0), periodic(14.0), lossy].into_iter().enumerate() {
        let radius = if k == 0 { (0.2, 0.5) } else { (0.4, 0.4) };
        let discs = gas(k as u64, 60, 12.0, radius, (0.5, 3.0));
        // The contact time is one of real time: left out, so that the motion is the same.
        let drag = 0.1;
        let settings = Settings { drag, contact_time: Some(0.0), ..base };
        let judged = run(&mut plain(&free(&settings), &discs), 9.99);
        let slow =
            [run(&mut plain(&settings, &discs), 1e3), run(&mut events(&settings, &discs), 1e3)];
        assert!(judged.len() > 100, "{}", judged.len());
        for (name, contacts) in ["plain", "events"].into_iter().zip(slow) {
            assert!(contacts.len().abs_diff(judged.len()) <= 2, "{name} {}", contacts.len());
            for (n, (slow, judge)) in contacts.iter().zip(&judged).enumerate() {
                assert_eq!((slow.a, slow.b), (judge.a, judge.b), "{name} {k} {n}");
                let left = 1.0 - drag * judge.time;
                let wanted = -(-drag * judge.time).ln_1p() / drag;
                let doubt = 1e-15 * 10f64.powf(n as f64 / 12.0) + 1e-14 / left;
                let doubt = doubt.min(1e-6 / left);
                assert!((slow.time - wanted).abs() < doubt, "{name} {k} {n}: {doubt}");
                assert!((slow.impulse - judge.impulse * left).abs() < 1e-5, "{name} {k} {n}");
                let loss = judge.energy_loss * left * left;
                assert!((slow.energy_loss - loss).abs() < 1e-5, "{name} {k} {n}");
            }
        }
    }
}

#[test]
fn energy_falls_by_the_law_and_drift_stays_error() {
    for settings in [box_settings(12.0, 1.0), periodic(14.0)] {
        let discs = gas(3, 60, 12.0, (0.3, 0.4), (0.5, 2.0));
        let drag = 0.02;
        let settings = Settings { drag, ..settings };
        let (mut a, mut b) = (plain(&settings, &discs), events(&settings, &discs));
        let start = a.kinetic_energy();
        for frame in 1..=40 {
            let time = 10.0 * f64::from(frame);
            run(&mut a, time);
            run(&mut b, time);
            let wanted = start * (-2.0 * drag * time).exp();
            let off = |energy: f64| (energy / wanted - 1.0).abs();
            assert!(off(a.kinetic_energy()) < 1e-12, "{time}: {}", off(a.kinetic_energy()));
            assert!(off(b.kinetic_energy()) < 1e-12, "{time}: {}", off(b.kinetic_energy()));
            let drifts = [a.relative_energy_drift(), b.relative_energy_drift()];
            assert!(drifts.iter().all(|drift| drift.abs() < 2e-14), "{drifts:?}");
        }
        assert!(a.contacts() > 700, "{}", a.contacts());
    }
    // Losses, walls that lose, commands, a circle that somebody else owns: all are accounted for.
    let discs = gas(4, 60, 12.0, (0.3, 0.4), (0.5, 2.0));
    let settings = Settings { drag: 0.5, ..box_settings(12.0, 0.8) };
    let (mut a, mut b) = (plain(&settings, &discs), events(&settings, &discs));
    for frame in 1..=100 {
        let time = 0.2 * f64::from(frame);
        run(&mut a, time);
        run(&mut b, time);
        let (velocity, guest) = (DVec2::new(2.0, time), disc(99, [6.0; 2], [0.3, 1.0], 0.5, 5.0));
        a.set_velocity(frame % 60, velocity);
        b.set_velocity(frame % 60, velocity);
        a.observe(guest);
        b.observe(guest);
        let drifts = [a.relative_energy_drift(), b.relative_energy_drift()];
        assert!(drifts.iter().all(|drift| drift.abs() < 1e-13), "{drifts:?}");
    }
}

#[test]
fn after_all_has_stopped_any_time_comes_at_once() {
    let discs = gas(5, 60, 12.0, (0.3, 0.4), (0.5, 2.0));
    for drag in [0.05, 3.0, 1e6] {
        let settings = Settings { drag, ..box_settings(12.0, 0.9) };
        let start = std::time::Instant::now();
        let (mut a, mut b) = (plain(&settings, &discs), events(&settings, &discs));
        for time in [1e9, 2e9, 1e15, 1e30, 1e300, f64::MAX] {
            let late = a.contacts() + b.contacts();
            run(&mut a, time);
            run(&mut b, time);
            assert_eq!((a.now(), b.now()), (time, time));
            assert!(time == 1e9 || a.contacts() + b.contacts() == late);
            let (va, vb) = (states(&a)[7].velocity, states(&b)[7].velocity);
            assert!(va == DVec2::ZERO && vb == DVec2::ZERO, "{va} {vb}");
            // One call is enough.
            let mut contacts = Vec::new();
            a.advance(time * 1.5, &mut contacts).expect("no stall");
            b.advance(time * 1.5, &mut contacts).expect("no stall");
            assert_eq!((a.now(), b.now(), contacts.len()), (time * 1.5, time * 1.5, 0));
            // Moved, it stops again.
            a.set_velocity(7, DVec2::new(2e-9 * drag, 0.0));
            b.set_velocity(7, DVec2::new(2e-9 * drag, 0.0));
            for v in [states(&a)[7].velocity, states(&b)[7].velocity] {
                let wanted = if time * 1.5 < f64::INFINITY { 2e-9 * drag } else { v.x };
                assert!((v.x - wanted).abs() < 1e-15 * wanted, "{time} {v}");
            }
        }
        assert!(start.elapsed().as_secs_f64() < 60.0, "{drag}: {:?}", start.elapsed());
    }
}

#[test]
fn a_command_while_all_is_slow_is_followed() {
    for (name, drag, pauses) in
        [("early", 0.5, 0.3), ("late", 0.5, 30.0), ("stopped", 0.5, 1e4), ("stiff", 1e6, 1.0)]
    {
        let settings = Settings { drag, ..Settings::default() };
        let discs: Vec<Disc> =
            (0..60).map(|k| disc(k, [0.0, 3.0 * f64::from(k)], [0.0; 2], 0.5, 1.0)).collect();
        let (mut a, mut b) = (plain(&settings, &discs), events(&settings, &discs));
        let (mut time, mut wanted) = (0.0, 0.0);
        for k in 0..20 {
            let v = 0.1 * f64::from(k % 3 + 1);
            a.set_velocity(3, DVec2::new(v, 0.0));
            b.set_velocity(3, DVec2::new(v, 0.0));
            for found in [states(&a)[3], states(&b)[3]] {
                assert!((found.velocity.x - v).abs() < 4e-16 * v, "{name}");
            }
            let next = time + pauses;
            wanted += -v * (-drag * (next - time)).exp_m1() / drag;
            time = next;
            run(&mut a, time);
            run(&mut b, time);
            for x in [states(&a)[3].position.x, states(&b)[3].position.x] {
                assert!((x - wanted).abs() < 2e-15 * wanted.max(1.0), "{name} {k}: {x} {wanted}");
            }
        }
        assert!(a.relative_energy_drift().abs() < 1e-14 && b.relative_energy_drift().abs() < 1e-14);
    }
}

/// All that a run leaves behind, in so many frames.
fn film<M: Straight>(mut arena: Drag<M>, until: f64, frames: u32) -> (Vec<Contact>, Vec<Disc>) {
    let mut contacts = Vec::new();
    for frame in 1..=frames {
        let time = until * f64::from(frame) / f64::from(frames);
        while arena.now() < time {
            arena.advance(time, &mut contacts).expect("no stall");
        }
        states(&arena);
        if frame == frames / 2 {
            // Half way on everybody looks.
            arena.set_velocity(3, DVec2::new(0.7, 0.2));
        }
    }
    (contacts, states(&arena))
}

#[test]
fn looking_changes_no_bit() {
    let discs = gas(8, 60, 12.0, (0.3, 0.4), (1.0, 2.0));
    let slow: Vec<Disc> =
        discs.iter().map(|disc| Disc { velocity: disc.velocity * 1e-3, ..*disc }).collect();
    for (settings, discs) in [
        (box_settings(12.0, 0.95), &discs),
        (Settings { restitution: 0.9, ..periodic(14.0) }, &discs),
        (box_settings(12.0, 1.0), &slow),
        (Settings::default(), &slow),
    ] {
        for (drag, until) in [(0.1, 200.0), (2.0, 30.0), (0.1, 8.0)] {
            let settings = Settings { drag, ..settings };
            let once = film(plain(&settings, discs), until, 2);
            let quick = film(events(&settings, discs), until, 2);
            for frames in [6, 62, 998, 10_000] {
                assert!(film(plain(&settings, discs), until, frames) == once, "{drag} {frames}");
                assert!(film(events(&settings, discs), until, frames) == quick, "{drag} {frames}");
            }
        }
    }
}

#[test]
fn looking_at_discs_that_hardly_move_changes_no_bit() {
    // Nothing happens in many an epoch of the calendar, which was made for faster discs.
    let discs = gas(8, 60, 12.0, (0.3, 0.4), (1.0, 2.0));
    let settings = Settings { drag: 1e-3, ..box_settings(12.0, 1.0) };
    let run = |frames: u32| {
        let mut arena = events(&settings, &discs);
        arena.pass(3.0).expect("no stall");
        for disc in &discs {
            arena.set_velocity(disc.id, 1e-5 * disc.velocity);
        }
        for frame in 1..=frames {
            let time = 3.0 + 5_000.0 * f64::from(frame) / f64::from(frames);
            arena.pass(time).expect("no stall");
        }
        states(&arena)
    };
    let once = run(1);
    for frames in [7, 100, 9_000] {
        assert!(run(frames) == once, "{frames}");
    }
}

#[test]
fn without_drag_the_mapping_changes_no_bit() {
    let discs = gas(9, 60, 12.0, (0.3, 0.4), (0.5, 2.0));
    let lossy = Settings { contact_time: Some(1e-3), ..box_settings(12.0, 0.3) };
    for settings in [box_settings(12.0, 1.0), lossy, periodic(14.0)] {
        for method in [Method::Plain, Method::Events] {
            let mut plan = Plan { method, ..Plan::of(&settings, &discs) };
            assert!(!plan.built.has(Part::Drag));
            let laws = plan.laws(&settings);
            let mut bare = Arena::new(&plan, laws, &discs);
            plan.built = plan.built.and(Parts::only(Part::Drag));
            let mut mapped = Arena::new(&plan, laws, &discs);
            assert!(matches!(mapped, Arena::SlowedPlain(_) | Arena::SlowedEvents(_)));
            let (mut ours, mut judged) = (Vec::new(), Vec::new());
            for frame in 1..=50 {
                let time = 0.2 * f64::from(frame);
                for (arena, contacts) in [(&mut bare, &mut judged), (&mut mapped, &mut ours)] {
                    while arena.now() < time {
                        arena.advance(time, contacts).expect("no stall");
                    }
                    arena.set_velocity(frame % 60, DVec2::new(1.0, 0.1 * time));
                    arena.observe(disc(99, [time, 6.0], [1.0, 0.0], 0.3, 5.0));
                    if frame % 10 == 9 {
                        arena.forget(&[99].into());
                    }
                }
                for owner in [Owner::Simulated, Owner::Observed] {
                    assert!(bare.discs(owner).eq(mapped.discs(owner)), "{method} {frame}");
                }
            }
            assert!(judged.len() > 100 && ours == judged, "{method}");
            assert_eq!(bare.kinetic_energy(), mapped.kinetic_energy());
            assert_eq!(bare.relative_energy_drift(), mapped.relative_energy_drift());
            assert_eq!(bare.largest_miss(), mapped.largest_miss());
        }
    }
}

#[test]
fn the_slightest_drag_is_none_and_the_stiffest_stops_all() {
    let discs = gas(10, 60, 12.0, (0.3, 0.4), (0.5, 2.0));
    let base = box_settings(12.0, 1.0);
    let slight = Settings { drag: 1e-12, ..base };
    let free = run(&mut plain(&base, &discs), 2.0);
    let slow = run(&mut plain(&slight, &discs), 2.0);
    assert!(free.len() > 40 && free.len() == slow.len(), "{} {}", free.len(), slow.len());
    for (a, b) in free.iter().zip(&slow) {
        assert_eq!((a.a, a.b), (b.a, b.b));
        assert!((a.time - b.time).abs() < 1e-6);
    }
    let first = (free[0].time, slow[0].time);
    let later = 0.5e-12 * first.0 * first.0;
    assert!((first.1 - first.0 - later).abs() < 4e-16 * first.0, "{first:?}");
    for drag in [1e6, 1e30] {
        let stiff = Settings { drag, ..base };
        let (mut a, mut b) = (plain(&stiff, &discs), events(&stiff, &discs));
        assert!(run(&mut a, 60.0).len() + run(&mut b, 60.0).len() < 2);
        for (k, disc) in discs.iter().enumerate() {
            let wanted = disc.position + disc.velocity / drag;
            assert!(states(&a)[k].position.distance(wanted) < 1e-14);
            assert!(states(&b)[k].position.distance(wanted) < 1e-14);
        }
    }
}

#[test]
fn the_two_times_belong_together() {
    let mut random = Random::new(7);
    let mut worst = (0.0f64, 0.0f64);
    for _ in 0..2_000 {
        let drag = 10f64.powf(random.uniform(-12.0, 6.0));
        let mut slowing = Slowing::new(drag);
        let stage = random.below(400);
        (0..stage).for_each(|_| slowing.begin_next());
        let straight = random.uniform(0.0, slowing.end());
        let time = slowing.time(straight);
        let left = big(1.0) - big(drag) * big(straight);
        let exact = (big(2.0).ln() * big(stage as f64) - left.ln()) / big(drag);
        // Rounding of the ends of stages: as if drag were another in its last bits.
        worst.0 = worst.0.max(error(time, &exact));
        let speed = (-(big(drag) * big(time))).exp() * big(2f64.powi(stage as i32));
        worst.1 = worst.1.max(error(slowing.speed(time), &speed));
        let again = slowing.straight(time);
        assert!((again - straight).abs() < 1e-15 * (stage + 1) as f64 / drag);
        // A span of real time is one.
        let span = random.uniform(0.0, 0.1) / drag;
        let later = straight + straight_span(drag, straight, span);
        let off = slowing.time(later) - time - span;
        assert!(off.abs() < 1e-15 * (stage + 1) as f64 / drag, "{off} {span}");
    }
    println!("real time, speed, relative error: {worst:?}");
    assert!(worst.0 < 4e-15 && worst.1 < 1e-15, "{worst:?}");
    assert_eq!(straight_span(2.0, f64::NEG_INFINITY, 1.0), f64::INFINITY);
}

#[test]
fn contacts_are_quick_in_real_time() {
    // To and fro between walls every 1e-3 s of straight time, at first: while the disc slows down
    // its contacts are quick until so many have passed, and 128 of them make a collapse.
    for (quick, is_collapse) in [(120.0, false), (140.0, true)] {
        let contact_time = Some(1e-3 / (1.0 - 1e-3 * quick));
        let mut settings = Settings { drag: 1.0, contact_time, ..box_settings(1.001, 1.0 - 1e-12) };
        settings.walls.as_mut().expect("walls").max.y = 2.0;
        let discs = [disc(1, [0.5005, 1.0], [1.0, 0.0], 0.5, 1.0)];
        let both =
            [run(&mut plain(&settings, &discs), 9.0), run(&mut events(&settings, &discs), 9.0)];
        for contacts in both {
            assert!(contacts.len() > 990, "{}", contacts.len());
            let elastic = contacts.iter().filter(|contact| contact.energy_loss == 0.0).count();
            assert_eq!(elastic > 0, is_collapse, "{quick}: {elastic}");
        }
    }
}

/// What a disc meets that is stopped in a collapse, and moved again in another stage.
fn after_a_pause<M: Straight>(mut arena: Drag<M>) -> Vec<Contact> {
    let before = run(&mut arena, 0.2);
    assert_eq!(before.last().expect("contacts").energy_loss, 0.0);
    arena.set_velocity(1, DVec2::ZERO);
    let late = 5e3 * 2f64.ln() + 0.05;
    run(&mut arena, late);
    arena.set_velocity(1, DVec2::X);
    run(&mut arena, late + 0.01)
}

#[test]
fn a_collapse_is_over_after_a_pause_of_real_time() {
    let contact_time = Some(2.0);
    let mut settings = Settings { drag: 1.0, contact_time, ..box_settings(1.001, 1.0 - 1e-12) };
    settings.walls.as_mut().expect("walls").max.y = 2.0;
    let discs = [disc(1, [0.5005, 1.0], [1.0, 0.0], 0.5, 1.0)];
    for contacts in
        [after_a_pause(plain(&settings, &discs)), after_a_pause(events(&settings, &discs))]
    {
        assert!(contacts[0].energy_loss > 0.0);
    }
}

#[test]
fn a_gas_that_collapses_under_drag_is_the_same_by_both_methods() {
    for restitution in [0.6, 0.95] {
        let discs = gas(11, 80, 9.0, (0.3, 0.4), (1.0, 1.0));
        let settings =
            Settings { drag: 0.3, contact_time: Some(1e-4), ..box_settings(9.0, restitution) };
        let ours = run(&mut events(&settings, &discs), 100.0);
        let judged = run(&mut plain(&settings, &discs), 100.0);
        let same = ours.iter().zip(&judged).take_while(|(a, b)| (a.a, a.b) == (b.a, b.b)).count();
        assert!(same > 60 && judged.len() > 100, "{same} of {} {}", ours.len(), judged.len());
        let elastic = |c: &&Contact| c.energy_loss == 0.0;
        assert_eq!(
            ours[..same].iter().filter(elastic).count(),
            judged[..same].iter().filter(elastic).count()
        );
    }
}

#[test]
fn a_collapse_goes_on_across_the_end_of_a_stage() {
    // Three discs on a line, all but a collapse: the first stage ends between any two contacts.
    let line = [(0.0, 1.0), (1.5, 0.0), (3.2, -1.0)];
    let discs: Vec<Disc> =
        line.iter().zip(1..).map(|(&(x, v), id)| disc(id, [x, 0.0], [v, 0.0], 0.5, 1.0)).collect();
    let lossy = Settings { restitution: 0.05, ..Settings::default() };
    let settings = Settings { contact_time: Some(1e-12), ..lossy };
    let mut judged = run(&mut plain(&settings, &discs), 1.0);
    judged.truncate(40);
    let end = judged.last().expect("contacts").time;
    let mut ends = 0;
    for pair in judged.windows(2) {
        let middle = 0.5 * (pair[0].time + pair[1].time);
        let drag = 0.5 / middle;
        if drag * end >= 1.0 || middle == pair[0].time {
            continue;
        }
        ends += 1;
        let contacts = run(&mut plain(&Settings { drag, ..settings }, &discs), 50.0);
        assert!(contacts.len() >= judged.len(), "{middle}");
        for (slow, judge) in contacts.iter().zip(&judged) {
            assert_eq!((slow.a, slow.b), (judge.a, judge.b));
            let wanted = real_time(drag, &big(judge.time));
            assert!(error(slow.time, &wanted) < 2e-15, "{middle}");
            let speed = judge.approach_speed * (1.0 - drag * judge.time);
            let off = (slow.approach_speed / speed - 1.0).abs();
            assert!(off < 1e-13, "{middle} {}: {off}", judge.time);
        }
    }
    assert!(ends > 12, "{ends} of {}", judged.len());
}

#[test]
fn what_moves_with_infinite_mass_slows_down_too() {
    let discs = [
        disc(1, [0.0; 2], [3.0, 0.0], 0.5, f64::INFINITY),
        disc(2, [2.0, 0.0], [0.0; 2], 0.5, 1.0),
        disc(3, [-5.0, 0.0], [0.0; 2], 0.5, f64::INFINITY),
    ];
    let settings = Settings { drag: 1.0, ..Settings::default() };
    let (mut a, mut b) = (plain(&settings, &discs), events(&settings, &discs));
    for (contacts, found) in [(run(&mut a, 50.0), states(&a)), (run(&mut b, 50.0), states(&b))] {
        // After 1 of 3 metres, with two thirds of its speed.
        assert_eq!(contacts.len(), 1);
        assert!((contacts[0].time - 1.5f64.ln()).abs() < 1e-15);
        assert!((contacts[0].approach_speed - 2.0).abs() < 1e-14);
        let places: Vec<f64> = found.iter().map(|disc| disc.position.x).collect();
        for (x, wanted) in places.iter().zip([3.0, 6.0, -5.0]) {
            assert!((x - wanted).abs() < 1e-14, "{places:?}");
        }
        assert_eq!(found[2], discs[2]);
    }
    assert!(a.relative_energy_drift().abs() < 1e-15 && b.relative_energy_drift().abs() < 1e-15);
}

#[test]
fn an_observed_circle_slows_down_until_it_is_heard_of_again() {
    let puck = disc(1, [0.0; 2], [1.0, 0.0], 0.5, 1.0);
    let settings = Settings { drag: 0.5, stale_after: 10.0, ..Settings::default() };
    let mut world = World::new(settings, &[puck]);
    let guest = disc(7, [3.0, 0.0], [-1.0, 0.0], 0.5, 1.0);
    let instants = |time| Instants { heard_at: 0.0, advance_to: time };
    let observe = Command::Observe(Report { discs: vec![guest], time: 0.0 });
    let outcome = world.step(&[observe], instants(2.0));
    // Both come 1 m of the 2 m that they have: half the speed is left.
    assert_eq!(outcome.contacts.len(), 1);
    let contact = outcome.contacts[0];
    assert_eq!((contact.a, contact.b), (1, Partner::Disc(7)));
    assert!((contact.time - 2.0 * 2f64.ln()).abs() < 1e-15, "{}", contact.time);
    assert!((contact.approach_speed - 1.0).abs() < 1e-15);
    let speed = (-1.0f64).exp();
    assert!((outcome.corrections[0].1.x - speed).abs() < 1e-15, "{:?}", outcome.corrections);
    // Heard of again, it is where its owner says and as fast, long after all has stopped.
    world.step(&[], instants(1e4));
    let arena = world.arena().expect("a puck");
    assert!((arena.discs(Owner::Simulated).next().expect("it").position.x).abs() < 1e-15);
    let near = Disc { position: DVec2::new(1.25, 0.0), ..guest };
    let again = Command::Observe(Report { discs: vec![near], time: 0.0 });
    let outcome = world.step(&[again], instants(1e4 + 1.0));
    assert_eq!(outcome.contacts.len(), 1);
    let wanted = 1e4 - 2.0 * (0.875f64).ln();
    assert!((outcome.contacts[0].time - wanted).abs() < 4e-12, "{}", outcome.contacts[0].time);
    assert!((outcome.contacts[0].approach_speed - 0.875).abs() < 1e-11);
}

#[test]
fn a_scene_with_drag_runs_at_any_frame_rate() {
    let text = "drag: 0.8\nrestitution: 0.95\nwalls: {x: [0, 6], y: [0, 4]}\n\
                pucks: [{name: cue, position: [1, 2], velocity: [6, 0.1], radius: 0.1}]\n\
                batches: [{name: gas, count: 70, radius: 0.1, speed: 1, \
                region: {x: [2, 6], y: [0, 4]}}]";
    let scene = file::parse(text, "scene.yaml").expect("sound");
    assert_eq!(scene.settings.drag, 0.8);
    let run = |frames: u32| {
        let mut world = scene.world();
        let mut contacts = 0;
        for frame in 1..=frames {
            let advance_to = 20.0 * f64::from(frame) / f64::from(frames);
            while world.arena().expect("pucks").now() < advance_to {
                let outcome = world.step(&[], Instants { heard_at: 0.0, advance_to });
                assert_eq!(outcome.stall, None);
                contacts += outcome.contacts.len();
            }
        }
        let arena = world.arena().expect("pucks");
        assert!(matches!(arena, Arena::SlowedEvents(_)));
        assert!(arena.relative_energy_drift().abs() < 1e-14);
        assert!(arena.largest_miss() < 1e-11, "{}", arena.largest_miss());
        (contacts, arena.discs(Owner::Simulated).collect::<Vec<Disc>>())
    };
    let once = run(1);
    assert!(once.0 > 100, "{}", once.0);
    assert!(once == run(1200) && once == run(37));
}

#[test]
fn drag_is_read_or_refused() {
    let parse = |keys: &str| file::parse(keys, "scene.yaml");
    assert_eq!(parse("drag: 0").expect("a scene").settings.drag, 0.0);
    assert_eq!(parse("drag: 0\ngravity: [0, 1]").expect("a scene").settings.drag, 0.0);
    let refused = [
        ("drag: -1", "scene.yaml:1:7: drag = -1, must be 0, or from 1e-30 to 1e30 1/s"),
        ("drag: .nan", "scene.yaml:1:7: drag = NaN, must be 0, or from 1e-30 to 1e30 1/s"),
        ("drag: .inf", "scene.yaml:1:7: drag = inf, must be 0, or from 1e-30 to 1e30 1/s"),
        (
            "gravity: [0, 1]\ndrag: 0.5",
            "scene.yaml:2:7: drag: not with gravity; leave one of them out",
        ),
    ];
    for (keys, message) in refused {
        assert_eq!(parse(keys).expect_err("refused").to_string(), message);
    }
}
