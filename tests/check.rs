//! `carom check` as a user meets it: the shipped cases, wrong values, malformed files, exit codes.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::{Value, json};

const CASES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cases");

fn carom(arguments: &[&str], folder: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
    command.arg("check").args(arguments).current_dir(folder).output().expect("carom runs")
}

fn report(arguments: &[&str]) -> (Value, Option<i32>) {
    let output = carom(&[&["--json"], arguments].concat(), Path::new(CASES));
    let report = serde_json::from_slice(&output.stdout).expect("one JSON document");
    (report, output.status.code())
}

/// An empty folder of this test's own.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("a folder");
    folder
}

fn shipped(name: &str) -> Value {
    let text = fs::read_to_string(format!("{CASES}/{name}.json")).expect("a case");
    serde_json::from_str(&text).expect("JSON")
}

/// Runs one changed case; its report and the exit code.
fn run_changed(folder_name: &str, case: &Value) -> (Value, Option<i32>) {
    let folder = folder(folder_name);
    fs::write(folder.join("changed.json"), case.to_string()).expect("written");
    let (report, code) = report(&["--quick", "--cases", &folder.to_string_lossy()]);
    (report["cases"][0].clone(), code)
}

#[test]
fn every_shipped_case_passes_or_says_why_not() {
    let (report, code) = report(&["--quick", "--cases", CASES]);
    let cases = report["cases"].as_array().expect("cases");
    assert_eq!(cases.len(), 99);
    for case in cases {
        let name = case["name"].as_str().expect("a name");
        match case["verdict"].as_str().expect("a verdict") {
            "skip" => {
                let reason = case["reason"].as_str().expect("a reason");
                let known = ["not built yet: ", "needs long_run: "];
                assert!(known.iter().any(|k| reason.starts_with(k)), "{name}: {reason}");
            }
            "fail" => panic!("{case:#}"),
            _ => (),
        }
    }
    // The energy of mixed masses must not drift, not even within its looser bound.
    let conservation = cases.iter().find(|case| case["kind"] == "edmd_conservation");
    assert_eq!(conservation.expect("C01")["verdict"], "gold");
    assert_eq!((&report["failed"], code), (&json!(0), Some(0)));
}

#[test]
fn a_wrong_expected_value_fails() {
    let wrong = [
        ("R02_oblique_345", "/expected/subcases/0/v/0/1", json!("-0.4800000000001")),
        ("R02_oblique_345", "/expected/subcases/0/impulse", json!("0.6000000001")),
        ("T02_toi_grazing", "/expected/subcases/1/t", json!("7.5")),
        ("T01_toi_basic", "/expected/subcases/0/t", Value::Null),
        ("D01_contact_predicate", "/expected/subcases/1/touching_or_overlap", json!(true)),
        ("D03_hex_packing", "/expected/contact_count", json!(1178)),
        ("I01_invalid_inputs", "/expected/subcases/0/outcome", json!("Ok, no contacts")),
        ("E01_galperin_100e2", "/expected/total_collisions", json!(315)),
        ("E02_tonks_10", "/expected/x/3", json!("1.0")),
        ("E04_box_unfold_1e3", "/expected/x_bounces", json!(468)),
        ("E06_unstable_pair", "/expected/bounces/3/y", json!("1e-9")),
        ("E08_newton_cradle_5", "/expected/subcases/0/order/0", json!("1-2")),
        ("E16_corner_rest", "/expected/events_after", json!(1)),
        ("E20_chaos_N3", "/expected/events/4/i", json!(2)),
        ("E26_reversibility", "/expected/n_events_each_way", json!(40)),
        ("P01_spring_dashpot_restitution", "/expected/subcases/1/e_full", json!("0.80035364031")),
        ("P02_stability_limits", "/expected/rows/3/rk4", json!("0.94143056245")),
        ("P02_stability_limits", "/expected/limits/rk3", json!("sqrt(3)=1.7320508")),
        ("P02_stability_limits", "/expected/omega_max/pair", json!("sqrt(k/m)")),
        ("P03_soft_cradle", "/expected/v_final/0", json!("-0.130264")),
        ("P03_soft_cradle", "/expected/t_last_separation", json!(3.4272)),
        ("P04_hard_limit", "/expected/rows/2/max_overlap", json!("0.00014162")),
        ("W01_stepped_head_on", "/expected/rows/1/lag", json!("0.0062500000002")),
        ("W02_tunnel_threshold", "/expected/miss_probability/0.01", json!("0.75")),
        ("R14_wall", "/expected/subcases/0/v/0", json!("1.2500000000000004")),
        ("S03_four_discs_box", "/expected/wall_collision_rate", json!("17.500(1)")),
    ];
    for (name, place, value) in wrong {
        let mut case = shipped(name);
        *case.pointer_mut(place).expect("the place") = value;
        let (outcome, code) = run_changed("wrong", &case);
        assert_eq!((outcome["verdict"].as_str(), code), (Some("fail"), Some(1)), "{name} {place}");
    }
}

#[test]
fn other_numbers_of_a_kind_run_unchanged() {
    let mut case = shipped("T01_toi_basic");
    case["name"] = json!("nobody knows this name");
    case["inputs"]["subcases"][0]["bodies"][1]["x"] = json!(12.0);
    case["expected"]["subcases"][0]["t"] = json!("10");
    let (outcome, code) = run_changed("other", &case);
    assert_eq!((outcome["verdict"].as_str(), code), (Some("pass"), Some(0)));
}

