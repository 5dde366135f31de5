//! `carom explain` as a user meets it: a table for every shipped scene, JSON, clear refusals.

use std::process::{Command, Output};

use carom::plan::parts::Part;
use carom::scene::shipped;
use serde_json::Value;

fn explain(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
    command.arg("explain").args(arguments).output().expect("carom runs")
}

fn table(arguments: &[&str]) -> String {
    let output = explain(arguments);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && error.is_empty(), "{error}");
    String::from_utf8(output.stdout).expect("text")
}

fn document(arguments: &[&str]) -> Value {
    serde_json::from_str(&table(&[arguments, &["--json"]].concat())).expect("one JSON document")
}

/// The line of a part.
fn line<'a>(table: &'a str, part: &str) -> &'a str {
    table.lines().find(|line| line.starts_with(part)).unwrap_or_else(|| panic!("{part}: {table}"))
}

#[test]
fn every_shipped_scene_has_its_table() {
    for name in shipped::names() {
        let table = table(&[name, "--quick"]);
        for part in Part::ALL {
            let line = line(&table, part.name());
            let verdicts = ["kept", "left out", "always there"];
            assert!(verdicts.iter().any(|verdict| line.contains(verdict)), "{name}: {line}");
        }
        assert!(table.lines().all(|line| line.chars().count() < 130), "{table}");
        let method = match name {
            "resolver" => "no pucks",
            "arena" | "thousand" => "method events",
            "ssl-a" | "ssl-b" | "vsss-3v3" | "vsss-5v5" | "league-2d" => "method ticks",
            _ => "method plain",
        };
        assert!(table.lines().next().is_some_and(|first| first.contains(method)), "{table}");
    }
}

#[test]
fn what_is_asked_for_is_told() {
    let found = table(&["thousand", "--quick", "--method", "plain", "--keep-all"]);
    assert!(found.contains("one thousand pucks: method plain, asked for"), "{found}");
    assert!(line(&found, "drag").contains("asked for"), "{found}");
    let found = table(&["thousand", "--quick", "--keep-all"]);
    assert!(line(&found, "unequal masses").contains("asked for"), "{found}");
    assert!(line(&found, "walls").contains("kept"), "{found}");
}

#[test]
fn savings_are_measured() {
    for (name, parts) in [("thousand", 8), ("head_on", 3), ("teams", 3), ("resolver", 0)] {
        let found = document(&[name]);
        let rows = found["parts"].as_array().expect("a list");
        assert_eq!(rows.len(), Part::ALL.len());
        let measured = rows.iter().filter(|row| row["saves"]["percent"].is_number());
        assert!(measured.clone().count() >= parts, "{name}: {found:#}");
        assert!(measured.clone().all(|row| row["verdict"] == "left_out"), "{found:#}");
        assert_eq!(found["all_parts"]["percent"].is_number(), parts > 0, "{found:#}");
        assert_eq!(found["ns_per_contact"].is_number(), parts > 0, "{found:#}");
        assert_eq!(found["method"].is_null(), name == "resolver");
    }
    let quick = document(&["arena", "--quick"]);
    assert!(quick["parts"].as_array().expect("a list").iter().all(|row| row["saves"].is_null()));
}

#[test]
fn a_scene_in_which_nothing_happens_is_told_without_times() {
    let scene = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("rest.yaml");
    std::fs::write(&scene, "pucks: [{name: a, position: [0, 0], radius: 0.5}]\n").expect("room");
    let found = document(&[&scene.to_string_lossy()]);
    assert_eq!((&found["method"], &found["ns_per_contact"]), (&"plain".into(), &Value::Null));
}

#[test]
fn a_budget_is_weighed_on_the_scene() {
    let found = table(&["thousand", "--error", "1e-6", "--budget", "10s"]);
    let chosen = line(&found, "events");
    assert!(chosen.contains("<- chosen") && chosen.contains("e-15"), "{found}");
    assert!(line(&found, "steps of").contains("1.0e-6"), "{found}");
    assert!(found.contains("within error 1.0e-6 and budget 10 s"), "{found}");
    let budget = &document(&["head_on", "--budget", "1ns"])["budget"];
    let candidates = budget["candidates"].as_array().expect("a list");
    let chosen = candidates.iter().filter(|candidate| candidate["chosen"] == true);
    assert_eq!(chosen.count(), 1, "{budget:#}");
    assert!(candidates.iter().any(|candidate| candidate["time_s"].is_number()), "{budget:#}");
    let verdict = budget["verdict"].as_str().expect("words");
    assert!(verdict.contains("the budget of 1 ns gives way, by"), "{verdict}");
    assert!(document(&["head_on", "--quick"])["budget"].is_null());
}

#[test]
fn bad_use_is_one_line_and_code_2() {
    let bad = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("bad.yaml");
    std::fs::write(&bad, "walls: {x: [0, 4]}\n").expect("room");
    let cases: [(&[&str], &str); 6] = [
        (&["teams", "--budget", "2 hours"], "must be a time above 0, such as 2ms"),
        (&["teams", "--quick", "--error", "1"], "cannot be used with"),
        (&["nosuch"], "nosuch: No such file"),
        (&[&bad.to_string_lossy()], "bad.yaml:1:"),
        (&["teams", "--method", "springs"], "teams: method springs does not do restitution"),
        (&["teams", "--method", "fast"], "invalid value 'fast'"),
    ];
    for (arguments, expected) in cases {
        let output = explain(arguments);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(error.starts_with("carom: ") && error.contains(expected), "{error}");
        assert!(error.lines().count() == 1 && output.stdout.is_empty(), "{error}");
    }
}

#[test]
fn bench_gas_gives_the_same_physics_with_all_parts() {
    let gas = |more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
        let arguments = ["bench", "gas", "--discs", "300", "--collisions", "20000", "--json"];
        let output = command.args(arguments).args(more).output().expect("carom runs");
        let found: Value = serde_json::from_slice(&output.stdout).expect("one JSON document");
        ["rate", "energy_drift", "largest_miss", "collisions"].map(|key| found[key].clone())
    };
    for boundary in ["periodic", "walls"] {
        let bare = gas(&["--boundary", boundary]);
        assert_eq!(gas(&["--boundary", boundary, "--keep-all"]), bare);
    }
}
