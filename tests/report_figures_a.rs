//! Figures of the report in a tiny size: what they claim holds, and the same again has the same
//! bits.

use std::path::PathBuf;

use carom::bench::explain::Blocks;
use carom::check::Options;
use carom::detect::impact::Relative;
use carom::motion::springs::Explicit;
use carom::report::digits;
use carom::report::figures::impact::formulas::Formula;
use carom::report::figures::impact::pairs::Category;
use carom::report::figures::resolver::pairs::{Touching, categories};
use carom::report::figures::resolver::variants::ALL;
use carom::report::figures::resolver::{Outcome, bias, outcomes_of};
use carom::report::figures::stability::{self, chain, springs};
use carom::report::figures::{cases, impact, left_out, resolver, scaling};
use carom::report::page::{Item, Map, Section, Table};
use carom::world::Disc;
use glam::DVec2;
use serde_json::Value;

const FORMS: resolver::Size = resolver::Size { pairs: 800, repeats: 5, collisions: 4_000 };

fn case(name: &str) -> Value {
    let path = format!("{}/tests/cases/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).expect("a case")).expect("JSON")
}

fn tables(section: &Section) -> impl Iterator<Item = &Table> {
    section.items.iter().filter_map(|item| match item {
        Item::Table(table) => Some(table),
        _ => None,
    })
}

/// All that must be the same in every report.
fn untimed(section: &Section) -> String {
    let mut told = format!("{:?}", section.text);
    for item in &section.items {
        match item {
            Item::Map(map) => told += &format!("{:?} {:?}", map.values, map.lines),
            Item::Table(table) => {
                for row in &table.rows {
                    assert_eq!(row.len(), table.columns.len(), "{}", table.name);
                    let kept = row.iter().zip(&table.columns).filter(|(_, column)| !column.timed);
                    told += &format!("{:?}", kept.map(|(cell, _)| cell).collect::<Vec<_>>());
                }
            }
            Item::Plot(plot) => {
                for point in plot.series.iter().flat_map(|series| &series.points) {
                    let shown = (!plot.x.timed).then_some(point.x);
                    told += &format!("{shown:?} {:?}", (!plot.y.timed).then_some(point.y));
                    let on_decades =
                        (!plot.x.log || point.x > 0.0) && (!plot.y.log || point.y > 0.0);
                    assert!(on_decades, "{}: {point:?}", plot.name);
                }
            }
        }
    }
    told
}

#[test]
fn the_judge_of_contacts_gives_the_recorded_velocities() {
    for name in ["R03_mass_ratio", "R05_grazing", "R07_galilean", "R10_unit_scale"] {
        let case = case(name);
        let inputs = case["inputs"]["subcases"].as_array().expect("a list");
        let expected = case["expected"]["subcases"].as_array().expect("a list");
        for (input, expected) in inputs.iter().zip(expected) {
            let input = if input["inputs"].is_null() { input } else { &input["inputs"] };
            let disc = |k: usize| {
                let body = &input["bodies"][k];
                let number = |key: &str| body[key].as_f64().expect("a number");
                let position = DVec2::new(number("x"), number("y"));
                let velocity = DVec2::new(number("vx"), number("vy"));
                Disc { id: k as u32, position, velocity, radius: number("r"), mass: number("m") }
            };
            let restitution = input["e"].as_f64().unwrap_or(1.0);
            let found = digits::collide(&disc(0), &disc(1), restitution);
            assert_eq!(found.is_some(), expected["collides"] == true, "{name} {expected}");
            let Some((a, b)) = found else { continue };
            let ours = [&a[0], &a[1], &b[0], &b[1]].map(digits::nearest);
            let theirs = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(k, axis)| {
                let text = expected["v"][k][axis].as_str().expect("a decimal");
                text.parse::<f64>().expect("a number")
            });
            let size = theirs.into_iter().fold(0.0, |size: f64, v| size.max(v.abs()));
            for (ours, theirs) in ours.into_iter().zip(theirs) {
                let off = (ours - theirs).abs();
                // Of a 0, what 300 bits leave.
                assert!(
                    off <= f64::EPSILON * theirs.abs() + 1e-80 * size,
                    "{name}: {ours} {theirs}"
                );
            }
        }
    }
}

