//! `carom bench peers` at small sizes: what it says of the engines could be wrong; it is held here.

use std::process::{Command, Output};
use std::sync::OnceLock;

use serde_json::Value;

const STEPS: [f64; 2] = [1.0 / 60.0, 1.0 / 240.0];

fn peers(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
    command.args(["bench", "peers"]).args(arguments).output().expect("carom runs")
}

const SMALL: [&str; 8] =
    ["--discs", "100", "--area-fraction", "0.6", "--seconds", "2", "--dt", "1/60,1/240"];

/// One small comparison, which all tests read.
fn compared() -> &'static Value {
    static COMPARED: OnceLock<Value> = OnceLock::new();
    COMPARED.get_or_init(|| {
        let output = peers(&[&SMALL[..], &["--json"]].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).expect("one JSON document")
    })
}

/// The rows of a mover, in the order of the steps.
fn rows(table: &str, mover: &str) -> Vec<&'static Value> {
    let rows = compared()[table].as_array().expect("rows");
    rows.iter().filter(|row| row["mover"] == mover).collect()
}

fn numbers(table: &str, mover: &str, key: &str) -> Vec<f64> {
    let number = |row: &Value| row[key].as_f64().unwrap_or_else(|| panic!("{key}: {row}"));
    rows(table, mover).into_iter().map(number).collect()
}

#[test]
fn every_engine_has_a_row_at_every_step() {
    for table in ["gas", "isolated"] {
        assert_eq!(rows(table, "events").len(), 1);
        for mover in ["steps", "box2d", "rapier"] {
            assert_eq!(numbers(table, mover, "step_s"), STEPS, "{table} {mover}");
        }
    }
    assert_eq!(rows("gas", "events_periodic").len(), 1);
    assert_eq!(compared()["gas"].as_array().map(Vec::len), Some(8));
    assert_eq!(compared()["isolated"].as_array().map(Vec::len), Some(9));
}

#[test]
fn carom_keeps_the_energy_and_the_others_do_not() {
    let kept = ["events", "events_periodic", "steps"];
    for error in kept.into_iter().flat_map(|mover| numbers("gas", mover, "energy_error")) {
        assert!(error.abs() < 1e-12, "{error:e}");
    }
    for mover in ["box2d", "rapier"] {
        for error in numbers("gas", mover, "energy_error") {
            assert!(error < -1e-3 && error > -1.0, "{mover} {error:e}");
        }
    }
}

#[test]
fn all_are_timed_and_see_about_the_same_contacts() {
    for mover in ["steps", "box2d", "rapier"] {
        for row in rows("gas", mover) {
            assert!(row["wrong"].is_null() && row["ns_per_disc_step"]["least"].is_number());
            let (median, least) = (&row["ms_per_s"]["median"], &row["ms_per_s"]["least"]);
            assert!(median.as_f64() >= least.as_f64() && least.as_f64() > Some(0.0), "{row}");
        }
        for error in numbers("gas", mover, "contacts_error") {
            assert!(error.abs() < 0.5, "{mover} {error}");
        }
        for overlap in numbers("gas", mover, "largest_overlap") {
            assert!(overlap > 0.0 && overlap < 1.0, "{mover} {overlap}");
        }
    }
}

#[test]
fn one_collision_is_exact_or_of_first_order_or_does_not_converge() {
    let errors = |mover| numbers("isolated", mover, "rms_error_mps");
    assert!(errors("events")[0] < 1e-15, "{:?}", errors("events"));
    // A quarter of the step, a quarter of the error.
    let ratio = |mover| errors(mover)[0] / errors(mover)[1];
    assert!((3.5..4.5).contains(&ratio("steps")), "{}", ratio("steps"));
    // Sub-steps find the instant, but along the line of centres at the beginning of the step.
    for mover in ["box2d", "rapier_fresh"] {
        assert!((2.5..4.5).contains(&ratio(mover)), "{mover} {}", ratio(mover));
    }
    assert!((0.8..1.2).contains(&ratio("rapier")), "{}", ratio("rapier"));
}

#[test]
fn the_table_names_every_engine() {
    let output = peers(&SMALL);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let starting = |name: &str| text.lines().filter(|line| line.starts_with(name)).count();
    assert_eq!(starting("carom events"), 3, "{text}");
    assert_eq!(starting("carom steps"), 4, "{text}");
    assert_eq!(starting("Box2D"), 4, "{text}");
    assert_eq!(starting("Rapier"), 6, "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 108), "{text}");
}

#[test]
fn bad_use_is_one_line_and_code_2() {
    for arguments in [
        &["--dt", "0"][..],
        &["--dt", "1/0"],
        &["--dt", "1/60,fast"],
        &["--dt", ""],
        &["--seconds", "0.1"],
        &["--seconds", "-1"],
        &["--area-fraction", "0.89"],
        &["--discs", "5"],
    ] {
        let output = peers(arguments);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(error.lines().count() == 1 && error.starts_with("carom: "), "{error}");
        assert!(output.stdout.is_empty());
    }
}

#[cfg(feature = "report")]
#[test]
fn events_is_below_and_left_of_every_point_of_every_peer() {
    use carom::report::Effort;
    use carom::report::figures::gas::{Measured, Who, conclusion, movers, not_beaten};
    use carom::report::figures::mover::Mover;
    let compared = |who: &Who| !who.is_own() || *who == Who::Own(Mover::Events);
    let movers: Vec<Who> = movers(Effort::Quick).into_iter().filter(compared).collect();
    assert_eq!(movers.len(), 7, "events, two engines at three steps");
    let measure = |area_fraction| {
        let scene = (300, area_fraction, 1.0);
        Measured::new(scene, &movers, 3, |_| ()).expect("a measured gas")
    };
    let mut all = [0.3, 0.6].map(measure);
    for gas in &all {
        assert_eq!(not_beaten(gas), [] as [String; 0]);
        let peers = gas.rows.iter().filter(|row| !row.who.is_own());
        for row in peers {
            let error = row.ended.error.worst;
            assert!(error > 1e-6, "{}: {error}: not in doubles", row.who.curve());
            assert!(error < 50.0 || row.ended.lost > 0, "{}: {error}", row.who.curve());
        }
    }
    assert!(conclusion(&all)[1].contains("is below and left of every point"));
    // What is slower or farther off than one of them must say so.
    all[0].rows[0].timing.median_s = 10.0;
    assert_eq!(not_beaten(&all[0]).len(), 6);
    assert!(conclusion(&all)[1].contains("NOT"));
}
