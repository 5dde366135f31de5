//! Clean recordings: nothing may be called a violation, and the collisions must be the true ones.

use carom::audit::findings::{Findings, Sight};
use carom::audit::{Bounds, Frame, Options};
use carom::world::{Contact, Disc, Partner, Settings, Walls};
use glam::DVec2;

use crate::audited;
use crate::common::{arena, disc, run, states};
use crate::recordings::{Gas, in_single, sampled};

/// What the recorder knows of the law.
pub fn told(restitution: f64, walls: Option<Walls>) -> Options {
    let bounds = |walls: Walls| Bounds { min: walls.min, max: walls.max, restitution: None };
    Options {
        restitution: Some(restitution),
        no_walls: walls.is_none(),
        walls: walls.map(bounds),
        ..Options::default()
    }
}

pub fn assert_clean(findings: &Findings, what: &str) {
    let worst = findings.worst.first();
    assert_eq!(findings.violations_in_all(), 0, "{what}: {worst:?}");
}

/// Gases at these densities, rates and kinds: elastic equal discs, and others.
fn gases(count: usize, frames: usize) {
    for area_fraction in [0.2, 0.5] {
        let wide = if area_fraction < 0.3 { 2.0 } else { 1.2 };
        for (size_ratio, mass_max, restitution) in [(1.0, 1.0, 1.0), (wide, 5.0, 0.9)] {
            for rate in [240.0, 60.0] {
                let gas =
                    Gas { size_ratio, mass_max, restitution, ..Gas::new(count, area_fraction) };
                let (mut arena, settings) = gas.arena();
                let before = arena.contacts();
                let recorded = sampled(&mut arena, rate, frames);
                let contacts = arena.contacts() - before;
                for options in [told(restitution, settings.walls), Options::default()] {
                    let (findings, collisions) = audited(recorded.clone(), &options);
                    let what = format!("{area_fraction} {rate} Hz {restitution} {options:?}");
                    assert_clean(&findings, &what);
                    let counts = findings.counts;
                    let seen = collisions.len() as u64;
                    assert_eq!(
                        seen,
                        counts.alone + counts.foretold + counts.singled + counts.walls
                    );
                    // A wall that too few reached is not known.
                    let seen = seen + counts.unexplained;
                    // Only where several in a row fall between two samples some are left open.
                    let rare = contacts * 100 < count as u64 * frames as u64 * 20;
                    let least = if rare { contacts } else { contacts * 2 / 5 };
                    assert!(seen >= least && seen <= contacts, "{what}: {seen} of {contacts}");
                    let off = findings.law.restitution.map(|e| (e - restitution).abs());
                    assert!(off < Some(1e-9), "{what}: {off:?}");
                }
            }
        }
    }
}

#[test]
fn a_hundred_discs_have_no_violation() {
    gases(100, 240);
}

#[test]
fn a_thousand_discs_have_no_violation() {
    gases(1000, 60);
}

#[test]
fn numbers_of_4_bytes_are_no_violation() {
    for rate in [240.0, 60.0] {
        let (mut arena, settings) = Gas { restitution: 0.9, ..Gas::new(100, 0.2) }.arena();
        let mut frames = sampled(&mut arena, rate, 480);
        in_single(&mut frames);
        let (findings, collisions) = audited(frames, &told(0.9, settings.walls));
        assert!(findings.noise.single);
        assert_clean(&findings, "4 bytes");
        assert!(collisions.len() > 200, "{}", collisions.len());
    }
}

/// Samples of a scene of the tests' plain arena, and its contacts.
fn plain(
    settings: &Settings,
    discs: &[Disc],
    rate: f64,
    frames: usize,
) -> (Vec<Frame>, Vec<Contact>) {
    let mut arena = arena(settings, discs);
    let mut contacts = Vec::new();
    let sample = |k: usize| {
        let time = k as f64 / rate;
        contacts.extend(run(&mut arena, time));
        Frame { time_ns: (1e9 * time).round() as i64, discs: states(&arena) }
    };
    let all = (0..frames).map(sample).collect();
    (all, contacts)
}

