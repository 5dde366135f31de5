//! The error report: durations, causes, warnings, and the same numbers in `/diagnostics`.

use std::time::Duration;

use carom::messages::{DiagnosticStatus, Time};
use carom::publish::error_report::{Durations, Facts, Interval, Totals, diagnostics};
use carom::receive::{BadCircle, Cause, Refused, TooManyCircles};
use carom::scene::Scene;
use carom::world::{Defect, Instants, Refusal, World};

use crate::common::Random;

#[test]
fn durations_are_told_to_two_percent() {
    let mut random = Random::new(1);
    let mut durations = Durations::default();
    assert_eq!((durations.mean(), durations.quantile(0.99), durations.max()), (0.0, 0.0, 0.0));
    let mut all: Vec<u64> = (0..20_000).map(|_| (3e3 * random.wide(2.0).abs()) as u64).collect();
    all.iter().for_each(|&time| durations.note(Duration::from_nanos(time)));
    all.sort_unstable();
    for part in [0.01, 0.5, 0.9, 0.99, 0.999] {
        let expected = 1e-9 * all[(part * 20_000.0) as usize - 1] as f64;
        let found = durations.quantile(part);
        assert!((found / expected - 1.0).abs() < 0.02, "{part}: {found} {expected}");
    }
    let mean = 1e-9 * all.iter().sum::<u64>() as f64 / 20_000.0;
    assert!((durations.mean() / mean - 1.0).abs() < 1e-12);
    assert_eq!((durations.steps(), durations.max()), (20_000, 1e-9 * all[19_999] as f64));
}

#[test]
fn any_duration_finds_its_place() {
    for nanoseconds in
        (0..200).chain((8..64).flat_map(|bit| [(1 << bit) - 1, 1 << bit, 3 << (bit - 1)]))
    {
        let mut durations = Durations::default();
        durations.note(Duration::from_nanos(nanoseconds));
        let (found, exact) = (durations.quantile(0.99), 1e-9 * nanoseconds as f64);
        assert!(found <= exact, "{nanoseconds}: {found}");
        // Beyond a minute, it is only known to be long.
        let near = found >= 0.98 * exact || (exact > 60.0 && found > 60.0);
        assert!(near, "{nanoseconds}: {found}");
    }
    let mut durations = Durations::default();
    durations.note(Duration::MAX);
    assert!(durations.quantile(0.99) > 60.0);
}

#[test]
fn every_refusal_has_its_cause() {
    let defect = |value| Defect { field: "x", value, wanted: "" };
    let causes: Vec<Cause> = vec![
        Cause::from(&BadCircle::Defect(defect(f64::NAN))),
        Cause::from(&defect(f64::INFINITY)),
        Cause::from(&defect(1e70)),
        Cause::from(&BadCircle::Duplicate { count: 2 }),
        Cause::from(&BadCircle::Wall),
        Cause::from(&TooManyCircles(1_000_000)),
        Cause::from(&Refusal::Simulated),
        Cause::from(&Refusal::TooManyObserved),
        Cause::from(&Refusal::TooWide),
        Cause::from(&Refusal::NotMet),
        Cause::from(&carom::detect::TooManyPairs),
        Cause::UnknownRobot,
    ];
    let mut refused = Refused::default();
    causes.iter().for_each(|cause| refused.count(*cause));
    assert_eq!(refused.total(), 12);
    let told: Vec<(&str, u64)> =
        refused.counts().map(|(cause, count)| (cause.name(), count)).collect();
    let expected = [
        ("undecodable", 0),
        ("too_many_circles", 1),
        ("not_finite", 2),
        ("out_of_range", 1),
        ("duplicate_id", 1),
        ("wall_id", 1),
        ("simulated_id", 1),
        ("too_many_observed", 1),
        ("too_wide", 1),
        ("not_met", 1),
        ("too_many_pairs", 1),
        ("unknown_robot", 1),
    ];
    assert_eq!(told, expected);
}

fn world(name: &str) -> World {
    Scene::load(name).expect("shipped").world()
}

fn step(world: &mut World, advance_to: f64) {
    while world.arena().is_some_and(|arena| arena.now() < advance_to) {
        world.step(&[], Instants { heard_at: 0.0, advance_to });
    }
}

fn facts(asked: f64) -> Facts {
    Facts {
        frame_id: "map".into(),
        method: "events".into(),
        real_time_factor_asked: asked,
        left_out: vec!["drag".into(), "gravity".into()],
    }
}

