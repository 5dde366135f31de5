//! The report's figures of motion: what they say of errors could be wrong; it is held here, and
//! that a wrong method would be found out.

use carom::report::Effort;
use carom::report::figures::fit::{Walk, power_law};
use carom::report::figures::gas::{self, Measured, Stretch, Who};
use carom::report::figures::mover::{self, Mover, Scene};
use carom::report::figures::{long_time, short_time, statistics};
use carom::report::judge::retell;
use carom::world::{Contact, Partner};

/// A small gas, so that errors are small before order is lost.
fn stretch() -> Stretch {
    Stretch::new(60, 0.3, 1.0).expect("a gas that the judge agrees with")
}

fn contacts(scene: &Scene) -> Vec<Contact> {
    let mut arena = Mover::Plain.arena(scene).expect("an arena");
    mover::contacts(&mut arena, scene.until).expect("a run")
}

fn measured(movers: &[Mover]) -> Measured {
    let movers: Vec<Who> = movers.iter().copied().map(Who::Own).collect();
    Measured::new((60, 0.3, 1.0), &movers, 1, |_| ()).expect("a measured gas")
}

#[test]
fn the_judge_agrees_with_the_plain_method_and_with_no_other_story() {
    let stretch = stretch();
    let scene = &stretch.scene;
    assert!(stretch.plain.worst < 1e-14, "{:?}", stretch.plain);
    assert!(stretch.growth > 10.0 && stretch.growth < 1e6, "{}", stretch.growth);
    let truth = contacts(scene);
    let tell = |contacts: &[Contact]| {
        retell(&scene.settings, &scene.discs, contacts, scene.until).map(|_| ())
    };
    assert_eq!(tell(&truth), Ok(()));
    // Without any one contact, the two overlap later, or something else does not come about.
    for k in [0, 1, truth.len() / 2, truth.len() - 1] {
        let mut missing = truth.clone();
        missing.remove(k);
        assert!(tell(&missing).is_err(), "without contact {k}");
    }
    let mut turned = truth.clone();
    turned.swap(0, 1);
    assert!(tell(&turned).is_err());
    let mut other = truth.clone();
    let pair = other.iter().position(|contact| matches!(contact.b, Partner::Disc(_)));
    let pair = pair.expect("a pair");
    other[pair].b = Partner::Disc((other[pair].a + 1) % 60);
    assert!(tell(&other).is_err());
}

#[test]
fn a_rough_method_that_calls_itself_exact_is_found_out() {
    let stretch = stretch();
    let mut arena = Mover::Steps(1.0 / 64e3).arena(&stretch.scene).expect("an arena");
    mover::pass(&mut arena, 1.0).expect("a run");
    let ended = gas::ended(&stretch, &mover::discs(&arena));
    let events = Who::Own(Mover::Events);
    let error = gas::judge(events, &ended, &stretch).expect_err("steps are not exact");
    assert!(error.contains("events"), "{error}");
    // Nor is one that is so in place, but not in energy.
    let energy = 1e-9;
    let right = gas::Ended { error: stretch.plain, energy, ..ended };
    assert!(gas::judge(events, &right, &stretch).is_err());
    assert!(gas::judge(events, &gas::Ended { energy: 0.0, ..right }, &stretch).is_ok());
}

#[test]
fn steps_are_of_first_order_and_springs_of_the_half() {
    let rates = [4e3, 16e3, 64e3, 256e3];
    let stiff = [1e8, 1e10, 1e12];
    let springs = |stiffness| Mover::Springs { stiffness, step: 1.0 / 240.0 };
    let steps = rates.map(|rate| Mover::Steps(1.0 / rate));
    let gas = measured(&[&steps[..], &stiff.map(springs)].concat());
    let errors: Vec<f64> = gas.rows.iter().map(|row| row.ended.error.rms).collect();
    let points =
        |x: &[f64], y: &[f64]| x.iter().copied().zip(y.iter().copied()).collect::<Vec<_>>();
    let (order, _) = power_law(&points(&rates, &errors[..4]));
    assert!((-1.2..-0.8).contains(&order), "{order}: {errors:?}");
    let (order, _) = power_law(&points(&stiff, &errors[4..]));
    assert!((-0.6..-0.4).contains(&order), "{order}: {errors:?}");
}

#[test]
fn errors_of_the_gas_are_the_same_bits_in_every_run() {
    let movers = [
        Mover::Events,
        Mover::Ticks(1.0 / 60.0),
        Mover::Steps(1.0 / 240.0),
        Mover::Springs { stiffness: 1e6, step: 1.0 / 240.0 },
    ];
    let ended = |gas: &Measured| gas.rows.iter().map(|row| row.ended).collect::<Vec<_>>();
    assert_eq!(ended(&measured(&movers)), ended(&measured(&movers)));
}

