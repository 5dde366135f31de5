//! Exact recordings of small scenes that were once called wrong: blows passed on through touching
//! discs, fixed discs that cross, periodic boxes.

use carom::audit::Frame;
use carom::scene::file::parse;
use carom::world::{Instants, Owner};
use serde_json::Value;

use crate::{bag, folder, json};

/// What the audit says of a scene that is recorded at 60 Hz, and how many contacts it had.
fn recorded(name: &str, scene: &str, seconds: u32) -> (Value, u64) {
    let mut world = parse(scene, name).expect("sound").world();
    let record = |k: u32| {
        let advance_to = f64::from(k) / 60.0;
        world.step(&[], Instants { heard_at: 0.0, advance_to });
        let discs = world.arena().expect("pucks").discs(Owner::Simulated).collect();
        Frame { time_ns: (1e9 * advance_to).round() as i64, discs }
    };
    let frames: Vec<Frame> = (0..=60 * seconds).map(record).collect();
    let contacts = world.arena().expect("pucks").contacts();
    let path = folder(&format!("exact_{name}")).join("bag");
    bag(&path, &frames, 1, Some(scene));
    let (told, code) = json(&path, &[]);
    assert_eq!((told["violations"].as_u64(), code), (Some(0), Some(0)), "{name}: {told}");
    (told, contacts)
}

fn count(told: &Value, what: &str) -> u64 {
    told["counts"][what].as_u64().expect("a count")
}

/// Collisions of all kinds that were judged, none left open.
fn judged(told: &Value) -> u64 {
    for open in ["ambiguous", "unexplained", "displaced", "beside", "heaped", "teleports", "far"] {
        assert_eq!(count(told, open), 0, "{open}: {told}");
    }
    ["alone", "foretold", "singled", "walls"].map(|what| count(told, what)).iter().sum()
}

/// Pucks on the line y = 0.5 m: place, velocity and mass of each.
fn pucks(discs: &[(f64, f64, f64)]) -> String {
    let puck = |(k, (x, v, mass)): (usize, &(f64, f64, f64))| {
        let mass = if mass.is_infinite() { ".inf".to_owned() } else { mass.to_string() };
        format!(
            " - {{name: p{k}, position: [{x}, 0.5], velocity: [{v}, 0], radius: 0.0625, mass: \
             {mass}}}\n"
        )
    };
    "pucks:\n".to_owned() + &discs.iter().enumerate().map(puck).collect::<String>()
}

const WALLS: &str = "walls: {x: [0, 20], y: [0, 1]}\n";

/// One disc that hits a row of touching ones.
fn cradle(balls: u32, speed: f64) -> String {
    let row = (0..balls).map(|k| (5.0 + 0.125 * f64::from(k), 0.0, 1.0));
    pucks(&[(4.0, speed, 1.0)].into_iter().chain(row).collect::<Vec<_>>())
}

#[test]
fn a_blow_passed_on_through_touching_discs_is_lawful() {
    for (balls, speed) in [(2, 1.0), (3, 1.0), (5, 0.7), (8, 1.0), (20, 0.7), (20, 1.0), (50, 1.0)]
    {
        // The walls send the last one back.
        let scene = WALLS.to_owned() + &cradle(balls, speed);
        let (told, contacts) = recorded(&format!("cradle_{balls}_{speed}"), &scene, 30);
        assert_eq!(judged(&told), contacts, "{told}");
        assert!(contacts > u64::from(balls), "{contacts}");
    }
}

#[test]
fn rows_that_pass_a_blow_on_to_what_is_fixed_or_heavier_are_lawful() {
    let rest = [(5.0, 0.0, 1.0), (5.125, 0.0, 1.0), (5.25, 0.0, 1.0)];
    let row = |more: &[(f64, f64, f64)]| WALLS.to_owned() + &pucks(&[more, &rest].concat());
    let at_wall = [(1.0, -1.0, 1.0), (0.1875, 0.0, 1.0), (0.0625, 0.0, 1.0)];
    for (name, scene) in [
        ("two", row(&[(4.0, 1.0, 1.0), (3.875, 1.0, 1.0)])),
        ("fixed", row(&[(4.0, 1.0, 1.0), (5.375, 0.0, f64::INFINITY)])),
        ("heavy", row(&[(4.0, 1.0, 1.0), (5.375, 0.0, 2.0)])),
        ("wall", WALLS.to_owned() + &pucks(&at_wall)),
        ("lossy", "restitution: 0.9\n".to_owned() + WALLS + &cradle(4, 1.0)),
    ] {
        let (told, contacts) = recorded(&format!("row_{name}"), &scene, 5);
        assert!(contacts > 3 && judged(&told) > 0, "{name} {contacts} {told}");
    }
}

#[test]
fn fixed_discs_that_cross_are_lawful() {
    let light = (1.0, 0.0, 1.0);
    for speed in [1.0, 40.0] {
        let fixed = [(3.0, speed, f64::INFINITY), (4.0, -speed, f64::INFINITY)];
        for (name, discs) in [("two", fixed.to_vec()), ("three", [&fixed[..], &[light]].concat())] {
            let name = format!("fixed_{name}_{speed}");
            let (told, _) = recorded(&name, &pucks(&discs), 2);
            assert_eq!(told["overlaps"].as_u64(), Some(0), "{told}");
            judged(&told);
        }
    }
}

#[test]
fn contacts_across_the_border_of_a_periodic_box_are_judged_like_others() {
    for count in [3, 4, 6, 8] {
        for seed in 1..=3 {
            let scene = format!(
                "periodic: {{x: [0, 1], y: [0, 1]}}\nbatches:\n - {{name: g, count: {count}, \
                 seed: {seed}, radius: 0.1, speed: 1}}\n"
            );
            let (told, contacts) = recorded(&format!("periodic_{count}_{seed}"), &scene, 10);
            assert_eq!(judged(&told), contacts, "{count} {seed}: {told}");
            assert!(contacts > 10, "{contacts}");
        }
    }
}
