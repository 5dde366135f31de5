//! `carom bench gas` as a user meets it: checked physics, the same answer twice, clear refusals.

use std::process::{Command, Output};

use serde_json::Value;

fn gas(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
    command.args(["bench", "gas"]).args(arguments).output().expect("carom runs")
}

fn measured(arguments: &[&str]) -> Value {
    let output = gas(&[arguments, &["--json", "--collisions", "20000"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON document")
}

#[test]
fn every_kind_of_gas_is_measured_and_right() {
    for arguments in [
        "--discs 500 --area-fraction 0.2",
        "--discs 500 --area-fraction 0.68",
        "--discs 300 --boundary walls --area-fraction 0.4",
        "--discs 300 --mass-max 10 --size-ratio 1.4 --area-fraction 0.4",
        "--discs 300 --restitution 0.95 --melt 2",
        "--discs 100 --method plain",
    ] {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        let found = measured(&arguments);
        let number = |key: &str| found[key].as_f64().unwrap_or_else(|| panic!("{found}"));
        assert!(number("ns_per_collision") > 1.0);
        assert!(number("largest_miss") < 1e-11, "{found}");
        assert!(number("energy_drift").abs() < 1e-12, "{found}");
        assert!(number("collisions") >= 20_000.0);
    }
}

#[test]
fn every_method_is_measured() {
    for method in ["events", "plain", "ticks", "steps", "springs"] {
        let found = measured(&["--discs", "100", "--method", method, "--boundary", "walls"]);
        assert_eq!(found["method"], method);
        let steps = ["steps", "springs"].contains(&method);
        assert_eq!(found["ns_per_disc_step"].is_number(), steps, "{found}");
        assert_eq!(found["late"].is_number(), method == "steps", "{found}");
        let drift = found["energy_drift"].as_f64().expect("a number");
        assert!(drift.abs() < if method == "springs" { 1e-2 } else { 1e-12 }, "{found}");
    }
    let finer = measured(&["--discs", "100", "--method", "steps", "--step", "0.001"]);
    assert!(finer["missed"].as_f64().expect("a share") < 1e-3, "{finer}");
}

#[test]
fn a_processor_without_vector_units_gives_the_same_physics() {
    let of = |more: &[&str]| {
        let found = measured(&[&["--discs", "300"], more].concat());
        (found["rate"].clone(), found["largest_miss"].clone(), found["energy_drift"].clone())
    };
    assert_eq!(of(&[]), of(&["--portable"]));
}

#[test]
fn the_same_seed_gives_the_same_physics() {
    let run = |seed| measured(&["--discs", "300", "--seed", seed])["rate"].clone();
    assert_eq!(run("7"), run("7"));
    assert_ne!(run("7"), run("8"));
}

#[test]
fn bench_alone_says_what_it_can_measure() {
    let output = Command::new(env!("CARGO_BIN_EXE_carom")).arg("bench").output().expect("runs");
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2));
    assert!(error.contains("gas") && error.lines().count() == 1, "{error}");
}

#[test]
#[cfg(not(feature = "peers"))]
fn without_the_other_engines_bench_peers_says_how_to_get_them() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
    let output = command.args(["bench", "peers", "--dt", "1/60,0.001"]).output().expect("runs");
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2));
    assert!(error.contains("--features peers") && error.lines().count() == 1, "{error}");
}

#[test]
fn bad_use_is_one_line_and_code_2() {
    for arguments in [
        &["--area-fraction", "0.95"][..],
        &["--area-fraction", "nan"],
        &["--discs", "0"],
        &["--boundary", "round"],
        &["--method", "fast"],
        &["--collisions", "-3"],
        &["--restitution", "2"],
        &["--size-ratio", "0.5"],
        // Too close for the lattice; too few for a periodic box of the method.
        &["--area-fraction", "0.6", "--size-ratio", "3"],
        &["--discs", "9", "--method", "events"],
        &["--method", "springs"],
        &["--method", "steps", "--step", "0"],
    ] {
        let output = gas(arguments);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(error.starts_with("carom: ") && output.stdout.is_empty(), "{error}");
    }
}