#[test]
fn every_number_of_a_collision_alone_is_the_true_one() {
    let discs = [
        disc(7, [0.0, 0.03], [1.5, 0.0], 0.1, 2.0),
        disc(9, [0.5, 0.0], [-0.25, 0.125], 0.15, 1.0),
    ];
    let settings = Settings { restitution: 0.75, ..Settings::default() };
    let (frames, contacts) = plain(&settings, &discs, 60.0, 60);
    let (findings, collisions) = audited(frames, &told(0.75, None));
    assert_clean(&findings, "two discs");
    assert_eq!((collisions.len(), contacts.len()), (1, 1));
    let (found, truth) = (collisions[0], contacts[0]);
    assert_eq!(found.sight, Sight::Alone);
    assert_eq!(truth.b, Partner::Disc(9));
    assert!((found.time - truth.time).abs() < 1e-9);
    assert!(found.place.distance(truth.point) < 1e-9);
    assert!(found.normal.distance(truth.normal) < 1e-8);
    assert!((found.approach - truth.approach_speed).abs() < 1e-9);
    assert!((found.restitution.0 - 0.75).abs() < 1e-8);
    assert!((found.energy + truth.energy_loss).abs() < 1e-9);
    assert!((found.energy - found.energy_law).abs() < 1e-8);
    assert!(found.gap.abs() < 1e-8 && found.momentum < 1e-12);
}

/// Walls around twenty discs of several masses.
const WALLS: Walls = Walls { min: DVec2::ZERO, max: DVec2::splat(2.4), restitution: 1.0 };

/// Samples of the twenty, under these laws within their walls.
fn twenty(settings: Settings, rate: f64, frames: usize) -> Vec<Frame> {
    let discs: Vec<Disc> = (0..20)
        .map(|k| {
            let place = [0.3 + 0.4 * f64::from(k % 5), 0.3 + 0.4 * f64::from(k / 5)];
            let turn = DVec2::from_angle(2.4 * f64::from(k)) * 0.8;
            disc(k, place, turn.to_array(), 0.08, 1.0 + 0.1 * f64::from(k))
        })
        .collect();
    let settings = Settings { walls: Some(WALLS), ..settings };
    let plan = carom::plan::Plan::of(&settings, &discs);
    let mut arena = carom::motion::arena::Arena::new(&plan, plan.laws(&settings), &discs);
    sampled(&mut arena, rate, frames)
}

#[test]
fn drag_and_gravity_are_told_or_found_out() {
    let slowed = Settings { drag: 0.3, ..Settings::default() };
    let falling = Settings { gravity: Some(DVec2::new(0.5, -1.0)), ..Settings::default() };
    for (settings, drag, gravity) in
        [(slowed, 0.3, DVec2::ZERO), (falling, 0.0, DVec2::new(0.5, -1.0))]
    {
        let frames = twenty(settings, 120.0, 600);
        let known = Options {
            drag: Some(drag).filter(|drag| *drag > 0.0),
            gravity: Some(gravity).filter(|gravity| gravity.length() > 0.0),
            ..told(1.0, Some(WALLS))
        };
        for options in [known, told(1.0, Some(WALLS))] {
            let (findings, collisions) = audited(frames.clone(), &options);
            assert_clean(&findings, &format!("{options:?}"));
            assert!((findings.law.drag - drag).abs() < 1e-6, "{}", findings.law.drag);
            assert!(findings.law.gravity.distance(gravity) < 1e-6, "{}", findings.law.gravity);
            assert!(collisions.len() > 30, "{}", collisions.len());
            assert_eq!(findings.counts.unexplained, 0);
        }
    }
}

/// Discs that fly side by side, in touch and apart, as gravity or drag takes them.
fn formation(rate: f64, frames: usize, gravity: DVec2, drag: f64) -> Vec<Frame> {
    let start = DVec2::new(1.0, 0.5);
    let place =
        |k: usize, place: [f64; 2], mass| disc(k as u32, place, start.to_array(), 0.1, mass);
    let discs = [
        place(1, [0.0, 0.0], 1.0),
        place(2, [0.2, 0.0], 2.0),
        place(3, [0.0, 0.2], 1.0),
        place(4, [0.41, 0.0], 3.0),
        place(5, [4.0, 0.0], 1.0),
    ];
    let sample = |k: usize| {
        let time = k as f64 / rate;
        let length = if drag > 0.0 { (1.0 - (-drag * time).exp()) / drag } else { time };
        let way = start * length + 0.5 * gravity * time * time;
        let velocity = start * (-drag * time).exp() + gravity * time;
        let moved = |disc: &Disc| Disc { position: disc.position + way, velocity, ..*disc };
        Frame { time_ns: (1e9 * time).round() as i64, discs: discs.iter().map(moved).collect() }
    };
    (0..frames).map(sample).collect()
}