/// Outcomes of the seven steps, the reduced mass, and carom's three.
fn forms(name: &str) -> [Outcome; 5] {
    let all = categories(FORMS.pairs).expect("cases");
    let category = all.iter().find(|category| category.name.contains(name)).expect("there");
    outcomes_of(category, FORMS).expect("right").try_into().expect("five forms")
}

#[test]
fn carom_keeps_its_bound_where_plain_forms_break_it() {
    for (name, breaks) in [("mass ratios", true), ("frames", true), ("like sizes", false)] {
        let [seven, reduced, carom, events, plain] = forms(name);
        assert_eq!(seven.of_bound > 1.0, breaks, "{name}: {seven:?}");
        for outcome in [carom, events, plain] {
            assert!(outcome.of_bound < 0.6 && outcome.wrong == 0, "{name}: {outcome:?}");
            assert!(outcome.mean <= 1.001 * reduced.mean, "{name}: {outcome:?} {reduced:?}");
        }
    }
    let [seven, reduced, carom, events, plain] = forms("grazing");
    assert!(seven.wrong > 0 && reduced.wrong > 0, "{seven:?} {reduced:?}");
    assert_eq!([carom.wrong, events.wrong, plain.wrong], [0; 3]);
    let [seven, reduced, carom, ..] = forms("extreme units");
    assert!(seven.no_number > 0 && reduced.no_number > 0, "{seven:?} {reduced:?}");
    assert!(carom.no_number == 0 && carom.of_bound < 1.0, "{carom:?}");
}

#[test]
fn only_hi_and_lo_mass_fractions_leave_the_energy_without_bias() {
    let [seven, reduced, carom, events, plain] =
        [0, 1, 2, 3, 4].map(|k| bias(ALL[k].law, FORMS.collisions));
    assert!(seven.mean > 10.0 * seven.chance && reduced.mean > 10.0 * reduced.chance);
    for bias in [carom, events, plain] {
        assert!(bias.mean < 0.1 * reduced.mean, "{bias:?} {reduced:?}");
    }
}

#[test]
fn a_wrong_form_would_be_found_out() {
    let all = categories(10).expect("cases");
    // A parting pair between approaching ones, which nobody may collide.
    let mut pair: Touching = all[2].pairs[0];
    (pair.a.velocity, pair.b.velocity) = (pair.b.velocity, pair.a.velocity);
    assert!(digits::collide(&pair.a, &pair.b, 1.0).is_none());
    assert!(ALL.iter().all(|form| (form.law)(&pair.a, &pair.b, 1.0).is_none()));
}

#[test]
fn the_resolver_figure_is_the_same_again() {
    let size = resolver::Size { pairs: 200, repeats: 5, collisions: 500 };
    let section = resolver::section_of(size, &mut |_| {}).expect("right");
    let again = resolver::section_of(size, &mut |_| {}).expect("right");
    assert_eq!(untimed(&section), untimed(&again));
}

#[test]
fn times_of_impact_are_right_where_plain_formulas_lose_digits() {
    let size = impact::Size { pairs: 1_500, repeats: 5 };
    for category in Category::ALL {
        let found = impact::outcomes(category, size).expect("right");
        let of = |formula: Formula| &found[formula as usize];
        for formula in Formula::ALL.into_iter().filter(|formula| formula.is_robust()) {
            assert!(of(formula).largest <= 6.0 && of(formula).wrong == 0, "{category:?}");
        }
        let (school, stable) = (of(Formula::School), of(Formula::Stable));
        match category {
            Category::Far | Category::Near | Category::Grazing => {
                assert!(school.largest > 1e5 && stable.largest > 1e5, "{category:?}: {school:?}");
            }
            Category::FarGrazing => {
                assert!(school.wrong > size.pairs / 5, "{school:?}");
                assert!(of(Formula::Cross).wrong < school.wrong / 10, "{found:?}");
            }
            Category::Generic => assert!(stable.mean > of(Formula::Carom).mean),
            Category::Overlapping => {}
        }
    }
}