#[test]
fn a_report_is_about_its_interval() {
    let mut world = world("arena");
    world.keep_account();
    step(&mut world, 1.0);
    let mut interval = Interval::default();
    let arena = world.arena().expect("pucks");
    let totals = |simulated, contacts| Totals { simulated, contacts, ..Totals::default() };
    interval.begin(totals(1.0, arena.contacts()));
    let began = arena.contacts();
    step(&mut world, 3.0);
    let arena = world.arena().expect("pucks");
    interval.durations.note(Duration::from_micros(2));
    let contacts = arena.contacts();
    let told = interval.end(totals(3.0, contacts), 2.0, &facts(1.0), Some(arena));
    let report = &told.report;
    assert!(told.warnings.is_empty(), "{:?}", told.warnings);
    assert_eq!((report.header.stamp.sec, report.header.frame_id.as_str()), (3, "map"));
    assert_eq!((report.steps, report.step_max_s, report.real_time_factor), (1, 1e-9 * 2000.0, 1.0));
    assert_eq!(report.contacts_per_second, (contacts - began) as f64 / 2.0);
    assert_eq!(report.energy, arena.kinetic_energy());
    assert!(report.relative_energy_drift.abs() < 1e-14 && report.momentum_drift < 1e-13);
    assert!(report.largest_overlap < 1e-13 * 0.18, "{}", report.largest_overlap);
    assert_eq!(report.left_out, ["drag", "gravity"]);
    // The next one begins there: nothing has happened since.
    let told = interval.end(totals(3.0, contacts), 1.0, &facts(1.0), Some(arena));
    assert_eq!((told.report.steps, told.report.contacts_per_second), (0, 0.0));
    assert_eq!(told.warnings, ["real-time factor 0.000 of 1 asked"]);
}

#[test]
fn what_is_not_as_asked_is_a_warning_once() {
    let mut interval = Interval::default();
    let mut totals = Totals::default();
    interval.begin(totals);
    totals.simulated = 0.89;
    totals.refused.count(Cause::NotFinite);
    totals.refused.count(Cause::NotFinite);
    totals.refused.count(Cause::WallId);
    (totals.dropped_in, totals.dropped_out) = (3, 4);
    let world = world("head_on");
    let told = interval.end(totals, 1.0, &facts(1.0), world.arena());
    let expected = [
        "real-time factor 0.890 of 1 asked",
        "3 inputs refused: not_finite, wall_id",
        "7 messages dropped",
    ];
    assert_eq!(told.warnings, expected);
    assert!(told.report.momentum_drift.is_nan(), "no account is kept");
    totals.simulated += 0.91;
    let told = interval.end(totals, 1.0, &facts(1.0), world.arena());
    assert!(told.warnings.is_empty(), "{:?}", told.warnings);
    // As fast as possible is no promise, and without pucks there is no time.
    let told = interval.end(totals, 1.0, &facts(0.0), world.arena());
    assert!(told.warnings.is_empty(), "{:?}", told.warnings);
    let told = interval.end(totals, 1.0, &facts(1.0), None);
    assert!(told.warnings.is_empty(), "{:?}", told.warnings);
}

#[test]
fn diagnostics_have_the_same_numbers() {
    let mut interval = Interval::default();
    let mut totals = Totals { simulated: 1.0, contacts: 7, ..Totals::default() };
    totals.refused.count(Cause::DuplicateId);
    let world = world("arena");
    interval.durations.note(Duration::from_nanos(3300));
    let told = interval.end(totals, 1.1, &facts(1.0), world.arena());
    let array = diagnostics(&told, Time { sec: 5, nanosec: 6 });
    assert_eq!((array.header.stamp.sec, array.status.len()), (5, 1));
    let status = &array.status[0];
    assert_eq!((status.level, status.hardware_id.as_str()), (DiagnosticStatus::WARN, "carom"));
    assert_eq!(status.message, "1 inputs refused: duplicate_id");
    let value = |key: &str| {
        let found = status.values.iter().filter(|pair| pair.key == key);
        let found: Vec<&str> = found.map(|pair| pair.value.as_str()).collect();
        assert_eq!(found.len(), 1, "{key}");
        found[0].to_owned()
    };
    let report = &told.report;
    for (key, expected) in [
        ("step_p99_s", report.step_p99_s),
        ("contacts_per_second", report.contacts_per_second),
        ("energy", report.energy),
        ("real_time_factor", report.real_time_factor),
    ] {
        assert_eq!(value(key).parse(), Ok(expected), "{key}");
    }
    assert_eq!(value("momentum_drift"), "NaN");
    assert_eq!((value("refused.duplicate_id"), value("refused.wall_id")), ("1".into(), "0".into()));
    assert_eq!((value("dropped_in"), value("left_out")), ("0".into(), "drag, gravity".into()));
    let calm = diagnostics(&interval.end(totals, 1.0, &facts(0.0), world.arena()), Time::default());
    assert_eq!((calm.status[0].level, calm.status[0].message.as_str()), (0, "as asked"));
}