#[test]
fn small_scenes_have_two_references_that_agree_and_errors_of_known_order() {
    let [mut steps, mut springs] = [0, 0];
    for known in short_time::all().expect("references that agree") {
        assert!(known.end().growth <= 400.0);
        let gas = short_time::measure(known, &short_time::movers(Effort::Quick)).expect("exact");
        let law = |of: fn(Mover) -> Option<f64>| {
            let point = |row: &short_time::Row| of(row.mover).map(|x| (x, row.error.rms));
            let points: Vec<(f64, f64)> = gas.rows.iter().filter_map(point).collect();
            (points.len() > 2).then(|| power_law(&points).0)
        };
        // Packed discs lose the order of contacts in any step; a mass of 1e6 sinks into walls.
        let name = gas.known.name;
        if name != "E25_dense_hex16"
            && let Some(order) = law(short_time::step_of)
        {
            assert!((0.7..1.5).contains(&order), "{name}: steps {order}");
            steps += 1;
        }
        if !["E25_dense_hex16", "E22_mass_1e6"].contains(&name)
            && let Some(order) = law(short_time::stiffness_of)
        {
            assert!((-0.6..-0.4).contains(&order), "{name}: springs {order}");
            springs += 1;
        }
    }
    // Springs have no restitution (E21).
    assert_eq!((steps, springs), (5, 3));
}

#[test]
fn a_small_scene_finds_out_a_method_that_is_not_exact() {
    let known = short_time::all().expect("references").remove(0);
    let rough = short_time::measure(known.clone(), &[Mover::Steps(2f64.powi(-14))]).expect("rough");
    let error = rough.rows[0].error;
    assert!(short_time::judge(Mover::Events, &error, known.end()).is_err());
    assert!(short_time::judge(Mover::Steps(1.0), &error, known.end()).is_ok());
}

#[test]
fn coefficients_say_what_steps_and_springs_cost_in_error() {
    let all = short_time::coefficients().expect("coefficients");
    assert_eq!(all, short_time::coefficients().expect("coefficients"));
    for of in &all {
        // A contact at some metres a second, seen some part of a step late.
        assert!((0.1..1e4).contains(&of.steps_per_s), "{of:?}");
        assert_eq!(of.springs_per_root.is_none(), of.scene == "E21_chaos_e09");
    }
}

#[test]
fn a_drift_is_told_apart_into_bias_and_wandering() {
    // A walk of steps +-1 without a pattern, and the same with a bias.
    let sign = |k: u64| if k.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 63 == 0 { 1.0 } else { -1.0 };
    let walk = |bias: f64| {
        let mut sums = vec![0.0];
        for part in 0..200u64 {
            let steps = (0..10_000).map(|k| sign((part * 10_000 + k).pow(2) ^ part) + bias);
            sums.push(sums[part as usize] + steps.sum::<f64>());
        }
        Walk::of(&sums, 1e4)
    };
    let (fair, biased) = (walk(0.0), walk(0.02));
    assert!(!fair.is_biased() && fair.step > 0.2 && fair.step < 5.0, "{fair:?}");
    assert!(biased.is_biased() && (biased.bias - 0.02).abs() < 0.01, "{biased:?}");
}

#[test]
fn long_runs_keep_energy_and_distance_or_are_refused() {
    let scene = gas::melted(100, 0.5, 0.0).expect("a gas");
    let run = |mover| long_time::run(&scene, mover, 2e4, |_| ()).expect("a run");
    for mover in [Mover::Events, Mover::Plain, Mover::Ticks(1.0 / 60.0)] {
        let long = run(mover);
        let (events, drift, overlap) = *long.course.last().expect("a course");
        assert!(events > 15_000 && drift.abs() < 1e-13 && overlap < 1e-12, "{long:?}");
        assert_eq!(run(mover).course, long.course);
    }
    let rough = run(Mover::Steps(1.0 / 60.0));
    assert!(long_time::judge(&rough).is_ok());
    let called_exact = long_time::Long { mover: Mover::Events, ..rough };
    assert!(long_time::judge(&called_exact).is_err(), "it overlaps");
}

#[test]
fn rates_are_exact_and_a_wrong_one_is_found_out() {
    let scores = statistics::scores(0.005, |_| ()).expect("scores");
    assert_eq!(scores.len(), 19);
    let (distance, chance) = statistics::judge(&scores).expect("right means");
    assert!(distance < 0.5 && chance > 1e-3, "{distance} {chance}");
    let mut wrong = scores.clone();
    wrong[0].mean.0 += 6.0 * wrong[0].mean.1;
    assert!(statistics::judge(&wrong).is_err());
    // Each by itself right, and yet no chance: all on one side.
    let mut shifted = scores;
    shifted.iter_mut().for_each(|score| score.mean.0 = score.exact + 1.5 * score.mean.1);
    assert!(statistics::judge(&shifted).is_err());
}

#[test]
fn kolmogorovs_test_knows_its_own_quantiles() {
    // Evenly spread over the normal law, and all in one half of it.
    let normal = |k: u32| {
        let p = (f64::from(k) + 0.5) / 40.0;
        // Newton from 0: the law is convex enough in between.
        (0..60).fold(0.0f64, |z, _| {
            let law = 0.5 * libm::erfc(-z / std::f64::consts::SQRT_2);
            z - (law - p) / (0.4 * (-0.5 * z * z).exp()).max(0.02)
        })
    };
    let even: Vec<f64> = (0..40).map(normal).collect();
    let (distance, chance) = statistics::kolmogorov(&even);
    assert!((distance - 1.0 / 80.0).abs() < 1e-3 && chance > 0.999, "{distance} {chance}");
    let half: Vec<f64> = even.iter().map(|z| z.abs()).collect();
    let (distance, chance) = statistics::kolmogorov(&half);
    assert!((distance - 0.5).abs() < 0.03 && chance < 1e-8, "{distance} {chance}");
}