#[test]
fn malformed_cases_fail_with_their_place() {
    let mut missing = shipped("R01_head_on");
    missing["inputs"]["subcases"][1]["inputs"]["bodies"][0]["r"] = Value::Null;
    let mut wrong = shipped("E02_tonks_10");
    wrong["inputs"]["bodies"][2]["m"] = json!("heavy");
    let mut negative = shipped("E02_tonks_10");
    negative["inputs"]["bodies"][2]["m"] = json!(-1.0);
    let mut short = shipped("E02_tonks_10");
    short["expected"]["x"] = json!([]);
    let mut formula = shipped("T01_toi_basic");
    formula["tolerance"]["value"] = json!("8u*((((t");
    let mut uneven = shipped("R01_head_on");
    uneven["expected"]["subcases"] = json!([]);
    let cases = [
        (missing, "inputs.subcases[1].inputs.bodies[0]: `r` is missing"),
        (wrong, "inputs.bodies[2].m: must be a number"),
        (negative, "inputs.bodies[2]: mass = -1, must be above 0 kg (inf = fixed)"),
        (short, "expected.x: has no item 0"),
        (formula, "tolerance.value: formula `8u*((((t`: a `)` is missing"),
        (uneven, "expected.subcases: must be 3 like the inputs"),
        (json!({"name": "x"}), "the file: `kind` is missing"),
        (json!([1, 2]), "the file: `kind` is missing"),
    ];
    for (case, reason) in cases {
        let (outcome, code) = run_changed("malformed", &case);
        assert_eq!(outcome["reason"].as_str(), Some(reason));
        assert_eq!((outcome["verdict"].as_str(), code), (Some("fail"), Some(1)));
    }
    let folder = folder("no_json");
    fs::write(folder.join("text.json"), "{\"kind\": ").expect("written");
    let output = carom(&["--cases", &folder.to_string_lossy()], &folder);
    let text = String::from_utf8(output.stdout).expect("text");
    assert!(text.contains("text") && text.contains("not JSON"), "{text}");
    assert!(text.ends_with("0 passed, 1 failed, 0 skipped\n"), "{text}");
    assert_eq!(output.status.code(), Some(1));
}

#[test]
fn every_kind_survives_a_file_with_a_hole() {
    // Each top-level entry of inputs and expected is taken away, and replaced by nonsense, in turn.
    let folder = folder("holes");
    for entry in fs::read_dir(CASES).expect("cases") {
        let path = entry.expect("entry").path();
        let Some(name) = path.file_stem().filter(|_| path.extension().is_some_and(|e| e == "json"))
        else {
            continue;
        };
        let name = name.to_string_lossy();
        // One of a kind is enough, and none that takes long.
        if name.ends_with("_b") || fs::metadata(&path).expect("size").len() > 10_000 {
            continue;
        }
        let whole = shipped(&name);
        let kind = whole["kind"].as_str().expect("a kind");
        for room in if slow(kind) { &["inputs"][..] } else { &["inputs", "expected"] } {
            for key in whole[room].as_object().expect("an object").keys() {
                let mut case = whole.clone();
                case[room][key] = json!({"nonsense": [null]});
                let file = format!("{name}-{room}-{key}.json").replace('/', "_");
                fs::write(folder.join(file), case.to_string()).expect("written");
            }
        }
    }
    let output = carom(&["--quick", "--cases", &folder.to_string_lossy()], &folder);
    let text = String::from_utf8(output.stdout).expect("text");
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(!String::from_utf8_lossy(&output.stderr).contains("panicked"));
}

/// Kinds that compute for seconds before they read what is expected.
fn slow(kind: &str) -> bool {
    kind.starts_with("stats_") || ["edmd_piston", "edmd_tonks", "edmd_galperin"].contains(&kind)
}

#[test]
fn bad_use_is_one_line_and_code_2() {
    let empty = folder("empty");
    let cases: [(&[&str], &str); 4] = [
        (&[], "carom: tests/cases: not here; name the folder with --cases DIR\n"),
        (&["--cases", "nowhere"], "carom: nowhere: No such file or directory (os error 2)\n"),
        (&["--cases", "."], "carom: .: no case files (*.json)\n"),
        (&["--cases", CASES, "--only", "Q*"], "no case files (*.json) named `Q*`\n"),
    ];
    for (arguments, line) in cases {
        let output = carom(arguments, &empty);
        let error = String::from_utf8(output.stderr).expect("text");
        assert!(error.ends_with(line) && error.lines().count() == 1, "{error}");
        assert_eq!(output.status.code(), Some(2));
    }
}

#[test]
fn json_counts_sub_cases_and_unknown_kinds_are_skipped() {
    let (report, code) = report(&["--cases", CASES, "--only", "R0?_h*"]);
    assert_eq!((&report["passed"], code), (&json!(2), Some(0)), "{report}");
    assert_eq!(report["subcases"]["passed"], 6);
    let subcases = report["cases"][0]["subcases"].as_array().expect("sub-cases");
    let labels: Vec<_> = subcases.iter().map(|subcase| &subcase["label"]).collect();
    assert_eq!(labels, ["x", "y", "swap"]);
    assert!(subcases.iter().all(|subcase| subcase["error"].is_number()));
    let (whole, _) = run_changed("unknown", &json!({"kind": "edmd_teapot"}));
    assert_eq!(whole["reason"], "unknown kind edmd_teapot");
    assert_eq!(whole["verdict"], "skip");
}