#[test]
fn the_judge_of_times_knows_never_and_now() {
    let seen = |x: f64, w: f64| Relative { d: DVec2::new(x, 0.0), w: DVec2::new(w, 0.0), s: 1.0 };
    let time = |pair: &Relative| digits::time_of_impact(pair).map(|time| digits::nearest(&time));
    assert_eq!(time(&seen(3.0, -0.5)), Some(4.0));
    assert_eq!((time(&seen(3.0, 0.5)), time(&seen(0.5, -1.0))), (None, Some(0.0)));
    let passing = |y: f64| Relative { d: DVec2::new(3.0, y), w: DVec2::new(-1.0, 0.0), s: 1.0 };
    assert_eq!(time(&passing(1.0_f64.next_up())), None);
    assert!(time(&passing(1.0_f64.next_down())).is_some());
}

#[test]
fn the_impact_figure_is_the_same_again() {
    let size = impact::Size { pairs: 150, repeats: 5 };
    let section = impact::section_of(size, &mut |_| {}).expect("right");
    let again = impact::section_of(size, &mut |_| {}).expect("right");
    assert_eq!(untimed(&section), untimed(&again));
}

#[test]
fn exact_methods_stay_within_rounding_over_masses_and_gaps() {
    let size = stability::Size { chain: (5, 4), springs: (6, 3), phases: 1 };
    let section = stability::section_of(size, &mut |_| {}).expect("right");
    let [events, plain] = [&section.items[0], &section.items[1]].map(|item| match item {
        Item::Map(map) => map,
        _ => panic!("a map"),
    });
    let all = |map: &Map| map.values.iter().flatten().copied().collect::<Vec<f64>>();
    assert!(all(events).iter().all(|error| *error < 20.0), "{:?}", all(events));
    assert!(all(plain).iter().all(|error| *error < 1.0), "{:?}", all(plain));
    let again = stability::section_of(size, &mut |_| {}).expect("right");
    assert_eq!(untimed(&section), untimed(&again));
}

#[test]
fn the_truth_of_the_chain_shows_its_growth() {
    let discs = chain::discs(1.0, 1e-3);
    let short = chain::Truth::after(&discs, 2).expect("contacts");
    let long = chain::Truth::after(&discs, 14).expect("contacts");
    assert!(short.time < long.time && short.growth > 1.0 && long.growth > 10.0 * short.growth);
    // The start is far from where they are then.
    assert!(short.error(&discs) > 1.0);
}

#[test]
fn springs_blow_up_where_theory_says() {
    let size = stability::Size { chain: (1, 1), springs: (27, 7), phases: 1 };
    for rule in Explicit::ALL {
        let map = stability::springs_map(rule, size);
        for (beta, row) in map.ys.iter().zip(&map.values) {
            let blown =
                row.iter().position(|class| *class == springs::Outcome::BlowsUp as u8 as f64);
            let limit = rule.largest_stable_step(1.0, *beta);
            let predicted = map.xs.iter().position(|h| *h > limit);
            let [blown, predicted] = [blown, predicted].map(|at| at.unwrap_or(map.xs.len()) as i64);
            let name = rule.name();
            assert!((blown - predicted).abs() <= 1, "{name}, {beta}: {blown} {predicted}");
            assert!(row.contains(&0.0), "{name}, {beta}: a short step must be right");
        }
    }
}