/// Gravity and drag, one of them none.
const MOTIONS: [(DVec2, f64); 3] =
    [(DVec2::new(0.0, -9.81), 0.0), (DVec2::new(1.0, -30.0), 0.0), (DVec2::ZERO, 0.5)];

fn told_motion(gravity: DVec2, drag: f64, options: Options) -> Options {
    Options { gravity: Some(gravity), drag: Some(drag), ..options }
}

#[test]
fn stamps_that_are_no_period_are_no_violation_under_gravity_or_drag() {
    for rate in [30.0, 60.0, 100.0, 240.0] {
        for (gravity, drag) in MOTIONS {
            let frames = formation(rate, 3 * rate as usize, gravity, drag);
            let known = told_motion(gravity, drag, Options::default());
            for options in [known, told(1.0, None), Options::default()] {
                let (findings, collisions) = audited(frames.clone(), &options);
                let what = format!("{rate} {gravity} {drag} {options:?} {:?}", findings.counts);
                assert_clean(&findings, &what);
                let counts = findings.counts;
                let open = counts.ambiguous + counts.unexplained + counts.displaced;
                assert_eq!((collisions.len(), open), (0, 0), "{what}");
                assert!((findings.law.drag - drag).abs() < 1e-8, "{}", findings.law.drag);
                assert!(findings.law.gravity.distance(gravity) < 1e-7, "{}", findings.law.gravity);
            }
        }
    }
}

#[test]
fn collisions_under_gravity_or_drag_have_no_violation_at_any_rate() {
    for rate in [30.0, 60.0, 100.0, 240.0] {
        for (gravity, drag) in MOTIONS {
            let settings = Settings { drag, gravity: Some(gravity), ..Settings::default() };
            let frames = twenty(settings, rate, 3 * rate as usize);
            let known = told_motion(gravity, drag, told(1.0, Some(WALLS)));
            for options in [known, told(1.0, Some(WALLS))] {
                let (findings, collisions) = audited(frames.clone(), &options);
                let what = format!("{rate} {gravity} {drag} {options:?} {:?}", findings.counts);
                assert_clean(&findings, &what);
                assert!(collisions.len() > 30, "{what}");
                assert_eq!(findings.counts.unexplained, 0, "{what}");
            }
        }
    }
}

#[test]
fn one_collision_in_two_or_three_samples_is_no_motion_of_all() {
    let discs = [
        disc(1, [-0.2, 0.03], [1.5, 0.0], 0.1, 2.0),
        disc(2, [0.2, 0.0], [-0.25, 0.125], 0.1, 1.0),
    ];
    let (frames, contacts) = plain(&Settings::default(), &discs, 60.0, 60);
    assert_eq!(contacts.len(), 1);
    let hit = frames.iter().position(|frame| 1e-9 * frame.time_ns as f64 > contacts[0].time);
    let hit = hit.expect("a sample after it");
    for (before, after) in [(1, 1), (2, 1), (1, 2), (2, 2), (5, 1)] {
        let few = frames[hit - before..hit + after].to_vec();
        let (findings, collisions) = audited(few, &Options::default());
        assert_clean(&findings, &format!("{before} {after}"));
        assert_eq!((findings.law.gravity, findings.law.drag), (DVec2::ZERO, 0.0));
        assert_eq!(collisions.len(), 1);
    }
}

#[test]
fn the_shipped_scenes_have_no_violation() {
    for name in ["arena", "break_shot", "newtons_cradle", "head_on"] {
        let scene = carom::scene::Scene::load(name).expect("shipped");
        let discs: Vec<Disc> = scene.pucks.iter().map(|puck| puck.disc).collect();
        let settings = scene.settings;
        let plan = carom::plan::Plan::of(&settings, &discs);
        let mut arena = carom::motion::arena::Arena::new(&plan, plan.laws(&settings), &discs);
        let frames = sampled(&mut arena, 60.0, 300);
        let bounds = |walls: Walls| Bounds {
            min: walls.min,
            max: walls.max,
            restitution: Some(walls.restitution),
        };
        let options = Options {
            restitution: Some(settings.restitution),
            walls: settings.walls.map(bounds),
            no_walls: settings.walls.is_none(),
            gravity: settings.gravity,
            drag: Some(settings.drag),
            ..Options::default()
        };
        let (findings, _) = audited(frames, &options);
        assert_clean(&findings, name);
    }
}