#[test]
fn restitutions_are_those_of_the_reference_case() {
    let case = case("P01_spring_dashpot_restitution");
    let inputs = case["inputs"]["subcases"].as_array().expect("a list");
    let expected = case["expected"]["subcases"].as_array().expect("a list");
    for (input, expected) in inputs.iter().zip(expected) {
        let [k, gamma, mu] = ["k", "gamma", "mu"].map(|key| input[key].as_f64().expect("a number"));
        let damping = 0.5 * gamma / mu / (k / mu).sqrt();
        let text = expected["e_no_attraction"].as_str().expect("a decimal");
        let theirs: f64 = text.parse().expect("a number");
        let off = (springs::restitution(damping) - theirs).abs();
        assert!(off < 1e-13, "{input}: {theirs} {off}");
    }
}

#[test]
fn collisions_are_judged_before_their_time_is_told() {
    let size = scaling::Size {
        decades: 2,
        collisions: (3, 15_000),
        blocks: 3,
        few: vec![16, 64],
        stepped: vec![300],
    };
    let section = scaling::section_of(&size, &mut |_| {}).expect("right");
    let runs = tables(&section).find(|table| table.name == "scaling_runs").expect("there");
    // Four densities and two numbers; five kinds of sizes; two methods and two numbers.
    assert_eq!(runs.rows.len(), 4 * 2 + 5 + 2 * 2);
    let judged = runs.rows.iter().filter(|row| row[7] != "-");
    let mut count = 0;
    for row in judged {
        let [rate, theory] = [&row[6], &row[7]].map(|cell| cell.parse::<f64>().expect("a number"));
        let is_small = row[0] == "168";
        assert!(is_small || (rate / theory - 1.0).abs() < 0.05, "{row:?}");
        count += 1;
    }
    assert_eq!(count, 2 + 2 + 2 + 1, "0.1, 0.5, the crystal twice each, and 0.3");
    let again = scaling::section_of(&size, &mut |_| {}).expect("right");
    assert_eq!(untimed(&section), untimed(&again));
}

#[test]
fn cases_are_told_or_said_to_be_absent() {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cases"));
    let options = Options {
        cases: Some(folder),
        only: Some("R0*".to_owned()),
        quick: true,
        ..Options::default()
    };
    let mut last = 0.0;
    let section = cases::section_of(&options, &mut |part| last = part).expect("told");
    let table = tables(&section).next().expect("a table");
    assert_eq!((table.rows.len(), last), (12, 1.0));
    assert!(table.rows.iter().all(|row| row[1] == "pass" || row[1] == "gold"), "{table:?}");
    assert!(section.text[1].starts_with("12 pass"), "{:?}", section.text);
    untimed(&section);
    let nowhere = Options { cases: Some(PathBuf::from("no such folder")), ..Options::default() };
    let section = cases::section_of(&nowhere, &mut |_| {}).expect("told");
    assert!(section.items.is_empty() && section.text[0].starts_with("Left out: "));
}

#[test]
fn what_is_left_out_changes_no_bit() {
    let scenes = ["thousand", "head_on", "resolver"];
    let section = left_out::section_of(&scenes, Blocks::FEW, &mut |_| {}).expect("right");
    untimed(&section);
    let [scenes, parts] = tables(&section).collect::<Vec<_>>()[..] else { panic!("two tables") };
    let word = |row: &Vec<String>, k: usize| row[k].clone();
    let together: Vec<String> = scenes.rows.iter().map(|row| word(row, 7)).collect();
    assert_eq!(together, ["the same bits", "the same bits", "-"]);
    let of = |name: &str| parts.rows.iter().filter(|row| row[0] == name).count();
    assert!(of("thousand") >= 8 && of("head_on") >= 3 && of("resolver") == 0, "{parts:?}");
    for row in &parts.rows {
        let told = if row[1] == "grid for circles" { "-" } else { "the same bits" };
        assert_eq!(row[4], told, "{row:?}");
    }
}
